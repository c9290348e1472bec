"""Choosing a method: the cheapest whose predicted error stays within a tolerance."""

from dataclasses import dataclass, replace

import jax
import numpy as np
from jaxtyping import Float

from newtonjax.fields import (
    ErrorEstimate,
    Fields,
    Packed,
    closed_fields,
    error_of,
    node_arrivals,
    node_fields,
    pack,
    peak_amplitudes,
    polar,
    smooth,
    with_beams,
)
from newtonjax.methods import AbstractMethod, Chebyshev, ClosedForm, Traced
from newtonjax.numerics import require_concrete, require_tolerance
from newtonjax.planning.cost import passes
from newtonjax.scene import Camera, Scene, node_points, require_bench, why_not_closed

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
    return planned(scene, camera, tolerance)[0]


def planned(
    scene: Scene, camera: Camera, tolerance: float = 1e-3
) -> tuple[Plan, Float[np.ndarray, "fields nodes nodes"] | None]:
    """What `plan` returns; and where that is nodes, the coefficients of the fields, without a further ray.

    They are cut from those of the finer grid on which the plan was made, and so closer to the fields than those of
    rays at the plan's own nodes, where higher degrees fold back.
    """
    require_bench(scene, camera)
    require_tolerance(tolerance)
    require_concrete("plan", scene, camera)
    bench = pack(scene)
    beams = node_arrivals(bench, camera, _COARSE)
    strong, lost = _strong_beams(peak_amplitudes(bench, beams), 0.1 * tolerance)
    dropped = tuple(word for k, word in enumerate(scene.beams) if k not in strong)
    if dropped:
        scene = replace(scene, beams=tuple(scene.beams[k] for k in strong))
        bench, beams = with_beams(bench, beams, strong)
    fields = node_fields(bench, beams)
    rounding = float(fields.rounding.max())
    whole = Plan(Traced(), scene, dropped, rounding, lost + 2 * np.pi * rounding, "")
    if not fields.arrives.all():
        reason = "not every beam reaches the whole image"
        if beams.lost.any():
            reason = f"{reason}, and a caustic ends in it: where several rays of a beam land, one is followed"
            return replace(whole, phase_error=np.inf, intensity_error=np.inf, reason=reason), None
        return replace(whole, reason=reason), None
    single = not jax.config.read("jax_enable_x64")
    closed = _closed_error(scene, camera, fields)
    if closed is not None:
        by_formula = float(closed.intensity) + lost + (_SINGLE_CLOSED if single else 0.0)
        if by_formula <= tolerance:
            reason = "the screen is focused on the gap"
            return Plan(ClosedForm(), scene, dropped, float(closed.phase), by_formula, reason), None
    return _on_nodes(whole, bench, camera, fields, tolerance, lost, single)


def _on_nodes(whole: Plan, bench: Packed, camera: Camera, fields: Fields, tolerance: float, lost: float, single: bool):
    """The plan of the fewest nodes that keep the tolerance, and their coefficients; else that of the whole image."""
    dearest = passes(Traced(), whole.scene, camera)
    reason = "no grid of nodes is fine enough for the fields"
    for finest in (_COARSE, _FINE, _FINEST):
        if finest > _COARSE:
            fields = node_fields(bench, node_arrivals(bench, camera, finest))
        nodes = smooth(fields)
        if not nodes.reached:
            break
        for count in (n for n in _LADDER if n + _BEYOND <= finest):
            if passes(Chebyshev(count), whole.scene, camera) > dearest:
                reason = "rays at every pixel cost less than a grid of nodes that is fine enough"
                break
            phase, intensity = map(float, error_of(nodes, count))
            if intensity + lost > tolerance:
                continue
            rounded = intensity + lost + _SINGLE
            in_float32 = single and rounded <= tolerance
            chosen = replace(
                whole,
                method=Chebyshev(count, "float64" if single and not in_float32 else None),
                phase_error=phase,
                intensity_error=rounded if in_float32 else intensity + lost,
                reason=f"the fields are smooth: {count} x {count} nodes resolve them",
            )
            return chosen, nodes.coefficients[:, :count, :count]
    return replace(whole, reason=reason), None


def folds(scene: Scene, camera: Camera) -> bool:
    """Whether a caustic ends in the image: beyond it no ray of a beam lands, on this side several do.

    Seen at 17 x 17 points, where the search for a ray ends with one that reaches the screen elsewhere.
    """
    return bool(node_arrivals(pack(scene), camera, _COARSE).lost.any())


def beam_amplitudes(scene: Scene, camera: Camera) -> dict[str, float]:
    """Largest amplitude of each beam in the image, of incident light of irradiance 1, at 17 x 17 points."""
    bench = pack(scene)
    return dict(zip(scene.beams, peak_amplitudes(bench, node_arrivals(bench, camera, _COARSE)).tolist(), strict=True))


def _strong_beams(amplitude: Float[np.ndarray, " beams"], allowance: float) -> tuple[list[int], float]:
    """Drop the weakest beams while all that they add stays within the allowance; what they may add over the peak."""
    dropped, lost = [], 0.0
    if len(amplitude) > 2:
        peak, total = float((amplitude**2).sum()), amplitude.sum()
        for k in np.argsort(amplitude)[:-1].tolist():
            change = 2 * amplitude[[*dropped, k]].sum() * total / peak
            if change > allowance:
                break
            dropped.append(k)
            lost = float(change)
    return [k for k in range(len(amplitude)) if k not in dropped], lost


def _closed_error(scene: Scene, camera: Camera, traced: Fields) -> ErrorEstimate | None:
    """The closed form's error at the nodes, where the traced fields are known; half as much again in between."""
    if why_not_closed(scene):
        return None
    points = node_points(camera, _COARSE)
    closed = closed_fields(scene, points[:, 0], points[:, 1])
    (size, phase), (true_size, true_phase) = polar(closed), polar(traced)
    wrong = abs(phase - true_phase)
    wrong = abs(wrong - np.round(wrong)) + traced.rounding
    error = abs(closed.background - traced.background) + abs(abs(size) - abs(true_size))[0]
    error = error + 2 * np.pi * (wrong * abs(true_size))[0]
    peak = traced.background.max() + abs(true_size).max()
    return ErrorEstimate(1.5 * float(wrong.max()), 1.5 * float(error.max() / peak))
