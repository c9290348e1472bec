"""Light of a lamp and a camera whose curves are given: one spectrum for each channel, which may be off by a little."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from fitting.colour.waveform import COLOURS, Curve
from newtonjax.scene import Response, Spectrum

# Length over which a curve's tilt and curvature are counted [m].
_LENGTH = 50e-9
# Samples of a spectrum to a turn of its fringes at the rim, from its one end to the other; fewest and most of them.
_SAMPLES, _FEWEST, _MOST = 4.0, 60, 400
# Gaussian bands reach so many times their full width at half maximum.
_REACH = 1.5
# Of a spectrum's highest power: less is nothing.
_LEAST = 1e-3


class Curves(NamedTuple):
    """The spectrum of a lamp, and the responses of a camera's channels: red, green and blue, or one for all."""

    spectrum: Spectrum
    response: Response

    @property
    def mean(self) -> float:
        """The middle one of the channels' mean wavelengths [m]."""
        return float(np.median(self.means))

    @property
    def means(self) -> Float[np.ndarray, " channels"]:
        """Mean wavelength of each channel that takes light, by wavenumber [m]."""
        return given_light(self, 0.0).middles


class GivenLight(NamedTuple):
    """The spectrum of each channel: lamp times camera.

    - `wavelengths` [m], [waves]; `powers` of the waves in each channel over their sum [channels, waves].
    - `distances`: of the waves from each channel's mean wavelength [50 nm], [channels, waves].
    """

    wavelengths: Float[np.ndarray, " waves"]
    powers: Float[np.ndarray, "channels waves"]
    distances: Float[np.ndarray, "channels waves"]

    @property
    def widths(self) -> Float[np.ndarray, " waves"]:
        """Of the waves [m]: 0, for they stand close together."""
        return np.zeros(len(self.wavelengths))

    @property
    def lines(self) -> int:
        """How many components are lines: none."""
        return 0

    @property
    def middles(self) -> Float[np.ndarray, " channels"]:
        """Mean wavelength of each channel by wavenumber [m]; channels that take nothing are left out."""
        lit = self.powers[self.powers.any(axis=1)]
        return 1 / (lit @ (1 / self.wavelengths))

    def free(self, channels: tuple[int, ...], /) -> tuple[str, ...]:
        """Names of the curve's numbers that change the light of these channels, and of their own blur."""
        names = [f"{kind}_{COLOURS[channel]}" for channel in channels for kind in ("tilt", "curvature")]
        # What blurs red and blue otherwise than green, as a mosaic's filling in does, fades rings as a width would.
        return (*names, *(f"blur_{COLOURS[channel]}" for channel in channels if channel != 1 and len(channels) > 1))

    def variants(self) -> dict[str, "GivenLight"]:
        """Other lights that would do as well, by name: none."""
        return {}

    def shares_in(self, curve: Curve, channel: int, /) -> Float[np.ndarray, "waves 1"]:
        """Of the waves in the light of a channel: the given ones times exp(tilt x - curvature x²)."""
        colour, x = COLOURS[channel], self.distances[channel]
        exponent = getattr(curve, f"tilt_{colour}") * x - getattr(curve, f"curvature_{colour}") * x**2
        powers = self.powers[channel] * np.exp(np.clip(exponent, -30, 30))
        return (powers / powers.sum())[:, None]


def given_light(curves: Curves, turns: float) -> GivenLight:
    """The light of a lamp in the channels of a camera, sampled for so many turns of fringes at the rim.

    Of a camera of one channel all three are alike.
    """
    spectrum, response = curves
    wavelengths = _samples(spectrum, turns)
    density = _density(spectrum, wavelengths)
    rows = np.asarray(response.curves, float)
    at = np.asarray(response.wavelengths, float)
    powers = np.stack([np.interp(wavelengths, at, row, left=0.0, right=0.0) for row in rows]) * density
    powers = np.maximum(powers, 0.0)
    total = powers.sum(axis=1, keepdims=True)
    powers = powers / np.where(total > 0, total, 1.0)
    powers = np.broadcast_to(powers, (3, len(wavelengths))) if len(powers) == 1 else powers
    means = powers @ wavelengths
    return GivenLight(wavelengths, powers, (wavelengths - means[:, None]) / _LENGTH)


def _samples(spectrum: Spectrum, turns: float) -> np.ndarray:
    """Wavelengths equidistant in wavenumber over a spectrum [m]."""
    at, weights = np.asarray(spectrum.wavelengths, float), np.asarray(spectrum.weights, float)
    present = weights > _LEAST * weights.max()
    reach = np.zeros(len(at)) if spectrum.gaussian is None else _REACH * np.asarray(spectrum.gaussian, float)
    low, high = (at - reach)[present].min(), (at + reach)[present].max()
    if spectrum.triangle is not None:
        width = float(np.max(np.asarray(spectrum.triangle)[present]))
        low, high = low - width, high + width
    count = int(np.clip(np.ceil(_SAMPLES * turns * (high / low - 1)), _FEWEST, _MOST))
    return 1 / np.linspace(1 / high, 1 / low, count)


def _density(spectrum: Spectrum, wavelengths: np.ndarray) -> np.ndarray:
    """Power per wavenumber [any unit] of a spectrum of bands."""
    at, weights = np.asarray(spectrum.wavelengths, float), np.asarray(spectrum.weights, float)
    if spectrum.triangle is not None:
        per_wavelength = np.interp(wavelengths, at, weights / np.asarray(spectrum.triangle, float), left=0.0, right=0.0)
        return per_wavelength * wavelengths**2
    width = np.asarray(spectrum.gaussian, float) / at**2
    distance = (1 / wavelengths[:, None] - 1 / at) / width
    return np.exp(-4 * np.log(2) * distance**2) @ (weights / width)
