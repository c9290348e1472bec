"""The result of a fit of all channels under light of several lines, or of given curves."""

from typing import Any

import numpy as np

from fitting.colour import ColourFit, ColourReason, Distortion, fitted_images, gap_at_centre, measure, rings_in
from fitting.parameters import EXPONENTS, TABLE, Parameter, interval
from fitting.photo import Photograph, Rings, read_channels
from fitting.photograph.light_verdict import LightVerdict, verdict_on_light
from fitting.photograph.light_words import LampLight
from fitting.photograph.picture import DrawnPicture
from fitting.photograph.result import FitResult
from fitting.photograph.task import Task
from fitting.reasons import Reason

NAMES = {"red": 0, "green": 1, "blue": 2, "grey": 1}
_CURVES = "lamp and camera curves"
# Channels by themselves that scatter so many times as their noise.
_SCATTERED = 3.0
_CERTAIN = 0.99
# Share of the largest lit area that a channel must have.
_LEAST_LIT = 0.5
# Of a JPEG's fringe scale (the rms error of made ones, experiments/truth/colour_pairs.py): its channels have the fine
# rings of their mean. Whatever else is in the budget, it is no better.
_COMPRESSED = 5.5e-4


def fit_channels(task: Task, rings: Rings, light: LampLight, arguments: dict[str, Any]) -> FitResult:
    """One radius, pixel size or fringe scale of all channels; `task` has the light's reference for a wavelength."""
    source, transfer, mask, page = (arguments[name] for name in ("image", "transfer", "mask", "page"))
    channels = read_channels(source, transfer, mask, page)
    _check_response(channels, light)
    photographs = with_light(channels)
    fit = measured_under(task, rings, photographs, light)
    stated = task.quantities.sd.get("wavelength")
    verdict = verdict_on_light(fit, rings.scale, light, None if stated is None else stated / light.reference)
    of_photograph = [*task.photograph.warnings, *_dark(channels, photographs)]
    common = {
        "measured": task.quantities.unknown or "radius",
        "warnings": [*of_photograph, *verdict.warnings, *_warnings(task, fit, photographs)],
        "explained_variance": float(fit.explained.mean()),
        "model": _model(fit, photographs, verdict),
    }
    if verdict.reason:
        return FitResult("refused", verdict.reason, **common)
    numbers = _numbers(task, fit, photographs, light, verdict.wavelength_sd)
    picture = _picture(task.photograph, photographs, fit, light)
    return FitResult(**numbers, picture=picture, **common)


def _check_response(channels: tuple[Photograph, ...], light: LampLight) -> None:
    """Raises ValueError for a response of more or fewer channels than the image has."""
    if light.curves is not None and len(light.curves.response.curves) != len(channels):
        raise ValueError(
            f"response has {len(light.curves.response.curves)} channels, and the image {len(channels)}; allowed: a "
            "curve for each, red, green and blue, or one for a grey image"
        )


def with_light(channels: tuple[Photograph, ...]) -> tuple[Photograph, ...]:
    """The channels that a lamp lights: a yellow one leaves blue black, with nothing to measure."""
    areas = [0 if channel.is_uniform else int(np.count_nonzero(channel.image[channel.lit] > 0)) for channel in channels]
    return tuple(channel for channel, area in zip(channels, areas, strict=True) if area >= _LEAST_LIT * max(areas))


def _dark(channels: tuple[Photograph, ...], photographs: tuple[Photograph, ...]) -> list[str]:
    """What is said of the channels that are not measured."""
    lit = {photograph.channel for photograph in photographs}
    names = [channel.channel for channel in channels if channel.channel not in lit]
    return [ColourReason.CHANNELS_DARK(channels=" and ".join(names))] if names else []


def measured_under(task: Task, rings: Rings, photographs: tuple[Photograph, ...], light: LampLight) -> ColourFit:
    """The fit of all channels under a light; its sphere has the pixel size that is given, or follows from a radius."""
    quantities, index = task.quantities, task.quantities.given.get("gap_index", 1.0)
    pixel_size = 0.0 if quantities.unknown is None else quantities.values(rings.scale)["pixel_size"]
    sign = -1.0 if task.contact_phase else 1.0
    channels = tuple(NAMES[photograph.channel] for photograph in photographs)
    rings_of_channels = rings_in(photographs, rings, pixel_size * index, sign, channels)
    return measure(rings_of_channels, light.lines if light.curves is None else light.curves)


def fringe_scale(fit: ColourFit, light: LampLight) -> float:
    """N s²/(R λ) of the light's reference line [1/px²]."""
    return 2 * float(np.exp(fit.fit.optimum.curve.log_rate)) / light.reference


def scatter_of_channels(fit: ColourFit) -> tuple[float, float]:
    """Standard deviation of the channels' mean log rate by their scatter beyond noise, and scatter over noise."""
    if len(fit.by_channel) < 2:
        return 0.0, 0.0
    rates, sds = (np.array([getattr(channel, name) for channel in fit.by_channel]) for name in ("log_rate", "sd"))
    weights = 1 / sds**2
    mean = np.average(rates, weights=weights)
    chi2 = float(weights @ (rates - mean) ** 2) / (len(rates) - 1)
    return float(np.sqrt(max(chi2 - 1, 0.0) / weights.sum())), float(np.sqrt(chi2))


def _rows(fit: ColourFit, photographs: tuple[Photograph, ...]) -> list[tuple[str, float]]:
    """Relative standard deviations of the fringe scale, by source: each row is what those before it do not show."""
    by_channels, _ = scatter_of_channels(fit)
    may_be_jpeg = len(photographs) > 1 and photographs[0].transfer == "srgb"
    of_light = float(np.hypot(fit.spread, _beyond(by_channels, fit.spread)))
    return [
        ("noise", fit.deviation),
        ("models of the light", fit.spread),
        ("distortion", fit.distortion.spread),
        ("channels", _beyond(by_channels, fit.spread)),
        ("compression", _beyond(_COMPRESSED, float(np.hypot(fit.deviation, of_light))) if may_be_jpeg else 0.0),
    ]


def _beyond(deviation: float, shown: float) -> float:
    """What a standard deviation has beyond another one of the same error."""
    return float(np.sqrt(max(deviation**2 - shown**2, 0.0)))


def _numbers(
    task: Task, fit: ColourFit, photographs: tuple[Photograph, ...], light: LampLight, wavelength_sd: float
) -> dict[str, Any]:
    """The numbers of a `FitResult`, by name; `wavelength_sd`: relative, of all wavelengths of the light together."""
    quantities, scale = task.quantities, fringe_scale(fit, light)
    rows = [(source, sd) for source, sd in _rows(fit, photographs) if sd]
    relative = float(np.sqrt(sum(sd**2 for _, sd in rows)))
    figure = fit.rings.placed.figure
    index = quantities.given.get("gap_index", 1.0)
    common = {
        "fringe_scale_per_px2": scale,
        "fringe_scale_sd": relative * scale,
        "centre_px": (figure.x, figure.y),
        "gap": gap_at_centre(fit.fit) / index,
    }
    parameters = {
        "centre_x_px": Parameter(figure.x, None, False, "centre_x_px", "px"),
        "centre_y_px": Parameter(figure.y, None, False, "centre_y_px", "px"),
        "stretch": Parameter(figure.stretch, None, False, "stretch", ""),
        "shear": Parameter(figure.shear, None, False, "shear", ""),
        "gap": Parameter(common["gap"], None, False, "gap", "m"),
        "blur_px": Parameter(abs(fit.fit.optimum.curve.blur), None, False, "blur_px", "px"),
    }
    if quantities.unknown is None:
        missing = " and ".join(name for name in EXPONENTS if name not in quantities.given)
        message = Reason.NO_SCALE(missing=missing)
        return common | {"status": "no-scale", "message": message, "parameters": parameters}
    values, unknown = quantities.values(scale), quantities.unknown
    factor = values[unknown] / abs(EXPONENTS[unknown])
    budget = [(source, factor * sd) for source, sd in rows]
    # Of the fringe scale it is none: this is over the light's own wavelength.
    budget += [(_CURVES, factor * wavelength_sd)] if wavelength_sd else []
    for name, sd in quantities.sd.items():
        budget.append((name, factor * abs(EXPONENTS[name]) * sd / values[name]))
    total = float(np.sqrt(sum(sd**2 for _, sd in budget)))
    unit = TABLE[unknown].unit
    answer = {unknown: Parameter(values[unknown], total, False, unknown, unit)}
    held = {}
    for name in quantities.given:
        held[name] = Parameter(values[name], quantities.sd.get(name), True, name, TABLE[name].unit)
    by_channel = _by_channel(fit, photographs, values[unknown], unknown, unit)
    radius_sd = total if unknown == "radius" else quantities.sd.get("radius")
    unstated = [name for name in quantities.given if name not in quantities.sd and name in ("pixel_size", "radius")]
    return common | {
        "status": "ok",
        "radius": values["radius"],
        "radius_sd": radius_sd,
        "radius_interval": interval(values["radius"], total) if unknown == "radius" else None,
        "radius_sd_noise": budget[0][1] if unknown == "radius" else None,
        "budget": budget,
        "per_percent": {name: 0.01 * factor * abs(EXPONENTS[name]) for name in unstated},
        "parameters": answer | held | by_channel | parameters,
    }


def _by_channel(
    fit: ColourFit, photographs: tuple[Photograph, ...], value: float, unknown: str, unit: str
) -> dict[str, Parameter]:
    """The measured quantity of each channel by itself."""
    if len(fit.by_channel) < 2:
        return {}
    power, parameters = 1 / EXPONENTS[unknown], {}
    for photograph, channel in zip(photographs, fit.by_channel, strict=True):
        name = f"{unknown}_{photograph.channel}"
        change = channel.log_rate - fit.fit.optimum.curve.log_rate
        separate = value * float(np.exp(power * change))
        parameters[name] = Parameter(separate, abs(power) * channel.sd * separate, False, name, unit)
    return parameters


def _warnings(task: Task, fit: ColourFit, photographs: tuple[Photograph, ...]) -> list[str]:
    warnings: list[str] = []
    quantities = task.quantities
    if fit.clipped:
        channels = " and ".join(photographs[number].channel for number in fit.clipped)
        warnings.append(ColourReason.CHANNELS_CLIPPED(channels=channels))
    if quantities.unknown and "pixel_size" in quantities.given and "pixel_size" not in quantities.sd:
        warnings.append(Reason.TREATED_AS_EXACT(names="pixel_size"))
    _, deviations = scatter_of_channels(fit)
    rates = [channel.log_rate for channel in fit.by_channel]
    if deviations > _SCATTERED and np.ptp(rates) > 0.003:
        measured = quantities.unknown or "fringe scale"
        spread = float(np.ptp(rates))
        warnings.append(ColourReason.CHANNELS_DISAGREE(spread=spread, measured=measured, deviations=deviations))
    if (probability := fit.order_odds[0]) < _CERTAIN:
        warnings.append(ColourReason.GAP_ORDER_OPEN(probability=probability))
    return warnings


def _model(fit: ColourFit, photographs: tuple[Photograph, ...], verdict: LightVerdict) -> dict[str, str]:
    lateral = {variant.name: variant.shift for variant in fit.variants}
    variants = "; ".join(f"{name} {shift:+.2%}" for name, shift in lateral.items())
    shares = zip(photographs, fit.explained, strict=True)
    explained = ", ".join(f"{photograph.channel} {share:.1%}" for photograph, share in shares)
    return {
        "fringes": "2 n t at normal incidence, exact sphere, one for all channels",
        **verdict.model,
        "explained": explained,
        "distortion": _words_of(fit.distortion),
        "variants": f"relative change of the fringe scale: {variants}",
        "gap order": f"probability {fit.order_odds[0]:.0%}",
        "blur": "a Gaussian one; a width of the lines fades the rings alike",
        "aperture": "taken as 0: with a numerical aperture of 0.1 the radius is 0.25 % smaller",
    }


def _words_of(distortion: Distortion) -> str:
    is_in = "in the model" if distortion.is_in else "not in the model"
    return f"of the camera, {is_in}: probability {distortion.probability:.0%}, fringe scale {distortion.shift:+.2%}"


def _picture(
    photograph: Photograph, photographs: tuple[Photograph, ...], fit: ColourFit, light: LampLight
) -> DrawnPicture:
    """The channel that was clearest, at every pixel."""
    names = [channel.channel for channel in photographs]
    number = names.index(photograph.channel)
    height, width = photograph.mask.shape
    fitted, phase, holds = fitted_images(fit, number, (height, width), light.reference)
    weights = (holds & photograph.mask).astype(float)
    return DrawnPicture(photographs[number], fitted, phase, weights)
