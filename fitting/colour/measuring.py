"""From the channels of a photograph to one rate of all of them, with what speaks for it."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from fitting.colour.blocks import Blocks, blocks_of
from fitting.colour.distortion import Distortion, with_distortion
from fitting.colour.geometry import Placed, place
from fitting.colour.given_fit import best_given_fit, with_likeness
from fitting.colour.given_light import Curves, given_light
from fitting.colour.lamp_fit import LampFit, best_fit, weighed
from fitting.colour.palette import Lines, of_lamp
from fitting.colour.profiles import Profiles, profiles_of
from fitting.colour.scatter import deviation_of_rate
from fitting.colour.solver import ALWAYS_FREE, optimum
from fitting.colour.variants import Variant, spread_among, variants_of
from fitting.colour.waveform import View, gaps
from fitting.photo import Photograph, Rings

# Share of the highest level above which a channel is compared with itself; what is left over there and falls by so
# much without it was clipped. Faint rings have all their light there: what is below must be this share of a channel.
HIGH, CLIPPED, BELOW = 0.93, 0.75, 0.5
# Orders of the gap that are compared, to either side.
_ORDERS = (-2, -1, 1, 2)


class ChannelRate(NamedTuple):
    """A channel fitted by itself: its number, the logarithm of its rate and the standard deviation by its sectors."""

    channel: int
    log_rate: float
    sd: float


@dataclass(frozen=True)
class Rings1D:
    """Rings of all channels as profiles in their place."""

    blocks: Blocks
    placed: Placed
    profiles: Profiles
    view: View
    scale: float
    channels: tuple[int, ...]


@dataclass(frozen=True)
class ColourFit:
    """One curve for all channels, under light of some lines and bands.

    - `fit`: the best curve; `deviation` of its log rate by the sectors; `variants`: models as good.
    - `distortion`: of the camera, and whether the curve has it.
    - `by_channel`: each by itself; `clipped`: numbers of channels whose brightest rings were left out.
    """

    rings: Rings1D
    fit: LampFit
    deviation: float
    variants: list[Variant]
    distortion: Distortion
    by_channel: list[ChannelRate]
    clipped: tuple[int, ...]

    @property
    def spread(self) -> float:
        """Standard deviation of the log rate among admissible models."""
        return spread_among(self.variants, self.deviation)

    @property
    def explained(self) -> Float[np.ndarray, " channels"]:
        """Share of each channel's variance over its rings that the model explains."""
        return 1 - self.fit.unexplained

    @cached_property
    def order_odds(self) -> dict[int, float]:
        """Probability of the gap as found (0) and of gaps so many half wavelengths further."""
        problem, best = self.fit.problem, self.fit.optimum
        half = 0.5e6 * float(np.mean(problem.palette.middles))
        chi2 = {0: best.chi2}
        for order in _ORDERS:
            start = best.curve._replace(offset=best.curve.offset + order * half)
            moved_optimum = optimum(problem, start)
            if abs(moved_optimum.curve.offset - start.offset) < 0.4 * half:
                chi2[order] = moved_optimum.chi2
        least, inflation = min(chi2.values()), float(self.fit.correlations.max())
        weights = {order: float(np.exp(-(value - least) / (2 * inflation))) for order, value in chi2.items()}
        return {order: weight / sum(weights.values()) for order, weight in weights.items()}


def rings_in(
    photographs: tuple[Photograph, ...], rings: Rings, pixel_size: float, sign: float, channels: tuple[int, ...]
) -> Rings1D:
    """The profiles of the channels; `pixel_size` over the root of the index [m], `sign` of the fringes at contact.

    Raises ValueError where no block of pixels is used.
    """
    blocks = blocks_of(photographs, rings)
    placed = place(blocks, rings)
    profiles = profiles_of(blocks, placed, rings)
    view = View(pixel_size, sign, float(profiles.squares.max()))
    return Rings1D(blocks, placed, profiles, view, rings.scale, channels)


def fit_light(rings: Rings1D, light: Lines | Curves) -> tuple[LampFit, tuple[int, ...]]:
    """The best curve of lines and bands, or of given curves; and the channels whose brightest rings are clipped."""
    turns = rings.scale * float(rings.profiles.squares.max())
    if isinstance(light, Lines):
        palette = of_lamp(light, turns)
        return _unclipped(rings, best_fit(rings.profiles, palette, rings.scale, rings.view, rings.channels))
    in_channels = given_light(light, turns)
    plain = best_given_fit(rings.profiles, in_channels, rings.scale, rings.view, rings.channels)
    fit, clipped = _unclipped(rings, plain)
    return with_likeness(fit), clipped


def _unclipped(rings: Rings1D, plain: LampFit) -> tuple[LampFit, tuple[int, ...]]:
    """A fit without the rings that are clipped, and the channels that have such."""
    profiles = plain.problem.profiles
    below = profiles.below(np.full(len(rings.channels), HIGH)).weight.sum(axis=1)
    high = np.where(below > BELOW * profiles.weight.sum(axis=1), HIGH, np.inf)
    dim = profiles.below(high)
    problem = replace(plain.problem, profiles=dim)
    cut = weighed(problem, plain.optimum.curve)
    ratio = cut.problem.variances / weighed_on(problem, plain)
    clipped = tuple(np.flatnonzero(ratio < CLIPPED).tolist())
    if not clipped:
        return plain, ()
    level = np.where(ratio < CLIPPED, high, np.inf)
    problem = replace(plain.problem, profiles=profiles.below(level))
    return weighed(problem, cut.optimum.curve), clipped


def weighed_on(problem, plain: LampFit) -> Float[np.ndarray, " channels"]:
    """Variance of a block of weight 1 that a fit leaves on the bins of another problem [channels]."""
    weight, means = problem.profiles.weight, problem.profiles.means
    models = [answer.model for answer in plain.problem.solved(plain.optimum.curve)]
    return np.mean(weight * (means - np.stack(models)) ** 2, axis=1)


def measure(rings: Rings1D, light: Lines | Curves) -> ColourFit:
    """One curve for all channels under light of these lines or curves, with its standard deviation and its rivals."""
    plain, clipped = fit_light(rings, light)
    fit, distortion = with_distortion(plain, deviation_of_rate(plain.problem, plain.optimum))
    deviation = deviation_of_rate(fit.problem, fit.optimum)
    by_channel = [_alone(fit, k) for k in range(len(rings.channels))]
    return ColourFit(rings, fit, deviation, variants_of(fit, deviation), distortion, by_channel, clipped)


def _alone(fit: LampFit, number: int) -> ChannelRate:
    """One channel by itself, next to the curve of all."""
    problem = fit.problem
    part = slice(number, number + 1)
    one_channel = replace(
        problem,
        profiles=problem.profiles.channel(number),
        channels=problem.channels[part],
        variances=problem.variances[part],
        free=(*ALWAYS_FREE, *problem.palette.free(problem.channels[part])),
    )
    best = optimum(one_channel, fit.optimum.curve)
    return ChannelRate(problem.channels[number], best.curve.log_rate, deviation_of_rate(one_channel, best))


def gap_at_centre(fit: LampFit) -> float:
    """Gap times index at the centre [m]."""
    return float(gaps(fit.optimum.curve, np.zeros(1), 1, fit.problem.view)[0])
