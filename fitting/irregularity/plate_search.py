"""All forms that a picture of few fringes may show: draws on a small picture, or tiles, then fits of the best."""

from typing import NamedTuple

import numpy as np

from fitting.irregularity.blurred_fit import REPORTED, BlurredFit, fit_blurred
from fitting.irregularity.disc import Pupil
from fitting.irregularity.few_fringes import SMOOTH, TERMS, UNEVEN, Optima, optima_of
from fitting.irregularity.lit_disc import LitDisc, diameter_for, lit_disc
from fitting.irregularity.search import search
from fitting.photo import noise_variance

# Diameter of the small picture [px]; the share of the radius that is fitted, as blur brings dark over the rim.
_SMALL, _EDGE = 48.0, 0.95
# Of the light's variance that is no illumination and no noise, a form leaves less: of wrong ones the least was 0.2.
EXPLAINS = 0.1
# Forms that are followed on the picture: those whose chi-squared on the small one is within this of the best, further
# apart than this [turns rms] from one another, at most so many.
_WITHIN, _APART, _MOST = 300.0, 0.02, 6
# Two forms have equal merit where their chi-squared, with the noise as neighbours go together, differs by less.
_EQUAL = 30.0


class PlateSearch(NamedTuple):
    """Fits, best first; `rivals`: forms of equal merit that are another one than the first, up to the sign of all."""

    fits: list[BlurredFit]
    rivals: list[BlurredFit]


def plate_search(image: np.ndarray, usable: np.ndarray, pupil: Pupil, light_sd: float | None = None) -> PlateSearch:
    """Forms of a picture [rows, columns]; `light_sd`: of what is not even in its light, where that was taken out."""
    noise = noise_variance(image, usable)
    fits: list[BlurredFit] = []
    for starts in (_of_draws, _of_tiles, _of_uneven_draws):
        fits += [_fitted(image, usable, pupil, start, noise, light_sd) for start in starts(image, usable, pupil)]
        if any(fit.converged and fit.unexplained < EXPLAINS for fit in fits):
            break
    fits.sort(key=lambda fit: (not (fit.converged and fit.unexplained < EXPLAINS), fit.unexplained))
    return PlateSearch(fits, _rivals(fits))


class _Start(NamedTuple):
    form: np.ndarray
    visibility: float


def _fitted(
    image: np.ndarray, usable: np.ndarray, pupil: Pupil, start: _Start, noise: float, light_sd: float | None
) -> BlurredFit:
    disc = lit_disc(image, usable, pupil, diameter_for(start.form), _EDGE)
    return fit_blurred(disc, start.form, start.visibility, noise / disc.block**2, light_sd)


def _of_draws(image: np.ndarray, usable: np.ndarray, pupil: Pupil) -> list[_Start]:
    return _distinct(optima_of(_small(image, usable, pupil), SMOOTH))


def _of_uneven_draws(image: np.ndarray, usable: np.ndarray, pupil: Pupil) -> list[_Start]:
    return _distinct(optima_of(_small(image, usable, pupil), UNEVEN))


def _of_tiles(image: np.ndarray, usable: np.ndarray, pupil: Pupil) -> list[_Start]:
    candidates = search(image, usable, pupil, TERMS).candidates
    starts = []
    for candidate in candidates[:_MOST]:
        form = candidate.fit.coefficients
        # A contrast of the other sign is half a turn of the piston.
        starts += [_Start(form + np.eye(TERMS)[0] * turn, 0.7) for turn in (0.0, 0.5)]
    return starts


def _small(image: np.ndarray, usable: np.ndarray, pupil: Pupil) -> LitDisc:
    return lit_disc(image, usable, pupil, _SMALL, _EDGE)


def _distinct(optima: Optima) -> list[_Start]:
    """Optima near the best in merit, each another form."""
    variance = float(optima.squares.min()) / max(optima.pixels - 2 * TERMS, 1)
    starts: list[_Start] = []
    for form, visibility, square in zip(optima.forms, optima.visibilities, optima.squares, strict=True):
        if square > optima.squares.min() + _WITHIN * variance or len(starts) == _MOST:
            break
        if all(distance_of(form, start.form) > _APART for start in starts):
            starts.append(_Start(form, float(visibility)))
    return starts


def distance_of(first: np.ndarray, second: np.ndarray) -> float:
    """How far the reported terms of two forms lie apart, rms [turns], without piston, up to the sign of all."""
    first, second = first[1:REPORTED], second[1:REPORTED]
    return float(min(np.linalg.norm(first - second), np.linalg.norm(first + second)))


def _rivals(fits: list[BlurredFit]) -> list[BlurredFit]:
    """Forms other than the first whose chi-squared a pixel is as small."""
    if not fits:
        return []
    best, *following = fits
    rivals: list[BlurredFit] = []
    for fit in following:
        excess = best.pixels * (fit.square / fit.pixels / (best.square / best.pixels) - 1) / best.inflation
        is_new = all(distance_of(fit.form, form.form) > _APART for form in (best, *rivals))
        if excess < _EQUAL and is_new:
            rivals.append(fit)
    return rivals
