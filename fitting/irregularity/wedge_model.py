"""A wedge's wave from the terms of a form fit: straight fringes behind a radial distortion, and what bends them."""

from typing import NamedTuple

import numpy as np

from fitting.irregularity.disc import Pupil
from fitting.irregularity.projection import FormFit, nodes
from fitting.irregularity.straight import TERMS
from fitting.irregularity.zernike import terms_at

_ROUNDS = 6
# Numbers: phase, wave along x and y, distortion and its next term, and the three of a quadratic.
_STRAIGHT, _WAVE, _DISTORTIONS, _BEND = slice(3), slice(1, 3), slice(3, 5), slice(5, 8)
_COUNT, _DISTORTION = 8, 3
# Standard deviation of κ₂ of the next term, κ₂ r⁴.
_NEXT_SD = 0.05
# A chi-squared is beyond chance where it exceeds its mean by so many of its standard deviations.
_BEYOND = 3.0


class Wedge(NamedTuple):
    """The wave in the middle of a picture.

    - `wave` [2]: turns a pixel along x and y, its `covariance` [2, 2], and that with the distortion held.
    - `distortion`: κ of r (1 + κ r²), r in half diagonals of the picture from its middle; `distortion_sd`.
    - `change` [2, 2]: of the wave, turns a pixel, from the pupil's middle to its rim along x and along y.
    - `is_bent`: whether that change is beyond what noise makes of it.
    """

    wave: np.ndarray
    covariance: np.ndarray
    held_covariance: np.ndarray
    distortion: float
    distortion_sd: float
    change: np.ndarray
    is_bent: bool

    @property
    def frequency(self) -> float:
        """Fringes in a pixel across them."""
        return float(np.hypot(*self.wave))

    @property
    def normal(self) -> np.ndarray:
        """The unit vector across the fringes [2]."""
        return self.wave / self.frequency

    def relative_sd(self, covariance: np.ndarray) -> float:
        """The standard deviation of the frequency over it, by a covariance of the wave."""
        return float(np.sqrt(max(self.normal @ covariance @ self.normal, 0.0)) / self.frequency)

    @property
    def direction_sd(self) -> float:
        """The standard deviation of the direction [rad]."""
        along = np.array([-self.normal[1], self.normal[0]])
        return float(np.sqrt(max(along @ self.covariance @ along, 0.0)) / self.frequency)

    @property
    def relative_change(self) -> float:
        """By what share of the wave it changes from the pupil's middle to its rim, at most."""
        return float(np.linalg.norm(self.change, 2) / self.frequency)


def wedge_of(
    fit: FormFit, inflation: float, pupil: Pupil, shape: tuple[int, ...], distortion: tuple[float, float]
) -> Wedge:
    """The wave of a fit, by least squares with their covariance; `distortion`: κ as expected, and its deviation.

    φ = c + k·d (1 + κ d²/h² + κ₂ d⁴/h⁴) + eᵀ Q e, d from the middle of the picture of half diagonal h, e from that
    of the pupil: the quadratic, which takes what a bent plate or a view at a slant does, has no slope in its middle.
    """
    terms, precision = fit.coefficients[:TERMS], np.linalg.pinv(inflation * fit.covariance[:TERMS, :TERMS])
    fields = _Fields(pupil, shape)
    expected, prior = np.zeros(_COUNT), np.zeros(_COUNT)
    expected[_DISTORTION] = distortion[0]
    prior[_DISTORTIONS] = distortion[1] ** -2.0, _NEXT_SD**-2.0
    numbers = expected.copy()
    numbers[_STRAIGHT] = terms[0], 2 * terms[1], 2 * terms[2]
    matrix = np.eye(_COUNT)
    for _ in range(_ROUNDS):
        columns = fields.rates(numbers)
        matrix = columns.T @ precision @ columns + np.diag(prior)
        residual = terms - fields.terms(numbers)
        slope = columns.T @ precision @ residual + prior * (expected - numbers)
        numbers = numbers + np.linalg.solve(matrix, slope)
    residual = terms - fields.terms(numbers)
    freedom = TERMS + 2 - _COUNT
    chi_squared = float(residual @ precision @ residual + prior @ np.square(numbers - expected))
    misfit = chi_squared / freedom if chi_squared > freedom + _BEYOND * np.sqrt(2 * freedom) else 1.0
    return _answer(numbers, np.linalg.inv(matrix) * misfit, pupil)


def _answer(numbers: np.ndarray, covariance: np.ndarray, pupil: Pupil) -> Wedge:
    bend, of_bend = numbers[_BEND], covariance[_BEND, _BEND]
    weight = float(bend @ np.linalg.solve(of_bend, bend))
    # Of a number that is held the covariance of the others is less by what goes with it.
    across = covariance[_WAVE, _DISTORTIONS]
    held = covariance[_WAVE, _WAVE] - across @ np.linalg.solve(covariance[_DISTORTIONS, _DISTORTIONS], across.T)
    return Wedge(
        numbers[_WAVE] / pupil.radius,
        covariance[_WAVE, _WAVE] / pupil.radius**2,
        held / pupil.radius**2,
        float(numbers[_DISTORTION]),
        float(np.sqrt(covariance[_DISTORTION, _DISTORTION])),
        np.array([[2 * bend[0], bend[1]], [bend[1], 2 * bend[2]]]) / pupil.radius,
        weight > len(bend) + _BEYOND * np.sqrt(2 * len(bend)),
    )


class _Fields:
    """The model's phase and its rates as terms of a form."""

    def __init__(self, pupil: Pupil, shape: tuple[int, ...]) -> None:
        u, v, _ = nodes()
        rows, columns = shape
        middle_u, middle_v = ((columns - 1) / 2 - pupil.x) / pupil.radius, ((rows - 1) / 2 - pupil.y) / pupil.radius
        half_diagonal = np.hypot(rows - 1, columns - 1) / 2 / pupil.radius
        self._u, self._v = u - middle_u, v - middle_v
        self._squares = (np.square(self._u) + np.square(self._v)) / half_diagonal**2
        self._quadratic = np.column_stack([u * u, u * v, v * v])
        self._to_terms = np.linalg.pinv(terms_at(u, v, TERMS))

    def rates(self, numbers: np.ndarray) -> np.ndarray:
        """Derivatives of the terms [terms, numbers]."""
        powers = np.column_stack([self._squares, np.square(self._squares)])
        stretch = 1 + powers @ numbers[_DISTORTIONS]
        along = np.column_stack([self._u, self._v]) @ numbers[_WAVE]
        ones = np.ones_like(self._u)
        linear = [ones, self._u * stretch, self._v * stretch, *(along[:, None] * powers).T]
        return self._to_terms @ np.column_stack([*linear, self._quadratic])

    def terms(self, numbers: np.ndarray) -> np.ndarray:
        """The terms [terms] of the model: it is linear but for the distortion times the wave."""
        linear = numbers.copy()
        linear[_DISTORTIONS] = 0.0
        return self.rates(numbers) @ linear
