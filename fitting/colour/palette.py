"""What the light of a channel may be made of: lines of a lamp, and bands."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from fitting.colour.waveform import Curve
from newtonjax.scene import LAMPS, PROFILES, Spectrum

# Lines weaker than this over the strongest are not looked for: lamps' catalogued strengths are rough.
_WEAKEST = 0.03
# A line is narrower than this [m].
_LINE = 2e-9
# Bands of phosphors, continua and filters, as a non-negative sum of Gaussian ones: middles and full width [m].
BANDS, BAND_WIDTH = np.arange(400e-9, 721e-9, 20e-9), 45e-9
# Full widths of bands that do as well [m].
_OTHER_WIDTHS = (30e-9, 70e-9)
# Lines that part by less over all rings [turns] are one; standard deviation of its mean over the rms of its lines: what
# a thin vapour (2 : 1 of sodium) and a dense one (1 : 1) make of them.
_TOLD_APART, _RATIO_SD = 0.25, 0.2
# A wavelength is a lamp's line within the first; lines further from it than the second beat with it [m].
_SAME, _APART, _VISIBLE = 0.3e-9, 5e-9, (400e-9, 700e-9)


class Lines(NamedTuple):
    """Lines of a lamp that a photograph may show: wavelengths [m], and rough powers in any unit."""

    wavelengths: Float[np.ndarray, " lines"]
    powers: Float[np.ndarray, " lines"]


class Palette(NamedTuple):
    """Components of light: sums of waves.

    - `wavelengths` [m] and full widths at half maximum of Gaussian profiles [m], [waves].
    - `shares`: of the waves in each component [waves, components]; those of the lines come first.
    - `tilt`: what these change by, per standard deviation of the unknown ratio of close lines [waves, components].
    - `lines`: how many components are lines, or lines too close to be told apart.
    """

    wavelengths: Float[np.ndarray, " waves"]
    widths: Float[np.ndarray, " waves"]
    shares: Float[np.ndarray, "waves components"]
    tilt: Float[np.ndarray, "waves components"]
    lines: int = 0

    @property
    def middles(self) -> Float[np.ndarray, " lines"]:
        """Mean wavelengths of the components that are lines [m]."""
        return self.wavelengths @ self.shares[:, : self.lines]

    def free(self, _channels: tuple[int, ...], /) -> tuple[str, ...]:
        """Names of the curve's numbers that change the light."""
        return ("balance",) if self.tilt.any() else ()

    def shares_in(self, curve: Curve, _channel: int, /) -> Float[np.ndarray, "waves components"]:
        """Of the waves in each component, alike in all channels."""
        return self.shares + curve.balance * self.tilt

    def variants(self) -> dict[str, "Palette"]:
        """Other palettes that do as well, by name: with narrower and wider bands."""
        return {f"bands of {1e9 * width:.0f} nm": with_bands(self, width) for width in _OTHER_WIDTHS}


def lines_of(spectrum: Spectrum) -> Lines:
    """The lines of a light that a photograph may show; none of a continuous one."""
    wavelengths, weights = np.asarray(spectrum.wavelengths, float), np.asarray(spectrum.weights, float)
    # What is sampled has samples in place of lines.
    sharp = np.full(len(weights), spectrum.triangle is None)
    for profile in PROFILES:
        if (width := getattr(spectrum, profile)) is not None:
            sharp &= np.asarray(width) < _LINE
    strong = sharp & (weights >= _WEAKEST * weights.max())
    return Lines(wavelengths[strong], weights[strong])


def lines_of_lamp(name: str) -> Lines:
    """A named lamp's lines that a photograph may show, in air."""
    wavelengths, powers = np.array(LAMPS[name]).T
    strong = powers >= _WEAKEST * powers.max()
    return Lines(1e-9 * wavelengths[strong], powers[strong])


def lamp_of_line(wavelength: float) -> str | None:
    """The lamp that has a wavelength in air [m], and visible lines apart from it; None where there is none."""
    for name in LAMPS:
        lines = lines_of_lamp(name).wavelengths
        distance = np.abs(lines[(lines > _VISIBLE[0]) & (lines < _VISIBLE[1])] - wavelength)
        if np.any(distance < _SAME) and np.any(distance > _APART):
            return name
    return None


def of_lamp(lines: Lines | None, turns: float, band_width: float = BAND_WIDTH) -> Palette:
    """The lines of a lamp and bands, or bands alone.

    Lines whose fringes part by less than a quarter of a turn over `turns`, those that the photograph holds, are one
    component, in the ratio of the lamp's powers: their sum alone is seen, and its wavelength would go with the rate.
    """
    groups = [] if lines is None else _groups(lines, turns)
    places = [at for group in groups for at in group]
    count, middle = len(places), len(places) + len(BANDS)
    shares, tilt = (np.zeros((middle, len(groups) + len(BANDS))) for _ in range(2))
    shares[count:, len(groups) :] = np.eye(len(BANDS))
    wavelengths, first = BANDS, 0
    if lines is not None:
        wavelengths = np.concatenate([lines.wavelengths[places], BANDS])
        for k, group in enumerate(groups):
            rows = slice(first, first + len(group))
            shares[rows, k] = share = lines.powers[group] / lines.powers[group].sum()
            tilt[rows, k] = _tilt(lines.wavelengths[group], share)
            first += len(group)
    widths = np.concatenate([np.zeros(count), np.full(len(BANDS), band_width)])
    return Palette(wavelengths, widths, shares, tilt, len(groups))


def with_bands(palette: Palette, width: float) -> Palette:
    """A palette whose bands have another full width at half maximum [m]."""
    return palette._replace(widths=np.where(palette.widths > 0, width, 0.0))


def _groups(lines: Lines, turns: float) -> list[np.ndarray]:
    """Places of the lines, those together that the photograph does not tell apart."""
    order = np.argsort(lines.wavelengths)
    ascending = lines.wavelengths[order]
    steps = np.diff(ascending)
    apart = (steps > _APART) | (turns * steps / ascending[1:] > _TOLD_APART)
    return np.split(order, 1 + np.flatnonzero(apart))


def _tilt(wavelengths: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Change of the shares that moves their mean wavelength by `_RATIO_SD` of the lines' rms distance from it."""
    distance = wavelengths - share @ wavelengths
    rms = float(np.sqrt(share @ distance**2))
    return _RATIO_SD * share * distance / rms if rms else np.zeros(len(share))
