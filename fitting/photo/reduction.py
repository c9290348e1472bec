"""A photograph as means over blocks of pixels, as coarse as its finest fringe allows."""

from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Bool, Float, Float64
from numpy.polynomial.chebyshev import chebvander

from fitting.photo.reading import Photograph
from newtonjax.numerics import chebyshev

# Cycles of the finest fringe in a block: up to here means keep a radius within 0.07 of its standard deviation, and that
# within 2 %, against every pixel for itself; at 0.4 cycles it is 0.2 and 7 %.
CYCLES = 0.125
# Degrees of sums over blocks, twice the envelope's 16 and one more; nodes to a side.
DEGREES, NODES = 33, 17
_PLACES = chebyshev.nodes(NODES)
_BAND = 256


@dataclass(frozen=True)
class Grid:
    """Blocks of `block` x `block` pixels on the grid of a whole frame, cut to the box that holds the used ones.

    - `shape`: of the frame [px]; `rows`, `columns`: the first block of the box and one past its last one.
    - `x`, `y`: middles of the blocks [px]; `middle`, `half`: of the box, and half its extent, (y, x) [px].
    - `along_x`, `along_y`: Chebyshev polynomials over the box at the blocks.
    - `nodes`: positions x, y [px] of the 17 x 17 Chebyshev nodes of the box, row by row.

    One grid serves all frames of a view.
    """

    shape: tuple[int, int]
    block: int
    rows: tuple[int, int]
    columns: tuple[int, int]
    y: Float64[np.ndarray, " rows"] = field(init=False, repr=False, compare=False)
    x: Float64[np.ndarray, " columns"] = field(init=False, repr=False, compare=False)
    middle: tuple[float, float] = field(init=False, repr=False, compare=False)
    half: tuple[float, float] = field(init=False, repr=False, compare=False)
    along_y: Float64[np.ndarray, "rows degrees"] = field(init=False, repr=False, compare=False)
    along_x: Float64[np.ndarray, "columns degrees"] = field(init=False, repr=False, compare=False)
    nodes: tuple[Float64[np.ndarray, " nodes"], Float64[np.ndarray, " nodes"]] = field(
        init=False, repr=False, compare=False
    )

    def __post_init__(self):
        places = (self._middles(self.rows, self.shape[0]), self._middles(self.columns, self.shape[1]))
        derived = {
            "y": places[0],
            "x": places[1],
            "middle": tuple((at[0] + at[-1]) / 2 for at in places),
            "half": tuple(max((at[-1] - at[0]) / 2, 1.0) for at in places),
        }
        for name, value in derived.items():
            object.__setattr__(self, name, value)
        along = [chebvander(self.scaled(at, axis), DEGREES - 1) for axis, at in enumerate(places)]
        (middle_y, middle_x), (half_y, half_x) = self.middle, self.half
        y, x = np.meshgrid(middle_y + half_y * _PLACES, middle_x + half_x * _PLACES, indexing="ij")
        for name, value in {"along_y": along[0], "along_x": along[1], "nodes": (x.ravel(), y.ravel())}.items():
            object.__setattr__(self, name, value)

    def _middles(self, blocks: tuple[int, int], pixels: int) -> np.ndarray:
        first = np.arange(*blocks) * self.block
        # The last block of a frame may be cut off.
        return (first + np.minimum(first + self.block, pixels) - 1) / 2

    def scaled(self, at: np.ndarray, axis: int) -> np.ndarray:
        """Positions [px] along an axis in the box's units: -1 to 1 from the middle of its first block to its last."""
        return (at - self.middle[axis]) / self.half[axis]


@dataclass(frozen=True)
class Reduced:
    """A photograph's blocks: the mean light of their used pixels less `offset`, and weights, used pixels / block².

    `light`, `weights` [rows, columns]; a block of which less than half is used has weight 0. `used`: where a block
    counts; `pixels`: number of used pixels. `inverse_sd`: one over the noise of a pixel there, whose square is in the
    weights, in units that leave their sum; 1 where all pixels count alike.
    """

    grid: Grid
    light: Float[np.ndarray, "rows columns"]
    weights: Float[np.ndarray, "rows columns"]
    offset: float
    inverse_sd: Float[np.ndarray, "rows columns"]

    used: Bool[np.ndarray, "rows columns"] = field(init=False, repr=False)
    pixels: float = field(init=False)

    def __post_init__(self):
        object.__setattr__(self, "used", self.weights > 0)
        object.__setattr__(self, "pixels", float(self.weights.sum(dtype=float)) * self.grid.block**2)

    def weighed(self, variance: Float[np.ndarray, "rows columns"]) -> "Reduced":
        """The same with pixels weighed by one over their noise's variance, of which only ratios count."""
        share = np.where(self.used, 1 / variance, 0.0)
        share *= self.weights.sum(dtype=float) / (self.weights * share).sum(dtype=float)
        weights, inverse_sd = (one.astype(self.weights.dtype) for one in (self.weights * share, np.sqrt(share)))
        return replace(self, weights=weights, inverse_sd=inverse_sd)


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
        return photograph.codes.rows(start, stop)
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
    alike = np.broadcast_to(np.ones(1, light.dtype), light.shape)
    return Reduced(Grid(shape, block, *box), light, weights, offset, alike)
