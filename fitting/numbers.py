"""From free numbers to quantities: values, standard deviations and the budget of what is measured."""

from dataclasses import replace

import numpy as np

from fitting import least_squares as ls
from fitting.models import SceneModel, as_arrays, change, localize
from fitting.moments import model_coefficients, residuals
from fitting.quantity import EXPONENTS, Quantities
from fitting.result import Parameter, interval
from fitting.scene_start import gap_height
from newtonjax.gap import required_gap


def measured(found, known: Quantities, view: str, covariance: np.ndarray) -> dict:
    """The numbers of a `FitResult`, by name (`found`: a `fitting.measure.Fitted`)."""
    model, frame = found.model, found.model.frame
    free = np.asarray(found.solution.unknowns.model)
    centre = tuple(float(m + c * frame.unit) for m, c in zip(frame.middle, free[1:3], strict=True))
    if isinstance(model, SceneModel):
        values, slope, gap, period = _of_scene(model, known, free)
    else:
        values, slope, gap, period = _of_gap(model, known, view, free)
    jacobian = np.diag([slope, frame.unit, frame.unit, period])
    spread = jacobian @ covariance[:4, :4] @ jacobian.T
    sds = np.sqrt(np.clip(np.diag(spread), 0, None))
    scale = values["fringe_scale_per_px2"]
    relative = sds[0] / values[known.unknown or "fringe_scale_per_px2"]
    place = zip(("centre_x_px", "centre_y_px"), centre, sds[1:3], strict=True)
    common = {
        "fringe_scale_per_px2": scale,
        "fringe_scale_sd": float(relative * abs(EXPONENTS.get(known.unknown or "", 1)) * scale),
        "centre_px": centre,
    }
    parameters = {name: Parameter(value, float(sd), False) for name, value, sd in place}
    if known.unknown is None or gap is None:
        missing = " and ".join(name for name in ("wavelength", "pixel_size") if name not in known.given)
        return common | {
            "status": "no-scale",
            "message": f"without {missing} there is no radius: the fringe scale is the answer",
            "parameters": parameters,
            "names": ("fringe_scale_per_px2", *parameters),
            "covariance": spread[:3, :3],
        }
    effects = {name: _effect(found, known, name) * values[known.unknown] / values[name] for name in known.sd}
    budget = [("noise", float(sds[0]))] + [(name, abs(effects[name]) * sd) for name, sd in known.sd.items()]
    total = float(np.sqrt(sum(sd**2 for _, sd in budget)))
    given = {name: Parameter(values[name], known.sd.get(name), True) for name in known.given}
    answer = {known.unknown: Parameter(values[known.unknown], total, False)}
    return common | {
        "status": "ok",
        "gap": gap,
        "parameters": answer | given | parameters | {"gap": Parameter(gap, float(sds[3]), False)},
        "names": (known.unknown, *parameters, "gap"),
        "covariance": spread,
        "budget": budget,
        **_radius(known, values, total, budget),
    }


def _radius(known: Quantities, values: dict[str, float], total: float, budget) -> dict:
    if known.unknown != "radius":
        return {"radius": values["radius"], "radius_sd": known.sd.get("radius")}
    return {
        "radius": values["radius"],
        "radius_sd": total,
        "radius_interval": interval(values["radius"], total),
        "radius_sd_noise": budget[0][1],
    }


def _of_gap(model, known: Quantities, view: str, free: np.ndarray):
    """Values, change of the measured one per unit of the first free number, the gap [m], and the gap per turn."""
    unit2 = model.frame.unit**2
    scale = float(free[0]) / unit2
    if known.unknown is None:
        return {"fringe_scale_per_px2": scale}, 1 / unit2, None, 1.0
    values = known.values(scale)
    slope = values[known.unknown] / EXPONENTS[known.unknown] / free[0]
    period = values["wavelength"] / (2 * values["index"])
    turns = free[3] - (0.5 if view == "reflected" else 0.0)
    gap = float(turns - np.round(turns)) * period
    return values | {"fringe_scale_per_px2": scale}, slope, gap, period


def _of_scene(model: SceneModel, known: Quantities, free: np.ndarray):
    """As `_of_gap`; the gap is the scene's with the fitted rise, known modulo half a wavelength in its medium."""
    scene = model.scene
    values = {
        "radius": abs(1 / float(scene.surfaces[model.face].curvature)),
        "wavelength": float(scene.wavelength),
        "pixel_size": float(model.pixel_size),
        "index": float(scene.media[required_gap(scene) + 1]),
    }
    slope, period = values[known.measured], values["wavelength"] / 2
    values[known.measured] *= 1 + float(free[0])
    scale = values["index"] * values["pixel_size"] ** 2 / (values["radius"] * values["wavelength"])
    return values | {"fringe_scale_per_px2": scale}, slope, gap_height(scene) + float(free[3]) * period, period


def _effect(found, known: Quantities, name: str) -> float:
    """Relative change of the measured quantity per relative change of a given one, at the optimum.

    For the gap formula by its exponents. For a bench by -pinv(J) ∂r/∂p, the implicit function theorem for Gauss and
    Newton's normal equations; ∂r/∂p is a central difference of 1e-5, small against a turn and large against rounding.
    """
    if not isinstance(found.model, SceneModel):
        return -EXPONENTS[name] / EXPONENTS[known.measured]
    unknowns, model = found.solution.unknowns, found.model

    def left(factor):
        if name == "pixel_size":
            moved = replace(model, pixel_size=model.pixel_size * factor)
        else:
            moved = replace(model, scene=change(model.scene, name, factor, model.face))
        image = ls.fields(localize(as_arrays(moved), unknowns.model), unknowns)
        return np.asarray(residuals(found.kept, model_coefficients(*image, found.kept.reference)))

    step = 1e-5
    slope = (left(1 + step) - left(1 - step)) / (2 * step)
    jacobian = np.asarray(found.solution.jacobian)[:, np.asarray(found.solution.active)]
    return float(-np.linalg.lstsq(jacobian, slope, rcond=1e-12)[0][0]) / (1 + float(unknowns.model[0]))
