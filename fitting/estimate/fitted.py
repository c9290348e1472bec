"""Robust least squares on one photograph: the finished fit, and what is asked of it."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from fitting.estimate import robust
from fitting.estimate.block_phases import at_blocks, fringes_of, moved_to
from fitting.estimate.elimination import CONTRAST, eliminate
from fitting.estimate.fringe_sums import Residuals, fringe_count, sums
from fitting.estimate.illumination import FEW, FEW_SHAPES, near_fit, robust_from
from fitting.estimate.optimum import NormalMatrix, normal_matrix
from fitting.estimate.solver import NO_PRIOR, Prior, Problem, Solution
from fitting.model import BACKGROUND, GapModel, SceneModel, free_numbers
from fitting.photo import Photograph, Reduced, reduce

# Pixels up to which a fit may go on from blocks to each of them.
_MOST_PIXELS = 1_000_000
# Correlation of residuals up to which noise is what limits a fit, and shares of the variance that no photograph leaves
# so little of, and that single precision rounds.
_WHITE, _MADE, _EXACT = 2.0, 1e-4, 1e-8


@dataclass(frozen=True)
class Fitted:
    """A finished least-squares fit and what it was made of.

    - `reduced`: the photograph in blocks; `left`: what the fit leaves over, with the weights it was made with.
    - `scale`: standard deviation that Tukey's weights go by; None where all blocks count alike.
    - `fixed`: what the user held, by name; `parts`: of the model's parts those that are there.
    - `matrix`: the normal matrix of all unknowns.
    - `numbers`: the model's, in the order of `parameters.NUMBERS`; `shape`: degrees of background and contrast.
    - `chi2`: Σ w (light - fit)²; `weight`: sum of the weights.
    """

    model: GapModel | SceneModel
    reduced: Reduced
    solution: Solution
    left: Residuals
    scale: float | None
    fixed: dict
    parts: tuple[str, ...]
    matrix: NormalMatrix
    numbers: np.ndarray = field(init=False)
    shape: tuple[int, int] = field(init=False)
    converged: bool = field(init=False)
    chi2: float = field(init=False)
    weight: float = field(init=False)

    def __post_init__(self):
        derived = {
            "numbers": self.solution.numbers,
            "shape": self.solution.problem.degrees,
            "converged": self.solution.converged,
            "chi2": self.left.square,
            "weight": float(self.left.weights.sum(dtype=float)),
        }
        for name, value in derived.items():
            object.__setattr__(self, name, value)

    @cached_property
    def correlation(self) -> float:
        """By how much errors that neighbours share raise the variance of what the fringes measure."""
        return robust.fringe_correlation(self.reduced.grid, self.left)

    @cached_property
    def variance(self) -> float:
        """Weighted sum of squares about the best background without fringes, of a degree that does not imitate them."""
        return eliminate(self.solution.normal, FEW_SHAPES[-1][0] if self.orders < FEW else BACKGROUND).square

    @property
    def explained(self) -> float:
        """Share of that variance that the fringes explain."""
        return 1 - self.chi2 / self.variance if self.variance > 0 else 0.0

    @cached_property
    def orders(self) -> float:
        """Fringes across the used part of the image."""
        return fringe_count(self.reduced, self.solution.fields.phase)

    @cached_property
    def phase(self) -> np.ndarray:
        """The rings' phase at every block [turns]."""
        at = self.solution.problem.phase.edges(self.numbers)
        grid = self.reduced.grid
        return at_blocks(grid, self.solution.fields.phase) if at is None else at(grid, slice(None))


def finest(found: Fitted) -> float:
    """Largest frequency of the fringes where they are used [cycles per pixel]."""
    used = found.reduced.used
    slopes = [
        np.gradient(found.phase, at, axis=axis) for axis, at in enumerate((found.reduced.grid.y, found.reduced.grid.x))
    ]
    return float(np.percentile(np.hypot(*slopes)[used], 99.9))


def problem_of(
    model: GapModel | SceneModel,
    fixed: dict,
    parts: tuple[str, ...],
    degrees: tuple[int, int] = (BACKGROUND, CONTRAST),
    prior: Prior = NO_PRIOR,
) -> Problem:
    """What the solver is asked, for what the user holds and the parts that are there."""
    free = free_numbers(fixed, parts)
    return Problem(fringes_of(model), free, degrees, prior)


def robust_fit(
    model: GapModel | SceneModel,
    reduced: Reduced,
    starts: list[np.ndarray],
    fixed: dict,
    parts: tuple[str, ...] = (),
    prior: Prior = NO_PRIOR,
    is_near: bool = False,
) -> Fitted:
    """Fit, and where blocks lie far off the fit, weight them down by Tukey's biweight, up to its fixed point.

    `is_near`: whether the start is about the optimum of least squares: then outliers are those of the start. Dark
    fringes are those of a positive contrast: where it came out negative and the phase is free, half a turn puts it
    right.
    """
    problem = problem_of(model, fixed, parts, prior=prior)
    edges, phase = problem.phase.edges(starts[0]), problem.phase.fields(starts[0]).phase
    are_many = fringe_count(reduced, phase) >= FEW
    moments = sums(reduced, phase, edges) if is_near and are_many else None
    settled = None if moments is None else near_fit(problem, starts[0], reduced, moments)
    solution, left, scale = settled or robust_from(problem, reduced, starts, is_near)
    return Fitted(model, reduced, solution, left, scale, fixed, parts, normal_matrix(solution))


def finely(fit: Fitted, photograph: Photograph) -> Fitted:
    """The fit on every pixel for itself where blocks lose something: a tenth of the deviation that noise alone makes.

    Of most photographs other errors outweigh that by far. What leaves next to nothing over was no photograph: then in
    double precision.
    """
    reduced, unexplained = fit.reduced, 1 - fit.explained
    white = unexplained < _MADE or fit.correlation < _WHITE
    exact = unexplained < _EXACT
    is_fine = reduced.grid.block == 1 and not (exact and reduced.light.dtype == np.float32)
    if is_fine or not white or reduced.pixels > _MOST_PIXELS:
        return fit
    pixels = reduce(photograph, 1, dtype=np.float64 if exact else np.float32)
    model = moved_to(fit.model, pixels.grid)
    again = robust_fit(model, pixels, [fit.numbers], fit.fixed, fit.parts, fit.solution.problem.prior, True)
    return again if again.converged or not fit.converged else fit
