"""Least squares on the profiles of all channels: amplitudes inside, the few numbers of the curve outside.

Variable projection (G. H. Golub and V. Pereyra, SIAM J. Numer. Anal. 10, 413 (1973)) with difference quotients, for
the amplitudes cannot be negative.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from fitting.colour.amplitudes import Channel, background, solve
from fitting.colour.profiles import Profiles
from fitting.colour.waveform import PRIORS, STEPS, Curve, Light, View, fringes

# Fringes that are remembered: of one curve in three channels, and of those beside it.
_REMEMBERED = 6
# Numbers of a curve that every fit frees.
ALWAYS_FREE = ("log_rate", "offset", "blur")
ITERATIONS, _TRIALS, _STILL = 20, 7, 1e-7


@dataclass(frozen=True)
class Problem:
    """Profiles and what they are fitted with.

    - `channels`: numbers of the profiles' channels (0 red, 1 green, 2 blue).
    - `variances`: of a channel's block of weight 1 [channels]; `degree` of the background over r².
    - `free`: names of the curve's numbers that are fitted.
    """

    profiles: Profiles
    palette: Light
    view: View
    channels: tuple[int, ...]
    variances: Float[np.ndarray, " channels"]
    degree: int = 3
    free: tuple[str, ...] = ALWAYS_FREE
    _fringes: dict[tuple[float, ...], Float[np.ndarray, "bins waves"]] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    def solved(self, curve: Curve) -> list[Channel]:
        """Amplitudes and residuals of the channels."""
        profiles, answers = self.profiles, []
        smooth = background(profiles.squares, self.degree)
        means, weight = profiles.means, profiles.weight
        for k, channel in enumerate(self.channels):
            columns = self._fringes_of(curve, channel) @ self.palette.shares_in(curve, channel)
            answers.append(solve(columns, smooth, means[k], weight[k] / self.variances[k]))
        return answers

    def _fringes_of(self, curve: Curve, channel: int) -> Float[np.ndarray, "bins waves"]:
        """Of each wave: channels of one size and blur have them in common, and so have curves of other light alone."""
        key = curve.geometry(channel)
        if key not in self._fringes:
            if len(self._fringes) >= _REMEMBERED:
                self._fringes.pop(next(iter(self._fringes)))
            squares, width = self.profiles.squares, self.profiles.width
            self._fringes[key] = fringes(self.palette, curve, squares, width, channel, self.view)
        return self._fringes[key]

    def residual(self, curve: Curve) -> Float[np.ndarray, " rows"]:
        """Of all bins and priors, in standard deviations."""
        parts = [answer.residual for answer in self.solved(curve)]
        held = [getattr(curve, name) / sd for name in self.free if (sd := PRIORS[name])]
        return np.concatenate([*parts, np.array(held)])


class Optimum(NamedTuple):
    """The best curve of a problem, half its sum of squares times two, and the normal matrix of the free numbers."""

    curve: Curve
    chi2: float
    matrix: Float[np.ndarray, "free free"]

    def deviation(self) -> float:
        """Standard deviation of the first free number, for white noise."""
        return float(np.sqrt(max(np.linalg.pinv(self.matrix)[0, 0], 0.0)))


def optimum(problem: Problem, start: Curve, steps: int = ITERATIONS) -> Optimum:
    """The curve of least squares next to a start: at most so many steps of Levenberg and Marquardt."""

    def curve_of(numbers: np.ndarray) -> Curve:
        return start._replace(**{name: float(at) for name, at in zip(problem.free, numbers, strict=True)})

    def slopes(numbers: np.ndarray, residual: np.ndarray) -> np.ndarray:
        curve = curve_of(numbers)
        return np.stack([_slope(problem, curve, residual, name) for name in problem.free], axis=1)

    before = np.array([getattr(start, name) for name in problem.free])
    numbers, square, matrix = least_squares(lambda at: problem.residual(curve_of(at)), slopes, before, steps)
    return Optimum(curve_of(numbers), square, matrix)


def least_squares(
    residual: Callable[[np.ndarray], np.ndarray],
    slopes: Callable[[np.ndarray, np.ndarray], np.ndarray],
    start: Float[np.ndarray, " free"],
    steps: int,
) -> tuple[Float[np.ndarray, " free"], float, Float[np.ndarray, "free free"]]:
    """Numbers next to a start, their sum of squares and normal matrix; `slopes` of numbers and their residual.

    Where amplitudes reach zero the sum has kinks: the damping is kept from step to step.
    """
    numbers, damping = start, 1e-3
    rest = residual(numbers)
    matrix = np.eye(len(numbers))
    for _ in range(steps):
        design = slopes(numbers, rest)
        matrix, gradient = design.T @ design, design.T @ rest
        before = float(rest @ rest)
        for _ in range(_TRIALS):
            damped = matrix + damping * np.diag(np.diag(matrix) + 1e-30)
            trial = numbers - np.linalg.lstsq(damped, gradient, rcond=1e-14)[0]
            trial_rest = residual(trial)
            if trial_rest @ trial_rest < before:
                break
            damping *= 8
        else:
            break
        numbers, rest, damping = trial, trial_rest, damping / 4
        if before - float(rest @ rest) < _STILL * before:
            break
    return numbers, float(rest @ rest), matrix


def _slope(problem: Problem, curve: Curve, residual: np.ndarray, name: str) -> np.ndarray:
    step = STEPS[name]
    return (problem.residual(curve._replace(**{name: getattr(curve, name) + step})) - residual) / step
