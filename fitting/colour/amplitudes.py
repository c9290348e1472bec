"""The linear part of a channel's fit: background over r², and non-negative amplitudes of the light's components."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from numpy.polynomial.chebyshev import chebvander
from scipy.optimize import nnls

_RIDGE, _MOST_CHANGES = 1e-5, 30


class Channel(NamedTuple):
    """Amplitudes [components], model and weighted residual of the bins [bins]."""

    amplitudes: Float[np.ndarray, " components"]
    model: Float[np.ndarray, " bins"]
    residual: Float[np.ndarray, " bins"]


def background(squares: Float[np.ndarray, " bins"], degree: int) -> Float[np.ndarray, "bins terms"]:
    """Chebyshev polynomials over the squared distance."""
    low, high = squares.min(), squares.max()
    return chebvander((2 * squares - low - high) / max(high - low, 1e-12), degree)


def solve(
    waves: Float[np.ndarray, "bins components"],
    smooth: Float[np.ndarray, "bins terms"],
    values: Float[np.ndarray, " bins"],
    weight: Float[np.ndarray, " bins"],
    held: Float[np.ndarray, "rows components"] | None = None,
) -> Channel:
    """The least squares solution (C. L. Lawson and R. J. Hanson, Solving Least Squares Problems, 1974, chapter 23).

    The background is projected out first; of what remains a triangle as large as the number of components is solved.
    `held`: what is known of the amplitudes before, as rows whose products with them are 0 with standard deviation 1.
    """
    root = np.sqrt(weight)
    basis, triangle = np.linalg.qr(smooth * root[:, None])
    target = values * root
    columns = waves * root[:, None]
    across = basis.T @ columns
    columns = columns - basis @ across
    along = basis.T @ target
    target = target - basis @ along
    reduced, small = np.linalg.qr(columns)
    right = reduced.T @ target
    if held is None:
        # Of columns that are nearly alike a little of each: without, the active set may go round in circles.
        held = _RIDGE * float(np.linalg.norm(small)) * np.eye(columns.shape[1])
    system, zeros = np.concatenate([small, held]), np.zeros(len(held))
    amplitudes, _ = nnls(system, np.concatenate([right, zeros]), maxiter=_MOST_CHANGES * columns.shape[1])
    constants = np.linalg.lstsq(triangle, along - across @ amplitudes, rcond=1e-12)[0]
    model = smooth @ constants + waves @ amplitudes
    return Channel(amplitudes, model, target - columns @ amplitudes)
