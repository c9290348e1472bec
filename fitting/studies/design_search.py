"""The search for a design: sequential quadratic programming in the place of each number within its bounds."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize, nnls

from fitting.reasons import Reason
from fitting.studies.design_job import DesignTask
from fitting.studies.prospects import LIMITS, Bench, Layout, prospects
from fitting.studies.refusal import UndeterminedError

# A limit or a bound binds from so near on.
BINDS = 1e-3
_STEPS = 60


@dataclass(frozen=True)
class Binding:
    """A bound or a limit that holds the design back.

    - `name`; `side`: "low", "high", or "limit".
    - `gain`: by what share the deviation would fall per share by which it is relaxed.
    """

    name: str
    side: str
    gain: float


class Search:
    """Designs by their place in the bounds, 0 to 1 in each (by ratios where a bound is positive)."""

    def __init__(self, task: DesignTask, layout: Layout, bench: Bench, robust: str):
        self.task, self.layout, self.bench, self.robust = task, layout, bench, robust
        bounds = np.array(list(task.vary.values())).reshape(-1, 2)
        self.low, self.high = bounds.T
        self.ratio = (self.low > 0) & (self.high > 2 * self.low)
        self.base = np.where(self.ratio, self.low, 1.0)
        self.factor = np.where(self.ratio, self.high / self.base, 2.0)
        self.worst = robust == "worst" and len(task.over) > 1
        self.evaluations = 0

    def design(self, place: np.ndarray, choice: tuple[float, ...]) -> np.ndarray:
        by_ratio = self.base * self.factor**place
        return np.concatenate([np.where(self.ratio, by_ratio, self.low + (self.high - self.low) * place), choice])

    def to_unit(self, design: np.ndarray) -> np.ndarray:
        """Of a design, or what lies next to it in the bounds."""
        inside = np.clip(design[: len(self.low)], self.low, self.high)
        by_ratio = np.log(np.where(self.ratio, inside / self.base, 1.0)) / np.log(self.factor)
        return np.where(self.ratio, by_ratio, (inside - self.low) / (self.high - self.low))

    def step(self, place: np.ndarray) -> np.ndarray:
        """Change of each number per change of its place."""
        design = self.design(place, ())
        return np.where(self.ratio, design * np.log(self.factor), self.high - self.low)

    def evaluate(self, place: np.ndarray, choice: tuple[float, ...]):
        """Logarithms of deviations [targets] and rooms, -log of what is used of each limit; with slopes by place.

        Raises ArithmeticError where there is no number: beams miss the field, or nothing is determined.
        """
        self.evaluations += 1
        value, slope = prospects(self.layout, self.bench, self.design(place, choice), self.task.over)
        count, step = len(place), self.step(place)
        total, used = value.total, value.used
        by = slope.total[:, :count] * step, slope.used[..., :count] * step
        if not all(np.all(np.isfinite(part)) for part in (total, used, *by)):
            raise ArithmeticError
        worst = np.argmax(used, axis=0), np.arange(len(LIMITS))
        used, by_used = used[worst], by[1][worst]
        room = np.minimum(-np.log(np.maximum(used, 1e-300)), 5.0)
        by_room = np.where((room < 5.0)[:, None], -by_used / np.maximum(used, 1e-300)[:, None], 0.0)
        return total, by[0], room, by_room

    def problem(self, place: np.ndarray, choice: tuple[float, ...]):
        """Objective and constraints (0 or more) with slopes; the worst deviation is one more variable over all."""
        total, by_total, room, by_room = self.evaluate(place[: len(self.low)], choice)
        if not self.worst:
            share = np.exp(total - total.max())
            mean = np.log(share.mean()) + total.max()
            return mean, (share / share.sum()) @ by_total, room, by_room
        over = np.concatenate([place[-1] - total, room])
        slopes = np.concatenate([np.hstack([-by_total, np.ones((len(total), 1))]), np.pad(by_room, ((0, 0), (0, 1)))])
        return place[-1], np.eye(len(place))[-1], over, slopes

    def run(self, start: np.ndarray, choice: tuple[float, ...]) -> tuple[float, np.ndarray] | None:
        """Where a search ends, and its objective; None where it finds nothing within the limits."""
        last: list = [None, None]

        def at(place):
            if last[0] is None or not np.array_equal(last[0], place):
                last[:] = [place.copy(), self.problem(place, choice)]
            return last[1]

        bounds = [(0.0, 1.0)] * len(start)
        try:
            if self.worst:
                start = np.append(start, self.evaluate(start, choice)[0].max())
                bounds.append((-np.inf, np.inf))
            end = start
            if len(self.low):
                solution = minimize(
                    lambda p: at(p)[0],
                    start,
                    jac=lambda p: at(p)[1],
                    bounds=bounds,
                    constraints={"type": "ineq", "fun": lambda p: at(p)[2], "jac": lambda p: at(p)[3]},
                    method="SLSQP",
                    options={"maxiter": _STEPS, "ftol": 1e-5},
                )
                end = np.clip(solution.x, *np.array(bounds).T)
            value, _, room, _ = at(end)
        except ArithmeticError:
            return None
        return (float(value), end) if room.min() > -BINDS else None

    def bindings(self, place: np.ndarray, choice: tuple[float, ...]) -> tuple[Binding, ...]:
        """What holds a design, by the multipliers that balance its objective's slope (Karush, Kuhn and Tucker)."""
        _, slope, room, by_room = self.problem(place, choice)
        count, step = len(self.low), self.step(place[: len(self.low)])
        design = self.design(place[:count], ())
        columns, names = [], []
        targets = len(room) - len(LIMITS)
        for k in np.flatnonzero(room < 10 * BINDS):
            columns.append(by_room[k])
            names.append(None if k < targets else (LIMITS[k - targets], "limit", 1.0))
        for k, name in enumerate(self.task.vary):
            size = (abs(design[k]) or self.high[k] - self.low[k]) / step[k]
            if min(place[k], 1 - place[k]) < BINDS:
                low = place[k] < 0.5
                columns.append(np.eye(len(place))[k] * (1.0 if low else -1.0))
                names.append((name, "low" if low else "high", size))
        if not columns:
            return ()
        gains, _ = nnls(np.stack(columns, axis=1), slope)
        holding = (
            Binding(name[0], name[1], float(gain * name[2]))
            for name, gain in zip(names, gains, strict=True)
            if name is not None and gain * name[2] > 1e-4
        )
        return tuple(sorted(holding, key=lambda binding: -binding.gain))


def infeasible(search: Search, runs) -> ValueError:
    """What to raise: which limit is furthest from being met where it is best met."""
    best, name = np.inf, ""
    for point, choice in runs:
        try:
            room = search.evaluate(point, choice)[2]
        except ArithmeticError:
            continue
        if -room.min() < best:
            best, name = -room.min(), LIMITS[int(np.argmin(room))]
    if not name:
        return UndeterminedError(Reason.DESIGN_UNDETERMINED(target=search.task.target))
    return ValueError(Reason.NO_DESIGN_WITHIN_LIMITS(limit=name))
