"""The line r² against order that judges its own readings: miscounted, misread, or not a line."""

from dataclasses import dataclass

import numpy as np

from fitting.tables.bend import Bend, bend
from fitting.tables.breaks import Break, UncertainCount, best_break, uncertain_count
from fitting.tables.groups import GroupBreaks, group_breaks
from fitting.tables.mixture import Mixture, mixture
from fitting.tables.outliers import Misread, misread, suspect
from fitting.tables.regression import Regression, regression
from fitting.tables.sample import Sample
from fitting.tables.scatter import Scatter, scatter_of

# Steps of the count that are set right, or left open, at most; rounds in which readings are left out.
_BREAKS, _ROUNDS = 3, 60

Rival = Bend | Mixture | Misread | Break | GroupBreaks


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
    mixture: Mixture | None

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
    state = _State(sample, series)
    for _ in range(_ROUNDS):
        if not state.believe(state.best_rival()):
            break
    return state.line(expected)


class _State:
    """What is believed of a sample so far: orders, readings that are used, flags, uncertain breaks, a bend."""

    def __init__(self, sample: Sample, series: np.ndarray | None) -> None:
        self.sample, self.series = sample, series
        self.order, self.used = sample.order.copy(), np.ones(len(sample.radius), bool)
        self.flags = [""] * len(self.order)
        self.breaks: list[Break] = []
        self.corrections = 0
        self.bend: Bend | None = None
        self.mixture: Mixture | None = None

    def fair(self) -> Regression:
        """The line for questions."""
        return self.sample.line(self.order, self.used, self._group())

    def best_rival(self) -> Rival | None:
        """The rival that explains most of chi²; steps at all gaps where they explain what none does alone."""
        fair, floor = self.fair(), self.sample.floor
        rivals: list[Rival | None] = [
            bend(fair, self.sample.radius[self.used], floor),
            misread(fair, len(self.order), floor),
            mixture(fair, floor),
        ]
        steps = self.corrections + len(self.breaks)
        if steps < _BREAKS:
            rivals.append(best_break(fair, floor))
        best = max((rival for rival in rivals if rival is not None), key=lambda rival: rival.gain, default=None)
        groups = None if steps > _BREAKS else group_breaks(fair, floor)
        is_better = groups is not None and (
            isinstance(best, Break) or groups.explains_beyond(best.gain if best else 0.0)
        )
        return groups if is_better else best

    def believe(self, rival: Rival | None) -> bool:
        """Take a rival for true; whether there is more to ask."""
        if isinstance(rival, Bend):
            self.bend = rival
        elif isinstance(rival, Mixture):
            self.mixture = rival
        elif isinstance(rival, Misread):
            self._leave_out(rival)
        elif isinstance(rival, Break):
            self._step(rival)
        elif isinstance(rival, GroupBreaks):
            for step in rival.breaks:
                self._step(step)
        return not (rival is None or isinstance(rival, Bend | Mixture))

    def line(self, expected: float) -> Line:
        """The line of what is believed; `expected`: the contact's intercept, in orders."""
        sample, order, used, flags = self.sample, self.order, self.used, self.flags
        if not any(flags) and not self.breaks and (place := suspect(sample, expected)) is not None:
            flags[place] = "does not fit the other readings; with so few it cannot be left out: read more rings"
        group, fair = self._group(), self.fair()
        answer = regression(order[used], sample.ordinate[used], sample.weight[used], fair.group)
        scatter, levels = scatter_of(answer, fair, sample), _levels(answer, group, used)
        return Line(answer, fair, scatter, order, used, flags, levels, self.breaks, self.bend, self.mixture)

    def _group(self) -> np.ndarray:
        """The readings that share an intercept: those of one series between two breaks."""
        y = self.sample.ordinate
        side = sum((y >= step.first).astype(int) for step in self.breaks) + np.zeros(len(y), int)
        return side if self.series is None else side * (int(self.series.max()) + 1) + self.series

    def _leave_out(self, rival: Misread) -> None:
        places = np.flatnonzero(self.used)[rival.places]
        for place, distance in zip(places, rival.distances, strict=True):
            self.flags[place] = f"off the line of the others by {distance:+.2g} orders: misread or miscounted"
        self.used[places] = False

    def _step(self, rival: Break) -> None:
        """Set a certain number of rings right; leave the two sides of an uncertain one an intercept each."""
        if not rival.miscount:
            self.breaks += [rival] if rival.is_step else []
            return
        later = self.sample.ordinate >= rival.first
        self.corrections += 1
        self.order[later] += rival.miscount
        for place in np.flatnonzero(later):
            shift = self.order[place] - self.sample.order[place]
            direction = "low" if shift > 0 else "high"
            self.flags[place] = f"counted {abs(shift):g} too {direction}: taken as {self.order[place]:g}"


def _levels(line: Regression, group: np.ndarray, used: np.ndarray) -> np.ndarray:
    """The intercept that belongs to each reading; that of a neighbouring group where all of its own are left out."""
    numbers = np.unique(group[used])
    levels = np.array([line.intercept(k) for k in range(len(numbers))])
    return levels[np.minimum(np.searchsorted(numbers, group), len(numbers) - 1)]
