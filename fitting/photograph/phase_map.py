"""Where fringes lie against a fit of them: an image demodulated by the fit's phase, and unwrapped."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from fitting.estimate import Fitted, Problem, Solution, at_blocks
from fitting.model import gap_phase, numbers_of
from fitting.parameters import NUMBERS, Numbers, slots_of
from fitting.photo import Reduced, block_means

# A phase that misses the fringes by more than this (root mean square) [turns] is followed from block to block first;
# that takes so many fringes, and so many blocks to a side.
_ASTRAY, _MANY, _BLOCKS = 0.1, 20.0, 40
# A step of a trial that promises a smaller drop of chi-squared [variances, correlation included] is its last one; on
# the phase alone one that gains a smaller share of that is.
TOLERANCE, _NEGLIGIBLE = 0.02, 0.1
# Places to a side where only the nearest of many starts is looked for; steps while what is replaced is held, and after.
_FEW_BLOCKS, _FOLLOWING, _STEPS = 20, 3, 8


def followed(fit: Fitted, parts: tuple[str, ...]) -> np.ndarray | None:
    """Numbers to start a fit with parts from where the fit leaves whole fringes astray: the phase map's, else None."""
    numbers, model = fit.numbers, fit.solution.problem.phase.exact
    if model is None or fit.orders < _MANY:
        return None
    x, y, difference, strength = phase_map(fit.reduced, fit.phase)
    if not np.any(strength) or np.sqrt(np.average(difference**2, weights=strength)) < _ASTRAY:
        return None
    # What is given stays as it is.
    own = [name for name in ("curvature", "centre_x", "centre_y", "phase") if name in fit.solution.problem.free]
    names = (*own, *numbers_of(parts))
    target, root = gap_phase.phase(model, x, y, numbers) + difference, np.sqrt(strength)
    trial = numbers.copy()
    for _ in range(4):
        # A step may lead anywhere, as in `Target.nearest`.
        with np.errstate(over="ignore", invalid="ignore"):
            phase, slopes = gap_phase.phase_and_slopes(model, x, y, trial)
            slope = np.stack([slopes[name] for name in names], axis=1) * root[:, None]
            ahead = (target - phase) * root
        if not (np.isfinite(slope).all() and np.isfinite(ahead).all()):
            return None
        trial[slots_of(names)] += np.linalg.lstsq(slope, ahead, rcond=1e-12)[0]
    return trial if np.isfinite(trial).all() else None


def nearer_numbers(
    solution: Solution, reduced: Reduced, starts: Sequence[Mapping[str, float]], variance: float
) -> np.ndarray | None:
    """Numbers of less cost that make the fringes' phase, from a trial's with some replaced; None for none.

    They are looked for on the phase alone. `variance`: of the light per unit weight, correlation included.
    """
    problem, grid, numbers = solution.problem, reduced.grid, solution.numbers
    # A traced bench is known at its nodes alone.
    if problem.phase.exact is None:
        return None
    edges = problem.phase.edges(numbers)
    phase = at_blocks(grid, solution.fields.phase) if edges is None else edges(grid, slice(None))
    least = TOLERANCE * variance
    # The numbers of a fit that ran away may be beyond what a phase can be computed of.
    with np.errstate(over="ignore", invalid="ignore"):
        target = Target(solution, reduced, phase, _NEGLIGIBLE * least)
    if not np.isfinite(target.turns).all():
        return None
    reference, *alternatives = (target.nearest(problem, numbers, start) for start in ({}, *starts))
    end = min(alternatives, key=lambda end: end.cost, default=reference)
    return end.numbers if end.cost < reference.cost - least else None


class End(NamedTuple):
    """Numbers that make the fringes' phase, and what they cost: the difference in chi-squared, and priors."""

    numbers: np.ndarray
    cost: float


class Target:
    """Where the fringes of an image lie, place by place, as a fit of about the same phase tells.

    `negligible`: a cost for which no further step is made.
    """

    def __init__(self, solution: Solution, reduced: Reduced, phase: np.ndarray, negligible: float):
        self.negligible = negligible
        self.x, self.y, ahead, strength = phase_map(reduced, phase, _FEW_BLOCKS)
        self.turns = solution.problem.phase.slopes_at(self.x, self.y, solution.numbers)[0] + ahead
        # A phasor is half of the fringes' swing; they average over all phases.
        self.root = 2 * np.pi * np.sqrt(2 * strength * solution.weight / max(len(self.x), 1))

    def nearest(self, problem: Problem, numbers: np.ndarray, start: Mapping[str, float]) -> End:
        """The numbers that come nearest, priors and all, from some of them as they start: by Gauss and Newton's steps.

        These are held until the others have followed them.
        """
        numbers = np.array(Numbers(*numbers)._replace(**start))
        released = np.flatnonzero(problem.moving & ~np.isin(NUMBERS, list(start)))
        # A step may lead anywhere: what is no number there is not nearer.
        with np.errstate(over="ignore", invalid="ignore"):
            numbers = self._stepped(problem, numbers, released, _FOLLOWING).numbers
            return self._stepped(problem, numbers, np.flatnonzero(problem.moving), _STEPS)

    def _stepped(self, problem: Problem, numbers: np.ndarray, moving: np.ndarray, most: int) -> End:
        centre, cost = problem.pull
        names = [NUMBERS[at] for at in moving]
        end, share, step = End(numbers, np.inf), 1.0, np.zeros(len(moving))
        for _ in range(most):
            turns, slopes = problem.phase.slopes_at(self.x, self.y, numbers)
            ahead, pull = (self.turns - turns) * self.root, cost * (centre - numbers)
            total = float(ahead @ ahead + pull @ (centre - numbers))
            if total < end.cost:
                is_last = total > end.cost - self.negligible
                end, share = End(numbers, total), 1.0
                if is_last:
                    break
                rows = np.stack([slopes[name] * self.root for name in names])
                matrix, gradient = rows @ rows.T + np.diag(cost[moving]), rows @ ahead + pull[moving]
                if not (np.isfinite(matrix).all() and np.isfinite(gradient).all()):
                    break
                step = _solved(matrix, gradient)
            else:
                share /= 4
            numbers = end.numbers.copy()
            numbers[moving] += share * step
        return end


def _solved(matrix: np.ndarray, gradient: np.ndarray) -> np.ndarray:
    size = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    size = np.where(size > 0, size, 1.0)
    return np.linalg.lstsq(matrix / np.outer(size, size), gradient / size, rcond=1e-14)[0] / size


def phase_map(reduced: Reduced, phase: np.ndarray, to_a_side: int = _BLOCKS) -> tuple[np.ndarray, ...]:
    """By how much the fringes are ahead of a fit, place by place: x, y [px], turns, and strength.

    The image is demodulated by the fit's phase at every block, averaged over some places to a side, and its argument
    unwrapped.
    """
    from skimage.restoration import unwrap_phase

    factor = max(2, min(reduced.light.shape) // to_a_side)
    used = reduced.used
    background = block_means(reduced.light, factor)
    turns = np.exp(-2j * np.pi * phase) * used
    total, share = block_means(reduced.light * turns, factor), block_means(turns, factor)
    covered = block_means(used.astype(float), factor)
    phasors = total - share * background / np.maximum(covered, 1e-3)
    phasors = ndimage.gaussian_filter(phasors.real, 0.7) + 1j * ndimage.gaussian_filter(phasors.imag, 0.7)
    good = covered > 0.5
    strength = np.where(good, np.abs(phasors) ** 2, 0.0)
    good &= strength > 0.1 * np.median(strength[good]) if good.any() else False
    difference = np.ma.filled(unwrap_phase(np.ma.array(np.angle(phasors), mask=~good)), 0.0) / (2 * np.pi)
    y, x = np.meshgrid(
        *(block_means(at[:, None] * np.ones(factor), factor)[:, 0] for at in (reduced.grid.y, reduced.grid.x)),
        indexing="ij",
    )
    difference -= np.round(np.average(difference[good], weights=strength[good])) if good.any() else 0.0
    return x.ravel(), y.ravel(), difference.ravel(), np.where(good, strength, 0.0).ravel()
