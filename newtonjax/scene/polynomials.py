"""Sums of powers and of Chebyshev products with two derivatives, for numbers, traced numbers and jets.

Traced, powers are a loop over the degree, which compiles sooner than what is written out. A loop over Chebyshev's
polynomials, and sums over an axis of a table, would take most of a ray's time: these are written out.
"""

from functools import reduce
from operator import add
from typing import Any

import jax
import jax.numpy as jnp

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
    if traced:
        return _by_doubling(u, count)
    zero = 0.0 * u
    # Before T_0 comes T_1.
    current, before = (1.0 + zero, zero, zero), (u, 1.0 + zero, zero)
    rows = []
    for _ in range(count):
        rows.append(current)
        value, slope, bend = current
        after = (
            2 * u * value - before[0],
            2 * u * slope + 2 * value - before[1],
            2 * u * bend + 4 * slope - before[2],
        )
        current, before = after, current
    return [jets.stack(row) for row in zip(*rows, strict=True)]


def _by_doubling(u, count: int) -> Any:
    """The same by T_{n+k} = 2 T_n T_k - T_{n-k}: as few steps as the degree has binary digits."""
    ones, zeros = jnp.ones_like(u), jnp.zeros_like(u)
    value, slope, bend = jnp.stack([ones, u]), jnp.stack([zeros, ones]), jnp.stack([zeros, zeros])
    while len(value) < count:
        t, t1, t2 = value[-1], slope[-1], bend[-1]
        v, s, b = value[1:], slope[1:], bend[1:]
        v0, s0, b0 = (part[-2::-1] for part in (value, slope, bend))
        value = jnp.concatenate([value, 2 * t * v - v0])
        slope = jnp.concatenate([slope, 2 * (t1 * v + t * s) - s0])
        bend = jnp.concatenate([bend, 2 * (t2 * v + 2 * t1 * s + t * b) - b0])
    return value[:count], slope[:count], bend[:count]


def chebyshev_table(table, u, v) -> Any:
    """Σ table[j, i] T_j(v) T_i(u) and its derivatives [order in v, order in u], up to second ones.

    Beyond [-1, 1], where polynomials grow without bound, they go on along their tangents. `table` has axes of rays
    behind its first two, as many as u and v.
    """
    traced = _is_traced(table, u, v)
    xp = jnp if traced else jets
    at = xp.stack([v, u])
    within = abs(at) <= EDGE
    edge = xp.where(within, at, xp.where(at > 0, 1.0, -1.0))
    value, slope, bend = _chebyshev(edge, len(table), traced)
    # [degree, order, v or u, ...]
    orders = xp.stack([value + (at - edge) * slope, slope, xp.where(within, bend, 0.0)], 1)
    # Sums written out: of an axis that is not the last one XLA makes slow loops.
    degrees = range(len(table))
    rows = reduce(add, (orders[j, :, None, 0] * table[j] for j in degrees))  # [order in v, degree in u, ...]
    return reduce(add, (rows[:, i, None] * orders[i, :, 1] for i in degrees))
