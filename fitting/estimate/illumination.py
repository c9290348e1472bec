"""Least squares on one photograph: the illumination that it calls for, and its outliers."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from fitting.estimate import robust
from fitting.estimate.block_phases import at_blocks, fringes_of, moved_to
from fitting.estimate.elimination import CONTRAST, eliminate
from fitting.estimate.fringe_sums import Residuals, Sums, fringe_count, normal_equations, sums
from fitting.estimate.optimum import NormalMatrix, choose_degrees, normal_matrix
from fitting.estimate.solver import NO_PRIOR, Prior, Problem, Solution, solve, stay
from fitting.model import BACKGROUND, GapModel, SceneModel, free_numbers
from fitting.parameters import Numbers
from fitting.photo import Photograph, Reduced, reduce

# With fewer fringes than this a background of high degree imitates them; then these degrees of background and contrast.
FEW = 4.0
_SHAPES = ((0, 0), (1, 1), (2, 2))
# Higher degrees then only finish the fit: what moves the scale by more than this is another optimum.
_NEAR = 0.15
# How often moments are taken anew in one solve, at most.
ROUNDS = 15
# A step that promises a smaller drop of chi-squared [variances] is the last one before degrees or weights are known.
_LOOSE = 1e-2

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
        return eliminate(self.solution.normal, _SHAPES[-1][0] if self.orders < FEW else BACKGROUND).square

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
    return Problem(fringes_of(model), free_numbers(fixed, parts), degrees, prior)


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
    phase, edges = problem.phase.fields(starts[0]).phase, problem.phase.edges(starts[0])
    is_near = is_near and fringe_count(reduced, phase) >= FEW
    settled = _near_fit(problem, starts[0], reduced, sums(reduced, phase, edges)) if is_near else None
    solution, left, scale = settled or _robust_from(problem, reduced, starts)
    return Fitted(model, reduced, solution, left, scale, fixed, parts, normal_matrix(solution))


def _robust_from(
    problem: Problem, reduced: Reduced, starts: list[np.ndarray]
) -> tuple[Solution, Residuals, float | None]:
    """The robust fit from starts that may be far: its outliers are those of a fit without weights."""
    solution = _illuminated(problem, reduced, starts)
    if float(solution.point.modulus.mean()) < 0 and "phase" in solution.problem.free:
        turned = np.array(Numbers(*solution.numbers)._replace(phase=solution["phase"] + 0.5))
        solution = _illuminated(problem, reduced, [turned])
    left, scale = robust.residuals_of(solution, reduced, None), None
    spread = robust.spread_of(left, reduced.used)
    if not robust.is_clean(left, reduced, spread):
        weighted = replace(reduced, weights=robust.tukey(left.value, reduced, spread))
        start = _illuminated(problem, weighted, [solution.numbers])
        settled = robust.settle(start.problem, reduced, start, spread)
        # What a bad first fit took for outliers may be none.
        if robust.is_clean(settled.left, reduced, settled.scale):
            solution = _illuminated(problem, reduced, [settled.solution.numbers])
        else:
            solution, left, scale = settled
    if scale is None:
        solution = solve(solution.problem, reduced, solution.numbers, first=solution.normal)
        left = robust.residuals_of(solution, reduced, None)
    return solution, left, scale


def _near_fit(problem: Problem, numbers: np.ndarray, reduced: Reduced, moments: Sums) -> robust.Settled | None:
    """The robust fit next to numbers by which outliers are told; None where they are none.

    `moments`: about the phase of these numbers.
    """
    settled = None
    solution = stay(problem, normal_equations(moments), numbers)
    left = robust.residuals_of(solution, reduced, None)
    spread = robust.spread_of(left, reduced.used)
    is_dark = float(solution.point.modulus.mean()) >= 0
    if is_dark and not robust.is_clean(left, reduced, spread):
        weighted = replace(reduced, weights=robust.tukey(left.value, reduced, spread))
        start = converge(problem, weighted, numbers)
        settled = robust.settle(start.problem, reduced, start, spread)
        if not settled.solution.converged or robust.is_clean(settled.left, reduced, settled.scale):
            settled = None
    return settled


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


def _illuminated(problem: Problem, reduced: Reduced, starts: list[np.ndarray]) -> Solution:
    """The optimum with the illumination that the image calls for.

    Many fringes tell it at once: the degrees are chosen on the optimum of full degree. A few are imitated by a
    background of high degree, and that optimum may be a false one: then every shape up to the second degree is fitted,
    from every start and from the others' optima, and the least Bayesian information criterion of the fits themselves
    decides; higher degrees then may join next to that optimum.
    """
    phase = problem.phase.fields(starts[0]).phase
    if fringe_count(reduced, phase) >= FEW:
        return converge(problem, reduced, starts[0])
    shapes = [replace(problem, degrees=shape) for shape in _SHAPES]
    tried = [converge(one, reduced, at) for one in shapes for at in starts]
    pixels = reduced.pixels

    def criterion(solution: Solution) -> float:
        variance = max(min(one.chi2 for one in tried) / pixels * reduced.grid.block**2, 1e-300)
        chi2 = solution.chi2 / variance
        spent = sum(normal_matrix(solution).active)
        return chi2 + float(spent) * np.log(pixels) if np.isfinite(chi2) else np.inf

    for best in sorted(tried, key=criterion)[:2]:
        tried += [converge(one, reduced, best.numbers) for one in shapes]
    best = min(tried, key=criterion)
    # Light of a high degree may take the fringes' place, and leave their numbers to run away.
    with np.errstate(over="ignore", invalid="ignore"):
        finer = converge(problem, reduced, best.numbers)
        tried.append(finer)
        is_near = abs(finer["curvature"] / best["curvature"] - 1) < _NEAR
        return finer if is_near and criterion(finer) < criterion(best) else best


def converge(problem: Problem, reduced: Reduced, numbers: np.ndarray, rounds: int = ROUNDS) -> Solution:
    """Near the optimum next to given numbers: with the problem's degrees, then with those that the image calls for."""
    solution = solve(problem, reduced, numbers, tolerance=_LOOSE, rounds=rounds)
    if not np.isfinite(solution.chi2):
        return solution
    degrees = choose_degrees(normal_matrix(solution), solution.chi2, solution.weight, reduced.pixels)
    chosen = (min(degrees[0], problem.degrees[0]), min(degrees[1], problem.degrees[1]))
    if chosen == problem.degrees:
        return solution
    again = solve(
        replace(problem, degrees=chosen),
        reduced,
        solution.numbers,
        tolerance=_LOOSE,
        first=solution.normal,
        rounds=rounds,
    )
    return again if solution.converged else replace(again, converged=False)
