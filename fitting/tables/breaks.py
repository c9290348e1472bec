"""The rival "miscounted": from some ring on the orders are off by rings that were skipped or counted twice."""

from dataclasses import dataclass

import numpy as np

from fitting.tables.regression import Regression, regression
from fitting.tables.sample import chance_of

# Chance that an honest table is taken for a miscounted one, over all its rings.
ALARM = 0.003
# Chance beyond which a whole number of rings is set right without asking.
_BEYOND_DOUBT = 0.001
# Two readings this far apart, in orders, are of two rings.
_NEXT_RING = 0.4
# A step less than this, in orders, is not of rings; nobody miscounts by more than the other.
_SMALLEST, _LARGEST = 0.3, 20


@dataclass(frozen=True)
class Break:
    """A step of the orders by `rings` +- `sd` from readings of ordinate `first` on; `chance` that it is none.

    `before`, `after`: orders as they are counted on its two sides; `gain`: the fall of chi².
    """

    first: float
    before: float
    after: float
    rings: float
    sd: float
    chance: float
    gain: float

    @property
    def miscount(self) -> int:
        """Rings by which the count is off beyond doubt; 0 where several numbers are possible, or none."""
        nearest = round(self.rings)
        near = abs(self.rings - nearest) <= min(0.3, max(3 * self.sd, 0.02))
        return nearest if near and abs(nearest) <= _LARGEST and self.sd < 0.15 and self.chance < _BEYOND_DOUBT else 0

    @property
    def is_step(self) -> bool:
        """Whether the count is off by something."""
        return abs(self.rings) >= _SMALLEST or 3 * self.sd > 1

    @property
    def candidates(self) -> list[int]:
        """Whole numbers of rings within three standard deviations, the nearest first, three at most."""
        span = [k for k in range(-_LARGEST, _LARGEST + 1) if k and abs(k - self.rings) <= 3 * self.sd]
        return sorted(span, key=lambda k: abs(k - self.rings))[:3]


def best_break(line: Regression, floor: float) -> Break | None:
    """The likeliest miscount of a table; None where no honest one is ruled out."""
    if line.freedom < 3 or line.slope <= 0:
        return None
    by_size = np.argsort(line.y, kind="stable")
    weight, centred, order, y = (column[by_size] for column in (line.weight, line.centred, line.order, line.y))
    group, residual = line.group[by_size], line.residual[by_size]
    later_weight, later_moment, later_residual = (
        _from_each_on(column) for column in (weight, weight * centred, weight * residual)
    )
    in_groups = sum(
        _from_each_on(np.where(group == k, weight, 0.0)) ** 2 / total for k, total in enumerate(line.group_weight)
    )
    size = later_weight - in_groups - later_moment**2 / line.spread
    size = np.where(size > 1e-9 * weight.sum(), size, np.inf)
    coefficient = later_residual / size
    gain = coefficient * later_residual
    slope = line.slope - coefficient * later_moment / line.spread
    variance = np.maximum((line.chi2 - gain) / (line.freedom - 1), floor)
    t = later_residual / np.sqrt(size * variance)
    possible = np.isfinite(size) & (slope > 0) & _between_rings(order, y, line.slope)
    if not possible.any():
        return None
    chances = np.where(possible, chance_of(t, line.freedom - 1) * _places(order, possible), np.inf)
    # Of chances that are all rounded to nothing, the first would be taken.
    best = int(np.argmax(np.where(chances <= chances.min(), np.abs(t), -1.0)))
    chance = float(chances[best])
    rings = float(coefficient[best] / slope[best])
    if chance > ALARM or abs(rings) < _SMALLEST:
        return None
    sd = float(np.sqrt(variance[best] / size[best]) / slope[best])
    before, after = float(order[best - 1]), float(order[best])
    return Break(float(y[best]), before, after, rings, sd, chance, float(gain[best]))


def _from_each_on(column: np.ndarray) -> np.ndarray:
    return np.cumsum(column[::-1])[::-1]


def _between_rings(order: np.ndarray, y: np.ndarray, slope: float) -> np.ndarray:
    """Whether a step may begin with a reading: at the next ring, with two rings on either side."""
    possible = np.zeros(len(y), bool)
    possible[1:] = np.diff(y) > _NEXT_RING * slope
    varies_before = np.minimum.accumulate(order) < np.maximum.accumulate(order)
    varies_after = (np.minimum.accumulate(order[::-1]) < np.maximum.accumulate(order[::-1]))[::-1]
    possible[1:] &= varies_before[:-1]
    return possible & varies_after


def _places(order: np.ndarray, possible: np.ndarray) -> np.ndarray:
    """Among how many places each one would stand out by chance: those where the count is uneven are few, and likelier.

    Half of the alarms is for them, half for all places.
    """
    steps = np.diff(order, prepend=np.nan)
    uneven = possible & (steps != np.median(steps[possible]))
    shares = 2 if uneven.any() and not uneven[possible].all() else 1
    return shares * np.where(uneven, uneven.sum(), possible.sum())


@dataclass(frozen=True)
class UncertainCount:
    """A gap in the table's orders across which the readings do not exclude a miscount.

    `before`, `after`: orders on its sides; `slopes`: by the rings missed (negative: counted twice), likeliest first.
    """

    before: float
    after: float
    slopes: dict[int, float]

    def effect(self, slope: float) -> float:
        """The largest change of the slope."""
        return max((abs(changed - slope) for changed in self.slopes.values()), default=0.0)


# Orders that are missing in a row, and in steps of the table, before their count may be doubted; the gaps looked at.
_MISSING, _STEPS, _GAPS = 2, 2.0, 5
# Chance that excludes a miscount; miscounts that are tried, and listed.
_EXCLUDED, _TRIED, _LISTED = 0.003, 5, 2


def gaps_of(order: np.ndarray) -> np.ndarray:
    """Orders before the gaps of a table: where more are missing than between its rings."""
    orders = np.unique(order)
    steps = np.diff(orders)
    return orders[:-1][steps > max(_MISSING, _STEPS * np.median(steps))] if len(steps) else orders[:0]


def uncertain_count(line: Regression, floor: float, slope_sd: float) -> UncertainCount | None:
    """The gap across which a miscount would move the slope most, and by more than twice its sd."""
    before = gaps_of(line.order)
    if len(before) > _GAPS:
        return None
    gaps = [_count_across(line, floor, order, before[before != order]) for order in before]
    widest_effect = max(gaps, key=lambda gap: gap.effect(line.slope), default=None)
    if widest_effect is None or widest_effect.effect(line.slope) <= 2 * slope_sd:
        return None
    return widest_effect


def _count_across(line: Regression, floor: float, before: float, elsewhere: np.ndarray) -> UncertainCount:
    """The slopes with rings missed or counted twice in a gap, as far as the readings do not exclude them.

    `elsewhere`: orders before the remaining gaps, at each of which the count may be off as well.
    """
    later = (line.order > before).astype(float)
    side = np.searchsorted(elsewhere, line.order) * (int(line.group.max()) + 1) + line.group
    apart = regression(line.order, line.y, line.weight, np.unique(side, return_inverse=True)[1])
    step, freedom = apart.added(later), apart.freedom - 1
    sd = np.sqrt(max((apart.chi2 - step.gain) / max(freedom, 1), floor)) * step.unit_sd
    # Where the groups are too small to determine a step, a ring more or less is all that is asked.
    is_blind = freedom < 1 or not np.isfinite(sd) or step.slope <= 0
    slopes, distances = {}, {}
    for rings in range(-_TRIED, _TRIED + 1):
        centred = line.centred + rings * line.without_means(later)
        spread = float(line.weight @ centred**2)
        slope = float(line.weight * centred @ line.without_means(line.y)) / spread if spread > 0 else 0.0
        distance = abs(rings) if is_blind else abs(step.coefficient - rings * step.slope) / sd
        is_excluded = abs(rings) > 1 if is_blind else chance_of(distance, freedom) < _EXCLUDED
        if rings and slope > 0 and not is_excluded:
            slopes[rings], distances[rings] = slope, distance
    likeliest = sorted(slopes, key=lambda rings: distances[rings])[:_LISTED]
    after = float(line.order[line.order > before].min())
    return UncertainCount(float(before), after, {rings: slopes[rings] for rings in likeliest})
