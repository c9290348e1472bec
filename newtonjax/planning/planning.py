"""Choosing a method: the cheapest whose predicted error stays within a tolerance."""

from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from newtonjax.fields import (
    Fields,
    Packed,
    error_of,
    node_arrivals,
    node_fields,
    pack,
    peak_amplitudes,
    smooth,
    with_beams,
)
from newtonjax.methods import (
    ORDERS,
    AbstractMethod,
    AbstractPicture,
    Chebyshev,
    ClosedForm,
    OverSource,
    Traced,
    error_of_order,
    error_of_profile,
    has_channels,
    is_single,
    means_error,
    of_points,
    one_line,
    parallel,
)
from newtonjax.numerics import Statement, require_concrete, require_tolerance
from newtonjax.planning.faces import crossing_warnings, end_warnings, refuse_folds
from newtonjax.planning.grids import LADDER, resolved
from newtonjax.planning.reasons import PlanReason
from newtonjax.scene import Camera, Scene, channels_of, grey, has_lateral_colour, require_bench

# Nodes to a side of the probes; a grid is judged by one that has at least so many more.
_COARSE, _FINE, _FINEST, _BEYOND = 17, 33, 41, 4
# What tables of a spectrum may err by, of the tolerance; and those that hold what pixels leave of the fringes.
_OF_TABLES, _OF_MEANS = 0.02, 0.2


@dataclass(frozen=True)
class Plan:
    """What `plan` decided.

    - `method`: the method object for `render`.
    - `scene`: the scene without the beams that cannot matter.
    - `dropped`: their words.
    - `phase_error`: bound [turns].
    - `intensity_error`: bound, over the peak as in `ErrorEstimate`, dropped beams included.
    - `reason`: one sentence; its `code` is a name of `PlanReason`.
    - `warnings`: likewise, of surfaces that end within the image or pass through each other.
    """

    method: AbstractMethod
    scene: Scene
    dropped: tuple[str, ...]
    phase_error: float
    intensity_error: float
    reason: str
    warnings: tuple[Statement, ...] = ()


def plan(scene: Scene, camera: Camera, tolerance: float = 1e-3) -> Plan:
    """The cheapest method whose predicted largest intensity error, over the peak, is at most the tolerance.

    Traces 17 x 17 (if need be 33 x 33 or 41 x 41) nodes: from the decay of their coefficients follows the error of
    every smaller grid, and from the nodes themselves that of the closed form. Beams that together change no pixel by
    more than a tenth of the tolerance are dropped.

    The errors are infinite where a beam folds within the image, since of several rays one is followed: the one that
    the search from the axis finds. Others that come from beyond the image, through parts of a lens that a real one may
    not have, are not looked for. Where JAX is in float32 they hold the rounding of the pixels; a tolerance that this
    would break gets pixels in float64.

    Raises ValueError for a tolerance that is not positive, traced values, and a face that is no sphere and folds rays.
    """
    return planned(scene, camera, tolerance)[0]


def planned(scene: Scene, camera: Camera, tolerance: float = 1e-3) -> tuple[Plan, AbstractPicture]:
    """What `plan` returns, and the picture of its method, ready for the pixels.

    One on nodes comes without a further ray: its coefficients are cut from those of the finer grid on which the plan
    was made, and so closer to the fields than those of rays at the plan's own nodes, where higher degrees fold back.
    """
    require_bench(scene, camera)
    require_tolerance(tolerance)
    require_concrete("plan", scene, camera)
    if scene.light.extent is not None:
        return _over_source(scene, camera, tolerance)
    if scene.all_orders is not None:
        return _all_orders(scene, camera, tolerance)
    if has_channels(scene.light, camera):
        return _in_channels(scene, camera, tolerance)
    bench = pack(scene)
    beams = node_arrivals(bench, camera, _COARSE)
    strong, dropped_error = _strong_beams(peak_amplitudes(bench, beams), 0.1 * tolerance)
    dropped = tuple(word for k, word in enumerate(scene.beams) if k not in strong)
    if dropped:
        scene = replace(scene, beams=tuple(scene.beams[k] for k in strong))
        bench, beams = with_beams(bench, beams, strong)
    fields = node_fields(bench, beams)
    rounding = float(fields.rounding.max())
    warnings = crossing_warnings(scene, camera, beams.path, beams.arrives, bench.pairs)
    by_rays = Plan(Traced(), scene, dropped, rounding, dropped_error + 2 * np.pi * rounding, "", warnings)
    if not fields.arrives.all():
        ends = end_warnings(scene, camera)
        refuse_folds(scene, camera, fields.arrives, bool(beams.lost.any()) or not ends)
        by_rays = replace(by_rays, warnings=warnings + ends)
        reason = PlanReason.BEAM_MISSES_IMAGE()
        if beams.lost.any():
            reason = PlanReason.CAUSTIC()
            by_rays = replace(by_rays, phase_error=np.inf, intensity_error=np.inf)
        return _with_picture(replace(by_rays, reason=reason), camera)
    formula = ClosedForm()
    if formula.refusal(scene) is None and camera.lens is None:
        error = formula.error_against(fields, scene, camera)
        intensity = float(error.intensity) + dropped_error + (formula.float32_error if is_single() else 0.0)
        if intensity <= tolerance:
            phase, reason = float(error.phase), PlanReason.FOCUSED_ON_GAP()
            return _with_picture(Plan(formula, scene, dropped, phase, intensity, reason, warnings), camera)
    return _on_nodes(by_rays, bench, camera, fields, tolerance, dropped_error)


def _over_source(scene: Scene, camera: Camera, tolerance: float) -> tuple[Plan, AbstractPicture]:
    """By the profile of the gap, or envelopes of all directions at nodes, where they keep the tolerance.

    Else a sum of images over directions. Raises ValueError where that would take too many.
    """
    if ClosedForm().refusal(scene) is None:
        if scene.all_orders is not None:
            return _all_orders(scene, camera, tolerance)
        with suppress(ValueError):
            chosen, picture = _in_channels(scene, camera, 0.5 * tolerance)
            of_rays = error_of_profile(scene, camera) if isinstance(chosen.method, ClosedForm) else 0.0
            if of_rays <= 0.5 * tolerance:
                return replace(chosen, intensity_error=chosen.intensity_error + of_rays), picture
    return _sum_over_source(scene, camera, tolerance)


def _sum_over_source(scene: Scene, camera: Camera, tolerance: float) -> tuple[Plan, AbstractPicture]:
    by_direction, _ = planned(parallel(scene), camera, 0.5 * tolerance)
    if isinstance(by_direction.method, ClosedForm):
        method = Chebyshev(table_error=_OF_TABLES * tolerance)
        of_nodes = method.error(parallel(scene), camera)
        by_direction = replace(by_direction, method=method, intensity_error=of_nodes.intensity)
    of_order, error = error_of_order(scene, camera), np.inf
    for order in ORDERS:
        error = of_order(order)
        if error <= 0.5 * tolerance:
            chosen = replace(
                by_direction,
                method=OverSource(by_direction.method, order),
                scene=replace(by_direction.scene, light=scene.light),
                intensity_error=by_direction.intensity_error + error,
                reason=PlanReason.SUM_OVER_SOURCE(),
            )
            return _with_picture(chosen, camera)
    raise ValueError(
        f"a source of {ORDERS[-1]} x {ORDERS[-1]} directions or more: the sum over these errs by {error:.2g} of "
        f"the peak; allowed: {0.5 * tolerance:g}; give a smaller source, a larger tolerance, or method=OverSource()"
    )


def _all_orders(scene: Scene, camera: Camera, tolerance: float) -> tuple[Plan, AbstractPicture]:
    """The closed form, with the error that it has.

    Raises ValueError where it does not hold, and where it errs by more than the tolerance.
    """
    method = ClosedForm(_OF_TABLES * tolerance)
    method.check(scene)
    method.check_camera(camera)
    error = method.error(scene, camera)
    if error.intensity > tolerance:
        raise ValueError(
            f"the closed form of all orders errs by {error.intensity:.2g} of the peak; allowed: {tolerance:g}; "
            "give a larger tolerance, a flatter lens or a smaller image, or method=ClosedForm()"
        )
    return _with_picture(Plan(method, scene, (), *error, PlanReason.ALL_ORDERS()), camera)


def _in_channels(scene: Scene, camera: Camera, tolerance: float) -> tuple[Plan, AbstractPicture]:
    """The plan of the mean line, whose phase errors are larger in shorter waves; and a table that errs by less."""
    stretch = float(np.max(channels_of(scene.light, None).lines.ratios))
    table_error = (_OF_MEANS if camera.takes_means else _OF_TABLES) * tolerance
    points, line = grey(of_points(camera)), one_line(scene)
    line_plan, _ = planned(line, points, (tolerance - table_error) / stretch)
    method, picture = line_plan.method, None
    if isinstance(method, Chebyshev | ClosedForm):
        line_plan = replace(line_plan, method=replace(method, table_error=table_error))
    if line_plan.dropped:
        scene = replace(line_plan.scene, light=scene.light)
    if camera.takes_means or scene.light.extent is not None:
        line_plan, picture = _resolving(line_plan, scene, camera, (tolerance - table_error) / stretch, table_error)
    phase, intensity = line_plan.phase_error * stretch, line_plan.intensity_error * stretch + table_error
    line_plan = replace(line_plan, scene=scene, phase_error=phase, intensity_error=intensity)
    if picture is None or has_lateral_colour(camera):
        return _with_picture(line_plan, camera)
    return line_plan, picture


def _resolving(line_plan: Plan, scene: Scene, camera: Camera, tolerance: float, table_error: float):
    """The plan with the closed form where its means hold, else nodes for pixels and source; and their picture."""
    if isinstance(line_plan.method, ClosedForm):
        of_means = means_error(scene, camera)
        if line_plan.intensity_error + of_means <= tolerance:
            return replace(line_plan, intensity_error=line_plan.intensity_error + of_means), None
    least = line_plan.method.nodes if isinstance(line_plan.method, Chebyshev) else LADDER[0]
    method, error, picture = resolved(scene, camera, least, tolerance, table_error)
    error, reason = max(error, line_plan.intensity_error), PlanReason.NODES_RESOLVE(count=method.nodes)
    return replace(line_plan, method=method, intensity_error=error, reason=reason), picture


def _with_picture(chosen: Plan, camera: Camera) -> tuple[Plan, AbstractPicture]:
    return chosen, chosen.method.picture(chosen.scene, camera)


def _on_nodes(by_rays: Plan, bench: Packed, camera: Camera, fields: Fields, tolerance: float, dropped_error: float):
    """The plan of the fewest nodes that keep the tolerance, and their picture; else that of rays at every pixel."""
    dearest = by_rays.method.passes(by_rays.scene, camera)
    reason = PlanReason.NO_GRID_FINE_ENOUGH()
    for finest in (_COARSE, _FINE, _FINEST):
        if finest > _COARSE:
            fields = node_fields(bench, node_arrivals(bench, camera, finest))
        nodes = smooth(fields)
        if not nodes.reached:
            break
        for count in (n for n in LADDER if n + _BEYOND <= finest):
            if Chebyshev(count).passes(by_rays.scene, camera) > dearest:
                reason = PlanReason.RAYS_ARE_CHEAPER()
                break
            phase, intensity = map(float, error_of(nodes, count))
            if intensity + dropped_error > tolerance:
                continue
            method, intensity = _with_pixels(Chebyshev(count), intensity + dropped_error, tolerance)
            chosen = replace(
                by_rays,
                method=method,
                phase_error=phase,
                intensity_error=intensity,
                reason=PlanReason.NODES_RESOLVE(count=count),
            )
            return chosen, method.picture_of(nodes.coefficients[:, :count, :count], camera)
    return _with_picture(replace(by_rays, reason=reason), camera)


def _with_pixels(method: Chebyshev, error: float, tolerance: float) -> tuple[Chebyshev, float]:
    """The method with pixels in JAX's setting, or in float64 where float32 would break the tolerance; its error."""
    if not is_single():
        return method, error
    rounded = error + method.float32_error
    return (method, rounded) if rounded <= tolerance else (replace(method, dtype="float64"), error)


def beam_amplitudes(scene: Scene, camera: Camera) -> dict[str, float]:
    """Largest amplitude of each beam in the image, of incident light of irradiance 1, at 17 x 17 points."""
    bench = pack(scene)
    return dict(zip(scene.beams, peak_amplitudes(bench, node_arrivals(bench, camera, _COARSE)).tolist(), strict=True))


def _strong_beams(amplitude: Float[np.ndarray, " beams"], allowance: float) -> tuple[list[int], float]:
    """Drop the weakest beams while all that they add stays within the allowance; what they may add over the peak."""
    dropped, error = [], 0.0
    if len(amplitude) > 2:
        peak, total = float((amplitude**2).sum()), amplitude.sum()
        for k in np.argsort(amplitude)[:-1].tolist():
            change = 2 * amplitude[[*dropped, k]].sum() * total / peak
            if change > allowance:
                break
            dropped.append(k)
            error = float(change)
    return [k for k in range(len(amplitude)) if k not in dropped], error
