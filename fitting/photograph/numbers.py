"""From free numbers to quantities: values, standard deviations and the budget of what is measured."""

from dataclasses import replace

import numpy as np

from fitting.estimate import Fitted, bends, fringes_of
from fitting.model import GapModel, SceneModel, free_numbers, gap_phase
from fitting.parameters import (
    EXPONENTS,
    NUMBERS,
    Numbers,
    Quantities,
    block_of,
    change,
    held_turns,
    interval,
    lensless,
    quantities_of,
    rescaled,
    result_names,
)
from fitting.photo import thin
from fitting.photograph.result import Parameter
from newtonjax.scene import gap_height


def measured(
    found: Fitted, known: Quantities, view: str, covariance: np.ndarray, rows: list[tuple[str, float]]
) -> dict:
    """The numbers of a `FitResult`, by name; `rows`: (source, deviation of the curvature) of the image itself."""
    model, frame = found.model, found.model.frame
    numbers = Numbers(*found.numbers)
    offsets = (numbers.centre_x, numbers.centre_y)
    centre = tuple(float(m + c * frame.unit) for m, c in zip(frame.middle, offsets, strict=True))
    if isinstance(model, SceneModel):
        values, slope, gap, period = _of_scene(model, known, numbers)
    else:
        values, slope, gap, period = _of_gap(model, known, view, numbers)
    disc, disc_slope = _disc(found, values)
    relative_sd = {name: sd / known.given[name] for name, sd in known.sd.items()}
    units = {"curvature": slope, "centre_x": frame.unit, "centre_y": frame.unit, "phase": period, "contact": disc_slope}
    spread = rescaled(block_of(covariance), units)
    sds = Numbers(*np.sqrt(np.clip(np.diag(spread), 0, None)))
    scale = values["fringe_scale_per_px2"]
    rows = [(source, abs(slope) * deviation) for source, deviation in rows]
    of_image = float(np.sqrt(sum(sd**2 for _, sd in rows)))
    relative = of_image / values[known.unknown or "fringe_scale_per_px2"]
    common = {
        "fringe_scale_per_px2": scale,
        "fringe_scale_sd": relative * abs(EXPONENTS.get(known.unknown or "", 1)) * scale,
        "centre_px": centre,
    }
    scaled = known.unknown is not None
    free, names = free_numbers(found.fixed, found.parts), result_names(known.unknown)
    x, y = centre
    in_units = numbers._replace(centre_x=x, centre_y=y, contact=disc)._asdict()
    gap = found.fixed.get("gap", gap)
    moving = tuple(name for name in free if scaled or name != "phase")
    parameters = {
        names[name]: _parameter(float(in_units[name]), sd, name not in free)
        for name, sd in sds._asdict().items()
        if name not in ("curvature", "phase") and (name in free or name in ("centre_x", "centre_y"))
    }
    common |= {
        "names": tuple(names[name] for name in moving),
        "covariance": block_of(spread, moving),
        "parameters": parameters,
    }
    if known.unknown is None or gap is None:
        common |= _on_the_mean(found, common, spread, units, moving)
        missing = " and ".join(name for name in EXPONENTS if name not in known.given)
        return common | {
            "status": "no-scale",
            "message": f"{missing} are not given; only one unknown can be measured, so the result is the fringe scale",
        }
    effects = {n: _effect(found, known, n) * values[known.unknown] / values[n] for n, sd in known.sd.items() if sd}
    budget = rows + [(name, abs(effects[name]) * sd) for name, sd in known.sd.items() if sd]
    if known.plate is not None:
        if reason := lensless(known.plate[0], values["radius"], 0.0):
            return common | {"status": "refused", "message": reason}
        budget, factor = _on_plate(known, values, budget)
        common["covariance"] = block_of(rescaled(spread, {"curvature": factor}), moving)
    total = float(np.sqrt(sum(sd**2 for _, sd in budget)))
    if known.plate is not None and 1.96 * total > values["radius"]:
        plate = f"with a plate radius of {known.plate[0]:g} m"
        reason = f"{plate} the curvature of the lens is zero within its standard deviation"
        return common | {"status": "refused", "message": reason}
    # The measured gap and contact are lengths in units of what is given.
    period_sd = np.hypot(relative_sd.get("wavelength", 0.0), relative_sd.get("gap_index", 0.0))
    gap_sd = float(np.hypot(sds.phase, gap * period_sd))
    if "contact_radius" in parameters:
        contact = parameters["contact_radius"]
        whole = np.hypot(contact.sd or 0.0, disc * relative_sd.get("pixel_size", 0.0))
        parameters["contact_radius"] = Parameter(disc, float(whole), contact.fixed)
    given = {name: Parameter(values[name], known.sd.get(name), True) for name in known.given}
    answer = {known.unknown: Parameter(values[known.unknown], total, False)}
    return common | {
        "status": "ok",
        "gap": gap,
        "contact_radius": disc if "contact" in found.parts else None,
        "parameters": answer | given | parameters | {"gap": _parameter(gap, gap_sd, "phase" not in free)},
        "budget": budget,
        **_radius(known, values, total, budget),
    }


def _on_plate(known: Quantities, values: dict[str, float], budget: list) -> tuple[list, float]:
    """The budget of a lens on a curved plate, and d radius / d effective radius; puts the lens's radius into `values`.

    The rings' radius is that of 1/R + 1/R_plate.
    """
    other, sd = known.plate or (np.inf, 0.0)
    effective = values["radius"]
    values["radius"] = 1 / (1 / effective - 1 / other)
    factor = (values["radius"] / effective) ** 2
    rows = [(source, factor * row) for source, row in budget]
    return [*rows, ("plate_radius", (values["radius"] / other) ** 2 * sd)], factor


def _on_the_mean(
    found: Fitted, common: dict, spread: np.ndarray, units: dict[str, float], moving: tuple[str, ...]
) -> dict:
    """Fringe scale, its deviation and the covariance, where the scale is that of the mean of the field."""
    numbers, scale = found.numbers, common["fringe_scale_per_px2"]
    mean, step, first = mean_scale(found, numbers), 1e-5, NUMBERS.index("curvature")
    slope = np.array(
        [
            (mean_scale(found, numbers + e) - mean_scale(found, numbers - e)) / (2 * step)
            for e in step * np.eye(len(numbers))
        ]
    )
    # Columns of the covariance are in units of the answer, the slope is per free number.
    change = np.eye(len(numbers))
    change[first] = scale * slope / np.array([units.get(name) or 1.0 for name in NUMBERS])
    change[first, first] += mean
    changed = change @ spread @ change.T
    beside = max(common["fringe_scale_sd"] ** 2 - spread[first, first], 0.0) * mean**2
    return {
        "fringe_scale_per_px2": scale * mean,
        "fringe_scale_sd": float(np.sqrt(max(changed[first, first], 0.0) + beside)),
        "covariance": block_of(changed, moving),
    }


def mean_scale(found: Fitted, numbers: np.ndarray) -> float:
    """What a distortion makes of the scale on the mean of the field: slope of the object's r² over the image's."""
    model = found.model
    if not isinstance(model, GapModel):
        return 1.0
    rows, columns = np.nonzero(found.left.weights[thin(found.left.weights > 0, 20_000)] > 0)
    step = thin(found.left.weights > 0, 20_000)[0].step
    x, y = found.reduced.grid.x[columns * step], found.reduced.grid.y[rows * step]
    at, unit, middle = Numbers(*numbers), model.frame.unit, model.frame.middle
    dx, dy = x - at.centre_x * unit - middle[0], y - at.centre_y * unit - middle[1]
    in_image = dx**2 + dy**2
    in_image = in_image - in_image.mean()
    return float(in_image @ gap_phase.squared_distance(model, x, y, numbers) / (in_image @ in_image))


def _disc(found: Fitted, values: dict[str, float]) -> tuple[float, float]:
    """Radius of a contact [m], or [px] without a scale, and its change per unit of the contact's number."""
    square, unit = float(Numbers(*found.numbers).contact), found.model.frame.unit * values.get("pixel_size", 1.0)
    if not square > 0:
        return 0.0, 0.0
    return float(np.sqrt(square)) * unit, unit / (2 * float(np.sqrt(square)))


def _parameter(value: float, sd: float, held: bool) -> Parameter:
    return Parameter(value, None if held else float(sd), held)


def _radius(known: Quantities, values: dict[str, float], total: float, budget) -> dict:
    if known.unknown != "radius":
        return {"radius": values["radius"], "radius_sd": known.sd.get("radius")}
    return {
        "radius": values["radius"],
        "radius_sd": total,
        "radius_interval": interval(values["radius"], total),
        "radius_sd_noise": budget[0][1],
    }


def _of_gap(model, known: Quantities, view: str, numbers: Numbers):
    """Values, change of the measured one per unit of the first free number, the gap [m], and the gap per turn."""
    unit2 = model.frame.unit**2
    scale = float(numbers.curvature) / unit2
    if known.unknown is None:
        return {"fringe_scale_per_px2": scale}, 1 / unit2, None, 1.0
    values = known.values(scale)
    slope = values[known.unknown] / EXPONENTS[known.unknown] / numbers.curvature
    period = values["wavelength"] / (2 * values["gap_index"])
    turns = numbers.phase - (0.5 if view == "reflected" else 0.0)
    gap = float(turns - np.round(turns)) * period
    return values | {"fringe_scale_per_px2": scale}, slope, gap, period


def _of_scene(model: SceneModel, known: Quantities, numbers: Numbers):
    """As `_of_gap`; the gap is the scene's with the fitted rise, known modulo half a wavelength in its medium."""
    scene = model.scene
    values = {**quantities_of(scene, model.face), "pixel_size": float(model.pixel_size)}
    slope, period = values[known.measured], values["wavelength"] / 2
    values[known.measured] *= 1 + float(numbers.curvature)
    scale = values["gap_index"] * values["pixel_size"] ** 2 / (values["radius"] * values["wavelength"])
    return values | {"fringe_scale_per_px2": scale}, slope, gap_height(scene) + float(numbers.phase) * period, period


def _effect(found: Fitted, known: Quantities, name: str) -> float:
    """Relative change of the measured quantity per relative change of a given one, at the optimum.

    -(JᵀJ)⁻¹ Jᵀ ∂r/∂p, the implicit function theorem for Gauss and Newton's normal equations, gives the change of the
    curvature; the phase's and the contrast's changes are central differences of 1e-5, small against a turn and
    large against rounding.
    """
    model, first = found.model, float(Numbers(*found.numbers).curvature)

    def fields(factor):
        free, moved = found.numbers, model
        if not isinstance(model, SceneModel):
            changed = replace(known, given={**known.given, name: known.given[name] * factor})
            moved = replace(model, sphere=changed.sphere(first / model.frame.unit**2), plate=changed.plate_curvature)
            if "gap" in found.fixed:
                turns = held_turns(found.fixed, changed) - held_turns(found.fixed, known)
                free = np.array(Numbers(*free)._replace(phase=Numbers(*free).phase + turns))
        elif name == "pixel_size":
            moved = replace(model, pixel_size=model.pixel_size * factor)
        else:
            moved = replace(model, scene=change(model.scene, name, factor, model.face))
        at = fringes_of(moved).fields(free)
        return at.phase, np.ones_like(at.phase) if at.contrast is None else at.contrast

    step = 1e-5
    (phase, contrast), (other, other_contrast) = fields(1 + step), fields(1 - step)
    bend, fade = (phase - other) / (2 * step), (contrast - other_contrast) / (contrast + other_contrast) / step
    crossed = bends(found.solution, bend[:, None], fade[:, None])[0][:, 0]
    moved = float(Numbers(*found.matrix.shift(crossed)).curvature)
    if isinstance(model, SceneModel):
        return moved / (1 + first)
    return (moved / first - EXPONENTS[name]) / EXPONENTS[known.measured]
