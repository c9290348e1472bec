"""The lines of a ruler by number against place: their frequency in the middle of the picture, with what it is worth."""

from typing import NamedTuple

import numpy as np
from scipy import stats

# Rounds of leaving out lines that are so many scatters off.
_ROUNDS, _OFF = 6, 4.0
# Standard deviations of what a camera and a slant do at the corners of the picture, as shares of the scale.
_DISTORTION_SD, _SLANT_SD = 0.05, 0.05


class Ticks(NamedTuple):
    """Lines: their `number` and `place` [px], [n]."""

    number: np.ndarray
    place: np.ndarray


class Line(NamedTuple):
    """Number against place: lines a pixel in the middle of the picture, their deviation, κ, its deviation, the scatter.

    `used` [n]: the lines that lie on it; `scatter` in pixels.
    """

    frequency: float
    frequency_sd: float
    distortion: float
    distortion_sd: float
    scatter: float
    used: np.ndarray


class _Fit(NamedTuple):
    """Values and standard deviations of a regression, widened for few points, its scatter, and the points on it."""

    values: np.ndarray
    sds: np.ndarray
    scatter: float
    used: np.ndarray


def through(ticks: Ticks, turns: np.ndarray, across: tuple[float, float], half_diagonal: float) -> Line:
    """The line through the ticks of a strip, whose ends `across` are in pixels from the picture's middle.

    Along the ruler a radial distortion adds a cubic and a slant a square. A slant across it changes the scale with the
    distance from the middle; lines then converge, which `turns` [n], dx/dy of each line, shows. Both are expected to
    be small.
    """
    s, sides = ticks.place / half_diagonal, np.linspace(*across, 9) / half_diagonal
    squares = np.square(s) + np.mean(np.square(sides))
    frequency = half_diagonal / float(np.median(np.diff(np.sort(ticks.place))))
    design = np.column_stack([np.ones(len(s)), s, s * squares, np.square(s)])
    bends = frequency * _DISTORTION_SD, frequency * _SLANT_SD
    fit = _regression(design, ticks.number, np.array([np.inf, np.inf, *bends]))
    _, frequency, bend, _ = fit.values
    distortion, side = float(bend / frequency), float(sides.mean())
    # What the distortion turns is no convergence.
    straight = turns + 2 * distortion * side * s
    is_seen = np.isfinite(straight) & fit.used
    design = np.column_stack([np.ones(is_seen.sum()), s[is_seen]])
    convergence = _regression(design, straight[is_seen], np.array([np.inf, _SLANT_SD]))
    in_middle = 1 + float(convergence.values[1]) * side
    relative = np.hypot(fit.sds[1] / frequency, convergence.sds[1] * side)
    return Line(
        abs(float(frequency)) * in_middle / half_diagonal,
        float(abs(frequency) * relative) / half_diagonal,
        distortion,
        float(fit.sds[2] / abs(frequency)),
        fit.scatter * half_diagonal / abs(float(frequency)),
        fit.used,
    )


def _regression(design: np.ndarray, target: np.ndarray, expected: np.ndarray) -> _Fit:
    """Least squares with zero expected of each value to `expected`, points off the line left out.

    The deviations are those of a normal law that covers as Student's t with the freedom of the points does.
    """
    prior = expected**-2.0
    used = np.ones(len(target), bool)
    values, covariance = np.zeros(len(expected)), np.diag(np.minimum(expected, 1.0) ** 2)
    variance, freedom = max(float(np.var(target)) * 1e-4, 1e-12), 1.0
    for _ in range(_ROUNDS):
        normal = design[used].T @ design[used] / variance + np.diag(prior)
        covariance = np.linalg.pinv(normal, hermitian=True)
        values = covariance @ (design[used].T @ target[used]) / variance
        residual = target - design @ values
        # What the expectations hold is no freedom that the lines have lost.
        lost_freedom = len(values) - float(np.diag(covariance) @ prior)
        freedom = max(used.sum() - lost_freedom, 1.0)
        variance = max(float(np.square(residual[used]).sum()) / freedom, 1e-12)
        scatter = 1.4826 * float(np.median(np.abs(residual[used])))
        used = np.abs(residual) < _OFF * max(scatter, 1e-6)
    spread = float(stats.t.ppf(0.975, freedom) / stats.norm.ppf(0.975))
    return _Fit(values, spread * np.sqrt(np.diag(covariance)), float(np.sqrt(variance)), used)
