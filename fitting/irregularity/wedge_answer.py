"""From a wave in pixels to spacing, angle and thickness with their budget."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from fitting.irregularity.disc import Pupil
from fitting.irregularity.straight import StraightFit
from fitting.irregularity.wedge_model import Wedge
from fitting.irregularity.wedge_photo_result import UNITS, WedgePhoto
from fitting.parameters import CameraScale, Parameter, interval
from fitting.reasons import Reason
from fitting.sheet_reasons import SheetReason

# A wedge is thinner than long.
_LARGEST_ANGLE = np.pi / 4
# The rms of a coordinate over the unit disc: the change of the fringes at a place like any.
_RMS = 0.5
# Width of a fringe [px] below which sampling is said; inflation of the noise beyond which it is said.
_FINE, _CORRELATED = 3.0, 1.5

Budget = list[tuple[str, float]]


class Request(NamedTuple):
    """What is given beside the photograph: values in SI, and their standard deviations, relative ones, by name."""

    values: dict[str, float | None]
    relative_sds: dict[str, float]
    scale: CameraScale | None


def answer_of(blank: WedgePhoto, straight: StraightFit, wedge: Wedge, request: Request) -> WedgePhoto:
    """The result of a wave; `blank` has the photograph, the pupil and its warnings."""
    wavelength, pixel_size = request.values["wavelength"], request.values["pixel_size"]
    pupil = blank.pupil or Pupil(0.0, 0.0, 1.0)
    numbers, budget = _in_pixels(wedge)
    if pixel_size is not None:
        budget.append(("pixel_size", request.relative_sds["pixel_size"]))
        numbers |= _with_interval("spacing", numbers["spacing_px"] * pixel_size, _total(budget))
    if pixel_size is not None and wavelength is not None:
        slope = wavelength / (2 * (request.values["gap_index"] or 1.0) * numbers["spacing"])
        if slope > np.tan(_LARGEST_ANGLE):
            return replace(blank, message=Reason.WEDGE_TOO_STEEP(spacing=numbers["spacing"]))
        budget += [(name, request.relative_sds[name]) for name in ("wavelength", "gap_index")]
        numbers |= _of_angle(slope, budget, request)
    missing = [name.replace("_", " ") for name in ("wavelength", "pixel_size") if request.values[name] is None]
    return replace(
        blank,
        status="no-scale" if missing else "ok",
        message=SheetReason.NO_ANGLE(missing=" and ".join(missing)) if missing else "",
        **numbers,
        change=wedge.relative_change,
        budget=[(source, sd) for source, sd in budget if sd],
        fringes=2 * pupil.radius * wedge.frequency,
        explained=straight.fit.explained,
        agreement=straight.agreement,
        inflation=straight.inflation,
        coefficients=straight.fit.coefficients.tolist(),
        parameters=_parameters(numbers, request),
        model=_model(straight, wedge, request),
        warnings=[*blank.warnings, *_warnings(straight, wedge, request, blank)],
    )


def _in_pixels(wedge: Wedge) -> tuple[dict[str, Any], Budget]:
    """Spacing and direction in the picture, and where the spacing's deviation comes from."""
    total, noise = wedge.relative_sd(wedge.covariance), wedge.relative_sd(wedge.held_covariance)
    # Of what bends the fringes, what it does to the spacing, and to the direction.
    along = np.array([-wedge.normal[1], wedge.normal[0]])
    change, turn = (_RMS * float(np.linalg.norm(wedge.change @ way)) / wedge.frequency for way in (wedge.normal, along))
    distortion = float(np.sqrt(max(total**2 - noise**2, 0.0)))
    budget = [("noise", noise), ("distortion", distortion), ("bend", change if wedge.is_bent else 0.0)]
    normal = wedge.normal if wedge.normal[0] >= 0 else -wedge.normal
    numbers = {
        "spacing_px": 1 / wedge.frequency,
        "spacing_px_sd": _total(budget) / wedge.frequency,
        "direction": float(np.arctan2(normal[1], normal[0])),
        "direction_sd": float(np.hypot(wedge.direction_sd, turn if wedge.is_bent else 0.0)),
        "distortion": wedge.distortion,
        "distortion_sd": wedge.distortion_sd,
    }
    return numbers, budget


def _of_angle(slope: float, budget: Budget, request: Request) -> dict[str, Any]:
    """Angle, and thickness where a length is given, whose deviation joins the budget."""
    angle, length = float(np.arctan(slope)), request.values["length"]
    # d tan α = dα / cos² α.
    numbers = _with_interval("wedge_angle", angle, slope / (1 + slope**2) / angle * _total(budget))
    if length is None:
        return numbers
    budget.append(("length", request.relative_sds["length"]))
    return numbers | _with_interval("thickness", length * slope, _total(budget))


def _with_interval(name: str, value: float, relative_sd: float) -> dict[str, Any]:
    sd = value * relative_sd
    return {name: value, f"{name}_sd": sd, f"{name}_interval": interval(value, sd)}


def _total(budget: Budget) -> float:
    return float(np.linalg.norm([sd for _, sd in budget]))


def _parameters(numbers: dict[str, Any], request: Request) -> dict[str, Parameter]:
    """What was measured and given, by name."""
    rows = {
        name: Parameter(numbers[name], numbers[f"{name}_sd"], False, name, unit)
        for name, unit in UNITS.items()
        if name in numbers
    }
    for name, unit in {"wavelength": "m", "pixel_size": "m", "gap_index": "", "length": "m"}.items():
        value = request.values[name]
        if value is not None:
            rows[name] = Parameter(float(value), value * request.relative_sds[name], True, name, unit)
    return rows


def _model(straight: StraightFit, wedge: Wedge, request: Request) -> dict[str, str]:
    index = request.values["gap_index"] or 1.0
    source = "free" if request.scale is None or request.scale.distortion is None else "expected as the scale has it"
    bend = "beyond noise" if wedge.is_bent else "within noise"
    return {
        "fringes": f"straight; their phase is confirmed in {straight.agreement:.0%} of the circle",
        "wedge": f"tan α = λ / (2 n s), index {index:g}, seen along the normal",
        "bend": f"a quadratic beside the straight fringes, {wedge.relative_change:.2%} at the rim, {bend}",
        "distortion": f"radial about the picture's middle, {source}",
        "illumination": "background and contrast smooth, of degree 6 and 4",
    }


def _warnings(straight: StraightFit, wedge: Wedge, request: Request, blank: WedgePhoto) -> list[str]:
    texts: list[str] = []
    values, relative = request.values, request.relative_sds
    exact = [name for name in ("wavelength", "pixel_size", "length") if values[name] is not None and not relative[name]]
    # Without both of these the answer is the spacing in pixels, which depends on none.
    if exact and None not in (values["wavelength"], values["pixel_size"]):
        texts.append(Reason.TREATED_AS_EXACT(names=", ".join(exact)))
    if wedge.is_bent:
        texts.append(SheetReason.WEDGE_BENT(change=wedge.relative_change))
    if straight.inflation > _CORRELATED:
        texts.append(Reason.CORRELATED_RESIDUALS(inflation=straight.inflation))
    if 1 / wedge.frequency < _FINE:
        texts.append(Reason.NEAR_SAMPLING_LIMIT(width=1 / wedge.frequency))
    if request.scale is not None and blank.photograph is not None:
        texts += request.scale.size_warning(blank.photograph.image.shape)
    return texts
