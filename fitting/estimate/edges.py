"""The last steps of a fit whose phase has an edge, on the blocks themselves.

A contact's disc ends in an edge of the phase's derivatives that nodes do not resolve: on moments alone a radius stops
0.07 to 0.25 of its standard deviation away from the optimum of all blocks. So Gauss and Newton's steps go on from there
with every block's own derivatives, its weights those of its own residual.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from fitting.estimate import edges, robust
from fitting.estimate.elimination import CONTRAST, coefficients_of, contrast_at_nodes
from fitting.estimate.fitted import Fitted
from fitting.estimate.fringe_sums import TUKEY, normal_equations, sums, table_of
from fitting.estimate.optimum import NormalMatrix, active_mask
from fitting.estimate.solver import Problem, stay
from fitting.model import BACKGROUND, degrees
from fitting.parameters import NUMBERS
from fitting.photo import NODES, Reduced

_CHUNK = 64


class Refined(NamedTuple):
    """Numbers, background and contrast after the last step, and the normal matrix there."""

    numbers: np.ndarray
    background: np.ndarray
    contrast: np.ndarray
    matrix: NormalMatrix


def refine(
    problem: Problem,
    reduced: Reduced,
    numbers: np.ndarray,
    background: np.ndarray,
    contrast: np.ndarray,
    scale: float,
    near: NormalMatrix | None = None,
) -> Refined:
    """The optimum over all blocks next to one on moments; `scale`: of Tukey's weights, 0 for those of the blocks alone.

    `background`, `contrast`: coefficients of full degree; `near`: the normal matrix of the optimum on moments, with
    which a first step needs a gradient only. That leaves a hundredth of what it moved.
    """
    blocks = _Blocks(problem, reduced, scale)
    values = np.concatenate([numbers, background, contrast])
    first, low = len(NUMBERS), len(background)
    cost, centre = np.zeros((2, len(values)))
    centre[:first], cost[:first] = problem.pull
    matrix = blocks.normal_equations(values)[0] if near is None else near.matrix
    gradient = blocks.gradient(values)
    values = values + blocks.step(matrix + np.diag(cost), gradient - cost * (values - centre))
    matrix, gradient = blocks.normal_equations(values)
    values = values + blocks.step(matrix + np.diag(cost), gradient - cost * (values - centre))
    numbers, background, contrast = np.split(values, [first, first + low])
    return Refined(numbers, background, contrast, NormalMatrix(matrix, gradient, values, blocks.active, cost))


class _Chunk(NamedTuple):
    """Rows of blocks at one set of values, float32 [rows, columns]; phase's derivatives by number.

    `turned`: the light's change by turns; `cosine`: its change by contrast; `along_y`: polynomials of the rows.
    """

    turned: np.ndarray
    cosine: np.ndarray
    residual: np.ndarray
    weights: np.ndarray
    slopes: dict[str, np.ndarray]
    along_y: np.ndarray
    rows: slice


class _Blocks:
    """The blocks of a photograph, with what is free of numbers, background and contrast."""

    def __init__(self, problem: Problem, reduced: Reduced, scale: float):
        self.phase, self.reduced, self.scale = problem.phase, reduced, scale
        self.active = active_mask(problem.moving, problem.degrees)
        self.degrees = problem.degrees
        self.along_x = reduced.grid.along_x.astype(np.float32)

    def step(self, matrix: np.ndarray, gradient: np.ndarray) -> np.ndarray:
        """The step of what is free; zero of all else."""
        step, active = np.zeros(len(gradient)), self.active
        block = matrix[np.ix_(active, active)]
        size = np.sqrt(np.maximum(np.diag(block), 0.0))
        size = np.where(size > 0, size, 1.0)
        step[active] = np.linalg.lstsq(block / np.outer(size, size), gradient[active] / size, rcond=1e-12)[0] / size
        return step

    def gradient(self, values: np.ndarray) -> np.ndarray:
        """Jᵀ W r of all numbers and of background and contrast of full degree."""
        total, tables = np.zeros(len(NUMBERS)), np.zeros((2, BACKGROUND + 1, BACKGROUND + 1))
        along_x = self.along_x[:, : BACKGROUND + 1]
        for chunk in self._chunks(values):
            weighted = chunk.weights * chunk.residual
            along_y = chunk.along_y[:, : BACKGROUND + 1].T
            tables += along_y @ np.stack([weighted, weighted * chunk.cosine]) @ along_x
            weighted *= chunk.turned
            total += [float((weighted * chunk.slopes[name]).sum(dtype=float)) for name in NUMBERS]
        smooth, swing = (
            table[tuple(degrees(most).T)] for table, most in zip(tables, (BACKGROUND, CONTRAST), strict=True)
        )
        return np.concatenate([total, smooth, swing])

    def normal_equations(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Jᵀ W J and Jᵀ W r of all numbers and of what is free of the illumination."""
        low, free = degrees(BACKGROUND), self.active.copy()
        free[: len(NUMBERS)] = True
        lows, highs = (
            coefficients_of(degree, most) for degree, most in zip(self.degrees, (BACKGROUND, CONTRAST), strict=True)
        )
        matrix, gradient = np.zeros((len(values),) * 2), np.zeros(len(values))
        for chunk in self._chunks(values):
            inside = self.reduced.used[chunk.rows]
            cosine = chunk.cosine[inside]
            polynomials = [(chunk.along_y[:, j, None] * self.along_x[:, i])[inside] for j, i in low[: max(lows, highs)]]
            columns = [
                (chunk.turned * np.broadcast_to(chunk.slopes[name], inside.shape))[inside].astype(np.float32)
                for name in NUMBERS
            ]
            columns += polynomials[:lows] + [polynomial * cosine for polynomial in polynomials[:highs]]
            # A product with its own transpose takes half of another's operations.
            root = np.sqrt(chunk.weights[inside])
            table = np.stack(columns) * root
            matrix[np.ix_(free, free)] += table @ table.T
            gradient[free] += table @ (root * chunk.residual[inside])
        return matrix, gradient

    def _chunks(self, values: np.ndarray) -> Iterator[_Chunk]:
        """The blocks, some rows at a time, at given numbers, background and contrast."""
        grid, reduced = self.reduced.grid, self.reduced
        numbers, background, contrast = np.split(values, [len(NUMBERS), len(NUMBERS) + len(degrees(BACKGROUND))])
        faded = self.phase.fields(numbers).contrast
        fading = None if faded is None else table_of(faded).astype(np.float32)
        smooth, swing = np.zeros((2, BACKGROUND + 1, BACKGROUND + 1), np.float32)
        smooth[tuple(degrees(BACKGROUND).T)] = background
        swing[tuple(degrees(CONTRAST).T)] = contrast
        wide, narrow = (np.ascontiguousarray(self.along_x[:, :count].T) for count in (NODES, BACKGROUND + 1))
        for first in range(0, len(reduced.light), _CHUNK):
            rows = slice(first, first + _CHUNK)
            if not reduced.used[rows].any():
                continue
            turns, slopes = self.phase.slopes_at(grid.x[None], grid.y[rows, None], numbers)
            along_y = grid.along_y[rows].astype(np.float32)
            low_y = along_y[:, : BACKGROUND + 1]
            angle = (2 * np.pi * (turns - np.floor(turns))).astype(np.float32)
            shade = np.float32(1) if fading is None else along_y[:, :NODES] @ fading @ wide
            cosine, modulus = np.cos(angle) * shade, low_y @ swing @ narrow
            residual = reduced.light[rows] - low_y @ smooth @ narrow - modulus * cosine
            weights = reduced.weights[rows]
            if self.scale:
                share = residual * reduced.inverse_sd[rows] / np.float32(TUKEY * self.scale)
                weights = weights * np.maximum(1 - share * share, 0) ** 2
            turned = np.float32(-2 * np.pi) * modulus * shade * np.sin(angle)
            yield _Chunk(turned, cosine, residual, weights, slopes, along_y, rows)


def sharpened(found: Fitted) -> Fitted:
    """The fit with its last steps made on the blocks themselves, where its phase has an edge."""
    solution, reduced = found.solution, found.reduced
    problem = solution.problem
    if problem.phase.edges(found.numbers) is None:
        return found
    contrast = np.zeros(contrast_at_nodes().shape[1])
    contrast[: len(solution.point.contrast)] = solution.point.contrast
    start = (found.numbers, solution.point.background, contrast)
    last = edges.refine(problem, reduced, *start, found.scale or 0.0, found.matrix)
    weighted, at = replace(reduced, weights=found.left.weights), problem.phase.edges(last.numbers)
    normal = normal_equations(sums(weighted, problem.phase.fields(last.numbers).phase, at))
    solution = stay(problem, normal, last.numbers, solution.converged)
    left = robust.residuals_of(solution, reduced, found.scale)
    return replace(found, solution=solution, left=left, matrix=last.matrix)
