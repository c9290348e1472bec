"""The rival "several series": readings of the same rings that were taken, or counted, each in its own way."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from fitting.tables.regression import Regression, regression
from fitting.tables.sample import Sample

# Chances that honest series are taken for different ones: of slope, and of first ring.
_ALARM, _ALARM_COUNT = 0.005, 0.002
# Fewer rings make no series that is found by its place alone; more series than these are no series.
_RINGS, _MOST = 3, 50


@dataclass(frozen=True)
class Series:
    """Which reading belongs to which series [readings], their names, and whether a column says so."""

    number: np.ndarray
    names: tuple[str, ...]
    by_column: bool


def series_in(order: np.ndarray, radius: np.ndarray, column: np.ndarray | None, names: Sequence[str]) -> Series | None:
    """The series of a table: by its column, or where the rows begin anew at the first rings; None for a single one."""
    number, by_column = column, column is not None
    if number is None:
        direction = np.sign(np.median(np.sign(np.diff(order)[np.diff(order) != 0]))) if np.ptp(order) else 0
        restarts = (np.diff(order) * direction < 0) & (np.diff(radius) * direction < 0)
        number = np.concatenate([[0], np.cumsum(restarts)])
        names = [str(k + 1) for k in range(number[-1] + 1)]
    if not 1 < len(names) <= _MOST:
        return None
    rings = [len(np.unique(order[number == k])) for k in range(len(names))]
    if min(rings) < (2 if by_column else _RINGS):
        return None
    return Series(number, tuple(names), by_column)


def are_counted_apart(sample: Sample, series: Series) -> bool:
    """Whether the series begin at different rings, beyond doubt: an intercept each explains what one does not."""
    common, apart = sample.line(), sample.line(group=series.number)
    steps = len(series.names) - 1
    if apart.freedom < 1:
        return False
    variance = max(apart.chi2 / apart.freedom, sample.floor)
    return bool(stats.f.sf((common.chi2 - apart.chi2) / steps / variance, steps, apart.freedom) < _ALARM_COUNT)


@dataclass(frozen=True)
class SeriesSpread:
    """The slopes of the series, and the sd of their mean by what they differ beyond reading errors, with its freedom.

    `chance`: of slopes so different by reading errors alone.
    """

    slopes: np.ndarray
    sd: float
    freedom: int
    chance: float

    @property
    def is_beyond_chance(self) -> bool:
        """Whether the series differ by more than their readings' errors."""
        return self.chance < _ALARM


def series_spread(line: Regression, number: np.ndarray, variance: float, common: bool) -> SeriesSpread | None:
    """How far the slopes of series differ (random effects: DerSimonian and Laird 1986). None where one has no slope.

    `number` [readings of the line]: the series; `variance`: of a reading of unit weight. `common`: the error of a ring
    is that of all its readings, so that reading errors do not make series differ, and all of their difference counts.
    """
    apart = regression(line.order, line.y, line.weight, number)
    spreads = np.bincount(number, line.weight * apart.centred**2)
    if len(spreads) < 2 or np.any(spreads <= 0):
        return None
    slopes = apart.slope + np.bincount(number, line.weight * apart.centred * apart.residual) / spreads
    residual = apart.residual - (slopes - apart.slope)[number] * apart.centred
    count, freedom = len(slopes), len(number) - 2 * len(slopes)
    if freedom > 0:
        variance = max(float(line.weight @ residual**2) / freedom, 1e-300)
    mean = float(spreads @ slopes) / spreads.sum()
    square = float(spreads @ (slopes - mean) ** 2)
    chance = float(stats.f.sf(square / (count - 1) / variance, count - 1, max(freedom, 1)))
    if common:
        return SeriesSpread(slopes, float(np.sqrt(square / (count - 1) / spreads.sum())), count - 1, chance)
    excess = max(square - (count - 1) * variance, 0.0) / (spreads.sum() - spreads @ spreads / spreads.sum())
    sd = float(np.sqrt(excess * (spreads @ spreads))) / spreads.sum()
    return SeriesSpread(slopes, sd, count - 1, chance)
