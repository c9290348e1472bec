"""Where the rings of a colour photograph are: centre and ellipse, from the ring means themselves; and the light behind.

No waveform is assumed: the mean of a channel over a ring is its waveform, and what the photograph leaves over of these
means says how the rings have to be moved.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from numpy.polynomial.chebyshev import chebvander

from fitting.colour.blocks import Blocks
from fitting.photo import Rings

# Degree of the light behind the rings; blocks from which it is taken; bins to a ring of the search's scale.
_DEGREE, _SAMPLED, _BINS = 4, 40_000, 16
_STEPS, _STILL = 6, 1e-2
# Blocks that differ from their ring by so many standard deviations are dust.
_DUST = 6.0


class Figure(NamedTuple):
    """Centre (x, y) [px], and stretch and shear of the ellipse that the rings are."""

    x: float
    y: float
    stretch: float = 0.0
    shear: float = 0.0

    def squares(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Squared distance from the centre over the ellipse's form [px²]."""
        dx, dy = x - self.x, y - self.y
        return (1 + self.stretch) * dx**2 + (1 - self.stretch) * dy**2 + 2 * self.shear * dx * dy

    def slopes(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Derivatives of the squares in the four numbers [blocks, 4]."""
        dx, dy = x - self.x, y - self.y
        along_x = -2 * ((1 + self.stretch) * dx + self.shear * dy)
        along_y = -2 * ((1 - self.stretch) * dy + self.shear * dx)
        return np.stack([along_x, along_y, dx**2 - dy**2, 2 * dx * dy], axis=1)


class Placed(NamedTuple):
    """Rings in their place: figure, light behind them [channels, blocks], and blocks that are neither dust nor dark."""

    figure: Figure
    behind: Float[np.ndarray, "channels blocks"]
    is_used: Bool[np.ndarray, " blocks"]


def place(blocks: Blocks, rings: Rings) -> Placed:
    """The figure that makes the rings' means sharpest: Gauss and Newton's steps on all channels together."""
    figure = Figure(*map(float, rings.centre))
    used = ~blocks.is_saturated
    terms = _terms(blocks)
    behind = np.ones_like(blocks.light)
    for _ in range(_STEPS):
        matrix, right, clean = np.zeros((4, 4)), np.zeros(4), used.copy()
        squares, slopes = figure.squares(blocks.x, blocks.y), figure.slopes(blocks.x, blocks.y)
        for channel, light in enumerate(blocks.light):
            means, derivative = _ring_means(squares, light / behind[channel], used, rings.scale)
            behind[channel] = _behind(terms, light, means, used)
            residual = light - behind[channel] * means
            deviation = 1.4826 * float(np.median(np.abs(residual[used]))) or 1e-12
            clean &= np.abs(residual) < _DUST * deviation
            design = (behind[channel] * derivative / deviation)[used, None] * slopes[used]
            matrix += design.T @ design
            right += design.T @ (residual[used] / deviation)
        step = np.linalg.lstsq(matrix, right, rcond=1e-12)[0]
        figure = Figure(*(float(number) for number in np.array(figure) + step))
        used = clean & ~blocks.is_saturated
        if np.hypot(*step[:2]) < _STILL:
            break
    return Placed(figure, behind, used)


def _terms(blocks: Blocks) -> np.ndarray:
    """Products of Chebyshev polynomials over the field [blocks, terms]."""
    along = []
    for at in (blocks.x, blocks.y):
        low, high = at.min(), at.max()
        along.append(chebvander((2 * at - low - high) / max(high - low, 1.0), _DEGREE))
    pairs = [(i, j) for i in range(_DEGREE + 1) for j in range(_DEGREE + 1 - i)]
    return np.stack([along[0][:, i] * along[1][:, j] for i, j in pairs], axis=1)


def _behind(terms: np.ndarray, light: np.ndarray, means: np.ndarray, used: np.ndarray) -> np.ndarray:
    """The smooth light which times the ring means is the photograph."""
    some = np.flatnonzero(used)
    some = some[:: max(1, len(some) // _SAMPLED)]
    design = terms[some] * means[some, None]
    coefficients = np.linalg.lstsq(design.T @ design, design.T @ light[some], rcond=1e-12)[0]
    smooth = terms @ coefficients
    return np.maximum(smooth, max(0.05 * float(np.median(smooth[some])), 1e-6))


def _ring_means(
    squares: np.ndarray, light: np.ndarray, used: np.ndarray, scale: float
) -> tuple[np.ndarray, np.ndarray]:
    """Mean light of each block's ring, and its slope against the squared distance [per px²]."""
    bins = bins_of(squares, used, scale)
    width = float(squares[used].max()) / bins
    place_of = np.minimum((squares[used] / width).astype(int), bins - 1)
    counts = np.bincount(place_of, minlength=bins)
    sums = np.bincount(place_of, light[used], bins)
    filled = counts > 0
    middles = (np.arange(bins) + 0.5) * width
    means = np.interp(middles, middles[filled], sums[filled] / counts[filled])
    return np.interp(squares, middles, means), np.interp(squares, middles, np.gradient(means, width))


def bins_of(squares: np.ndarray, used: np.ndarray, scale: float) -> int:
    """How many bins of equal squared distance resolve the rings."""
    return int(np.clip(_BINS * scale * float(squares[used].max()), 100, 6000))
