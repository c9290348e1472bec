"""A photograph as means over blocks of pixels, as coarse as its finest fringe allows."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float, Float64
from numpy.polynomial.chebyshev import chebvander

from fitting.photo.reading import Photograph
from newtonjax.numerics import chebyshev

# Cycles of the finest fringe in a block: up to here means keep a radius within 0.07 of its standard deviation, and that
# within 2 %, against every pixel for itself; at 0.4 cycles it is 0.2 and 7 %.
CYCLES = 0.125
# Degrees of sums over blocks, twice the envelope's 16 and one more; nodes to a side.
DEGREES, NODES = 33, 17
_BAND = 256


@dataclass(frozen=True)
class Grid:
    """Blocks of `block` x `block` pixels on the grid of a whole frame, cut to the box that holds the used ones.

    `shape`: of the frame [px]; `rows`, `columns`: the first block of the box and one past its last one. One grid serves
    all frames of a view.
    """

    shape: tuple[int, int]
    block: int
    rows: tuple[int, int]
    columns: tuple[int, int]

    @cached_property
    def y(self) -> Float64[np.ndarray, " rows"]:
        """Middles of the blocks [px]."""
        return _middles(self.rows, self.block, self.shape[0])

    @cached_property
    def x(self) -> Float64[np.ndarray, " columns"]:
        """Middles of the blocks [px]."""
        return _middles(self.columns, self.block, self.shape[1])

    @cached_property
    def along_y(self) -> Float64[np.ndarray, "rows degrees"]:
        """Chebyshev polynomials over the box."""
        return chebvander(self.scaled(self.y, 0), DEGREES - 1)

    @cached_property
    def along_x(self) -> Float64[np.ndarray, "columns degrees"]:
        """Chebyshev polynomials over the box."""
        return chebvander(self.scaled(self.x, 1), DEGREES - 1)

    @cached_property
    def middle(self) -> tuple[float, float]:
        """The box's, (y, x) [px]."""
        return (self.y[0] + self.y[-1]) / 2, (self.x[0] + self.x[-1]) / 2

    @cached_property
    def half(self) -> tuple[float, float]:
        """Half the box's extent, (y, x) [px]."""
        return max((self.y[-1] - self.y[0]) / 2, 1.0), max((self.x[-1] - self.x[0]) / 2, 1.0)

    def scaled(self, at: np.ndarray, axis: int) -> np.ndarray:
        """Positions [px] along an axis in the box's units: -1 to 1 from the middle of its first block to its last."""
        return (at - self.middle[axis]) / self.half[axis]

    @cached_property
    def nodes(self) -> tuple[Float64[np.ndarray, " nodes"], Float64[np.ndarray, " nodes"]]:
        """Positions x, y [px] of the 17 x 17 Chebyshev nodes of the box, row by row."""
        at = chebyshev.nodes(NODES)
        y, x = np.meshgrid(self.middle[0] + self.half[0] * at, self.middle[1] + self.half[1] * at, indexing="ij")
        return x.ravel(), y.ravel()


def _middles(blocks: tuple[int, int], block: int, pixels: int) -> np.ndarray:
    first = np.arange(*blocks) * block
    # The last block of a frame may be cut off.
    return (first + np.minimum(first + block, pixels) - 1) / 2


@dataclass(frozen=True)
class Reduced:
    """A photograph's blocks: the mean light of their used pixels less `offset`, and weights, used pixels / block².

    `light`, `weights` [rows, columns]; a block of which less than half is used has weight 0.
    """

    grid: Grid
    light: Float[np.ndarray, "rows columns"]
    weights: Float[np.ndarray, "rows columns"]
    offset: float

    @cached_property
    def used(self) -> np.ndarray:
        """True where a block counts [rows, columns]."""
        return self.weights > 0

    @property
    def pixels(self) -> float:
        """Number of used pixels."""
        return float(self.weights.sum(dtype=float)) * self.grid.block**2


def block_size(finest: float, cycles: float = CYCLES) -> int:
    """Pixels to a side of a block, for the finest fringe [cycles per pixel] and so many cycles of it in one."""
    return max(1, int(cycles / max(finest, 1e-9)))


def reduce(photograph: Photograph, block: int, dtype: type[np.floating] = np.float32) -> Reduced:
    """The photograph in blocks of so many pixels to a side; `dtype`: what is computed in from here on.

    Read by bands of rows: nothing of the frame's size is made in float64 unless asked for. Raises ValueError where no
    block is used.
    """
    mask = photograph.mask
    shape = (mask.shape[0], mask.shape[1])
    counts = np.zeros([-(-n // block) for n in shape], dtype)
    light = np.zeros_like(counts)
    step = max(1, _BAND // block)
    for first in range(0, len(counts), step):
        start, stop = first * block, min((first + step) * block, shape[0])
        used = mask[start:stop]
        image = np.where(used, _light(photograph, start, stop, dtype), dtype(0))
        light[first : first + step] = _totals(image, block)
        counts[first : first + step] = used if block == 1 else _totals(used.astype(dtype), block)
    return _cut(shape, block, light, counts)


def _light(photograph: Photograph, start: int, stop: int, dtype: type[np.floating]) -> np.ndarray:
    if dtype is np.float32:
        return photograph.light_rows(start, stop)
    return photograph.codes.light((slice(start, stop), slice(None)))


def _totals(image: np.ndarray, block: int) -> np.ndarray:
    """Sums over blocks; those that the far edges cut off too."""
    if block == 1:
        return image
    rows, columns = image.shape
    lines = np.zeros((-(-rows // block), columns), image.dtype)
    totals = np.zeros((len(lines), -(-columns // block)), image.dtype)
    # Slices, added one by one: a sum over two short axes takes several times as long.
    for k in range(block):
        part = image[k::block]
        lines[: len(part)] += part
    for k in range(block):
        part = lines[:, k::block]
        totals[:, : part.shape[1]] += part
    return totals


def _cut(shape: tuple[int, int], block: int, light: np.ndarray, counts: np.ndarray) -> Reduced:
    is_used = counts >= block**2 / 2
    if not is_used.any():
        raise ValueError("no block of pixels is used: the mask leaves nothing")
    rows, columns = (np.flatnonzero(is_used.any(axis=1 - axis)) for axis in (0, 1))
    box = tuple((int(at[0]), int(at[-1]) + 1) for at in (rows, columns))
    inside = tuple(slice(*ends) for ends in box)
    is_used, counts, light = is_used[inside], counts[inside], light[inside]
    zero = light.dtype.type(0)
    weights = np.where(is_used, counts / light.dtype.type(block**2), zero)
    mean = light / np.maximum(counts, 1)
    offset = float((mean * weights).sum(dtype=float) / weights.sum(dtype=float))
    light = np.where(is_used, mean - light.dtype.type(offset), zero)
    return Reduced(Grid(shape, block, *box), light, weights, offset)
