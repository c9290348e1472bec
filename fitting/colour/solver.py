"""Least squares on the profiles of all channels: amplitudes inside, the few numbers of the curve outside.

Variable projection (G. H. Golub and V. Pereyra, SIAM J. Numer. Anal. 10, 413 (1973)) with difference quotients, for
the amplitudes cannot be negative.
"""

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
_ITERATIONS, _TRIALS, _STILL = 20, 7, 1e-7


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


def optimum(problem: Problem, start: Curve, steps: int = _ITERATIONS) -> Optimum:
    """The curve of least squares next to a start: at most so many steps of Levenberg and Marquardt."""
    curve, damping = start, 1e-3
    residual = problem.residual(curve)
    matrix = np.eye(len(problem.free))
    for _ in range(steps):
        slopes = np.stack([_slope(problem, curve, residual, name) for name in problem.free], axis=1)
        matrix, gradient = slopes.T @ slopes, slopes.T @ residual
        before = float(residual @ residual)
        for _ in range(_TRIALS):
            damped = matrix + damping * np.diag(np.diag(matrix) + 1e-30)
            step = -np.linalg.lstsq(damped, gradient, rcond=1e-14)[0]
            values = {name: getattr(curve, name) + float(by) for name, by in zip(problem.free, step, strict=True)}
            trial = curve._replace(**values)
            trial_residual = problem.residual(trial)
            if trial_residual @ trial_residual < before:
                break
            damping *= 8
        else:
            break
        curve, residual, damping = trial, trial_residual, damping / 4
        if before - float(residual @ residual) < _STILL * before:
            break
    return Optimum(curve, float(residual @ residual), matrix)


def _slope(problem: Problem, curve: Curve, residual: np.ndarray, name: str) -> np.ndarray:
    step = STEPS[name]
    return (problem.residual(curve._replace(**{name: getattr(curve, name) + step})) - residual) / step
