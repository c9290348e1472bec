"""Whether the rings of all channels are those of the light that was given, and what that light may be off by."""

from typing import NamedTuple

import numpy as np

from fitting.colour import BANDS_ALONE, ONE_LINE, ColourFit, ColourReason, misfit, odds_of_lamps
from fitting.photograph.light_words import LampLight
from newtonjax.numerics import Statement

# Odds (natural logarithm) that lines need over bands alone, and several lines over a single one; and at which another
# lamp is believed instead.
_LEAST_ODDS, _SEVERAL_LINES, _OTHER_LAMP = 5.0, 40.0, 30.0
# Relative standard deviation of all wavelengths of given curves together, where none is stated: rings do not tell it.
_USUAL = 0.008


class LightVerdict(NamedTuple):
    """What the rings say of the light.

    - `reason`: why it is not that of the rings; None where it is.
    - `model`: words of the model, by name; `warnings`.
    - `wavelength_sd`: relative standard deviation of all its wavelengths together, beyond what is stated.
    """

    reason: Statement | None
    model: dict[str, str]
    warnings: tuple[str, ...] = ()
    wavelength_sd: float = 0.0


def verdict_on_light(fit: ColourFit, scale: float, light: LampLight, stated: float | None) -> LightVerdict:
    """Of a fit under lines or under curves.

    `scale`: of the search's rings [turns per px²]; `stated`: relative standard deviation of the wavelengths of curves.
    """
    return _on_lines(fit, scale, light) if light.curves is None else _on_curves(fit, light, stated)


def _on_lines(fit: ColourFit, scale: float, light: LampLight) -> LightVerdict:
    odds = odds_of_lamps(fit.fit, scale)
    no_lamps = (ONE_LINE, BANDS_ALONE)
    lamps = [*(name for name in odds if name not in no_lamps), *no_lamps]
    model = {
        "light": f"lines of {light.words} nm and bands, amplitudes of 0 or more, free in each channel",
        "lamps": "logarithms of the odds against this light: "
        + ", ".join(f"{name} {round(odds[name]):+d}" for name in lamps),
    }
    return LightVerdict(doubt_of(odds, light, fit.fit.problem.palette.lines), model)


def doubt_of(odds: dict[str, float], light: LampLight, components: int) -> Statement | None:
    """Why the lines that were given are not those of the rings; None where they are.

    `components`: of the light that the rings tell apart. Of one alone nothing tells that it is not another's.
    """
    lamps = {name: value for name, value in odds.items() if name not in (BANDS_ALONE, ONE_LINE)}
    best = max(lamps, key=lambda name: lamps[name])
    # What tells single lines apart is bands beside them alone, which the model has by chance.
    limit = _OTHER_LAMP if components > 1 else 2 * _OTHER_LAMP
    if lamps[best] > limit:
        return ColourReason.ANOTHER_LAMP(best=best, lines=light.words, odds=odds[best])
    if -odds[BANDS_ALONE] < _LEAST_ODDS:
        return ColourReason.LINES_NOT_SEEN(odds=-odds[BANDS_ALONE], least=_LEAST_ODDS)
    if components > 1 and -odds[ONE_LINE] < _SEVERAL_LINES:
        return ColourReason.ONE_LINE_SEEN(odds=-odds[ONE_LINE], least=_SEVERAL_LINES)
    return None


def _on_curves(fit: ColourFit, light: LampLight, stated: float | None) -> LightVerdict:
    size = misfit(fit.fit)
    curve, free = fit.fit.optimum.curve, fit.fit.problem.free
    changes = [f"{name.replace('_', ' of ')} {getattr(curve, name):+.2f}" for name in free if name.startswith("tilt")]
    model = {
        "light": f"lamp times camera, channels of {light.words} nm in the mean, each times exp(tilt x - curvature x²), "
        "x in 50 nm from its mean",
        "curves": f"{', '.join(changes)}; left over beyond noise: {size.share:.1e} of the fringes' variance, "
        f"{size.worst:.1e} in the worst channel",
    }
    by_rings = size.wavelength_sd
    if by_rings is None:
        return LightVerdict(ColourReason.OTHER_CURVES(share=size.share, change=size.change), model)
    if by_rings >= _USUAL:
        warnings = (ColourReason.CURVES_OFF(share=size.share, change=size.change, sd=by_rings),)
    else:
        warnings = () if stated is not None else (ColourReason.WAVELENGTHS_ASSUMED(sd=_USUAL),)
    sd = max(by_rings, _USUAL) if stated is None else by_rings
    return LightVerdict(None, model, warnings, float(np.sqrt(max(sd**2 - (stated or 0.0) ** 2, 0.0))))
