"""The last steps of a fit whose phase has an edge, on the blocks themselves.

A contact's disc ends in an edge of the phase's derivatives that nodes do not resolve: on moments alone a radius stops
0.07 to 0.25 of its standard deviation away from the optimum of all blocks. So Gauss and Newton's steps go on from there
with every block's own derivatives, its weights those of its own residual.
"""

from typing import NamedTuple

import numpy as np

from fitting.estimate.elimination import CONTRAST, coefficients_of
from fitting.estimate.fringe_sums import TUKEY, table_of
from fitting.estimate.optimum import NormalMatrix, active_mask
from fitting.estimate.solver import Problem
from fitting.model import BACKGROUND, degrees
from fitting.parameters import NUMBERS
from fitting.photo import NODES, Reduced

_CHUNK = 64
# From an optimum on moments the first step leaves a hundredth of what it moved.
_STEPS = 2


class Refined(NamedTuple):
    """Numbers, background and contrast after the last step, and the normal matrix there."""

    numbers: np.ndarray
    background: np.ndarray
    contrast: np.ndarray
    matrix: NormalMatrix


def refine(
    problem: Problem, reduced: Reduced, numbers: np.ndarray, background: np.ndarray, contrast: np.ndarray, scale: float
) -> Refined:
    """The optimum over all blocks next to one on moments; `scale`: of Tukey's weights, 0 for those of the blocks alone.

    `background`, `contrast`: coefficients of full degree.
    """
    values = np.concatenate([numbers, background, contrast])
    count, low = len(NUMBERS), len(background)
    moving = problem.moving
    active = active_mask(moving, problem.degrees)
    centre, cost = np.zeros((2, len(values)))
    centre[:count], cost[:count] = problem.pull
    matrix, gradient = np.zeros((len(values),) * 2), np.zeros(len(values))
    for _ in range(_STEPS):
        matrix, gradient = _normal_equations(problem, reduced, values, active, scale)
        # What priors pull.
        pull = gradient - cost * (values - centre)
        values[active] += _solved((matrix + np.diag(cost))[np.ix_(active, active)], pull[active])
    numbers, background, contrast = np.split(values, [count, count + low])
    return Refined(numbers, background, contrast, NormalMatrix(matrix, gradient, values, active, cost))


def _solved(matrix: np.ndarray, gradient: np.ndarray) -> np.ndarray:
    size = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    size = np.where(size > 0, size, 1.0)
    return np.linalg.lstsq(matrix / np.outer(size, size), gradient / size, rcond=1e-12)[0] / size


def _normal_equations(problem: Problem, reduced: Reduced, values: np.ndarray, active: np.ndarray, scale: float):
    """Jᵀ W J and Jᵀ W r of all numbers and of what is free of the illumination."""
    fringes, grid, count = problem.phase, reduced.grid, len(NUMBERS)
    low = degrees(BACKGROUND)
    used = np.flatnonzero(np.concatenate([np.ones(count, bool), active[count:]]))
    smooth, swing = values[count : count + len(low)], values[count + len(low) :]
    lows, highs = (
        coefficients_of(degree, most) for degree, most in zip(problem.degrees, (BACKGROUND, CONTRAST), strict=True)
    )
    faded = fringes.fields(values[:count]).contrast
    fading = None if faded is None else table_of(faded)
    matrix, gradient, along_x = np.zeros((len(values),) * 2), np.zeros(len(values)), grid.along_x.astype(np.float32)
    for first in range(0, len(reduced.light), _CHUNK):
        rows = slice(first, first + _CHUNK)
        inside = reduced.used[rows]
        if not inside.any():
            continue
        turns, slopes = fringes.slopes_at(grid.x[None], grid.y[rows, None], values[:count])
        along_y = grid.along_y[rows].astype(np.float32)
        angle = (2 * np.pi * (turns - np.floor(turns)))[inside].astype(np.float32)
        cosine, sine = np.cos(angle), np.sin(angle)
        polynomials = [(along_y[:, j, None] * along_x[:, i])[inside] for j, i in low[: max(lows, highs)]]
        shade = (
            np.float32(1)
            if fading is None
            else (along_y[:, :NODES] @ fading.astype(np.float32) @ along_x[:, :NODES].T)[inside]
        )
        modulus = sum(np.float32(a) * p for a, p in zip(swing[:highs], polynomials, strict=False)) * shade
        turned = np.float32(-2 * np.pi) * modulus * sine
        columns = [turned * np.broadcast_to(slopes[name], turns.shape)[inside].astype(np.float32) for name in NUMBERS]
        columns += polynomials[:lows] + [p * cosine * shade for p in polynomials[:highs]]
        fit = sum(np.float32(a) * p for a, p in zip(smooth[:lows], polynomials, strict=False)) + modulus * cosine
        residual, weights = reduced.light[rows][inside] - fit, reduced.weights[rows][inside]
        if scale:
            weights = weights * np.maximum(1 - (residual / np.float32(TUKEY * scale)) ** 2, 0) ** 2
        # A product with its own transpose takes half of another's operations.
        root = np.sqrt(weights)
        table = np.stack(columns) * root
        matrix[np.ix_(used, used)] += table @ table.T
        gradient[used] += table @ (root * residual)
    return matrix, gradient
