"""What a fit leaves over: Tukey's biweights at their fixed point, and errors that neighbours share.

The weights are those of the very fit that they make.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from fitting.estimate.elimination import contrast_at_nodes
from fitting.estimate.fringe_sums import (
    TUKEY,
    Image,
    Pass,
    PhaseAt,
    Residuals,
    Sums,
    image_of,
    normal_equations,
    residuals,
)
from fitting.estimate.optimum import normal_matrix
from fitting.estimate.solver import Problem, Solution, descend
from fitting.model import BACKGROUND, degrees
from fitting.parameters import NUMBERS
from fitting.photo import Grid, Reduced, median, thin

# Share of blocks beyond four standard deviations from which on they are outliers (a normal distribution: 6e-5), and
# how many times the variance that their median tells residuals may have without any.
_OUTLIERS, _HEAVY = 1e-3, 2.0
# What rounding leaves of the light's sum of squares, in squares of its type's precision.
_ROUNDED = 1e6
# A step below this share of the numbers' standard deviation, correlation of residuals included, ends the rounds.
_SETTLED = 0.002
_MOST, _MEMORY, _SHORTER = 30, 4, 1.0
# What has not settled to this share after so many rounds has no fixed point nearby.
_LOST = 0.1
_LOW = len(degrees(BACKGROUND))
# Residuals are averaged over blocks of so many pixels to a side.
SIZES = (16, 32, 64, 128, 256)
_FEWEST = 8


class Settled(NamedTuple):
    """A fit at the fixed point, what it leaves over, and the standard deviation that its weights go by."""

    solution: Solution
    left: Residuals
    scale: float


def spread_of(residual: np.ndarray, reduced: Reduced) -> float:
    """Standard deviation of residuals, over the noise where it is not the same everywhere, from their median."""
    sample = thin(reduced.used)
    return 1.4826 * median(np.abs((residual[sample] * reduced.inverse_sd[sample])[reduced.used[sample]]))


def residuals_of(solution: Solution, reduced: Reduced, scale: float | None) -> Residuals:
    """What a solution leaves over of a reduced photograph."""
    edges = solution.problem.phase.edges(solution.numbers)
    image = image_of(solution.point.background, solution.point.modulus)
    return residuals(reduced, solution.fields.phase, image, scale, edges)


def is_clean(left: Residuals, reduced: Reduced, spread: float) -> bool:
    """Whether residuals hold no outliers: none beyond a normal distribution's, or rounding alone."""
    light = float((reduced.weights * reduced.light**2).sum(dtype=float))
    if left.square < _ROUNDED * np.finfo(reduced.light.dtype).eps ** 2 * light:
        return True
    sample = thin(reduced.used)
    deviations = np.abs((left.value[sample] * reduced.inverse_sd[sample])[reduced.used[sample]])
    square = float((reduced.weights * left.value**2).sum(dtype=float) / reduced.weights.sum(dtype=float))
    return bool(np.mean(deviations > 4 * spread) < _OUTLIERS and square < _HEAVY * spread**2)


def tukey(residual: np.ndarray, reduced: Reduced, spread: float | None = None) -> np.ndarray:
    """The blocks' weights times Tukey's biweights, which end at six standard deviations as the median tells them."""
    spread = spread_of(residual, reduced) if spread is None else spread
    if not spread:
        return reduced.weights
    share = np.clip(1 - (residual * reduced.inverse_sd / np.float32(TUKEY * spread)) ** 2, 0, None)
    return (reduced.weights * share**2).astype(reduced.weights.dtype)


def settle(problem: Problem, reduced: Reduced, start: Solution, scale: float) -> Settled:
    """The fixed point of fitting with the weights of the last fit, next to a start.

    Rounds alone come nearer by a third each; Anderson's mixing of the last few (1965), in the metric of the normal
    matrix, takes some six to ten rounds to a hundredth of a standard deviation. The answer is the point itself: it does
    not depend on how many rounds were made, nor on where they began.
    """
    state, solution, metric = _state(start, scale), start, None
    states: list[np.ndarray] = []
    steps: list[np.ndarray] = []
    shortest, inflation = np.inf, 1.0
    for _ in range(_MOST):
        moments, left = _round(problem, reduced, state)
        # One step: what it leaves, the next round takes, and mixing sees both alike.
        solution = descend(problem, normal_equations(moments), state[: len(NUMBERS)], steps=1)
        scale = spread_of(left.value, reduced)
        result = _state(solution, scale)
        step = result - state
        if metric is None:
            variance = max(left.square, 1e-300) / solution.weight
            inflation = fringe_correlation(reduced.grid, left)
            metric = _metric(solution, variance)
        moved = np.sqrt(float(((metric[: len(NUMBERS)] @ step) ** 2).sum()) / inflation)
        solution = replace(solution, converged=bool(moved < _LOST))
        if moved < _SETTLED or not np.isfinite(moved):
            break
        length = float(np.linalg.norm(metric @ step))
        if length > _SHORTER * shortest:
            # Mixing steps from where the map is not yet linear leads astray: begin again from here.
            states, steps = [], []
        shortest = length
        states, steps = [*states, state][-_MEMORY:], [*steps, step][-_MEMORY:]
        state = _mixed(states, steps, metric)
    left = residuals_of(solution, reduced, scale)
    return Settled(solution, left, scale)


def _state(solution: Solution, scale: float) -> np.ndarray:
    """Numbers, background, contrast of full degree, and the logarithm of the scale."""
    contrast = np.zeros(contrast_at_nodes().shape[1])
    contrast[: len(solution.point.contrast)] = solution.point.contrast
    return np.concatenate([solution.numbers, solution.point.background, contrast, [np.log(max(scale, 1e-300))]])


def _round(problem: Problem, reduced: Reduced, state: np.ndarray):
    numbers, background, contrast = np.split(state[:-1], [len(NUMBERS), len(NUMBERS) + _LOW])
    fields = problem.phase.fields(numbers)
    modulus = contrast_at_nodes() @ contrast
    image: Image = image_of(background, modulus if fields.contrast is None else modulus * fields.contrast)
    return fused(reduced, fields.phase, image, float(np.exp(state[-1])), problem.phase.edges(numbers))


def _metric(solution: Solution, variance: float) -> np.ndarray:
    """A matrix whose product with a step has its length in standard deviations: first that of the numbers alone."""
    here, count = normal_matrix(solution), len(NUMBERS)
    moving, size = np.flatnonzero(solution.problem.moving), len(here.values) + 1
    block = solution.point.matrix[np.ix_(moving, moving)] / variance
    value, vector = np.linalg.eigh(block)
    rows = np.zeros((count + size, size))
    rows[: len(moving), moving] = np.sqrt(np.maximum(value, 0))[:, None] * vector.T
    value, vector = np.linalg.eigh(here.matrix / variance * np.outer(here.active, here.active))
    rows[count:-1, :-1] = np.sqrt(np.maximum(value, 0))[:, None] * vector.T
    # The scale's own: half of chi-squared's information.
    rows[-1, -1] = np.sqrt(2 * solution.weight)
    return rows


def _mixed(states: list[np.ndarray], steps: list[np.ndarray], metric: np.ndarray) -> np.ndarray:
    """The point at which the steps seem to vanish: the combination of the last ones whose step is shortest."""
    if len(steps) == 1:
        return states[-1] + steps[-1]
    differences = np.stack([steps[-1] - step for step in steps[:-1]], axis=1)
    share = np.linalg.lstsq(metric @ differences, metric @ steps[-1], rcond=1e-6)[0]
    if np.abs(share).sum() > 100:
        return states[-1] + steps[-1]
    back = sum(
        part * (states[-1] + steps[-1] - state - step) for part, state, step in zip(share, states, steps, strict=False)
    )
    return states[-1] + steps[-1] - back


def fringe_correlation(grid: Grid, left: Residuals) -> float:
    """For a fringe's place: of the residual in quadrature to the fringes."""
    return correlation(grid, left.value * left.sine, left.weights, SIZES)


def correlation(grid: Grid, residual: np.ndarray, weights: np.ndarray, sizes: tuple[int, ...]) -> float:
    """Variance of block sums of residuals over that of independent ones; 1 for white noise.

    Where the blocks lie moves the ratio by some 20 %: it is the mean over four grids, on the frame's own and half a
    block off it in rows, columns and both, so that a picture and its mirror have the same. A ratio within three
    standard errors of 1 is 1; of several sizes of blocks [px] the largest ratio counts.
    """
    variance = _mean(weights * residual**2, weights)
    if not variance > 0:
        return 1.0
    tables = np.stack([_summed(weights), _summed(weights * residual)])
    largest = 1.0
    for size in sizes:
        # A size in the grid's own blocks, at least two of them.
        side = max(2, round(size / grid.block))
        ratios, count = [], np.inf
        for rows in (0, side // 2):
            for columns in (0, side // 2):
                weight, total = _blocks(tables, grid, side, (rows, columns))
                covered = weight > 0.5 * side**2
                count = min(count, covered.sum())
                if covered.sum() >= _FEWEST:
                    ratios.append(float(np.mean(total[covered] ** 2 / weight[covered])) / variance)
        if ratios and count >= _FEWEST and (ratio := float(np.mean(ratios))) > 1 + 3 * np.sqrt(2 / count):
            largest = max(largest, ratio)
    return largest


def _mean(values: np.ndarray, weights: np.ndarray) -> float:
    return float(values.sum(dtype=float) / max(weights.sum(dtype=float), 1e-300))


def _summed(table: np.ndarray) -> np.ndarray:
    """Sums over all above and to the left, with a row and a column of zeros first."""
    totals = np.zeros([n + 1 for n in table.shape])
    np.cumsum(table, axis=0, dtype=float, out=totals[1:, 1:])
    np.cumsum(totals[1:, 1:], axis=1, out=totals[1:, 1:])
    return totals


def _blocks(summed: np.ndarray, grid: Grid, side: int, offset: tuple[int, int]) -> np.ndarray:
    """Sums over blocks on the whole frame's grid, moved by an offset; those at the box's edges are cut off by it.

    `summed` [tables, rows + 1, columns + 1].
    """
    edges = []
    for first, shift, size in zip((grid.rows[0], grid.columns[0]), offset, summed.shape[1:], strict=True):
        inner = range((shift - first) % side or side, size - 1, side)
        edges.append(np.array([0, *inner, size - 1]))
    return np.diff(np.diff(summed[:, edges[0][:, None], edges[1]], axis=1), axis=2)


def fused(
    reduced: Reduced,
    reference: Float64[np.ndarray, " nodes"],
    image: Image,
    scale: float | None,
    phase_at: PhaseAt | None = None,
) -> tuple[Sums, Residuals]:
    """Both in one pass: residuals of a fit whose phase is the reference, and moments with Tukey's weights of them."""
    work = Pass(reduced, reference, phase_at, image, scale)
    return work.sums(), work.residuals()
