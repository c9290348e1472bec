"""The best curve of one kind of light: from its starts, with each channel's own noise."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from fitting.colour.palette import Palette
from fitting.colour.profiles import Profiles
from fitting.colour.solver import ALWAYS_FREE, Optimum, Problem, optimum
from fitting.colour.starts import Start, starts
from fitting.colour.waveform import Curve, Light, View

# Starts that are followed, and steps after which the best of them goes on alone.
_FOLLOWED, _ROUGH = 3, 8
# Rings are judged from this gap on [m]: nearer, a pressed lens is no sphere; it is an eighth of a wave at 0.6 um.
_INNERMOST = 0.15e-6


@dataclass(frozen=True)
class LampFit:
    """The best curve of a palette of light: its problem and optimum."""

    problem: Problem
    optimum: Optimum

    @property
    def unexplained(self) -> Float[np.ndarray, " channels"]:
        """Weighted mean square that is left over in each channel, over its variance about its smooth background."""
        solved = self.problem.solved(self.optimum.curve)
        weight, means = self.problem.profiles.weight, self.problem.profiles.means
        shares = []
        for k, answer in enumerate(solved):
            spread = means[k] - np.average(means[k], weights=weight[k])
            shares.append((weight[k] @ (means[k] - answer.model) ** 2) / (weight[k] @ spread**2))
        return np.array(shares)

    @property
    def components(self) -> Int[np.ndarray, " channels"]:
        """How many components of light each channel has."""
        return np.array([np.count_nonzero(answer.amplitudes) for answer in self.problem.solved(self.optimum.curve)])

    @property
    def correlations(self) -> Float[np.ndarray, " channels"]:
        """Variance of a sum of neighbouring bins' residuals over that of white noise: bins to an independent one."""
        sums = []
        for answer in self.problem.solved(self.optimum.curve):
            residual = answer.residual - answer.residual.mean()
            spectrum = np.correlate(residual, residual, "full")[len(residual) - 1 :]
            ends = np.flatnonzero(spectrum <= 0)
            length = ends[0] if len(ends) else len(spectrum)
            sums.append(2 * spectrum[:length].sum() / max(spectrum[0], 1e-30) - 1)
        return np.maximum(1.0, sums)


def best_fit(
    profiles: Profiles,
    palette: Palette,
    scale: float,
    view: View,
    channels: tuple[int, ...],
) -> LampFit:
    """The best curve of a palette with lines; `scale`: of the search's rings [turns per px²]."""
    return followed(profiles, palette, starts(profiles, palette.middles, scale, view), view, channels)


def followed(
    profiles: Profiles,
    light: Light,
    candidates: list[Start],
    view: View,
    channels: tuple[int, ...],
    most: int = _FOLLOWED,
) -> LampFit:
    """The best curve of a light next to the likeliest of the candidates, at `most` so many."""
    rate = np.exp(candidates[0].curve.log_rate)
    outer = profiles.within(_INNERMOST / rate, np.inf)
    free = (*ALWAYS_FREE, *light.free(channels))
    return _best(Problem(outer, light, view, channels, outer.noise, free=free), candidates, most)


def _best(problem: Problem, candidates: list[Start], most: int) -> LampFit:
    """The best of the optima next to the candidates; the channels weighed by what they leave over."""
    ranked = sorted(candidates, key=lambda start: _square(problem, start.curve))
    optima = [optimum(problem, start.curve, _ROUGH) for start in ranked[:most]]
    return weighed(problem, min(optima, key=lambda best: best.chi2).curve)


def weighed(problem: Problem, curve: Curve) -> LampFit:
    """The optimum next to a curve, each channel weighed by the variance that it leaves over."""
    variances = variances_of(problem, curve)
    problem = replace(problem, variances=variances)
    return LampFit(problem, optimum(problem, curve))


def variances_of(problem: Problem, curve: Curve) -> Float[np.ndarray, " channels"]:
    """Of a block of weight 1 in each channel: the mean square of its weighted residuals."""
    solved = problem.solved(curve)
    squares = [float(np.mean(answer.residual**2)) for answer in solved]
    return problem.variances * np.maximum(squares, 1e-12 * max(squares))


def _square(problem: Problem, curve: Curve) -> float:
    residual = problem.residual(curve)
    return float(residual @ residual)
