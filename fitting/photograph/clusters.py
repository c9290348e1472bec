"""How residuals that err together make a curvature scatter: sums over blocks, sectors and zones of the field.

The influence of each block of pixels on the curvature times its residual, summed over clusters: the sum of squares is
the curvature's variance whatever the errors inside of a cluster have in common (Liang and Zeger 1986).
"""

from collections.abc import Iterator

import numpy as np

from fitting.estimate import Fitted, at_blocks, contrast_at_nodes
from fitting.model import BACKGROUND, WARPS, degrees
from fitting.parameters import NUMBERS, Numbers
from fitting.photograph.averaging import variance_of
from fitting.photograph.choice import Choice

# Blocks to a side [px], sectors about the rings' centre, and zones of order; clusters that a sum needs.
_SIDES, _SECTORS, _ZONES, _FEWEST = (16, 32, 64, 128, 256, 512), (12, 16, 20), (8, 10, 12), 8


def with_shift_to_mean(choice: Choice) -> Choice:
    """The choice with `shift` and `ratio`, of its fit after `finely` and `sharpened`."""
    fit, averaging = choice.found, choice.averaging
    if averaging is None or not fit.converged:
        return choice
    variance = variance_of(fit)[0]
    of_data = max(data_variance(fit, variance), 1e-300)
    warps = frozenset(part for part in fit.parts if part in WARPS)
    average = averaging.mean(variance)
    of_warps = averaging.mean(variance, lambda parts: parts == warps).best[2]
    shift = np.where(fit.solution.problem.moving, average.numbers - of_warps, 0.0)
    return choice._replace(shift=shift, ratio=scatter(fit, of_data) / of_data)


def scatter(fit: Fitted, least: float) -> float:
    """The largest variance of the curvature, over ways to cut the field into clusters; `least`: what it is at least.

    A variance of few clusters is uncertain: within two of its standard deviations of the least one it is that.
    """
    influence = fit.left.weights * fit.left.value * _influence(fit)
    largest = least
    for ways in (*_blocks(fit, influence), _slices(_angles(fit), influence, fit), _slices(_ranks(fit), influence, fit)):
        cuts = [(float(sums @ sums), count) for sums in ways if (count := np.count_nonzero(sums)) >= _FEWEST]
        variances = [square * count / (count - 1) for square, count in cuts]
        if not cuts:
            continue
        mean, fewest = float(np.mean(variances)), min(count for _, count in cuts)
        if mean > least * (1 + 2 * np.sqrt(2 / fewest)):
            largest = max(largest, mean)
    return largest


def data_variance(fit: Fitted, variance: float) -> float:
    """What the image, without priors, adds to the variance of the curvature for one of the light."""
    matrix, row = fit.matrix, _row(fit)
    return float(row @ matrix.matrix @ row) * variance


def _row(fit: Fitted) -> np.ndarray:
    """The row of the inverse normal matrix that the curvature has, over all unknowns."""
    matrix = fit.matrix
    row = np.zeros(len(matrix.values))
    place = int(np.count_nonzero(matrix.active[: NUMBERS.index("curvature")]))
    row[matrix.active] = matrix.inverse[place]
    return row


def _influence(fit: Fitted) -> np.ndarray:
    """By how much light of a block, per unit weight, moves the curvature."""
    grid, point, fields = fit.reduced.grid, fit.solution.point, fit.solution.fields
    numbers, smooth, swing = np.split(_row(fit), [len(NUMBERS), len(NUMBERS) + len(degrees(BACKGROUND))])
    shape = contrast_at_nodes() @ swing
    shape = shape if fields.contrast is None else shape * fields.contrast
    table = np.zeros((BACKGROUND + 1,) * 2)
    table[tuple(degrees(BACKGROUND).T)] = smooth
    background = grid.along_y[:, : BACKGROUND + 1] @ table @ grid.along_x[:, : BACKGROUND + 1].T
    turns = 2 * np.pi * (fit.phase - np.floor(fit.phase))
    bend = -2 * np.pi * at_blocks(grid, point.modulus) * at_blocks(grid, fields.slopes @ numbers)
    return bend * np.sin(turns) + background + at_blocks(grid, shape) * np.cos(turns)


def _blocks(fit: Fitted, influence: np.ndarray) -> Iterator[list[np.ndarray]]:
    """Sums over squares, for each side on four grids that are half a side apart."""
    grid = fit.reduced.grid
    for side in _SIDES:
        width = max(2, round(side / grid.block))
        shifts, sums = (0, width // 2), []
        for row in shifts:
            for column in shifts:
                at_rows, at_columns = (
                    np.flatnonzero(np.diff((first + np.arange(count) + shift) // width, prepend=-1))
                    for first, count, shift in zip(
                        (grid.rows[0], grid.columns[0]), influence.shape, (row, column), strict=True
                    )
                )
                total = np.add.reduceat(influence, at_rows, axis=0, dtype=float)
                sums.append(np.add.reduceat(total, at_columns, axis=1).ravel())
        yield sums


def _slices(at: tuple[np.ndarray, tuple[int, ...]], influence: np.ndarray, fit: Fitted) -> list[np.ndarray]:
    """Sums over slices of a place from 0 to 1 of each block that is used."""
    place, counts = at
    flat = influence[fit.left.weights > 0].astype(float)
    return [np.bincount(np.minimum((place * count).astype(int), count - 1), flat, count) for count in counts]


def _angles(fit: Fitted) -> tuple[np.ndarray, tuple[int, ...]]:
    """Angle about the rings' centre, over a turn."""
    numbers, frame, grid = Numbers(*fit.numbers), fit.model.frame, fit.reduced.grid
    x = grid.x[None] - frame.middle[0] - numbers.centre_x * frame.unit
    y = grid.y[:, None] - frame.middle[1] - numbers.centre_y * frame.unit
    return np.arctan2(y, x)[fit.left.weights > 0] / (2 * np.pi) + 0.5, _SECTORS


def _ranks(fit: Fitted) -> tuple[np.ndarray, tuple[int, ...]]:
    """Rank of the phase: zones hold as many blocks each."""
    phase = fit.phase[fit.left.weights > 0]
    rank = np.empty(len(phase))
    rank[np.argsort(phase)] = np.arange(len(phase)) / max(len(phase), 1)
    return rank, _ZONES
