"""The form by variable projection on moments: contrast eliminated, Gauss-Newton steps, new references as it moves."""

from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np

from fitting.irregularity.disc import Disc
from fitting.irregularity.moments import DEGREE, Normal, normal_equations, products_at
from fitting.irregularity.zernike import terms_at

# Turns that a node may move in one step, and from the reference before a new one is made.
_STEP, _REFERENCE = 0.3, 0.45
# The fit has converged where a step moves no node by more, in turns, and no term by more in standard deviations.
# Nearer than this the fields of a change are polynomials of `DEGREE`: at 0.2 turns terms were wrong by 50 sd.
_NEAR = 0.03
_STILL, _STILL_SDS = 2e-3, 0.02
_REFERENCES, _STEPS = 8, 12


class Degrees(NamedTuple):
    """Total degrees of the background and of the contrast: one lamp's uneven light, and what blur takes."""

    background: int = 6
    contrast: int = 4


DEGREES = Degrees()


@dataclass(frozen=True)
class FormFit:
    """A form at its optimum.

    - `coefficients` [terms]: turns of phase, rms; `covariance` [terms, terms] for white noise.
    - `contrast`: coefficients of M over the Chebyshev products; `background`: of B.
    - `variance`: of a pixel; `explained`: share of the light's variance, the background's part left out.
    """

    coefficients: np.ndarray
    covariance: np.ndarray
    contrast: np.ndarray
    background: np.ndarray
    degrees: Degrees
    variance: float
    explained: float
    converged: bool


@cache
def nodes() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points of a polar quadrature u, v [n], and the map [k, n] from values there to Chebyshev products.

    Gauss in r², evenly in the angle: exact for twice the degree on the disc. Square nodes would not do, for a Zernike
    term of order 7 is 11 times its rim value in the corners.
    """
    squares, weights = np.polynomial.legendre.leggauss(DEGREE // 2 + 3)
    count = 2 * DEGREE + 5
    angles = 2 * np.pi * np.arange(count) / count
    r = np.sqrt((squares + 1) / 2)
    u, v = (np.outer(r, wave(angles)).ravel() for wave in (np.cos, np.sin))
    root = np.sqrt(np.repeat(weights, count))
    inverse = np.linalg.pinv(root[:, None] * products_at(u, v, DEGREE), rcond=1e-12) * root
    return u, v, inverse


def fit_form(disc: Disc, start: np.ndarray, degrees: Degrees = DEGREES, references: int = _REFERENCES) -> FormFit:
    """The form next to `start` [terms], turns: each reference gives the optimum near it, the next one."""
    fit = _near(disc, np.array(start, float), degrees)
    for _ in range(references - 1):
        if fit.converged:
            break
        fit = _near(disc, fit.coefficients, degrees)
    return fit


def _near(disc: Disc, reference: np.ndarray, degrees: Degrees) -> FormFit:
    """The optimum on the moments of one reference; converged where it lies as near to that as they bear."""
    normal = normal_equations(disc, reference, degrees.background)
    values = terms_at(*nodes()[:2], len(reference))
    change, settled = np.zeros(len(reference)), False
    for _ in range(_STEPS):
        state = _state(normal, values, change, degrees.contrast)
        step = np.linalg.lstsq(state.curvature, state.slope, rcond=1e-13)[0]
        largest = float(np.abs(values @ step).max())
        change = change + step * min(1.0, _STEP / max(largest, 1e-30))
        still = np.abs(step) / np.sqrt(np.maximum(state.variance / np.diag(state.curvature), 1e-30))
        if largest < _STILL and still.max() < _STILL_SDS:
            settled = True
            break
        if np.abs(values @ change).max() > _REFERENCE:
            break
    state = _state(normal, values, change, degrees.contrast)
    near = bool(np.abs(values @ change).max() < _NEAR)
    background = normal.background - normal.through @ state.fields
    return FormFit(
        reference + change,
        state.variance * np.linalg.pinv(state.curvature, hermitian=True),
        state.contrast,
        background,
        degrees,
        state.variance,
        1 - state.chi_squared / normal.square,
        settled and near,
    )


class _State(NamedTuple):
    """The contrast that fits best at a form, and what Gauss and Newton need of it."""

    contrast: np.ndarray
    fields: np.ndarray
    chi_squared: float
    variance: float
    slope: np.ndarray
    curvature: np.ndarray


def _state(normal: Normal, values: np.ndarray, change: np.ndarray, degree: int) -> _State:
    u, v, inverse = nodes()
    envelope = products_at(u, v, degree)
    angle = 2 * np.pi * (values @ change)
    cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
    columns = np.vstack([inverse @ (envelope * cosine), -inverse @ (envelope * sine)])
    through = normal.matrix @ columns
    products = columns.T @ through
    contrast = np.linalg.solve(products, columns.T @ normal.light)
    rate = 2 * np.pi * (envelope @ contrast)[:, None] * values
    rates = np.vstack([-inverse @ (rate * sine), -inverse @ (rate * cosine)])
    fields = columns @ contrast
    rates_through = normal.matrix @ rates
    mixed = columns.T @ rates_through
    curvature = rates.T @ rates_through - mixed.T @ np.linalg.solve(products, mixed)
    chi_squared = float(normal.square - contrast @ (columns.T @ normal.light))
    numbers = len(normal.background) + len(contrast) + values.shape[1]
    variance = max(chi_squared, 1e-12 * normal.square) / max(normal.pixels - numbers, 1.0)
    return _State(contrast, fields, chi_squared, variance, rates.T @ (normal.light - through @ contrast), curvature)
