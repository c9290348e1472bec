"""One frame after another of the same view: each fit starts from the one before it, and says where it was lost."""

from dataclasses import dataclass, replace

import numpy as np

from fitting.estimate import (
    Fitted,
    Normal,
    Problem,
    Residuals,
    Solution,
    eliminate,
    fused,
    image_of,
    is_clean,
    moved_to,
    normal_equations,
    normal_matrix,
    problem_of,
    robust,
    sharpened,
    solve,
    sums,
    tilted,
)
from fitting.parameters import NUMBERS
from fitting.photo import Photograph, Reduced, read_again, reduce
from fitting.reasons import Reason
from newtonjax.numerics import Statement

# A share of the lit field that must be left to measure; of the variance of the last frame's light, that tells a dark
# or blank frame from one whose rings went elsewhere.
_USABLE, _FAINT = 0.2, 0.01
# Of what the last frame's rings left unexplained, so many times, and so much more of the variance, is followed.
_WORSE, _MORE = 2.0, 0.03
# New moments in one frame, at most: further away the rings are not those of the last frame.
_ROUNDS = 6
# Robust rounds end so many standard deviations before their fixed point, or after so many.
_SETTLED, _MOST, _SLOWEST = 0.05, 10, 0.9
_PHASE = NUMBERS.index("phase")


@dataclass(frozen=True)
class Track:
    """The last frame that was measured, and the numbers of the one before it (None: none).

    `spread`: standard deviation of its light. The phase goes on from frame to frame, whole turns included.
    """

    photograph: Photograph
    fit: Fitted
    spread: float
    before: np.ndarray | None = None


class LostError(Exception):
    """A frame that holds no rings to follow: why; `hopeless`: a search would find none either."""

    def __init__(self, reason: Statement, hopeless: bool = False):
        super().__init__(reason)
        self.reason, self.hopeless = reason, hopeless


def begin(photograph: Photograph, fit: Fitted) -> Track:
    """The track of a frame that was measured by itself."""
    return Track(photograph, fit, _spread(photograph))


def follow(track: Track, frame: np.ndarray) -> Track:
    """The next frame, from the last one's numbers, or from where these were going. Raises LostError."""
    try:
        photograph = read_again(frame, track.photograph)
    except ValueError as error:
        raise LostError(Reason.FRAME_UNUSABLE(error=str(error)), hopeless=True) from None
    _require_light(photograph, track)
    numbers = track.fit.numbers
    starts = [numbers] if track.before is None else [numbers, 2 * numbers - track.before]
    for start in starts:
        try:
            fit = _fit(photograph, track.fit, start)
        except ValueError:  # no block of pixels is left, or an illumination that nothing determines
            fit = None
        if fit is not None and 1 - fit.explained < _WORSE * (1 - track.fit.explained) + _MORE:
            return Track(photograph, fit, _spread(photograph), numbers)
    if _spread(photograph) < np.sqrt(_FAINT) * track.spread:
        raise LostError(Reason.FRAME_DARK(), hopeless=True)
    raise LostError(Reason.RINGS_LOST())


def _require_light(photograph: Photograph, track: Track) -> None:
    field = int(track.photograph.lit.sum())
    finite, usable = int(photograph.lit.sum()), int(photograph.mask.sum())
    if finite < _USABLE * field:
        raise LostError(Reason.FRAME_MASKED(share=1 - finite / field), hopeless=True)
    if usable < _USABLE * field:
        raise LostError(Reason.FRAME_SATURATED(share=1 - usable / field), hopeless=True)
    if _spread(photograph) == 0:
        raise LostError(Reason.FRAME_UNIFORM(), hopeless=True)


def _spread(photograph: Photograph) -> float:
    step = max(1, min(photograph.codes.shape) // 64)
    some = (slice(None, None, step),) * 2
    light = photograph.codes.light(some)[photograph.mask[some]]
    return float(light.std()) if light.size else 0.0


def _fit(photograph: Photograph, last: Fitted, start: np.ndarray) -> Fitted | None:
    """The optimum with the last frame's parts and degrees of the illumination; None where there is none near."""
    reduced = reduce(photograph, last.reduced.grid.block, dtype=last.reduced.light.dtype.type)
    model = moved_to(last.model, reduced.grid, start)
    problem = problem_of(model, last.fixed, last.parts, last.shape, last.solution.problem.prior)
    solution = _nearest(problem, _with_weights_of(last, reduced), start, last)
    same_sign = solution.point.modulus.mean() * last.solution.point.modulus.mean() > 0
    if not (solution.converged and np.isfinite(solution.chi2) and same_sign):
        return None
    solution, residuals, scale = _weighed_down(problem, reduced, solution, last)
    if not solution.converged:
        return None
    matrix = normal_matrix(solution)
    return sharpened(Fitted(model, reduced, solution, residuals, scale, last.fixed, last.parts, matrix))


def _with_weights_of(last: Fitted, reduced: Reduced) -> Reduced:
    """What was in the way of the last frame is in the way of this one."""
    if last.scale is None or last.reduced.grid != reduced.grid:
        return reduced
    return replace(reduced, weights=np.minimum(reduced.weights, last.left.weights))


def _nearest(problem: Problem, reduced: Reduced, start: np.ndarray, last: Fitted) -> Solution:
    """The optimum next to a start whose phase is first moved as all fringes together moved."""
    normal = normal_equations(sums(reduced, problem.phase.fields(start).phase, problem.phase.edges(start)))
    shifted = start.copy()
    if problem.moving[_PHASE]:
        shifted[_PHASE] += _step(problem, normal, last)
    return solve(problem, reduced, shifted, first=normal, rounds=_ROUNDS)


def _weighed_down(
    problem: Problem, reduced: Reduced, first: Solution, last: Fitted
) -> tuple[Solution, Residuals, float | None]:
    """A fit whose outliers are weighted down, if it has any, as `estimate.robust_fit` does."""
    residuals = robust.residuals_of(first, reduced, None)
    spread = robust.spread_of(residuals.value, reduced)
    if not is_clean(residuals, reduced, spread):
        return _rounds(problem, reduced, first, spread)
    if last.scale is None:
        return first, residuals, None
    # It was begun with the weights of a frame that had outliers.
    plain = solve(problem, reduced, first.numbers)
    return plain, robust.residuals_of(plain, reduced, None), None


def _rounds(problem: Problem, reduced: Reduced, solution: Solution, scale: float) -> tuple[Solution, Residuals, float]:
    """Fits with the weights of the last fit: from the last frame's weights a few come as near as need be.

    The way that is left to the fixed point of `robust.settle` is told from two steps, as a geometric series.
    """
    moving, distance = problem.moving, 0.0
    for _ in range(_MOST):
        edges = problem.phase.edges(solution.numbers)
        image = image_of(solution.point.background, solution.point.modulus)
        moments, residuals = fused(reduced, solution.fields.phase, image, scale, edges)
        weighted = replace(reduced, weights=residuals.weights)
        further = solve(problem, weighted, solution.numbers, first=normal_equations(moments), rounds=_ROUNDS)
        step = (further.numbers - solution.numbers)[moving]
        information = further.point.matrix[np.ix_(moving, moving)] * further.weight / max(further.chi2, 1e-300)
        solution, scale = further, robust.spread_of(residuals.value, reduced)
        previous, distance = distance, float(np.sqrt(step @ information @ step))
        share = min(distance / previous, _SLOWEST) if previous else _SLOWEST
        if distance * share < _SETTLED * (1 - share):
            break
    return solution, robust.residuals_of(solution, reduced, scale), scale


def _step(problem: Problem, normal: Normal, last: Fitted) -> float:
    """By how many turns, -1/2 to 1/2, all fringes moved together: both quadratures of the last contrast, linearly.

    As in phase stepping (Greivenkamp 1984): no search of half-turns, which differ by the sign of the contrast only.
    """
    profiled = eliminate(normal, problem.degrees[0])
    modulus = last.solution.point.modulus[:, None]
    columns = np.concatenate([tilted(modulus, np.full(len(modulus), turn)) for turn in (0.0, 0.25)], axis=1)
    even, odd = np.linalg.lstsq(columns.T @ profiled.fringes @ columns, columns.T @ profiled.of_fringes, rcond=1e-12)[0]
    return float(np.arctan2(odd, even) / (2 * np.pi))
