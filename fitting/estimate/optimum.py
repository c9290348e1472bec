"""All that an optimum's normal matrix says: deviations, what parts would cost or gain, which degrees are needed.

Unknowns in the order numbers (`parameters.NUMBERS`), background (28), contrast (15), free or not: so that score tests
and drops need no further pass over the image.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float64

from fitting.estimate.elimination import CONTRAST, bent, contrast_at_nodes, pseudo_inverse, tilted
from fitting.estimate.solver import Solution
from fitting.model import BACKGROUND, degrees
from fitting.parameters import NUMBERS

# Backgrounds and contrasts that are tried, as (degree, degree).
SHAPES = ((0, 0), (1, 0), (1, 1), (2, 1), (2, 2), (3, 2), (4, 2), (4, 4), (6, 4))
# Directions below this share of the largest eigenvalue, unknowns in their own units, are not determined: single
# precision leaves 1e-7 of each sum, and not the same for all.
_UNDETERMINED, _RANK = 1e-13, 1e-13


@dataclass(frozen=True)
class NormalMatrix:
    """Normal matrix Jᵀ W J of all unknowns at an optimum, Jᵀ W r, the unknowns' values, and which are free.

    `prior` [unknowns]: what priors add to the diagonal.
    """

    matrix: Float64[np.ndarray, "unknowns unknowns"]
    gradient: Float64[np.ndarray, " unknowns"]
    values: Float64[np.ndarray, " unknowns"]
    active: Bool[np.ndarray, " unknowns"]
    prior: Float64[np.ndarray, " unknowns"]

    def block(self, rows: np.ndarray, columns: np.ndarray | None = None) -> np.ndarray:
        """Part of the matrix by masks or positions."""
        full = self.matrix + np.diag(self.prior)
        return full[rows][:, rows if columns is None else columns]

    def holding(self, names: Iterable[str]) -> "NormalMatrix":
        """The same with some of the numbers held."""
        active = self.active.copy()
        active[[NUMBERS.index(name) for name in names]] = False
        return replace(self, active=active)

    @cached_property
    def inverse(self) -> np.ndarray:
        """Of the free unknowns' block, least norm where it is undetermined."""
        return pseudo_inverse(self.block(self.active), _RANK)

    def covariance(self, variance: float) -> Float64[np.ndarray, "unknowns unknowns"]:
        """Covariance of the unknowns for a variance per unit weight; zero where they are not free.

        Raises LinAlgError where the data leave a direction undetermined, and names what is alike.
        """
        block, names = self.block(self.active), np.array(_names())[self.active]
        size = np.sqrt(np.diag(block))
        if not np.all(size > 0):
            raise np.linalg.LinAlgError(f"the {names[~(size > 0)][0]} does not change the image")
        value, vector = np.linalg.eigh(block / np.outer(size, size))
        if not value[0] > _UNDETERMINED * value[-1]:
            pair = names[np.argsort(np.abs(vector[:, 0]))[-2:][::-1]]
            raise np.linalg.LinAlgError(f"the image determines only a combination of {pair[0]} and {pair[1]}")
        covariance = np.zeros_like(self.matrix)
        covariance[np.ix_(self.active, self.active)] = (vector / value) @ vector.T * variance / np.outer(size, size)
        return covariance

    def deviation(self, name: str, variance: float) -> float:
        """Standard deviation of one of the free numbers."""
        return float(np.sqrt(np.diag(self.covariance(variance))[NUMBERS.index(name)]))

    def rise_without(self, dropped: np.ndarray) -> float:
        """By how much chi-squared rises when some unknowns are set to zero, on the model linearized here."""
        remaining = self.active & ~dropped
        values = self.values[dropped]
        crossed = self.block(remaining, dropped) @ values
        inverse = pseudo_inverse(self.block(remaining), _RANK)
        return float(values @ self.block(dropped) @ values - crossed @ inverse @ crossed)

    def drop_with(self, names: Iterable[str]) -> float:
        """By how much chi-squared would drop if some held numbers became free (Rao's score test, 1948)."""
        slots = [NUMBERS.index(name) for name in names]
        return score_drop(self, self.matrix[:, slots], self.matrix[np.ix_(slots, slots)], self.gradient[slots])

    def shift(self, crossed: np.ndarray) -> Float64[np.ndarray, "numbers *changes"]:
        """Change of the numbers that makes up for one of the image, of which Jᵀ W change is given [unknowns].

        Of many changes [unknowns, n]: [numbers, n]. Zero where a number is not free.
        """
        change = np.zeros(crossed.shape)
        change[self.active] = -self.inverse @ crossed[self.active]
        return change[: len(NUMBERS)]

    def shift_by(self, name: str) -> Float64[np.ndarray, " numbers"]:
        """Change of the numbers when one that is held moves by one: the implicit function theorem."""
        return self.shift(self.matrix[:, NUMBERS.index(name)])

    def deviation_if_free(self, name: str, variance: float) -> float:
        """Standard deviation that a held number would have if it were free."""
        slot = NUMBERS.index(name)
        crossed = self.matrix[self.active, slot]
        remaining = self.matrix[slot, slot] - crossed @ self.inverse @ crossed
        return float(np.sqrt(variance / remaining)) if remaining > 0 else np.inf

    def if_free(self, names: Iterable[str], variance: float) -> tuple[np.ndarray, np.ndarray]:
        """Values and covariance that some numbers would have if they were free too, on the model linearized here."""
        slots = np.array([NUMBERS.index(name) for name in names])
        active = self.active.copy()
        active[slots] = True
        inverse = pseudo_inverse(self.block(active), _RANK)
        change = np.zeros(len(self.values))
        change[active] = inverse @ self.gradient[active]
        covariance = np.zeros_like(self.matrix)
        covariance[np.ix_(active, active)] = inverse * variance
        # What is free is at its optimum already: its gradient is rounding.
        step = np.where(self.active[slots], 0.0, change[slots])
        return self.values[slots] + step, covariance[np.ix_(slots, slots)]


def score_drop(normal: NormalMatrix, crossed: np.ndarray, among: np.ndarray, gradient: np.ndarray) -> float:
    """Drop of chi-squared when columns join: their products with all unknowns, among themselves, and their gradient."""
    crossed = crossed[normal.active]
    share = normal.inverse @ crossed
    remaining = among - crossed.T @ share
    slope = gradient - share.T @ normal.gradient[normal.active]
    independent = np.diag(remaining) > 1e-12 * np.diag(among)
    if not independent.any():
        return 0.0
    inverse = pseudo_inverse(remaining[np.ix_(independent, independent)], 1e-10)
    return float(slope[independent] @ inverse @ slope[independent])


def active_mask(moving: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Which unknowns are free, for the numbers that move and degrees of background and contrast."""
    low, high = (
        degrees(most).sum(axis=1) <= degree for most, degree in zip((BACKGROUND, CONTRAST), shape, strict=True)
    )
    return np.concatenate([moving, low, high])


def normal_matrix(solution: Solution) -> NormalMatrix:
    """The normal matrix of all unknowns at an optimum on moments."""
    normal, point = solution.normal, solution.point
    edge, left = _edge(solution), _left(solution)
    crossed = normal.crossed @ edge
    # From numbers, contrast, background to numbers, background, contrast.
    numbers, contrast, smooth = np.split(np.arange(edge.shape[1] + len(normal.smooth)), [len(NUMBERS), edge.shape[1]])
    order = np.concatenate([numbers, smooth, contrast])
    matrix = np.block([[edge.T @ normal.fringes @ edge, crossed.T], [crossed, normal.smooth]])[np.ix_(order, order)]
    gradient = np.concatenate([edge.T @ left, _smooth_left(solution)])[order]
    polynomials = np.zeros(len(contrast))
    polynomials[: len(point.contrast)] = point.contrast
    cost = np.zeros(len(matrix))
    cost[: len(NUMBERS)] = solution.problem.pull[1]
    return NormalMatrix(
        matrix,
        gradient,
        np.concatenate([solution.numbers, solution.point.background, polynomials]),
        active_mask(solution.problem.moving, solution.problem.degrees),
        cost,
    )


def bends(
    solution: Solution, phases: Float64[np.ndarray, "nodes n"], fades: Float64[np.ndarray, "nodes n"] | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Changes of the phase [turns] and of the contrast [share of it] at the nodes as columns beside the unknowns.

    Returns their products with the unknowns' columns and among themselves, and Jᵀ W r.
    """
    normal, modulus, away = solution.normal, solution.point.modulus, solution.fields.phase - solution.normal.reference
    columns = bent(modulus, away, phases)
    if fades is not None:
        columns = columns + tilted(modulus[:, None] * fades, away)
    edge, count = _edge(solution), len(NUMBERS)
    changed = normal.fringes @ columns
    numbers = edge.T @ changed
    crossed = np.concatenate([numbers[:count], normal.crossed @ columns, numbers[count:]])
    return crossed, columns.T @ changed, columns.T @ _left(solution)


def _edge(solution: Solution) -> np.ndarray:
    """How the envelope's coefficients change with the numbers and the contrast of full degree."""
    fields = solution.fields
    shapes = contrast_at_nodes() if fields.contrast is None else contrast_at_nodes() * fields.contrast[:, None]
    return np.concatenate([solution.point.tails, tilted(shapes, fields.phase - solution.normal.reference)], axis=1)


def _left(solution: Solution) -> np.ndarray:
    normal, coefficients = solution.normal, solution.point.columns @ solution.point.contrast
    return normal.of_fringes - normal.fringes @ coefficients - normal.crossed.T @ solution.point.background


def _smooth_left(solution: Solution) -> np.ndarray:
    normal, coefficients = solution.normal, solution.point.columns @ solution.point.contrast
    return normal.of_smooth - normal.smooth @ solution.point.background - normal.crossed @ coefficients


def choose_degrees(here: NormalMatrix, chi2: float, weight: float, pixels: float) -> tuple[int, int]:
    """Degrees of background and contrast with the least Bayesian information criterion (Schwarz 1978).

    Judged on the linearized model at the optimum of full degree: setting the other coefficients to zero costs a rise of
    chi-squared that linear algebra gives at once. `weight`: sum of the weights; `pixels`: number of independent ones.
    """
    moving = here.active[: len(NUMBERS)]
    variance = max(chi2, 0.0) / max(weight - here.active.sum(), 1) or 1e-300

    def criterion(shape: tuple[int, int]) -> float:
        rest = active_mask(moving, shape) & here.active
        return here.rise_without(here.active & ~rest) / variance + rest.sum() * np.log(pixels)

    return min(SHAPES, key=criterion)


def _names() -> list[str]:
    low, high = (len(degrees(most)) for most in (BACKGROUND, CONTRAST))
    names = [name.replace("_", " ") for name in NUMBERS]
    return [*names, *["background"] * low, *["contrast"] * high]
