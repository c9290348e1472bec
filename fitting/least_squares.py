"""Least squares on fringe moments: curvature, centre and phase with a smooth background and contrast."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
from jaxtyping import Array, Bool, Float
from numpy.polynomial.chebyshev import chebvander

from fitting.models import NUMBERS, Local
from fitting.moments import BACKGROUND, ENVELOPE, Moments, degrees, model_coefficients, node_grid, residuals

# Degree of the contrast, at most; backgrounds and contrasts that are tried, as (degree, degree).
CONTRAST = 4
SHAPES = ((0, 0), (1, 0), (1, 1), (2, 1), (2, 2), (3, 2), (4, 2), (4, 4), (6, 4))


class Unknowns(NamedTuple):
    """The free numbers: the model's, and the coefficients of background and contrast by `degrees`."""

    model: Float[Array, " free"]
    background: Float[Array, " low"]
    contrast: Float[Array, " contrast"]


class Solution(NamedTuple):
    """A least-squares optimum.

    - `unknowns`; `chi2` over the whole image; `converged`.
    - `jacobian` [basis, unknowns]: of the residuals, in the order of the flattened unknowns.
    - `active`: which of these are free.
    - `excursion`: largest distance of the phase from the moments' reference, over the nodes [turns].
    - `image`: background coefficients, modulus and phase at the nodes; `moments.synthesize` makes the picture of it.
    """

    unknowns: Unknowns
    chi2: Float[Array, ""]
    converged: Bool[Array, ""]
    jacobian: Float[Array, "basis unknowns"]
    active: Bool[Array, " unknowns"]
    excursion: Float[Array, ""]
    image: tuple[Array, Array, Array]


def flatten(unknowns: Unknowns) -> Float[Array, " unknowns"]:
    return jnp.concatenate(list(unknowns))


def contrast_at_nodes() -> np.ndarray:
    """The polynomials of the contrast, lowest degree first, at the envelope's nodes [nodes, polynomials]."""
    x, y = node_grid(ENVELOPE + 1)
    order = degrees(CONTRAST)
    return chebvander(y, CONTRAST)[:, order[:, 0]] * chebvander(x, CONTRAST)[:, order[:, 1]]


def fields(local: Local, unknowns: Unknowns) -> tuple[Array, Array, Array]:
    """Background coefficients, and modulus and phase at the nodes."""
    phase, shape = local(unknowns.model)
    return unknowns.background, shape * (jnp.asarray(contrast_at_nodes()) @ unknowns.contrast), phase


def _misfit(unknowns: Unknowns, arguments) -> Float[Array, " residuals"]:
    local, kept, active, held, scale = arguments
    # What is not free stays as it was for the image, and a residual of its own keeps the solver's matrix regular.
    image = residuals(kept, model_coefficients(*fields(local, _hold(unknowns, active, held)), kept.reference))
    return jnp.concatenate([image * scale, jnp.where(active, 0.0, flatten(unknowns) - held)])


def _hold(unknowns: Unknowns, active: Bool[Array, " unknowns"], held: Float[Array, " unknowns"]) -> Unknowns:
    sizes = np.cumsum([len(part) for part in unknowns])[:-1]
    return Unknowns(*jnp.split(jnp.where(active, flatten(unknowns), held), sizes))


@eqx.filter_jit
def solve(local: Local, kept: Moments, start: Unknowns, active: Bool[Array, " unknowns"]) -> Solution:
    """The optimum next to a start, by Levenberg and Marquardt's method (optimistix) on the moments."""
    held = jnp.concatenate([local.free, jnp.zeros(len(active) - len(local.free))])
    start = _hold(start._replace(model=local.free), active, held)
    # Damping dies out by a constant factor: a step of 1e-7 leaves an error a thousand times below any noise's.
    solver = optx.LevenbergMarquardt(rtol=1e-7, atol=1e-9)
    arguments = (local, kept, active, held, 1 / jnp.sqrt(kept.power))
    found = optx.least_squares(_misfit, solver, start, arguments, max_steps=60, throw=False)
    unknowns = _hold(found.value, active, held)
    left, jacobian = tangent(local, kept, unknowns)
    return Solution(
        unknowns,
        left @ left + kept.rest,
        found.result == optx.RESULTS.successful,
        jacobian,
        active,
        jnp.abs(local(unknowns.model)[0] - kept.reference).max(),
        fields(local, unknowns),
    )


@eqx.filter_jit
def tangent(
    local: Local, kept: Moments, unknowns: Unknowns
) -> tuple[Float[Array, " basis"], Float[Array, "basis unknowns"]]:
    """The residuals, and their Jacobian in the order of the flattened unknowns."""

    def image(u):
        return residuals(kept, model_coefficients(*fields(local, u), kept.reference))

    return image(unknowns), jnp.concatenate(list(jax.jacfwd(image)(unknowns)), axis=1)


@eqx.filter_jit
def linear_start(local: Local, kept: Moments, active: Bool[Array, " unknowns"]) -> Unknowns:
    """Background and contrast, as far as they are free, by linear least squares, for a model's numbers as they are."""
    low, high = len(degrees(BACKGROUND)), len(degrees(CONTRAST))

    def image(linear):
        unknowns = Unknowns(local.free, linear[:low], linear[low:])
        return residuals(kept, model_coefficients(*fields(local, unknowns), kept.reference))

    zero = jnp.zeros(low + high)
    # What is not free has no column, and so keeps the least norm, 0.
    slope = jnp.where(active[len(local.free) :], jax.jacfwd(image)(zero), 0.0)
    best = jnp.linalg.lstsq(slope, -image(zero), rcond=1e-10)[0]
    return Unknowns(local.free, best[:low], best[low:])


def active_mask(free: int, background: int, contrast: int, held: tuple[int, ...] = ()) -> np.ndarray:
    """Which unknowns are free for degrees of background and contrast; `held` of the model's numbers are not."""
    model = np.array([k not in held for k in range(free)])
    low, high = (degrees(limit).sum(axis=1) <= d for limit, d in ((BACKGROUND, background), (CONTRAST, contrast)))
    return np.concatenate([model, low, high])


def choose_shape(solution: Solution, free: int, pixels: float, held: tuple[int, ...] = ()) -> tuple[int, int]:
    """Degrees of background and contrast with the least Bayesian information criterion (Schwarz 1978).

    Judged on the linearized model at the optimum of full degree: setting the other coefficients to zero costs a rise of
    chi-squared that linear algebra gives at once.
    """
    full = np.asarray(solution.active)
    variance = float(solution.chi2) / max(pixels - full.sum(), 1)

    def criterion(shape: tuple[int, int]):
        kept = active_mask(free, *shape, held) & full
        return rise_without(solution, full & ~kept) / variance + kept.sum() * np.log(pixels)

    return min(SHAPES, key=criterion)


def rise_without(solution: Solution, dropped: np.ndarray) -> float:
    """By how much chi-squared rises when some unknowns are set to zero, on the model linearized at the optimum."""
    jacobian, unknowns = np.asarray(solution.jacobian), np.asarray(flatten(solution.unknowns))
    kept = np.asarray(solution.active) & ~dropped
    away = jacobian[:, dropped] @ unknowns[dropped]
    rest = away - jacobian[:, kept] @ np.linalg.lstsq(jacobian[:, kept], away, rcond=1e-10)[0]
    return float(rest @ rest)


@eqx.filter_jit
def responses(
    solution: Solution, kept: Moments, bends: Float[Array, "bends nodes"]
) -> tuple[Float[Array, " basis"], Float[Array, "bends basis"]]:
    """The residuals at an optimum, and how they change with phases [turns] given at the nodes, per unit of each."""
    background, modulus, phase = solution.image

    def image(turns):
        return residuals(kept, model_coefficients(background, modulus, turns, kept.reference))

    left, change = jax.linearize(image, phase)
    return left, jax.vmap(change)(bends)


def drop_with(solution: Solution, left: np.ndarray, columns: np.ndarray) -> float:
    """By how much chi-squared would drop if columns [basis, more] joined the Jacobian's (Rao's score test, 1948)."""
    here = np.asarray(solution.jacobian)[:, np.asarray(solution.active)]
    basis = np.linalg.qr(here)[0]
    rest = columns - basis @ (basis.T @ columns)
    length = np.linalg.norm(rest, axis=0)
    kept = length > 1e-6 * np.linalg.norm(columns, axis=0)
    more = np.linalg.qr(rest[:, kept] / length[kept])[0]
    return float(((more.T @ left) ** 2).sum())


def covariance(solution: Solution, variance: float) -> np.ndarray:
    """Covariance of the flattened unknowns for a variance per unit weight; zero where not free.

    By singular values of the Jacobian: directions below 1e-10 of the largest, in columns of unit length, have no finite
    variance, and raise LinAlgError.
    """
    active = np.asarray(solution.active)
    jacobian = np.asarray(solution.jacobian)[:, active]
    length = np.linalg.norm(jacobian, axis=0)
    names = np.array(_names(solution.unknowns))[active]
    if np.any(length == 0):
        raise np.linalg.LinAlgError(f"the {names[length == 0][0]} does not change the image")
    _, singular, right = np.linalg.svd(jacobian / length, full_matrices=False)
    if singular[-1] < 1e-10 * singular[0]:
        pair = names[np.argsort(np.abs(right[-1]))[-2:][::-1]]
        raise np.linalg.LinAlgError(f"{pair[0]} and {pair[1]} change the image alike")
    inner = (right.T / singular**2) @ right * variance / np.outer(length, length)
    total = np.zeros((len(active),) * 2)
    total[np.ix_(active, active)] = inner
    return total


def _names(unknowns: Unknowns) -> list[str]:
    parts = ["background"] * len(unknowns.background) + ["contrast"] * len(unknowns.contrast)
    return [*NUMBERS[: len(unknowns.model)], *parts]


def background_only(kept: Moments, degree: int = BACKGROUND) -> Float[Array, ""]:
    """Chi-squared of the best background of a degree without fringes."""
    low = len(degrees(degree))  # lowest degrees come first
    columns = np.asarray(kept.root)[:, :low]
    target = np.asarray(kept.target)
    left = target - columns @ np.linalg.lstsq(columns, target, rcond=1e-10)[0]
    return kept.rest + left @ left
