"""Sums of powers and of Chebyshev products with two derivatives, for numbers, traced numbers and jets.

Traced, they are loops over the degree: written out they would be most of what there is to compile of a ray.
"""

from typing import Any

import jax

from newtonjax.numerics import Jet, jets

# By so much of itself a domain is larger, for rays on its very edge.
EDGE = 1 + 1e-9


def _is_traced(*numbers) -> bool:
    return not any(isinstance(number, Jet) for number in numbers) and any(isinstance(n, jax.Array) for n in numbers)


def powers(coefficients, q) -> tuple[Any, Any, Any]:
    """P(q) = Σ coefficients[k] q^k, P' and P''/2 (Horner's scheme)."""

    def step(state, coefficient):
        value, slope, bend = state
        return (value * q + coefficient, slope * q + value, bend * q + slope), None

    zero = 0.0 * (coefficients[0] * q)
    state = (zero, zero, zero)
    if _is_traced(coefficients, q):
        return jax.lax.scan(step, state, coefficients, reverse=True)[0]
    for k in range(len(coefficients) - 1, -1, -1):
        state, _ = step(state, coefficients[k])
    return state


def _chebyshev(u, count: int, traced: bool) -> Any:
    """T_k(u) and its first two derivatives, each [count, ...]."""
    zero = 0.0 * u

    def step(state, _):
        current, before = state
        value, slope, bend = current
        after = (
            2 * u * value - before[0],
            2 * u * slope + 2 * value - before[1],
            2 * u * bend + 4 * slope - before[2],
        )
        return (after, current), current

    # Before T_0 comes T_1.
    state = ((1.0 + zero, zero, zero), (u, 1.0 + zero, zero))
    if traced:
        return jax.lax.scan(step, state, None, length=count)[1]
    rows = []
    for _ in range(count):
        state, current = step(state, None)
        rows.append(current)
    return [jets.stack(row) for row in zip(*rows, strict=True)]


def chebyshev_table(table, u, v) -> Any:
    """Σ table[j, i] T_j(v) T_i(u) and its derivatives [order in v, order in u], up to second ones.

    Beyond [-1, 1], where polynomials grow without bound, they go on along their tangents. `table` has axes of rays
    behind its first two, as many as u and v.
    """
    traced = _is_traced(table, u, v)
    xp = jax.numpy if traced else jets
    at = xp.stack([v, u])
    within = abs(at) <= EDGE
    edge = xp.where(within, at, xp.where(at > 0, 1.0, -1.0))
    value, slope, bend = _chebyshev(edge, len(table), traced)
    # [degree, order, v or u, ...]
    orders = xp.stack([value + (at - edge) * slope, slope, xp.where(within, bend, 0.0)], 1)
    rows = (orders[:, :, None, 0] * table[:, None]).sum(0)  # [order in v, degree in u, ...]
    return (rows[:, :, None] * orders[None, :, :, 1]).sum(1)
