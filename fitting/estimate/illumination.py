"""Least squares on one photograph: the illumination that it calls for, and its outliers."""

from dataclasses import replace

import numpy as np

from fitting.estimate import robust
from fitting.estimate.fringe_sums import Residuals, Sums, fringe_count, normal_equations
from fitting.estimate.optimum import choose_degrees, normal_matrix
from fitting.estimate.solver import Problem, Solution, solve, stay
from fitting.parameters import Numbers
from fitting.photo import Reduced

# With fewer fringes than this a background of high degree imitates them; then these degrees of background and contrast.
FEW = 4.0
FEW_SHAPES = ((0, 0), (1, 1), (2, 2))
# Higher degrees then only finish the fit: what moves the scale by more than this is another optimum.
_NEAR = 0.15
# How often moments are taken anew in one solve, at most.
ROUNDS = 15
# A step that promises a smaller drop of chi-squared [variances] is the last one before degrees or weights are known.
_LOOSE = 1e-2


def robust_from(
    problem: Problem, reduced: Reduced, starts: list[np.ndarray], is_near: bool = False
) -> tuple[Solution, Residuals, float | None]:
    """The robust fit from starts that may be far: its outliers are those of a fit without weights.

    `is_near`: whether they are about the optimum.
    """
    solution = _illuminated(problem, reduced, starts, is_near)
    if float(solution.point.modulus.mean()) < 0 and "phase" in solution.problem.free:
        turned = np.array(Numbers(*solution.numbers)._replace(phase=solution["phase"] + 0.5))
        solution = _illuminated(problem, reduced, [turned], is_near)
    left, scale = robust.residuals_of(solution, reduced, None), None
    spread = robust.spread_of(left.value, reduced)
    if not robust.is_clean(left, reduced, spread):
        weighted = replace(reduced, weights=robust.tukey(left.value, reduced, spread))
        start = _illuminated(problem, weighted, [solution.numbers], is_near)
        settled = robust.settle(start.problem, reduced, start, spread)
        # What a bad first fit took for outliers may be none.
        if robust.is_clean(settled.left, reduced, settled.scale):
            solution = _illuminated(problem, reduced, [settled.solution.numbers], is_near)
        else:
            solution, left, scale = settled
    if scale is None:
        solution = solve(solution.problem, reduced, solution.numbers, first=solution.normal)
        left = robust.residuals_of(solution, reduced, None)
    return solution, left, scale


def near_fit(problem: Problem, numbers: np.ndarray, reduced: Reduced, moments: Sums) -> robust.Settled | None:
    """The robust fit next to numbers by which outliers are told; None where they are none.

    `moments`: about the phase of these numbers.
    """
    settled = None
    solution = stay(problem, normal_equations(moments), numbers)
    left = robust.residuals_of(solution, reduced, None)
    spread = robust.spread_of(left.value, reduced)
    is_dark = float(solution.point.modulus.mean()) >= 0
    if is_dark and not robust.is_clean(left, reduced, spread):
        weighted = replace(reduced, weights=robust.tukey(left.value, reduced, spread))
        start = converge(problem, weighted, numbers)
        settled = robust.settle(start.problem, reduced, start, spread)
        if not settled.solution.converged or robust.is_clean(settled.left, reduced, settled.scale):
            settled = None
    return settled


def _illuminated(problem: Problem, reduced: Reduced, starts: list[np.ndarray], is_near: bool = False) -> Solution:
    """The optimum with the illumination that the image calls for.

    Many fringes tell it at once: the degrees are chosen on the optimum of full degree. A few are imitated by a
    background of high degree, and that optimum may be a false one: then every shape up to the second degree is fitted,
    from every start and, unless these are near, from the others' optima, and the least Bayesian information criterion
    of the fits themselves decides; higher degrees then may join next to that optimum.
    """
    phase = problem.phase.fields(starts[0]).phase
    if fringe_count(reduced, phase) >= FEW:
        return converge(problem, reduced, starts[0])
    shapes = [replace(problem, degrees=shape) for shape in FEW_SHAPES]
    tried = [converge(one, reduced, at) for one in shapes for at in starts]
    pixels = reduced.pixels

    def criterion(solution: Solution) -> float:
        variance = max(min(one.chi2 for one in tried) / pixels * reduced.grid.block**2, 1e-300)
        chi2 = solution.chi2 / variance
        spent = sum(normal_matrix(solution).active)
        return chi2 + float(spent) * np.log(pixels) if np.isfinite(chi2) else np.inf

    for best in () if is_near else sorted(tried, key=criterion)[:2]:
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
