"""What the light of a channel may be made of: lines of a lamp, and bands."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from newtonjax.scene import LAMPS, Spectrum

# Lines weaker than this over the strongest are not looked for: lamps' catalogued strengths are rough.
_WEAKEST = 0.05
# A line is narrower than this [m].
_LINE = 2e-9
# Bands of phosphors, continua and filters, as a non-negative sum of Gaussian ones: middles and full width [m].
BANDS, BAND_WIDTH = np.arange(400e-9, 721e-9, 20e-9), 45e-9
# A wavelength is a lamp's line within the first; lines further from it than the second beat with it [m].
_SAME, _APART, _VISIBLE = 0.3e-9, 5e-9, (400e-9, 700e-9)


class Palette(NamedTuple):
    """Components of light.

    - `wavelengths` [m] and full widths at half maximum of Gaussian profiles [m], [components].
    - `lines`: how many are lines; they come first.
    """

    wavelengths: Float[np.ndarray, " components"]
    widths: Float[np.ndarray, " components"]
    lines: int = 0


def lines_of(spectrum: Spectrum) -> Float[np.ndarray, " lines"]:
    """Wavelengths [m] of the lines of a lamp that a photograph may show; none of a continuous one."""
    wavelengths, weights = np.asarray(spectrum.wavelengths, float), np.asarray(spectrum.weights, float)
    sharp = np.ones(len(weights), bool)
    for width in (spectrum.gaussian, spectrum.lorentzian, spectrum.triangle):
        if width is not None:
            sharp &= np.asarray(width) < _LINE
    return wavelengths[sharp & (weights >= _WEAKEST * weights.max())]


def lines_of_lamp(name: str) -> Float[np.ndarray, " lines"]:
    """Wavelengths in air [m] of a named lamp's lines that a photograph may show."""
    strongest = max(strength for _, strength in LAMPS[name])
    return np.array([1e-9 * line for line, strength in LAMPS[name] if strength >= _WEAKEST * strongest])


def lamp_of_line(wavelength: float) -> str | None:
    """The lamp that has a wavelength in air [m], and visible lines apart from it; None where there is none."""
    for name in LAMPS:
        lines = lines_of_lamp(name)
        distance = np.abs(lines[(lines > _VISIBLE[0]) & (lines < _VISIBLE[1])] - wavelength)
        if np.any(distance < _SAME) and np.any(distance > _APART):
            return name
    return None


def of_lamp(lines: Float[np.ndarray, " lines"], band_width: float = BAND_WIDTH) -> Palette:
    """The lines of a lamp, and bands."""
    wavelengths = np.concatenate([lines, BANDS])
    widths = np.concatenate([np.zeros(len(lines)), np.full(len(BANDS), band_width)])
    return Palette(wavelengths, widths, lines=len(lines))
