"""The rival "misread": single readings that do not lie on the line of the remaining ones."""

from dataclasses import dataclass

import numpy as np

from fitting.tables.regression import Regression, regression
from fitting.tables.sample import Sample, chance_of

# Chance of leaving out anything of a table of honest readings.
ALARM = 0.01
# A reading nearer to the line than this, in orders, is not left out: one at the end of a short line pulls it.
_NEAR = 0.1
# Share of the readings that may be left out at most, and in one round of a long table.
_MOST, _A_ROUND = 0.25, 0.01
# A reading this far off the line, in orders, is no reading error: half an order is another ring.
_FAR = 0.4
# Nor is what lies off by less than so many standard deviations of the rounding to the table's division.
_BY_ROUNDING = 4.0
# Above so many readings the misread one stands out by itself.
_FEW = 6


@dataclass(frozen=True)
class Misread:
    """Readings to leave out, by place, their distances from the line of the remaining ones [orders]; fall of chi²."""

    places: np.ndarray
    distances: np.ndarray
    gain: float


def misread(line: Regression, count: int, floor: float) -> Misread | None:
    """The readings whose externally studentized residuals no honest table has; None where none is to be left out.

    `count`: readings of the whole table.
    """
    used = len(line.y)
    if used < 5 or line.freedom < 3 or count - used >= _MOST * count or line.slope <= 0:
        return None
    free = 1 - line.leverage()
    squares = line.weight * line.residual**2 / free
    variance = np.maximum((line.chi2 - squares) / (line.freedom - 1), floor)
    size = np.sqrt(squares / variance)
    worst = np.argsort(-size)[: max(1, int(_A_ROUND * count))]
    # y less the line through the remaining readings, and that line's slope.
    difference = line.residual[worst] / free[worst]
    slope = line.slope - line.weight[worst] * line.centred[worst] * difference / line.spread
    distances = np.where(slope > 0, difference / np.where(slope > 0, slope, 1.0), np.sign(difference) * np.inf)
    leave = (chance_of(size[worst], line.freedom - 1) * used < ALARM) & (np.abs(distances) > _NEAR)
    leave &= size[worst] > 0.5 * size[worst[0]]
    worst, distances = worst[leave], distances[leave]
    if not len(worst) or len(np.unique(np.delete(line.order, worst))) < 2:
        return None
    return Misread(worst, distances, float(squares[worst].sum()))


def suspect(sample: Sample, expected: float) -> int | None:
    """Of a few readings that do not lie on a line, the one without which the remaining ones come closest to contact.

    `expected`: the contact's intercept, in orders.
    """
    count, weight = len(sample.radius), sample.weight
    if not 3 <= count <= _FEW or len(np.unique(sample.order)) < 3:
        return None
    line = regression(sample.order, sample.ordinate, weight)
    is_misread = np.abs(line.residual) > _FAR * abs(line.slope)
    if sample.sd is not None:
        is_misread &= np.abs(line.residual) * np.sqrt(weight) > 3
    else:
        is_misread &= np.abs(line.residual) > _BY_ROUNDING * 2 * sample.radius * sample.rounding
    if not is_misread.any():
        return None
    distances = []
    for reading in range(count):
        remaining = np.arange(count) != reading
        distances.append(np.inf)
        if len(np.unique(sample.order[remaining])) > 1:
            line = regression(sample.order[remaining], sample.ordinate[remaining], weight[remaining])
            if line.slope > 0:
                distances[-1] = abs(line.intercept() / line.slope - expected)
    return int(np.argmin(distances))
