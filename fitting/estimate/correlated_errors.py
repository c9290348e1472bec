"""By how much errors that neighbours share raise the variance of what a fit measures."""

import numpy as np

from fitting.estimate.fringe_sums import Residuals
from fitting.photo import Grid

# Residuals are averaged over blocks of so many pixels to a side.
SIZES = (16, 32, 64, 128, 256)
_FEWEST = 8


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
                whole = weight > 0.5 * side**2
                count = min(count, whole.sum())
                if whole.sum() >= _FEWEST:
                    ratios.append(float(np.mean(total[whole] ** 2 / weight[whole])) / variance)
        if ratios and count >= _FEWEST and (ratio := float(np.mean(ratios))) > 1 + 3 * np.sqrt(2 / count):
            largest = max(largest, ratio)
    return largest


def _mean(values: np.ndarray, weights: np.ndarray) -> float:
    return float(values.sum(dtype=float) / max(weights.sum(dtype=float), 1e-300))


def _summed(table: np.ndarray) -> np.ndarray:
    """Sums over all above and to the left, with a row and a column of zeros first."""
    found = np.zeros([n + 1 for n in table.shape])
    np.cumsum(table, axis=0, dtype=float, out=found[1:, 1:])
    np.cumsum(found[1:, 1:], axis=1, out=found[1:, 1:])
    return found


def _blocks(summed: np.ndarray, grid: Grid, side: int, offset: tuple[int, int]) -> np.ndarray:
    """Sums over blocks on the whole frame's grid, moved by an offset; those at the box's edges are cut off by it.

    `summed` [tables, rows + 1, columns + 1].
    """
    edges = []
    for first, shift, size in zip((grid.rows[0], grid.columns[0]), offset, summed.shape[1:], strict=True):
        inner = range((shift - first) % side or side, size - 1, side)
        edges.append(np.array([0, *inner, size - 1]))
    return np.diff(np.diff(summed[:, edges[0][:, None], edges[1]], axis=1), axis=2)
