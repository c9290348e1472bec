"""The fringe scales of pictures of one set-up under one unknown light: their ratios, and what these may be off by."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from fitting.colour.measuring import BELOW, CLIPPED, HIGH, Rings1D
from fitting.colour.profiles import Profiles
from fitting.colour.unknown_light import unknown_light
from fitting.colour.unknown_problem import Number, SharedOptimum, SharedProblem, shared_optimum, variances_of, weighed
from fitting.colour.unknown_starts import Likeness, likenesses, valleys
from fitting.colour.unknown_variants import Shift, estimate, shifts_of
from fitting.colour.variants import Variant, spread_among
from fitting.colour.waveform import COLOURS, Curve

# Wavelengths that the spectrum is drawn about where the rings of a channel were searched [m].
_MIDDLES = (600e-9, 540e-9, 460e-9)
# Rings are judged from this gap on [m]: nearer, a pressed lens is no sphere.
_INNERMOST, _REACH = 0.15e-6, 0.3e-6
# Gaps at the centre of the first picture that are tried [m]: near contact, and wide ones, at which a spectrum with
# waves in it does for that of any gap; how many are followed, and how many times as much as by a wide one may be left.
_NEAR, _WIDE, _TRIED, _WORSE = (np.arange(-0.3e-6, 0.31e-6, 0.02e-6), np.arange(0.6e-6, 4e-6, 0.3e-6), 2, 2.0)
# Starts that are tried and followed, and steps after which the best of them goes on alone.
_LIKELIEST, _FOLLOWED, _ROUGH = 4, 3, 4


class Alone(NamedTuple):
    """A picture by itself.

    Logarithm of its fringe scale, the standard deviation of that by its sectors, and how many times as much variance
    it leaves over beside the others.
    """

    log_scale: float
    deviation: float
    worse: float


@dataclass(frozen=True)
class SharedFit:
    """Pictures under one unknown light.

    - `problem` and `best`; `log_scales`: logarithms of the fringe scales of the mean wave [turns per px²], [pictures].
    - `noise`: standard deviations by the sectors, of these and of their differences from the first [2, pictures].
    - `shifts`: by other models, by name; `clipped`: numbers of channels whose brightest rings were left out.
    - `alone`: each picture with a light of its own.
    """

    problem: SharedProblem
    best: SharedOptimum
    log_scales: Float[np.ndarray, " pictures"]
    noise: Float[np.ndarray, "2 pictures"]
    shifts: dict[str, Shift]
    clipped: tuple[int, ...]
    alone: tuple["Alone", ...]

    @property
    def spread(self) -> Float[np.ndarray, "2 pictures"]:
        """Standard deviations among admissible models, of the scales and of their differences from the first."""
        spread = np.zeros_like(self.noise)
        for row, picture in np.argwhere(self.noise > 0).tolist():
            variants = [
                Variant(name, float(shift.change[row, picture]), float(shift.noise[row, picture]))
                for name, shift in self.shifts.items()
            ]
            spread[row, picture] = spread_among(variants, float(self.noise[row, picture]))
        return spread

    @property
    def explained(self) -> Float[np.ndarray, "pictures channels"]:
        """Share of the variance of each picture's channels over its rings that the model explains."""
        shares = []
        left_over = variances_of(self.problem, self.best.curves)
        for picture, single in enumerate(self.problem.profiles):
            middle = np.average(single.means, axis=1, weights=single.weight)[:, None]
            spread = np.mean(single.weight * (single.means - middle) ** 2, axis=1)
            shares.append(1 - left_over[picture] / spread)
        return np.array(shares)


def fit_unknown_light(rings: Sequence[Rings1D], clearest: int) -> SharedFit:
    """The best curves of pictures whose channels are the same.

    `clearest`: number of the channel in which the first picture's rings were searched.
    """
    rate = 0.5 * rings[0].scale * _MIDDLES[clearest]
    problem, curves = _start(rings, rate)
    problem, best = weighed(problem, curves)
    problem, best, clipped = _unclipped(problem, best)
    return _judged(problem, best, clipped)


def _judged(problem: SharedProblem, best: SharedOptimum, clipped: tuple[int, ...]) -> SharedFit:
    """An optimum with its standard deviations, other models, and each picture alone."""
    usual = estimate(problem, best.curves)
    alone = tuple(_alone(problem, best, picture) for picture in range(len(best.curves)))
    return SharedFit(problem, best, usual.values[0], usual.deviations, shifts_of(problem, best, usual), clipped, alone)


def _alone(problem: SharedProblem, best: SharedOptimum, picture: int) -> Alone:
    """One picture by itself, next to the curves of all."""
    part = slice(picture, picture + 1)
    free = (Number("offset", (0,)), Number("blur", (0,)))
    single = replace(
        problem,
        profiles=problem.profiles[part],
        views=problem.views[part],
        variances=problem.variances[part],
        free=free,
    )
    curves = shared_optimum(single, best.curves[part]).curves
    by_itself = estimate(single, curves)
    together = variances_of(problem, best.curves)[part]
    worse = float(np.median(together / variances_of(single, curves)))
    return Alone(float(by_itself.values[0, 0]), float(by_itself.deviations[0, 0]), worse)


def _problem(rings: Sequence[Rings1D], rates: Float[np.ndarray, " pictures"]) -> SharedProblem:
    """The problem of pictures of such rates [m per px²], without the rings next to contact."""
    channels, count = rings[0].channels, len(rings)
    outer = [single.profiles.within(_INNERMOST / rate, np.inf) for single, rate in zip(rings, rates, strict=True)]
    path = 2 * max(rate * float(single.squares.max()) + _REACH for single, rate in zip(outer, rates, strict=True))
    variances = np.array([single.noise for single in outer])
    # The camera's distortion is one for all: over the largest rim.
    rim = max(single.view.rim for single in rings)
    views = tuple(single.view._replace(rim=rim) for single in rings)
    together, others = tuple(range(count)), range(1, count)
    free = [Number("log_rate", (picture,)) for picture in others]
    free += [Number("offset", (picture,)) for picture in together]
    free.append(Number("blur", together))
    free += [Number(f"gain_{COLOURS[channel]}", (picture,)) for picture in others for channel in channels]
    return SharedProblem(tuple(outer), views, unknown_light(path), channels, variances, tuple(free))


def _start(rings: Sequence[Rings1D], rate: float) -> tuple[SharedProblem, tuple[Curve, ...]]:
    """The likeliest curves of gaps of the first picture, and of what makes the others like it."""
    gap = _gap_of_first(rings, rate)
    first = rings[0].profiles
    likest = [
        likenesses(first, single.profiles, rate, float(np.log(single.scale / rings[0].scale))) for single in rings[1:]
    ]
    trials = []
    # Of many pictures not all of these together.
    most = max(1, round(_LIKELIEST ** (1 / max(len(likest), 1))))
    for pairs in product(*(pairs[:most] for pairs in likest)):
        likeness = [Likeness(0.0, 0.0), *pairs]
        rates = rate * np.exp([single.ratio for single in likeness])
        problem = _problem(rings, rates)
        curves = tuple(
            Curve(float(np.log(at)), 1e6 * (gap + single.difference))
            for at, single in zip(rates, likeness, strict=True)
        )
        trials.append((_square(problem, curves), problem, curves))
    trials.sort(key=lambda trial: trial[0])
    rough = [(shared_optimum(problem, curves, _ROUGH), problem) for _, problem, curves in trials[:_FOLLOWED]]
    optimum, problem = min(rough, key=lambda pair: pair[0].chi2)
    return problem, optimum.curves


def _gap_of_first(rings: Sequence[Rings1D], rate: float) -> float:
    """Gap at the centre of the first picture [m], by itself: near contact where that does as well as any."""
    alone, optima = _problem(rings[:1], np.array([rate])), []
    for gaps in (_NEAR, _WIDE):
        curves = [(Curve(float(np.log(rate)), 1e6 * float(gap)),) for gap in gaps]
        squares = np.array([_square(alone, curve) for curve in curves])
        followed = [shared_optimum(alone, curves[place], _ROUGH) for (place,) in valleys(squares)[:_TRIED]]
        optima.append(min(followed, key=lambda optimum: optimum.chi2))
    near, wide = optima
    return 1e-6 * (near if near.chi2 < _WORSE * wide.chi2 else wide).curves[0].offset


def _square(problem: SharedProblem, curves: tuple[Curve, ...]) -> float:
    residual = problem.residual(curves)
    return float(residual @ residual)


def _unclipped(problem: SharedProblem, plain: SharedOptimum) -> tuple[SharedProblem, SharedOptimum, tuple[int, ...]]:
    """A fit without the rings that are clipped, and the channels that have such in some picture."""
    levels = []
    for single in problem.profiles:
        below = single.below(np.full(len(problem.channels), HIGH)).weight.sum(axis=1)
        levels.append(np.where(below > BELOW * single.weight.sum(axis=1), HIGH, np.inf))
    dim = tuple(single.below(level) for single, level in zip(problem.profiles, levels, strict=True))
    dimmed, cut = weighed(replace(problem, profiles=dim), plain.curves)
    ratio = dimmed.variances / _left_over(problem, plain, dim)
    is_clipped = ratio < CLIPPED
    if not is_clipped.any():
        return problem, plain, ()
    below = [np.where(each, level, np.inf) for each, level in zip(is_clipped, levels, strict=True)]
    profiles = tuple(single.below(level) for single, level in zip(problem.profiles, below, strict=True))
    problem, best = weighed(replace(problem, profiles=profiles), cut.curves)
    return problem, best, tuple(np.flatnonzero(is_clipped.any(axis=0)).tolist())


def _left_over(
    problem: SharedProblem, best: SharedOptimum, profiles: Sequence[Profiles]
) -> Float[np.ndarray, "pictures channels"]:
    """Variance of a block of weight 1 that a fit's own models leave over of other bins."""
    ends = np.cumsum([len(single.squares) for single in problem.profiles])[:-1]
    models = [np.split(answer.model, ends) for answer in problem.solved(best.curves)]
    return np.array(
        [
            [np.mean(single.weight[k] * (single.means[k] - models[k][picture]) ** 2) for k in range(len(models))]
            for picture, single in enumerate(profiles)
        ]
    )
