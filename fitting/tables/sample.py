"""Readings as the line and its rivals look at them: ordinate, weights, and the smallest scatter to believe in."""

from dataclasses import dataclass

import numpy as np
from scipy import stats

from fitting.tables.regression import Regression, regression

# No table is read to this share of its largest ring; below it, scatter is rounding.
_FINEST = 1e-5


@dataclass(frozen=True)
class Sample:
    """Ring radii with their ordinate (r², or a sphere's), and their sds where they are stated; all by reading.

    `rounding`: standard deviation of a radius by the division that it was read to, 0 where that is not known.
    """

    order: np.ndarray
    radius: np.ndarray
    ordinate: np.ndarray
    sd: np.ndarray | None
    rounding: float = 0.0

    @property
    def weight(self) -> np.ndarray:
        """Of the answer: 1/sd² of the ordinate, or 1 without stated sds."""
        # The variance of r², to second order: at the centre the first order vanishes.
        return np.ones(len(self.radius)) if self.sd is None else 1 / _variance(self.radius, self.sd)

    @property
    def fair_weight(self) -> np.ndarray:
        """For questions: without stated sds half of the variance is an equal error of r, half one of r².

        A ring is read to a share of its fringe's width, which is an equal error of r², and to the scale's division,
        which is one of r; tables show both. The scale is such that chi² is one of radii [m² or px²].
        """
        if self.sd is not None:
            return self.weight
        slope = 4 * self.radius**2
        return 2 / (slope + np.mean(slope))

    @property
    def floor(self) -> float:
        """The least chi² to a degree of freedom: what is stated, or what nobody reads, or the digits do not show.

        Readings of one ring that are rounded alike have one rounding among them.
        """
        if self.sd is not None:
            return 1.0
        repeats = len(self.order) / len(np.unique(self.order))
        return max((_FINEST * float(self.radius.max())) ** 2, repeats * self.rounding**2)

    def line(self, order=None, used=None, group=None) -> Regression:
        """The line for questions, by fair weights, through the used readings."""
        used = slice(None) if used is None else used
        order = self.order if order is None else order
        group = None if group is None else np.unique(group[used], return_inverse=True)[1]
        return regression(order[used], self.ordinate[used], self.fair_weight[used], group)


def chance_of(t: float | np.ndarray, freedom: int):
    """Two-sided chance of Student's t."""
    return 2 * stats.t.sf(np.abs(t), freedom)


def _variance(radius, sd):
    return (2 * radius * sd) ** 2 + 2 * sd**4
