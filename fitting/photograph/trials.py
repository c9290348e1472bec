"""Fits with parts beside the plain one: warps of the map from image to object, and contacts.

They are made on blocks coarser than the final fit's, whose contrast is lowered as `model.Frame` says: a choice needs
no last digit.
"""

from collections.abc import Collection
from dataclasses import replace
from itertools import combinations
from typing import NamedTuple

import numpy as np

from fitting.estimate import (
    CONTRAST,
    FEW,
    Fitted,
    Residuals,
    Solution,
    finest,
    moved_to,
    problem_of,
    residuals_of,
    solve,
    tukey,
)
from fitting.model import BACKGROUND, PARTS, SEARCHED, WARPS, numbers_of
from fitting.parameters import TABLE, Numbers
from fitting.photo import Photograph, Reduced, pixels_of, reduce
from fitting.photograph.phase_map import followed

# A trial that has not settled after so many new moments is judged as it is; the chosen one is fitted again. Its phase
# may be so far from the moments' [turns].
_ROUNDS, _NEAR = 25, 0.1
# A step of a trial that promises a smaller drop of chi-squared [variances, correlation included] is its last one.
_TOLERANCE = 0.02
# Steps of a trial, and of each disc's before the best ones go on, and how many these are: false optima are near. One
# that then has so many times the least chi-squared is on none of the best.
_STEPS, _FIRST_STEPS, _FURTHER, _FALSE = 60, 3, 4, 2.0
# Cycles of the finest fringe in a block of a trial, and blocks to a side that are left, at least.
_CYCLES, _FEWEST = 0.4, 64


class Trial(NamedTuple):
    """A fit to coarse blocks: all count alike, since outliers are those of the model that is chosen in the end."""

    solution: Solution
    left: Residuals
    parts: tuple[str, ...]

    @property
    def numbers(self) -> np.ndarray:
        return self.solution.numbers


class Trials:
    """Fits with parts next to a plain one."""

    def __init__(self, found: Fitted, photograph: Photograph, wishes: dict[str, bool], before: Fitted | None):
        self.found, self.wishes = found, wishes
        # Numbers of an earlier choice, on the same photograph with another curve: a better start than any.
        self.before = None if before is None or not before.parts else before
        self.reduced = _coarser(found, photograph)
        self.model = moved_to(found.model, self.reduced.grid, found.numbers)
        self.rim = rim(photograph.lit)
        # A criterion counts chi-squared in units of the correlated variance.
        self.tolerance = _TOLERANCE * found.correlation
        self.plain = self._plain()

    def _plain(self) -> Trial:
        """The plain fit on the coarse blocks; its outliers are known."""
        first = self.fit((), self.found.numbers)
        weighted = replace(self.reduced, weights=tukey(first.left.value, self.reduced))
        solution = solve(first.solution.problem, weighted, first.numbers)
        return Trial(solution, residuals_of(solution, self.reduced, None), ())

    def fit(self, parts: tuple[str, ...], numbers: np.ndarray, steps: int = _STEPS) -> Trial:
        """A fit with parts from given numbers, of which those of other parts are left out."""
        shape = self.found.shape if self.found.orders < FEW else (BACKGROUND, CONTRAST)
        problem = problem_of(self.model, self.found.fixed, parts, shape)
        start = _without(numbers, parts)
        solution = solve(
            problem, self.reduced, start, tolerance=self.tolerance, rounds=_ROUNDS, near=_NEAR, steps=steps
        )
        return Trial(solution, residuals_of(solution, self.reduced, None), parts)

    def bent(self) -> Trial:
        """The fit with the largest set of distortions whose values a camera can have."""
        allowed = [part for part in WARPS if self.wishes.get(part, True)]
        forced = {part for part in allowed if self.wishes.get(part)}
        sets = [s for n in range(len(allowed), 0, -1) for s in combinations(allowed, n) if is_nested(s)]
        for parts in sorted(sets, key=lambda parts: not forced <= set(parts)):
            starts = [self.found.numbers]
            if self.before is not None:
                starts.insert(0, self.before.numbers)
            elif (mapped := followed(self.found, parts)) is not None:
                starts.insert(0, mapped)
            for start in starts:
                trial = self.fit(parts, start)
                if self.is_sane(trial):
                    return trial
        return self.plain

    def searched(self, part: str, without: Trial, pinned: float) -> list[Trial]:
        """Fits with a part beside another fit's: as it pins a number, and with what frees that, as far as wished.

        `pinned`: the phase of contact. What it pins makes a ladder of optima. Freed that ladder is gone, so the search
        goes there first, from several starts, and takes the nearest rung in the end.
        """
        freed = SEARCHED[part].name
        parts = (*without.parts, part, freed)
        starts = [np.array(start) for start in PARTS[part].starts(Numbers(*self.found.numbers))]
        if self.before is not None and part in self.before.parts:
            starts = [self.before.numbers]
        first = sorted((self.fit(parts, at, _FIRST_STEPS) for at in starts), key=lambda fit: fit.solution.chi2)
        near = [fit for fit in first[:_FURTHER] if fit.solution.chi2 < _FALSE * first[0].solution.chi2]
        finished: list[Trial] = []
        for at in near:
            numbers = Numbers(*at.numbers)
            if not any(PARTS[part].is_beside(numbers, Numbers(*fit.numbers)) for fit in finished):
                finished.append(self.fit(parts, at.numbers))
        finished = [fit for fit in finished if self.is_sane(fit)]
        if not finished:
            return []
        loose = min(finished, key=lambda fit: fit.solution.chi2)
        turn = 0.5 if float(loose.solution.point.modulus.mean()) < 0 else 0.0
        start = PARTS[part].pinned(Numbers(*loose.numbers), pinned, turn)
        tight = self.fit((*without.parts, part), np.array(start))
        fits = [tight] if self.is_sane(tight) and not self.wishes.get(freed) else []
        return fits + [loose] * self.wishes.get(freed, True)

    def is_sane(self, fit: Trial) -> bool:
        """Whether all numbers of a fit are such as can be meant: those of the camera, at the rim of the lit field."""
        numbers = Numbers(*fit.numbers)._asdict()
        sizes = {
            name: numbers[name] * self.rim ** PARTS[part].radial_power
            for part in fit.parts
            for name in PARTS[part].parameters
        }
        for pair in filter(None, (PARTS[part].stretches for part in fit.parts)):
            sizes |= dict.fromkeys(pair, np.hypot(*(numbers[name] for name in pair)))
        is_finite = bool(np.isfinite(fit.numbers).all())
        return is_finite and all(TABLE[name].bounds[0] < size < TABLE[name].bounds[1] for name, size in sizes.items())


def _coarser(found: Fitted, photograph: Photograph) -> Reduced:
    block, grid = found.reduced.grid.block, found.reduced.grid
    sides = min(len(grid.x), len(grid.y)) * block
    coarse = min(int(_CYCLES / max(finest(found), 1e-9)), sides // _FEWEST)
    return found.reduced if coarse <= block else reduce(photograph, coarse)


def rim(lit: np.ndarray) -> float:
    """Largest squared distance of the lit field from the image's middle [half diagonals squared]."""
    x, y = pixels_of(lit)
    middle_y, middle_x = ((n - 1) / 2 for n in lit.shape)
    return float(((x - middle_x) ** 2 + (y - middle_y) ** 2).max()) / (middle_x**2 + middle_y**2)


def _without(numbers: np.ndarray, parts: tuple[str, ...]) -> np.ndarray:
    """Numbers without those of parts that are not there."""
    return np.array(
        Numbers(*numbers)._replace(**dict.fromkeys(numbers_of(part for part in PARTS if part not in parts), 0.0))
    )


def is_nested(names: Collection[str]) -> bool:
    """Whether no part is there without what it needs."""
    return all(need in names for name in names for need in PARTS[name].needs)
