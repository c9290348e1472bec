"""Fits with parts beside the plain one: warps of the map from image to object, and contacts.

They are made on blocks coarser than the final fit's, whose contrast is lowered as `model.Frame` says: a choice needs
no last digit.
"""

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

import numpy as np

from fitting.estimate import (
    CONTRAST,
    FEW,
    Fitted,
    Residuals,
    Solution,
    finest,
    fringe_correlation,
    moved_to,
    problem_of,
    residuals_of,
    solve,
    tukey,
)
from fitting.model import AXIS, BACKGROUND, PARTS, WARPS, numbers_of
from fitting.parameters import TABLE, Numbers
from fitting.photo import Photograph, Reduced, pixels_of, reduce
from fitting.photograph.averaging import variance_of
from fitting.photograph.phase_map import TOLERANCE, followed, nearer_numbers
from fitting.photograph.priors import Priors

# A trial that has not settled after so many new moments is judged as it is; the chosen one is fitted again. Its phase
# may be so far from the moments' [turns]: the envelope holds a quarter turn.
_ROUNDS, _NEAR = 25, 0.25
# Steps of a trial, at most.
_STEPS = 60
# Where the axis of a picture that has been cut is looked for, in half diagonals from its middle.
_AXES = ((0.0, 0.0), (0.2, 0.0), (-0.2, 0.0), (0.0, 0.2), (0.0, -0.2))
# Cycles of the finest fringe in a block of a trial, and blocks to a side that are left, at least.
_CYCLES, _FEWEST = 0.4, 64


@dataclass(frozen=True)
class Trial:
    """A fit to coarse blocks: all count alike, since outliers are those of the model that is chosen in the end."""

    solution: Solution
    reduced: Reduced
    parts: tuple[str, ...]

    @property
    def numbers(self) -> np.ndarray:
        return self.solution.numbers

    @cached_property
    def left(self) -> Residuals:
        """What it leaves over: a pass that most trials do without."""
        return residuals_of(self.solution, self.reduced, None)


class Trials:
    """Fits with parts next to one of fewer parts, or of none."""

    def __init__(
        self, fitted: Fitted, photograph: Photograph, wishes: dict[str, bool], priors: Priors, before: Fitted | None
    ):
        self.fitted, self.wishes, self.priors = fitted, wishes, priors
        # Numbers of an earlier choice, on the same photograph with another curve: a better start than any.
        self.before = None if before is None or not before.parts else before
        self.reduced = _coarser(fitted, photograph)
        self.model = moved_to(fitted.model, self.reduced.grid, fitted.numbers)
        self.rim = rim(photograph.lit)
        # A criterion counts chi-squared in units of the correlated variance.
        self.tolerance = TOLERANCE * fitted.correlation
        # A prior weighs against the image in units of the correlated variance, which means over blocks leave.
        self.variance = variance_of(fitted)[0] * (fitted.reduced.grid.block / self.reduced.grid.block) ** 2
        self.first = self._first()
        self.variance = self.variance_of(self.first)

    def variance_of(self, trial: Trial) -> float:
        """The variance of the light that a trial leaves over, errors that neighbours share included."""
        weights = tukey(trial.left.value, self.reduced)
        square = float((weights * trial.left.value**2).sum(dtype=float))
        inflation = fringe_correlation(self.reduced.grid, trial.left._replace(weights=weights))
        return square / float(weights.sum(dtype=float)) * inflation

    def _first(self) -> Trial:
        """The same fit on the coarse blocks; its outliers are known."""
        first = self.fit(self.fitted.parts, self.fitted.numbers)
        weighted = replace(self.reduced, weights=tukey(first.left.value, self.reduced))
        solution = solve(first.solution.problem, weighted, first.numbers)
        return Trial(solution, self.reduced, self.fitted.parts)

    def fit(
        self, parts: tuple[str, ...], numbers: np.ndarray, steps: int = _STEPS, variance: float | None = None
    ) -> Trial:
        """A fit with parts from given numbers, of which those of other parts are left out.

        `variance`: of the light that priors are weighed against, that of the first trial unless given.
        """
        shape = self.fitted.shape if self.fitted.orders < FEW else (BACKGROUND, CONTRAST)
        start = without(numbers, parts)
        prior = self.priors.of(parts, start, self.variance if variance is None else variance)
        problem = problem_of(self.model, self.fitted.fixed, parts, shape, prior)
        solution = solve(
            problem, self.reduced, start, tolerance=self.tolerance, rounds=_ROUNDS, near=_NEAR, steps=steps
        )
        return Trial(solution, self.reduced, parts)

    def bent(self) -> Trial:
        """The fit with the largest set of distortions whose values a camera can have."""
        allowed = [part for part in WARPS if self.wishes.get(part, True)]
        forced = {part for part in allowed if self.wishes.get(part)}
        sets = [s for n in range(len(allowed), 0, -1) for s in combinations(allowed, n) if is_nested(s)]
        for parts in sorted(sets, key=lambda parts: not forced <= set(parts)):
            if self.before is not None:
                trial = self.fit(parts, self.before.numbers)
            else:
                mapped = followed(self.fitted, parts)
                trial = self.fit(parts, self.fitted.numbers if mapped is None else mapped)
                starts = [numbers for part in parts for numbers in PARTS[part].also_from]
                if (elsewhere := nearer_numbers(trial.solution, self.reduced, starts, self.variance)) is not None:
                    trial = self._better(trial, self.fit(parts, elsewhere))
            if self.is_sane(trial):
                return trial
        return self.first

    def beside(self, trial: Trial) -> Trial:
        """The same parts under the priors of these trials, from where another trial ended, and from other starts."""
        beyond = [numbers for part in trial.parts for numbers in PARTS[part].also_from]
        axes = [dict(zip(AXIS, axis, strict=True)) for axis in _AXES]
        starts = [{**numbers, **axis} for numbers in ({}, *beyond) for axis in axes]
        trial = self.fit(trial.parts, trial.numbers)
        elsewhere = nearer_numbers(trial.solution, self.reduced, starts, self.variance)
        return trial if elsewhere is None else self._better(trial, self.fit(trial.parts, elsewhere))

    def _better(self, *trials: Trial) -> Trial:
        """The one of least cost, of those that are sane where any is."""
        return min(trials, key=lambda trial: (not self.is_sane(trial), self.cost(trial)))

    def cost(self, trial: Trial) -> float:
        """What a trial leaves over, and what its priors cost [squares of the light]."""
        centre, cost = trial.solution.problem.pull
        return trial.solution.chi2 + float(cost @ (trial.numbers - centre) ** 2)

    def is_sane(self, fit: Trial) -> bool:
        """Whether all numbers of a fit are such as can be meant: those of the camera, at the rim of the lit field."""
        numbers = Numbers(*fit.numbers)._asdict()
        sizes = {
            name: numbers[name] * self.rim ** (PARTS[part].radial_power if name not in PARTS[part].axis else 0)
            for part in fit.parts
            for name in PARTS[part].parameters
        }
        for pair in filter(None, (PARTS[part].stretches for part in fit.parts)):
            sizes |= dict.fromkeys(pair, np.hypot(*(numbers[name] for name in pair)))
        is_finite = bool(np.isfinite(fit.numbers).all())
        return is_finite and all(TABLE[name].bounds[0] < size < TABLE[name].bounds[1] for name, size in sizes.items())


def _coarser(fitted: Fitted, photograph: Photograph) -> Reduced:
    block, grid = fitted.reduced.grid.block, fitted.reduced.grid
    sides = min(len(grid.x), len(grid.y)) * block
    coarse = min(int(_CYCLES / max(finest(fitted), 1e-9)), sides // _FEWEST)
    return fitted.reduced if coarse <= block else reduce(photograph, coarse)


def rim(lit: np.ndarray) -> float:
    """Largest squared distance of the lit field from the image's middle [half diagonals squared]."""
    x, y = pixels_of(lit)
    middle_y, middle_x = ((n - 1) / 2 for n in lit.shape)
    return float(((x - middle_x) ** 2 + (y - middle_y) ** 2).max()) / (middle_x**2 + middle_y**2)


def without(numbers: np.ndarray, parts: tuple[str, ...]) -> np.ndarray:
    """Numbers without those of parts that are not there, but for the axis: it means nothing without a distortion."""
    absent = numbers_of(part for part in PARTS if part not in parts)
    return np.array(Numbers(*numbers)._replace(**{name: 0.0 for name in absent if name not in AXIS}))


def is_nested(names: Collection[str]) -> bool:
    """Whether no part is there without what it needs."""
    return all(need in names for name in names for need in PARTS[name].needs)
