"""How far readings lie off their line: against what is stated, and against readings of the same ring."""

from dataclasses import dataclass

import numpy as np
from scipy import stats

from fitting.tables.regression import Regression
from fitting.tables.sample import Sample

# Chances that honest stated deviations are doubted, to either side, and honest repeats taken for dependent ones.
_ALARM_STATED, _ALARM_COMMON = 0.004, 0.001
# Chance below which a scatter above the stated one is used in its place: at any excess, honest intervals are too wide.
_IN_ITS_PLACE = 0.1


@dataclass(frozen=True)
class Scatter:
    """The variance of a reading of unit weight, with its degrees of freedom (infinite: as stated).

    - `ratio`: scatter over the stated standard deviation, None where none is stated or none can be seen.
    - `chance`: of so large (ratio above 1) or so small a ratio in an honest table.
    - `common`: how many times readings of one ring agree better than the rings lie on the line; 0 where they do not.
    - `is_rounding`: whether the variance is that of the readings' division, since they scatter by less.
    """

    variance: float
    freedom: float
    ratio: float | None
    chance: float
    common: float
    is_rounding: bool = False

    @property
    def is_above_stated(self) -> bool:
        """Whether the readings scatter by more than is stated."""
        return self.ratio is not None and self.ratio > 1 and self.chance < _ALARM_STATED

    @property
    def is_below_stated(self) -> bool:
        """Whether the readings scatter by less than is stated."""
        return self.ratio is not None and self.ratio < 1 and self.chance < _ALARM_STATED


def scatter_of(answer: Regression, fair: Regression, sample: Sample) -> Scatter:
    """The scatter about a line. `answer`: with the answer's weights; `fair`: with those for questions."""
    freedom = answer.freedom
    if freedom < 1:
        return Scatter(np.nan if sample.sd is None else 1.0, 0.0 if sample.sd is None else np.inf, None, 1.0, 0.0)
    mean_square, ratio, chance = answer.chi2 / freedom, None, 1.0
    variance, of_variance = mean_square, float(freedom)
    if sample.sd is not None:
        ratio = float(np.sqrt(mean_square))
        chance = float((stats.chi2.sf if ratio > 1 else stats.chi2.cdf)(answer.chi2, freedom))
        variance, of_variance = (mean_square, float(freedom)) if ratio > 1 and chance < _IN_ITS_PLACE else (1.0, np.inf)
    common = _common_errors(fair, sample)
    if common:
        between, rings_freedom = _between_rings(answer)
        if between > variance:
            variance, of_variance = between, float(rings_freedom)
    rounding = 0.0 if sample.sd is not None else _of_rounding(answer, sample.rounding)
    # With the freedom of the scatter, which may be less than that of the rounding: the interval only widens.
    return Scatter(max(variance, rounding), of_variance, ratio, chance, common, rounding > variance)


def _of_rounding(line: Regression, sd: float) -> float:
    """The variance of unit weight that gives the slope the variance which rounding the radii gives it.

    `sd`: of a radius by its rounding. Of r² it is 2 r sd; repeats of a ring that are all equal are rounded alike.
    """
    pull = line.weight * line.centred * 2 * np.sqrt(np.maximum(line.y, 0.0))
    ring = _ring(line)
    sum_of_pulls, squares = np.bincount(ring, pull), np.bincount(ring, pull**2)
    smallest, largest = np.full(len(squares), np.inf), np.full(len(squares), -np.inf)
    np.minimum.at(smallest, ring, line.y)
    np.maximum.at(largest, ring, line.y)
    alike = largest - smallest <= 1e-9 * largest
    return sd**2 * float(np.where(alike, sum_of_pulls**2, squares).sum()) / line.spread


def _ring(line: Regression) -> np.ndarray:
    """Number of the ring of each reading: of one order and group."""
    by_order = np.unique(line.order, return_inverse=True)[1]
    return np.unique(by_order * (int(line.group.max()) + 1) + line.group, return_inverse=True)[1]


def _within_rings(line: Regression) -> tuple[float, int]:
    """Sum of squares of readings about their rings' means, and its degrees of freedom."""
    ring = _ring(line)
    total = np.bincount(ring, line.weight)
    mean = np.bincount(ring, line.weight * line.residual) / total
    within = float(line.weight @ (line.residual - mean[ring]) ** 2)
    return within, len(ring) - len(total)


def _between_rings(line: Regression) -> tuple[float, int]:
    """Mean square of the rings' means about the line, a reading's weight each, and its degrees of freedom."""
    within, repeats = _within_rings(line)
    freedom = line.freedom - repeats
    return (line.chi2 - within) / max(freedom, 1), freedom


def _common_errors(line: Regression, sample: Sample) -> float:
    """How many times readings of one ring agree better than the rings lie on the line (lack of fit); 0 by chance.

    What rounding to one division makes alike is no error of the ring.
    """
    within, repeats = _within_rings(line)
    between, freedom = _between_rings(line)
    if repeats < 2 or freedom < 1:
        return 0.0
    # Rounded alike, the mean of n readings has the rounding's whole variance: n of it at one reading's weight.
    alike = 0.0 if sample.sd is not None else sample.rounding**2 * len(line.order) / (len(line.order) - repeats)
    inside = max(within / repeats, sample.floor) + alike
    ratio = between / inside
    return float(np.sqrt(ratio)) if stats.f.sf(ratio, freedom, repeats) < _ALARM_COMMON else 0.0
