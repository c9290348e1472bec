"""Choosing a method: the cheapest whose predicted error stays within a tolerance."""

from dataclasses import dataclass, replace
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from newtonjax import chebyshev
from newtonjax.aim import aim
from newtonjax.camera import Camera
from newtonjax.checks import require_bench, require_tolerance
from newtonjax.cost import passes
from newtonjax.fields import Fields, arrivals, polar
from newtonjax.gap import closed_fields, why_not_closed
from newtonjax.light import irradiance, shares
from newtonjax.methods import AbstractMethod, Chebyshev, ClosedForm, ErrorEstimate, Traced, error_from_nodes
from newtonjax.precision import afresh, require_concrete, x64
from newtonjax.scene import Scene
from newtonjax.trace import gather

_LADDER = (3, 4, 5, 6, 7, 9, 11, 13, 17, 21, 25, 29, 33)
# Nodes to a side of the probes; a grid is judged by one that has at least so many more.
_COARSE, _FINE, _FINEST, _BEYOND = 17, 33, 41, 4
# What pixels in float32 are away from those in float64 over the peak, by nodes and by the closed form.
_SINGLE, _SINGLE_CLOSED = 1e-5, 2e-6


@dataclass(frozen=True)
class Plan:
    """What `plan` decided.

    - `method`: the method object for `render`.
    - `scene`: the scene without the beams that cannot matter.
    - `dropped`: their words.
    - `phase_error`: bound [turns].
    - `intensity_error`: bound, over the peak as in `ErrorEstimate`, dropped beams included.
    - `reason`: one sentence.
    """

    method: AbstractMethod
    scene: Scene
    dropped: tuple[str, ...]
    phase_error: float
    intensity_error: float
    reason: str


@partial(jax.jit, static_argnames="count")
def _probe(scene: Scene, camera: Camera, count: int = _COARSE) -> Fields:
    return Chebyshev(count).fields(scene, camera)


@jax.jit
def _amplitudes(scene: Scene, camera: Camera) -> Float[Array, " beams"]:
    beams = arrivals(scene, chebyshev.node_points(camera, _COARSE))
    return jnp.sqrt(irradiance(shares(scene.light), beams.field).max(axis=1))


_error = jax.jit(error_from_nodes, static_argnums=1)


def plan(scene: Scene, camera: Camera, tolerance: float = 1e-3) -> Plan:
    """The cheapest method whose predicted largest intensity error, over the peak, is at most the tolerance.

    Traces 17 x 17 (if need be 33 x 33 or 41 x 41) nodes: from the decay of their coefficients follows the error of
    every smaller grid, and from the nodes themselves that of the closed form. Beams that together change no pixel by
    more than a tenth of the tolerance are dropped.

    The errors are infinite where a beam folds within the image, since of several rays one is followed: the one that
    the search from the axis finds. Others that come from beyond the image, through parts of a lens that a real one may
    not have, are not looked for. Where JAX is in float32 they hold the rounding of the pixels; a tolerance that this
    would break gets pixels in float64.

    Raises ValueError for a tolerance that is not positive, and for traced values, which have no error to compare.
    """
    require_bench(scene, camera)
    require_tolerance(tolerance)
    require_concrete("plan", scene, camera)
    scene, camera = afresh(scene, camera)
    single = not jax.config.read("jax_enable_x64")
    with x64():
        kept, lost = _strong_beams(scene, camera, 0.1 * tolerance)
        dropped = tuple(word for word in scene.beams if word not in kept.beams)
        fields = _probe(kept, camera)
        rounding = _rounding(fields)
        if not np.all(fields.arrives):
            reason = "not every beam reaches the whole image"
            if folds(kept, camera):
                reason = f"{reason}, and a caustic ends in it: where several rays of a beam land, one is followed"
                return Plan(Traced(), kept, dropped, np.inf, np.inf, reason)
            return Plan(Traced(), kept, dropped, rounding, lost + 2 * np.pi * rounding, reason)
        closed = _closed_error(kept, camera, fields)
        if closed is not None:
            by_formula = float(closed.intensity) + lost + (_SINGLE_CLOSED if single else 0.0)
            if by_formula <= tolerance:
                reason = "the screen is focused on the gap"
                return Plan(ClosedForm(), kept, dropped, float(closed.phase), by_formula, reason)
        reason = "no grid of nodes is fine enough for the fields"
        for finest in (_COARSE, _FINE, _FINEST):
            fields = _probe(kept, camera, finest)
            if not np.all(fields.arrives):
                break
            for count in (n for n in _LADDER if n + _BEYOND <= finest):
                if passes(Chebyshev(count), kept, camera) > passes(Traced(), kept, camera):
                    reason = "rays at every pixel cost less than a grid of nodes that is fine enough"
                    break
                phase, intensity = map(float, _error(fields, count))
                if intensity + lost <= tolerance:
                    reason = f"the fields are smooth: {count} x {count} nodes resolve them"
                    rounded = intensity + lost + _SINGLE
                    if single and rounded <= tolerance:
                        return Plan(Chebyshev(count), kept, dropped, phase, rounded, reason)
                    method = Chebyshev(count, "float64" if single else None)
                    return Plan(method, kept, dropped, phase, intensity + lost, reason)
        return Plan(Traced(), kept, dropped, rounding, lost + 2 * np.pi * rounding, reason)


def folds(scene: Scene, camera: Camera) -> bool:
    """Whether a caustic ends in the image: beyond it no ray of a beam lands, on this side several do.

    Seen at 17 x 17 points, where the search for a ray ends with one that reaches the screen elsewhere.
    """
    scene, camera = afresh(scene, camera)
    with x64():
        return bool(np.any(_lost(scene, chebyshev.node_points(camera, _COARSE))))


@jax.jit
def _lost(scene: Scene, points: Float[Array, "n 2"]) -> Bool[Array | np.ndarray, "beams n"]:
    routes, setting = gather(scene)
    return jax.vmap(lambda route: jax.vmap(lambda point: aim(route, setting, point).lost)(points))(routes)


def _rounding(fields: Fields) -> float:
    return float(np.max(fields.rounding))


def beam_amplitudes(scene: Scene, camera: Camera) -> dict[str, float]:
    """Largest amplitude of each beam in the image, of incident light of irradiance 1, at 17 x 17 points."""
    return dict(zip(scene.beams, np.asarray(_amplitudes(scene, camera)).tolist(), strict=True))


def _strong_beams(scene: Scene, camera: Camera, allowance: float) -> tuple[Scene, float]:
    """Drop the weakest beams while all that they add stays within the allowance; what they may add over the peak."""
    if len(scene.beams) <= 2:
        return scene, 0.0
    amplitude = np.asarray(_amplitudes(scene, camera))
    peak = float((amplitude**2).sum())
    order = np.argsort(amplitude)
    total, dropped, lost = amplitude.sum(), [], 0.0
    for k in order[:-1]:
        change = 2 * amplitude[[*dropped, k]].sum() * total / peak
        if change > allowance:
            break
        dropped.append(k)
        lost = float(change)
    words = tuple(word for k, word in enumerate(scene.beams) if k not in dropped)
    return replace(scene, beams=words), lost


def _closed_error(scene: Scene, camera: Camera, traced: Fields) -> ErrorEstimate | None:
    """The closed form's error at the nodes, where the traced fields are known; half as much again in between."""
    if why_not_closed(scene):
        return None
    points = chebyshev.node_points(camera, _COARSE)
    closed = closed_fields(scene, points[:, 0], points[:, 1])
    (size, phase), (true_size, true_phase) = polar(closed), polar(traced)
    wrong = jnp.abs(phase - true_phase)
    wrong = jnp.abs(wrong - jnp.round(wrong)) + traced.rounding
    error = jnp.abs(closed.background - traced.background) + jnp.abs(jnp.abs(size) - jnp.abs(true_size))[0]
    error = error + 2 * jnp.pi * (wrong * jnp.abs(true_size))[0]
    peak = traced.background.max() + jnp.abs(true_size).max()
    return ErrorEstimate(1.5 * float(wrong.max()), 1.5 * float(error.max() / peak))
