"""The rival "diameters among radii": sizes of a table that are half, or twice, what the remaining ones are."""

from dataclasses import dataclass

import numpy as np
from scipy import stats

from fitting.pieces import Piece
from fitting.reasons import Reason
from fitting.tables.regression import Regression, regression
from newtonjax.numerics import Statement

# Chance that an honest table is taken for a mixed one.
ALARM = 0.001
# r² goes with the square of the size: of readings at half, and at twice the size that they should have.
_FACTORS = {"half": 4.0, "twice": 0.25}
_WORDS = {"half": ("twice", "radii among diameters"), "twice": ("half", "diameters among radii")}
# A single reading belongs to a line that it meets within so many orders.
_NEAR = 0.3


@dataclass(frozen=True)
class Mixture:
    """Readings from an order on that lie on the line of those before at `size` ("half" or "twice") what they should be.

    `slope`: of the line with them set right; `gain`: the fall of chi².
    """

    first: float
    size: str
    slope: float
    gain: float

    def words(self) -> Statement:
        """What the readings show."""
        factor, look = _WORDS[self.size]
        return Piece.READINGS_AT_SIZE(first=self.first, factor=factor, look=look)


def mixture(line: Regression, floor: float) -> Mixture | None:
    """The mixture of two sizes that no honest table shows by chance; None without.

    Sums over the readings up to each order and beyond give the line of each split.
    """
    if line.freedom < 3 or line.group.any():
        return None
    place = np.argsort(line.order, kind="stable")
    x, y, weight = line.order[place] - line.order.mean(), line.y[place] / line.y.max(), line.weight[place]
    products = (weight, weight * x, weight * x**2, weight * y, weight * x * y, weight * y**2)
    powers = np.array([0, 0, 0, 1, 1, 2])[:, None]
    before = np.stack([np.concatenate([[0.0], np.cumsum(column)[:-1]]) for column in products])
    beyond = np.stack([np.cumsum(column[::-1])[::-1] for column in products])
    is_split = np.concatenate([[False], np.diff(x) > 0])
    candidates = []
    for size, factor in _FACTORS.items():
        w, wx, wxx, wy, wxy, wyy = before + beyond * factor ** (powers - 2.0)
        wxx, wxy, wyy = wxx - wx**2 / w, wxy - wx * wy / w, wyy - wy**2 / w
        slope = wxy / np.where(wxx > 0, wxx, np.inf)
        chi2 = np.where(is_split & (slope > 0), wyy - slope * wxy, np.inf)
        best = int(np.argmin(chi2))
        candidates.append((float(chi2[best]), float(line.order[place][best]), size))
    _, first, size = min(candidates)
    factor = np.where(line.order >= first, _FACTORS[size], 1.0)
    united = regression(line.order, factor * line.y, line.weight / factor**2)
    gain = line.chi2 - united.chi2
    ratio = gain / max(united.chi2 / (united.freedom - 1), floor)
    chance = float(stats.f.sf(ratio, 1, united.freedom - 1)) * 2 * int(is_split.sum())
    return Mixture(first, size, united.slope, gain) if chance < ALARM and united.slope > 0 else None


def single_sizes(level: np.ndarray, y: np.ndarray, used: np.ndarray, slope: float) -> Statement | None:
    """What readings that are left out look like, where at least half of them lie on the line at another size; or None.

    `level`: the line at each reading.
    """
    for size, factor in _FACTORS.items():
        is_near = np.abs(factor * y - level) < _NEAR * slope
        count = int((is_near & ~used).sum())
        # Innermost rings lie near the line at any size.
        if count and count >= 0.5 * (~used).sum() and is_near[used].mean() < 0.5:
            words, look = _WORDS[size]
            verb = "lies" if count == 1 else "lie"
            return Reason.LEFT_OUT_AT_SIZE(count=count, verb=verb, factor=words, look=look)
    return None
