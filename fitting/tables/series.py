"""The rival "several series": readings of the same rings that were taken, or counted, each in its own way."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from fitting.pieces import Piece
from fitting.tables.regression import Regression, regression
from fitting.tables.sample import Sample
from newtonjax.numerics import Joined

# Chances that honest series are taken for different ones: of slope, and of first ring.
_ALARM, _ALARM_COUNT = 0.005, 0.002
# Fewer rings make no series that is found by its place alone; more series than these are no series.
_RINGS, _MOST = 3, 50
# A series in diameters among radii has four times the slope, to this share and beyond so many standard deviations.
_SHARE, _BEYOND = 0.1, 10.0
# What the slope of a series in another size, or another unit, is multiplied by.
_MIXED = (
    (4.0, "diameters among radii"),
    (0.25, "radii among diameters"),
    *((100.0**power, "another unit among the sizes") for power in (-3, -2, -1, 1, 2, 3)),
)


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


def mixed_sizes(sample: Sample, series: Series, column: str) -> Joined | None:
    """That a series is in diameters among ones in radii, in radii among diameters, or in another unit; None for none.

    `column`: what sizes were read from. Its word tells which of two series is mistaken.
    """
    line = sample.line(group=series.number)
    spreads, slopes, residual = _slopes_apart(line, series.number)
    freedom = len(residual) - 2 * len(slopes)
    if freedom < 1 or np.any(spreads <= 0) or np.any(slopes <= 0):
        return None
    sds = np.sqrt(max(float(line.weight @ residual**2) / freedom, sample.floor) / spreads)
    is_of_radii = column.startswith("radius")
    # Of two series the one that is not what the column says is the odd one.
    usual = float(np.median(slopes)) if len(slopes) > 2 else float(slopes.min() if is_of_radii else slopes.max())
    texts = []
    for factor, look in _MIXED:
        is_odd = np.abs(slopes / (factor * usual) - 1) < _SHARE
        is_odd &= np.abs(slopes - usual) > _BEYOND * sds
        odd = [name for name, is_mixed in zip(series.names, is_odd, strict=True) if is_mixed]
        if odd:
            ratio = f"{float(np.median(slopes[is_odd])) / usual:#.2g}"
            verb, remaining = ("are" if len(odd) > 1 else "is"), ("others" if len(slopes) - len(odd) > 1 else "other")
            texts.append(
                Piece.SERIES_AT_SIZE(names=", ".join(odd), verb=verb, ratio=ratio, remaining=remaining, look=look)
            )
    return Joined("; ", texts) if texts else None


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
    spreads, slopes, residual = _slopes_apart(line, number)
    if len(spreads) < 2 or np.any(spreads <= 0):
        return None
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


def _slopes_apart(line: Regression, number: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Spread of the orders and slope [series], and residuals [readings], of a line for each series.

    The slope of a series without spread is that of all.
    """
    apart = regression(line.order, line.y, line.weight, number)
    spreads = np.bincount(number, line.weight * apart.centred**2)
    moments = np.bincount(number, line.weight * apart.centred * apart.residual)
    change = np.divide(moments, spreads, out=np.zeros(len(spreads)), where=spreads > 0)
    return spreads, apart.slope + change, apart.residual - change[number] * apart.centred
