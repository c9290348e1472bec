"""Weighted straight lines by sums alone: their cost is that of reading the table, whatever is asked of them.

Draper and Smith, Applied Regression Analysis (1998), chapters 1, 6 and 8; what one more column would change is the
theorem of Frisch and Waugh (1933).
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Regression:
    """y against order: one slope, and an intercept for each group of readings. Arrays are by reading.

    - `weight`: 1/sd², or up to a common factor; `centred`: order less its group's mean; `spread`: Σ weight centred².
    - `residual`: of y; `chi2`: Σ weight residual²; `freedom`: readings less parameters.
    """

    order: np.ndarray
    y: np.ndarray
    weight: np.ndarray
    group: np.ndarray
    group_weight: np.ndarray
    centred: np.ndarray
    spread: float
    slope: float
    residual: np.ndarray
    chi2: float
    freedom: int

    def without_means(self, column: np.ndarray) -> np.ndarray:
        """A column less its group's weighted means."""
        return column - _means(column, self.weight, self.group, self.group_weight)[self.group]

    def intercept(self, group: int = 0) -> float:
        """Y of a group's line at order 0."""
        in_group = self.group == group
        weight = self.weight[in_group]
        return float(weight @ (self.y - self.slope * self.order)[in_group] / weight.sum())

    def leverage(self) -> np.ndarray:
        """Share of each reading in its own fitted value, below 1."""
        leverage = self.weight * (1 / self.group_weight[self.group] + self.centred**2 / self.spread)
        return np.minimum(leverage, 1 - 1e-12)

    def added(self, column: np.ndarray) -> "Added":
        """What one more column of the design would change."""
        perpendicular = self.without_means(column)
        tilt = float(self.weight * perpendicular @ self.centred) / self.spread
        perpendicular = perpendicular - tilt * self.centred
        size = float(self.weight @ perpendicular**2)
        if size <= 1e-12 * float(self.weight @ column**2):
            return Added(0.0, np.inf, 0.0, self.slope)
        coefficient = float(self.weight * perpendicular @ self.residual) / size
        return Added(coefficient, size**-0.5, coefficient**2 * size, self.slope - coefficient * tilt)


@dataclass(frozen=True)
class Added:
    """A further column: its coefficient, the coefficient's sd at unit weight, the fall of chi², the slope with it."""

    coefficient: float
    unit_sd: float
    gain: float
    slope: float


def regression(order, y, weight, group=None) -> Regression:
    """The least-squares line. At least two orders within one group are needed for a slope."""
    group = np.zeros(len(y), int) if group is None else group
    group_weight = np.maximum(np.bincount(group, weight), 1e-300)
    centred = order - _means(order, weight, group, group_weight)[group]
    level = y - _means(y, weight, group, group_weight)[group]
    spread = float(weight @ centred**2)
    slope = float(weight * centred @ level) / spread
    residual = level - slope * centred
    freedom = len(y) - 1 - len(np.unique(group))
    chi2 = float(weight @ residual**2)
    return Regression(order, y, weight, group, group_weight, centred, spread, slope, residual, chi2, freedom)


def _means(column, weight, group, group_weight) -> np.ndarray:
    return np.bincount(group, weight * column) / group_weight
