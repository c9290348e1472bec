"""A fit at every pixel of its photograph: made only when somebody looks."""

import numpy as np
from numpy.polynomial.chebyshev import chebvander

from fitting.estimate.elimination import contrast_at_nodes
from fitting.estimate.fitted import Fitted
from fitting.estimate.fringe_sums import image_of, table_of
from fitting.model import gap_phase
from newtonjax.numerics import analysis


def _along(fit: Fitted, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Chebyshev polynomials over the fit's box at every row and column; beyond it those of its edge."""
    grid = fit.reduced.grid
    at = (np.clip(grid.scaled(np.arange(n, dtype=float), axis), -1, 1) for axis, n in enumerate(grid.shape))
    along_y, along_x = (chebvander(one, count - 1) for one in at)
    return along_y, along_x


def phase(fit: Fitted) -> np.ndarray:
    """The rings' phase at every pixel [turns]."""
    rows, columns = (np.arange(n, dtype=float) for n in fit.reduced.grid.shape)
    if (model := fit.solution.problem.phase.exact) is not None:
        return gap_phase.phase(model, columns[None], rows[:, None], fit.numbers)
    along_y, along_x = _along(fit, len(analysis(17)))
    return along_y @ table_of(fit.solution.fields.phase) @ along_x.T


def fitted(fit: Fitted, turns: np.ndarray) -> np.ndarray:
    """The model image at every pixel, for the phase there [turns]."""
    point = fit.solution.point
    contrast, (background, _) = point.contrast, image_of(point.background, point.modulus)
    modulus = contrast_at_nodes()[:, : len(contrast)] @ contrast
    low_y, low_x = _along(fit, len(background))
    high_y, high_x = _along(fit, 17)
    smooth = low_y @ background @ low_x.T + fit.reduced.offset
    return smooth + (high_y @ table_of(modulus) @ high_x.T) * np.cos(2 * np.pi * turns)


def weights(fit: Fitted, mask: np.ndarray) -> np.ndarray:
    """The weights of the pixels' blocks; 0 where the mask leaves a pixel out."""
    grid, frame = fit.reduced.grid, np.zeros(mask.shape)
    blocks = np.repeat(np.repeat(fit.left.weights, grid.block, axis=0), grid.block, axis=1)
    first = (grid.rows[0] * grid.block, grid.columns[0] * grid.block)
    part = frame[first[0] : first[0] + blocks.shape[0], first[1] : first[1] + blocks.shape[1]]
    part[:] = blocks[: part.shape[0], : part.shape[1]]
    return np.where(mask, frame, 0.0)
