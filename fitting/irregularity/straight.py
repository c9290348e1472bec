"""Straight fringes in a picture: their wave from the spectrum, and the form fit that starts from it."""

from typing import NamedTuple

import numpy as np
from scipy import fft

from fitting.irregularity.demodulation import demodulated, remainder_of
from fitting.irregularity.disc import Disc, Pupil, around, disc_of, reduced
from fitting.irregularity.projection import FormFit, fit_form
from fitting.irregularity.residuals import residual_of
from fitting.photo import flatten

# A wave, what bends it, and a camera's distortion: orders up to the third; up to the fifth with its next term.
_START_TERMS, TERMS = 10, 21
# Diameters of the reduced picture [px]: the first that shows fringes counts, the second is for fine ones.
_DIAMETERS = (400, 1200)
# A start is followed where so many tiles confirm it; noise has a quarter, and faint fringes in dust had 0.95.
CONFIRMED = 0.8
# Fringes over the diameter below which a peak of the spectrum is uneven light.
_FEWEST = 2.0


class StraightFit(NamedTuple):
    """The terms of a picture's fringes, the share of tiles that confirm them, and what their residual says.

    - `inflation`: of the noise's variance; `dust`: the share of pixels that was left out.
    """

    fit: FormFit
    agreement: float
    inflation: float
    dust: float


def straight_fit(image: np.ndarray, mask: np.ndarray, pupil: Pupil) -> StraightFit | None:
    """The fit from the strongest wave of the spectrum; None where too few tiles confirm one."""
    image, mask, pupil = around(image, mask, pupil)
    start, agreement = np.zeros(_START_TERMS), 0.0
    for diameter in _DIAMETERS:
        factor = max(int(2 * pupil.radius / diameter), 1)
        disc = disc_of(*reduced(image, mask, factor), pupil.reduced(factor))
        form = np.zeros(_START_TERMS)
        # Z2 = 2u and Z3 = 2v.
        form[1:3] = strongest_wave(disc) / 2
        start, agreement = demodulated(disc, form)
        if agreement > CONFIRMED or factor == 1:
            break
    if agreement < CONFIRMED:
        return None
    return _on_all_pixels(disc_of(image, mask, pupil), np.pad(start, (0, TERMS - _START_TERMS)))


def _on_all_pixels(disc: Disc, start: np.ndarray) -> StraightFit:
    """The fit on all pixels, again without dust where there is some."""
    fit = fit_form(disc, start)
    residual, dust = residual_of(disc, fit), 0.0
    if residual.dust is not None:
        dust = float(residual.dust.sum()) / max(disc.pixels, 1.0)
        weights = np.where(residual.dust, np.float32(0), disc.weights)
        disc = disc._replace(weights=weights, light=disc.light * weights)
        fit = fit_form(disc, fit.coefficients)
        residual = residual_of(disc, fit)
    return StraightFit(fit, remainder_of(disc, fit.coefficients).agreement, residual.inflation, dust)


def strongest_wave(disc: Disc) -> np.ndarray:
    """The wave vector of most power, turns a pupil radius along u and v [2]."""
    fringes = flatten(disc.light.astype(float), disc.weights > 0)
    size = [int(fft.next_fast_len(2 * count) or 2 * count) for count in fringes.shape]
    power = np.square(np.abs(np.asarray(fft.rfft2(fringes, size))))
    down, along = fft.fftfreq(size[0])[:, None], fft.rfftfreq(size[1])
    length = np.hypot(along, down) * 2 / disc.pixel
    row, column = np.unravel_index(np.argmax(np.where(length > _FEWEST, power, 0)), power.shape)
    return np.array([along[column], down[row, 0]]) / disc.pixel
