"""From free numbers to quantities: values, standard deviations and the budget of what is measured."""

from dataclasses import replace

import numpy as np

from fitting.estimate import Fitted, bends, fringes_of
from fitting.model import STRETCHES, free_numbers, shown_of
from fitting.parameters import (
    EXPONENTS,
    NUMBERS,
    TABLE,
    UNITS,
    Numbers,
    Parameter,
    Quantities,
    block_of,
    held_turns,
    interval,
    lensless,
    rescaled,
    result_names,
)
from fitting.photograph.meridians import Meridians, View, meridians_of
from fitting.photograph.model_rivals import LEAST, VIEW_OR_FORM
from fitting.reasons import Reason


def measured(
    fit: Fitted,
    known: Quantities,
    contact_phase: float,
    covariance: np.ndarray,
    rows: list[tuple[str, float]],
    view: View | None = None,
) -> dict:
    """The numbers of a `FitResult`, by name; `rows`: (source, deviation of the curvature) of the image itself.

    `view`: where it is given, the radius of elliptic rings is that of the mean curvature.
    """
    model, frame, meridians = fit.model, fit.model.frame, _meridians(fit, covariance, view)
    is_scaled = known.unknown is not None
    relative_effects = {name: _effect(fit, known, name) for name, sd in known.sd.items() if sd and is_scaled}
    numbers = Numbers(*fit.numbers)
    offsets = (numbers.centre_x, numbers.centre_y)
    centre = tuple(float(m + c * frame.unit) for m, c in zip(frame.middle, offsets, strict=True))
    values, slope, gap, period = model.answer(known, numbers, contact_phase)
    shown = shown_of(fit.parts, numbers, frame.unit * values.get("pixel_size", 1.0), is_scaled)
    relative_sd = {name: sd / known.given[name] for name, sd in known.sd.items()}
    units = {"curvature": slope, "centre_x": frame.unit, "centre_y": frame.unit, "phase": period}
    units |= {name: float(number.slope) for name, number in shown.items()}
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
    free = free_numbers(fit.fixed, fit.parts)
    names = result_names(known.unknown) | {name: number.name for name, number in shown.items()}
    in_units = dict(zip(("centre_x", "centre_y"), centre, strict=True))
    in_units |= {name: float(number.value) for name, number in shown.items()}
    gap = fit.fixed.get("gap", gap)
    moving = tuple(name for name in free if is_scaled or name != "phase")
    parameters = {
        names[name]: Parameter(
            in_units[name],
            float(getattr(sds, name)) if name in free else None,
            name not in free,
            names[name],
            UNITS.get(names[name], ""),
        )
        for name in NUMBERS
        if name in in_units
    }
    common |= {
        "names": tuple(names[name] for name in moving),
        "covariance": block_of(spread, moving),
        "parameters": parameters,
    }
    if known.unknown is None or gap is None:
        missing = " and ".join(name for name in EXPONENTS if name not in known.given)
        return common | {"status": "no-scale", "message": Reason.NO_SCALE(missing=missing)}
    effects = {name: share * values[known.unknown] / values[name] for name, share in relative_effects.items()}
    # A gap of index 1 is taken for one of air, and not for a measured one.
    unstated = [
        name for name in known.given if name not in known.sd and (name, known.given[name]) != ("gap_index", 1.0)
    ]
    percent = 0.01 * values[known.unknown] / EXPONENTS[known.unknown]
    per_percent = {name: abs(percent * EXPONENTS[name]) for name in unstated}
    budget = rows + [(name, abs(effects[name]) * sd) for name, sd in known.sd.items() if sd]
    radii = {}
    if meridians is not None:
        if known.unknown == "radius" and known.plate is None:
            deviation = float(np.linalg.norm([sd for source, sd in budget if source != VIEW_OR_FORM]))
            radii = meridians.parameters(values["radius"], deviation)
        if meridians.is_known:
            budget, factor = _of_mean_curvature(known, values, budget, meridians)
            per_percent = {name: factor * change for name, change in per_percent.items()}
            spread = rescaled(spread, {"curvature": factor})
            common["covariance"] = block_of(spread, moving)
    if known.plate is not None:
        if reason := lensless(known.plate[0], values["radius"], 0.0):
            return common | {"status": "refused", "message": reason}
        budget, factor = _on_plate(known, values, budget)
        per_percent = {name: factor * change for name, change in per_percent.items()}
        common["covariance"] = block_of(rescaled(spread, {"curvature": factor}), moving)
    total = float(np.sqrt(sum(sd**2 for _, sd in budget)))
    if known.plate is not None and 1.96 * total > values["radius"]:
        return common | {"status": "refused", "message": Reason.PLATE_LENS_FLAT(plate=known.plate[0])}
    # The measured gap and the parts' lengths are in units of what is given.
    period_sd = np.hypot(relative_sd.get("wavelength", 0.0), relative_sd.get("gap_index", 0.0))
    gap_sd = float(np.hypot(sds.phase, gap * period_sd))
    for number in shown.values():
        if TABLE[number.name].unit == "m":
            length = parameters[number.name]
            sd = np.hypot(length.sd or 0.0, length.value * relative_sd.get("pixel_size", 0.0))
            parameters[number.name] = replace(length, sd=float(sd))
    given = {name: Parameter(values[name], known.sd.get(name), True, name, UNITS[name]) for name in known.given}
    of_gap = Parameter(gap, gap_sd if "phase" in free else None, "phase" not in free, "gap", UNITS["gap"])
    answer = {known.unknown: Parameter(values[known.unknown], total, False, known.unknown, UNITS[known.unknown])}
    if known.unknown == "radius":
        radius = {
            "radius_sd": total,
            "radius_interval": interval(values["radius"], total),
            "radius_sd_noise": budget[0][1],
        }
    else:
        radius = {"radius_sd": known.sd.get("radius")}
    return common | {
        "status": "ok",
        "radius": values["radius"],
        "radius_sd": total if known.unknown == "radius" else known.sd.get("radius"),
        "gap": gap,
        "contact_radius": parameters["contact_radius"].value if "contact_radius" in parameters else None,
        "parameters": answer | given | radii | parameters | {"gap": of_gap},
        "budget": budget,
        "per_percent": per_percent,
        **radius,
    }


def _meridians(fit: Fitted, covariance: np.ndarray, view: View | None) -> Meridians | None:
    """The lens's two radii, where the rings are elliptic, or the view is given."""
    is_round = np.hypot(*(getattr(Numbers(*fit.numbers), name) for name in STRETCHES[0])) < LEAST
    if "oblique_view" not in fit.parts or (is_round and view is None):
        return None
    return meridians_of(fit.numbers, covariance, view)


def _of_mean_curvature(
    known: Quantities, values: dict[str, float], budget: list, meridians: Meridians
) -> tuple[list, float]:
    """The budget of the mean curvature's radius, and by what the measured quantity changes; puts it into `values`.

    The rings' radius is the geometric mean R of the two, that of the mean curvature R / cosh m.
    """
    flattening, deviation = meridians.flattening
    exponent = EXPONENTS[known.measured]
    factor = float(np.exp(flattening / exponent))
    values[known.measured] *= factor
    rows = [(source, factor * row) for source, row in budget]
    return [*rows, (VIEW_OR_FORM, values[known.measured] * deviation / abs(exponent))], factor


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


def _effect(fit: Fitted, known: Quantities, name: str) -> float:
    """Relative change of the measured quantity per relative change of a given one, at the optimum.

    -(JᵀJ)⁻¹ Jᵀ ∂r/∂p, the implicit function theorem for Gauss and Newton's normal equations, gives the change of the
    curvature; the phase's and the contrast's changes are central differences of 1e-5, small against a turn and
    large against rounding.
    """
    model, numbers = fit.model, Numbers(*fit.numbers)
    first = float(numbers.curvature)

    def fields(factor):
        quantities, held = replace(known, given={**known.given, name: known.given[name] * factor}), 0.0
        if model.holds_turns and "gap" in fit.fixed:
            held = held_turns(fit.fixed, quantities) - held_turns(fit.fixed, known)
        at = fringes_of(model.changed(quantities, numbers, name, factor)).fields(
            np.array(numbers._replace(phase=numbers.phase + held))
        )
        return at.phase, np.ones_like(at.phase) if at.contrast is None else at.contrast

    step = 1e-5
    (phase, contrast), (phase_below, contrast_below) = fields(1 + step), fields(1 - step)
    bend, fade = (phase - phase_below) / (2 * step), (contrast - contrast_below) / (contrast + contrast_below) / step
    crossed = bends(fit.solution, bend[:, None], fade[:, None])[0][:, 0]
    return model.effect(known, first, float(Numbers(*fit.matrix.shift(crossed)).curvature), name)
