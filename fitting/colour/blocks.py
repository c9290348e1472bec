"""The channels of a photograph on one grid of blocks."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float

from fitting.photo import Photograph, Rings, block_size, pixels_of, reduce

# More blocks than this are made wider: they hold the rings many times over.
_MOST = 400_000


@dataclass(frozen=True)
class Blocks:
    """Mean light of the channels in blocks of pixels.

    - `x`, `y`: middles [px]; `size`: pixels to a side.
    - `light`: over each channel's brightest [channels, blocks]; `top`: the level that few blocks exceed [channels].
    - `is_saturated`: blocks of which less than nine tenths are below saturation in all channels.
    """

    x: Float[np.ndarray, " blocks"]
    y: Float[np.ndarray, " blocks"]
    size: int
    light: Float[np.ndarray, "channels blocks"]
    top: Float[np.ndarray, " channels"]
    is_saturated: Bool[np.ndarray, " blocks"]


def blocks_of(channels: tuple[Photograph, ...], rings: Rings) -> Blocks:
    """The channels in blocks that resolve rings half as wide again as those that a search saw.

    Raises ValueError where no block is used.
    """
    lit = np.logical_and.reduce([photograph.lit for photograph in channels])
    x, y = pixels_of(lit)
    finest = 3 * rings.scale * float(np.hypot(x - rings.centre[0], y - rings.centre[1]).max())
    size = max(block_size(finest), int(np.ceil(np.sqrt(np.count_nonzero(lit) / _MOST))))
    reduced = [reduce(replace(photograph, mask=lit), size) for photograph in channels]
    grid, used = reduced[0].grid, reduced[0].weights > 0
    columns, rows = np.meshgrid(grid.x, grid.y)
    light = np.stack([(part.light + part.offset)[used] for part in reduced]).astype(float)
    usable = np.logical_and.reduce([photograph.mask for photograph in channels])
    saturated = np.zeros(used.sum(), bool)
    if (usable != lit).any():
        share = reduce(replace(channels[0], mask=lit), size).weights[used]
        still_usable = _shares(usable & lit, grid)[used]
        saturated = still_usable < 0.9 * share
    return Blocks(columns[used], rows[used], size, light, np.percentile(light, 99.9, axis=1), saturated)


def _shares(mask: np.ndarray, grid) -> np.ndarray:
    """Share of each block's pixels that a mask holds, on a grid."""
    size = grid.block
    padded = np.pad(mask, [(0, -n % size) for n in mask.shape])
    rows, columns = (n // size for n in padded.shape)
    shares = padded.reshape(rows, size, columns, size).mean(axis=(1, 3))
    return shares[slice(*grid.rows), slice(*grid.columns)]
