"""The line r² against order that judges its own readings: miscounted, misread, or not a line."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fitting.tables.bend import Bend, bend
from fitting.tables.breaks import Break, UncertainCount, best_break, uncertain_count
from fitting.tables.outliers import Misread, misread, suspect
from fitting.tables.regression import Regression, regression
from fitting.tables.sample import Sample
from fitting.tables.scatter import Scatter, scatter_of

# Steps of the count that are set right, or left open, at most; rounds in which readings are left out.
_BREAKS, _ROUNDS = 3, 60


@dataclass(frozen=True)
class Line:
    """The line of the readings that belong to it, with what else they show.

    - `order` [readings]: as counted rightly; `used` [readings]; `flags` [readings]: what is wrong with each, or "".
    - `regression`: of the used readings by the answer's weights; `fair`: the same for questions.
    - `level` [readings]: the intercept of each one's line, of which there is one on each side of a break.
    - `scatter`: its variance and degrees of freedom; `breaks`: steps whose number of rings is not certain.
    """

    regression: Regression
    fair: Regression
    scatter: Scatter
    order: np.ndarray
    used: np.ndarray
    flags: list[str]
    level: np.ndarray
    breaks: list[Break]
    bend: Bend | None

    @property
    def slope(self) -> float:
        """Of the ordinate against order."""
        return self.regression.slope

    @property
    def intercept(self) -> float:
        """Of the innermost readings' line."""
        return self.regression.intercept(0)

    def sd_of(self, slope: float, intercept: float) -> float | None:
        """Standard deviation of a number that changes so much with slope and intercept; None where none is known."""
        if not np.isfinite(self.scatter.variance):
            return None
        first = self.regression.group == 0
        weight = self.regression.weight[first]
        mean = float(weight @ self.regression.order[first] / weight.sum())
        # The slope and the mean of the first group are independent.
        variance = (slope - mean * intercept) ** 2 / self.regression.spread + intercept**2 / weight.sum()
        return float(np.sqrt(self.scatter.variance * variance))

    @property
    def slope_sd(self) -> float | None:
        """Standard deviation of the slope."""
        return self.sd_of(1.0, 0.0)

    def residual(self, y: np.ndarray) -> np.ndarray:
        """What is left of the ordinate over the line [readings]."""
        return y - self.slope * self.order - self.level

    def uncertain_count(self, floor: float) -> UncertainCount | None:
        """A gap of the orders across which the readings do not exclude a miscount that matters."""
        return uncertain_count(self.fair, floor, self.slope_sd or 0.0)


def ring_line(sample: Sample, expected: float, series: np.ndarray | None = None) -> Line:
    """The line through the readings that belong to it; `expected` is the contact's intercept, in orders.

    `series` [readings]: where each series is counted from a ring of its own.

    In each round the rival that explains most of chi² is believed: a whole number of rings miscounted is set right, an
    uncertain number leaves the two sides a line each of one slope, misread readings are left out where at least four
    remain, and a bend ends the search.
    """
    order, used = sample.order.copy(), np.ones(len(sample.radius), bool)
    flags, breaks, corrections = [""] * len(order), [], 0
    bent = None
    for _ in range(_ROUNDS):
        fair = sample.line(order, used, _groups(sample.ordinate, breaks, series))
        rivals = [bend(fair, sample.radius[used], sample.floor), misread(fair, len(order), sample.floor)]
        if corrections + len(breaks) < _BREAKS:
            rivals.append(best_break(fair, sample.floor))
        best = max((rival for rival in rivals if rival is not None), key=lambda rival: rival.gain, default=None)
        if best is None or isinstance(best, Bend):
            bent = best
            break
        if isinstance(best, Misread):
            _leave_out(best, used, flags)
        elif best.miscount:
            corrections += 1
            _set_right(best, sample.ordinate >= best.first, order, flags)
        else:
            breaks.append(best)
    if not any(flags) and not breaks and (place := suspect(sample, expected)) is not None:
        flags[place] = "does not fit the other readings; with so few it cannot be left out: read more rings"
    group = _groups(sample.ordinate, breaks, series)
    fair = sample.line(order, used, group)
    answer = regression(order[used], sample.ordinate[used], sample.weight[used], fair.group)
    scatter = scatter_of(answer, fair, sample)
    return Line(answer, fair, scatter, order, used, flags, _levels(answer, group, used), breaks, bent)


def _groups(y: np.ndarray, breaks: Sequence[Break], series: np.ndarray | None) -> np.ndarray:
    """The readings that share an intercept: those of one series between two breaks."""
    side = sum((y >= step.first).astype(int) for step in breaks) + np.zeros(len(y), int)
    return side if series is None else side * (int(series.max()) + 1) + series


def _levels(line: Regression, group: np.ndarray, used: np.ndarray) -> np.ndarray:
    """The intercept that belongs to each reading; that of a neighbouring group where all of its own are left out."""
    numbers = np.unique(group[used])
    levels = np.array([line.intercept(k) for k in range(len(numbers))])
    return levels[np.minimum(np.searchsorted(numbers, group), len(numbers) - 1)]


def _leave_out(rival: Misread, used: np.ndarray, flags: list[str]) -> None:
    places = np.flatnonzero(used)[rival.places]
    for place, distance in zip(places, rival.distances, strict=True):
        flags[place] = f"off the line of the others by {distance:+.2g} orders: misread or miscounted"
    used[places] = False


def _set_right(rival: Break, later: np.ndarray, order: np.ndarray, flags: list[str]) -> None:
    order[later] += rival.miscount
    direction = "low" if rival.miscount > 0 else "high"
    for place in np.flatnonzero(later):
        flags[place] = f"counted {abs(rival.miscount)} too {direction}: taken as {order[place]:g}"
