"""What a form leaves over at every pixel: its noise, how neighbours go together, and what is dust."""

from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from fitting.irregularity.disc import Disc, sums_of
from fitting.irregularity.moments import powers
from fitting.irregularity.projection import FormFit
from fitting.irregularity.zernike import on_grid

# Pixels off by more standard deviations are dust, hot or struck; they are left out where there are more than normal
# noise makes of them.
_DUST, _NORMAL_SHARE = 4.5, 2e-5
# Sides of the blocks over which sums are compared with white noise [px]; fewer blocks than this say nothing.
_BLOCKS, _LEAST_BLOCKS = (4, 8, 16, 32, 64), 60


class Residual(NamedTuple):
    """The residual of a fit.

    - `dust` [rows, columns]: pixels to leave out; None where there are none.
    - `inflation`: by how much the variance of sums over blocks exceeds that of white noise, at least 1.
    """

    dust: np.ndarray | None
    inflation: float


def residual_of(disc: Disc, fit: FormFit) -> Residual:
    """The residual light of a form fit and what it says of the noise."""
    u, v = disc.u.astype(np.float32), disc.v
    turns = on_grid(fit.coefficients, u, v)
    turns = (turns - np.round(turns)) * np.float32(2 * np.pi)
    background = _surface(fit.background, fit.degrees.background, u, v)
    contrast = _surface(fit.contrast, fit.degrees.contrast, u, v)
    residual = (disc.light - background - contrast * np.cos(turns)) * disc.weights
    # The middle 68 % of normal noise; a sample of the pixels is enough.
    step = max(int(np.sqrt(disc.pixels / 1e5)), 1)
    sample = residual[::step, ::step][disc.weights[::step, ::step] > 0]
    scale = float(np.median(np.abs(sample))) * 1.4826 if sample.size else 0.0
    outlying = np.abs(residual) > _DUST * scale
    count = np.count_nonzero(outlying)
    dust = outlying if count > _NORMAL_SHARE * disc.pixels else None
    score = residual * contrast * np.sin(turns)
    score = np.where(outlying, np.float32(0), score) if dust is not None else score
    return Residual(dust, inflation_of(score))


def _surface(coefficients: np.ndarray, degree: int, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Chebyshev products of a total degree on a grid, float32 [rows, columns]."""
    square, pairs = np.zeros((degree + 1, degree + 1)), powers(degree)
    square[pairs[:, 0], pairs[:, 1]] = coefficients
    rows = (chebyshev.chebvander(v, degree) @ square).astype(np.float32)
    return rows @ chebyshev.chebvander(u, degree).astype(np.float32).T


def inflation_of(score: np.ndarray) -> float:
    """The largest ratio of the variance of block sums to that of as many white pixels, where it is beyond chance."""
    square, largest = float(np.vdot(score, score)), 1.0
    sums, before = score, 1
    for block in _BLOCKS:
        step = block // before
        rows, columns = (size // step for size in sums.shape)
        if rows * columns < _LEAST_BLOCKS or square == 0:
            break
        sums = sums_of(sums, step, float)
        before = block
        ratio = float(np.square(sums, dtype=float).sum()) / square
        if ratio > 1 + 3 * np.sqrt(2 / (rows * columns)):
            largest = max(largest, ratio)
    return largest
