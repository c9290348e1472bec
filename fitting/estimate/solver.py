"""Least squares on a reduced photograph: a `Problem` down, a `Solution` up.

The loop is NumPy's: a solve from the last solution takes 3 ms and compiles nothing. optimistix on one compiled program
of 334 residuals and 52 unknowns took 4.0 s of CPU to compile and 1.3 s from a warm cache: 9 and 3 times `import jax`.

A user who fits many frames of one view makes the grid and the problem once and starts each frame from the last
solution's numbers; about 3 ms a frame of 256 x 256:

    reduced = reduce(photograph, block_size(finest))
    solution = solve(problem, reduced, solution.numbers)
    solution.converged, solution["curvature"], solution.covariance(variance)
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float64

from fitting.estimate.block_phases import AbstractFringes
from fitting.estimate.elimination import CONTRAST, Fields, Point, eliminate, evaluate_model
from fitting.estimate.fringe_sums import Normal, normal_equations, sums
from fitting.model import BACKGROUND
from fitting.parameters import NUMBERS
from fitting.photo import Reduced

# A phase further from the moments' reference [turns] is not followed without new ones; within the second, or where the
# phase has an edge within the third, they are exact to rounding.
_FAR, _NEAR, _NEAR_EDGE = 0.45, 0.1, 0.003
# A step that promises a smaller drop of chi-squared [variances] is the last one.
TOLERANCE = 1e-4
_STEPS, _ROUNDS = 100, 40
# What single precision leaves of the sum of squares.
_ROUNDING = 1e-9
# Of a phase beyond this [turns] no fraction of a turn is left.
_LOST = 1e12


@dataclass(frozen=True)
class Prior:
    """What is known before an image is seen: by number a value and its deviation; `variance`: of the light.

    A variance per unit weight, in which a prior weighs against the image.
    """

    numbers: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    variance: float = 1.0


NO_PRIOR = Prior()


@dataclass(frozen=True)
class Problem:
    """What is fitted: the phase's model, which of its numbers move, the illumination's degrees, and priors.

    `free`: names of `parameters.NUMBERS`; the others stay as they start. `degrees`: of background (0 to 6) and contrast
    (0 to 4).
    """

    phase: AbstractFringes
    free: tuple[str, ...]
    degrees: tuple[int, int] = (BACKGROUND, CONTRAST)
    prior: Prior = NO_PRIOR

    @cached_property
    def moving(self) -> Bool[np.ndarray, " numbers"]:
        return np.array([name in self.free for name in NUMBERS])

    @cached_property
    def pull(self) -> tuple[np.ndarray, np.ndarray]:
        """Centres of the priors and what a unit away from them costs, in chi-squared; by number, zero without."""
        none = (0.0, np.inf)
        held = self.prior.numbers
        centre, sd = np.array([held[name] if name in held and name in self.free else none for name in NUMBERS]).T
        return centre, self.prior.variance / sd**2


@dataclass(frozen=True)
class Solution:
    """An optimum: the numbers in the order of `parameters.NUMBERS`, and what is known of them.

    - `normal`: the moments that it is the optimum of; `point`: chi-squared and its derivatives there.
    - `chi2`: Σ w (light - fit)² as the moments give it; single precision leaves 1e-7 of the light's own sum of squares.
    - `converged`; `excursion`: largest distance of the phase from the moments' reference, over the nodes [turns].
    - `weight`: sum of the weights; `steps`: that were made on these moments.
    """

    problem: Problem
    numbers: Float64[np.ndarray, " numbers"]
    normal: Normal
    fields: Fields
    point: Point
    chi2: float
    converged: bool
    excursion: float
    weight: float
    steps: int = 0

    def __getitem__(self, name: str) -> float:
        """A number by its name in `parameters.NUMBERS`."""
        return float(self.numbers[NUMBERS.index(name)])


def solve(
    problem: Problem,
    reduced: Reduced,
    start: Float64[np.ndarray, " numbers"],
    *,
    tolerance: float = TOLERANCE,
    first: Normal | None = None,
    rounds: int = _ROUNDS,
    near: float | None = None,
    steps: int = _STEPS,
) -> Solution:
    """The optimum next to a start, on moments that follow it.

    `first`: moments about the phase of the start, where there are any; `rounds`: how often new ones are taken, at most;
    `near`: how far from them the optimum's phase may be [turns], 0.1 and with an edge 0.003 unless given; `steps`: in
    all. What runs out of them ends, not converged, where it is.
    """
    numbers, left, spent = np.array(start, float), rounds, 0
    while True:
        edges = problem.phase.edges(numbers)
        if first is None:
            # Numbers may lie anywhere; sums that are not finite end the solve below, not converged.
            with np.errstate(over="ignore", invalid="ignore"):
                first = normal_equations(sums(reduced, problem.phase.fields(numbers).phase, edges))
        solution = descend(problem, first, numbers, tolerance, steps - spent)
        spent += solution.steps
        if solution.excursion < (near or (_NEAR if edges is None else _NEAR_EDGE)) or not np.isfinite(solution.chi2):
            return solution
        numbers, first, left = solution.numbers, None, left - 1
        if left == 0 or spent >= steps:
            return replace(solution, converged=False)


def descend(
    problem: Problem, normal: Normal, start: np.ndarray, tolerance: float = TOLERANCE, steps: int = _STEPS
) -> Solution:
    """The optimum on given moments, by Gauss and Newton's steps, damped where they overshoot (Marquardt 1963).

    Ends, converged, at the edge of what the moments hold too: new ones are to be taken there.
    """
    moving, (centre, cost) = np.flatnonzero(problem.moving), problem.pull
    rest, degree = eliminate(normal, problem.degrees[0]), problem.degrees[1]
    weight = float(normal.smooth[0, 0])
    numbers, damping, converged = np.array(start, float), 0.0, False
    fields, point = evaluate_model(rest, problem.phase.fields, numbers, degree)
    count = 0
    for count in range(1, steps + 1):  # noqa: B007  # the solution says it
        # A start may lie anywhere, as a step may.
        with np.errstate(over="ignore", invalid="ignore"):
            matrix = point.matrix[np.ix_(moving, moving)] + np.diag(cost[moving])
            gradient = (point.gradient - cost * (numbers - centre))[moving]
        is_finite = np.isfinite(matrix).all() and np.isfinite(gradient).all()
        if not (is_finite and np.abs(fields.phase).max() < _LOST):
            break
        step = _step(matrix, gradient, damping)
        # Where every pixel is an outlier there is no weight.
        variance = max(_objective(point, numbers, centre, cost), 0.0) / max(weight, 1e-300)
        promised = float(2 * gradient @ step - step @ matrix @ step)
        share, reach = _within_moments(fields, moving, step, normal.reference)
        if not np.isfinite(reach):
            break
        step *= share
        trial = numbers.copy()
        trial[moving] += step
        further = evaluate_model(rest, problem.phase.fields, trial, degree)
        better = _objective(further[1], trial, centre, cost) <= _objective(point, numbers, centre, cost)
        small = promised < max(tolerance * variance, _ROUNDING * 1e-6 * normal.square)
        if better:
            numbers, (fields, point) = trial, further
            damping = damping / 10 if damping > 1e-8 else 0.0
        elif promised < _ROUNDING * normal.square:
            # Rounding hides which of both is better; the gradient, which vanishes at the optimum, still tells.
            numbers, (fields, point), small = trial, further, True
        else:
            damping = max(10 * damping, 1e-3)
        if small or (better and reach > _FAR):
            converged = True
            break
        if damping > 1e8:
            break
    return _solution(problem, normal, numbers, fields, point, converged, count)


def stay(problem: Problem, normal: Normal, numbers: np.ndarray, converged: bool = True) -> Solution:
    """The best illumination for given numbers, on moments about their phase."""
    rest = eliminate(normal, problem.degrees[0])
    fields, point = evaluate_model(rest, problem.phase.fields, numbers, problem.degrees[1])
    return _solution(problem, normal, numbers, fields, point, converged)


def _solution(
    problem: Problem,
    normal: Normal,
    numbers: np.ndarray,
    fields: Fields,
    point: Point,
    converged: bool,
    steps: int = 0,
) -> Solution:
    excursion, weight = float(np.abs(fields.phase - normal.reference).max()), float(normal.smooth[0, 0])
    return Solution(problem, numbers, normal, fields, point, point.chi2, converged, excursion, weight, steps)


def _objective(point: Point, numbers: np.ndarray, centre: np.ndarray, cost: np.ndarray) -> float:
    value = point.chi2 + float(cost @ (numbers - centre) ** 2)
    return value if np.isfinite(value) else np.inf


def _step(matrix: np.ndarray, gradient: np.ndarray, damping: float) -> np.ndarray:
    size = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    size = np.where(size > 0, size, 1.0)
    scaled = matrix / np.outer(size, size) + damping * np.eye(len(size))
    if not np.isfinite(scaled).all():
        return np.full(len(size), np.nan)
    return np.linalg.lstsq(scaled, gradient / size, rcond=1e-14)[0] / size


def _within_moments(fields: Fields, moving: np.ndarray, step: np.ndarray, reference: np.ndarray) -> tuple[float, float]:
    """The share of a step that the moments hold, as the phase's tangent has it, and how far all of it goes [turns]."""
    ahead, bend = fields.phase - reference, fields.slopes[:, moving] @ step
    reach = np.abs(fields.phase + bend - reference).max()
    if not reach > _FAR:
        return 1.0, reach
    room = np.where(bend > 0, _FAR - ahead, _FAR + ahead)
    return float(np.clip((room / np.maximum(np.abs(bend), 1e-300)).min(), 0.0, 1.0)), reach
