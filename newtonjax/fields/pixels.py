"""An image from the coefficients of its fields, outside of transformations: one small program a shape.

What is compiled for depends on rows, columns, a size class of the nodes and whether there is more than one pair of
beams. Above 32 MB one program of a few rows is called for one block of rows after the other.
"""

from collections.abc import Iterator
from functools import lru_cache, partial
from itertools import chain
from typing import Any

import jax
import numpy as np
from jaxtyping import Array, Float, Int

from newtonjax.fields.row_strips import AbstractRow, row, single_row
from newtonjax.fields.synthesis import image_of, terms_of
from newtonjax.fields.waveforms import Waveform, fringes_by_table
from newtonjax.numerics import chebyshev, cos_turns, image_memory, x64

# Nodes to a side, and pairs of beams, that programs are compiled for: coefficients are padded with zeros.
_NODES, _PAIRS = (5, 9, 17, 33, 65, 129), (1, 6, 28)
# An array above 32 MB is fresh memory each time, in pages of 4 kB unless NumPy asks for it. Below, blocks are such
# that one stays in the cache until it is copied to its place.
_WHOLE, _BLOCK = 2**25, 2**17
# Wide vectors halve the time where the processor has them. A program of a user's own cannot be told so.
WIDE = {"xla_cpu_prefer_vector_width": 512}


def image(
    coefficients: Float[np.ndarray | Array, "fields count count"],
    shape: tuple[int, int],
    dtype: str = "float64",
    result: str | None = None,
) -> Float[Array, "rows columns"]:
    """Background + Σ modulus cos 2π phase at every pixel, of fields given by their Chebyshev coefficients.

    - `coefficients`: background, moduli, phases [turns], concrete, in float64.
    - `dtype`: in which pixels are computed: in float32 they are at most 2e-5 of the peak away up to 250 turns.
    - `result`: the type of the image; None for that.

    Raises ValueError where the image is larger than memory.
    """
    result = dtype if result is None else result
    size, total, columns = np.dtype(result).itemsize, *shape
    in_blocks = total * columns * size > _WHOLE and jax.default_backend() == "cpu"
    image_memory(shape, size if in_blocks else 2 * size)
    rows = min(max(_BLOCK // columns, 1), total) if in_blocks else total
    blocks = parts(coefficients, shape, rows, dtype, result)
    if not in_blocks:
        return next(blocks)[1]
    pixels = _aligned(shape, result)
    for first, part in blocks:
        pixels[first : first + rows] = part
    with x64():
        return jax.device_put(pixels, may_alias=True)


def parts(
    coefficients: Float[np.ndarray | Array, "fields count count"],
    shape: tuple[int, int],
    rows: int,
    dtype: str = "float64",
    result: str | None = None,
) -> Iterator[tuple[int, Float[Array, "rows columns"]]]:
    """`image` as (first row, so many rows from there), all by one program: the last block overlaps the one before."""
    total = shape[0]
    padded = _padded(np.asarray(coefficients, dtype=np.float64))
    pairs = () if len(padded) == 1 + 2 * _PAIRS[0] else ((len(coefficients) - 1) // 2,)
    program = _of_pairs if pairs else _of_one_pair
    with x64():
        way = _way(shape[1], padded.shape[-1], dtype)
        along_y = _along_y(total, padded.shape[-1], rows == total)
    for first in chain(range(0, total - rows, rows), (total - rows,)):
        with x64():
            basis = along_y if rows == total else along_y[:, first : first + rows]
            part = program(padded, basis, way, *pairs, result or dtype)
        yield first, part


@lru_cache(maxsize=8)
def _way(columns: int, count: int, dtype: str) -> AbstractRow:
    """The way over a row, kept on the device for the next image of its shape."""
    single = single_row(columns, count) if dtype == "float32" else None
    return jax.device_put(row(columns, count) if single is None else single)


@lru_cache(maxsize=8)
def _along_y(rows: int, count: int, on_device: bool) -> Array | np.ndarray:
    """The basis along y, on the device where no blocks are cut from it."""
    basis = chebyshev.basis(rows, count)
    return jax.device_put(basis) if on_device else basis


@partial(jax.jit, static_argnames="dtype", compiler_options=WIDE)
def _of_one_pair(coefficients, along_y, way: AbstractRow, dtype: str):
    return image_of(way, coefficients, along_y).astype(dtype)


@partial(jax.jit, static_argnames="dtype", compiler_options=WIDE)
def _of_pairs(coefficients, along_y, way: AbstractRow, pairs: Int[Array, ""], dtype: str):
    terms = terms_of(way, coefficients, along_y)
    most = (len(terms) - 1) // 2

    def with_pair(pair, image):
        return image + way.field(terms[1 + pair]) * cos_turns(way.field(terms[1 + most + pair]))

    return way.flat(jax.lax.fori_loop(0, pairs, with_pair, way.field(terms[0]))).astype(dtype)


def image_in_channels(
    coefficients: Float[np.ndarray | Array, "fields count count"],
    shape: tuple[int, int],
    levels: Float[Any, " channels"],
    waves: tuple[Waveform, ...],
    over_carrier: bool,
    rows: tuple[int, int],
    has_axis: bool,
) -> Float[Array, "rows columns *channels"]:
    """Background · level + Σ Re[envelope Γ(turns)] at every pixel, in float64; see `waveforms`.

    - `coefficients`: background, real parts of the envelopes, imaginary parts, turns; concrete.
    - `rows`: the first, and the number, of those that are wanted.
    - `has_axis`: whether the image has one for channels.
    """
    padded = _with_zeros(np.asarray(coefficients, dtype=np.float64))
    first, count = rows
    with x64():
        way = _way(shape[1], padded.shape[-1], "float64")
        along_y = chebyshev.basis(shape[0], padded.shape[-1])[:, first : first + count]
        return _of_waveform(padded, along_y, way, levels, waves, shape[1], over_carrier, has_axis)


@partial(jax.jit, static_argnames=("columns", "over_carrier", "has_axis"), compiler_options=WIDE)
def _of_waveform(coefficients, along_y, way: AbstractRow, levels, waves, columns, over_carrier, has_axis):
    pixels = combined(way.fields(way.terms(coefficients, along_y)), levels, waves, over_carrier)
    pixels = pixels.reshape(len(pixels), -1, len(levels))[:, :columns]
    return pixels if has_axis else pixels[..., 0]


def combined(fields: list[Array], levels, waves: tuple[Waveform, ...], over_carrier: bool) -> Array:
    """Pixels of channels from fields at these pixels: background, real and imaginary parts of envelopes, turns.

    All pairs of the first waveform come first, then all of the second.
    """
    pairs = (len(fields) - 1) // 3
    real, imaginary, turns = (fields[1 + k * pairs : 1 + (k + 1) * pairs] for k in range(3))
    pixels = fields[0][..., None] * levels
    # A table of Γ's real parts comes with real envelopes.
    only_real = waves[0].cubics.shape[-1] == len(levels)
    for number, (along, aside, at) in enumerate(zip(real, imaginary, turns, strict=True)):
        wave = waves[number * len(waves) // pairs]
        pixels = pixels + fringes_by_table(along, None if only_real else aside, at, len(levels), wave, over_carrier)
    return pixels


def _with_zeros(coefficients: np.ndarray) -> np.ndarray:
    """Coefficients with zeros, up to the next class of nodes."""
    count = coefficients.shape[-1]
    nodes = next(size for size in (*_NODES, count) if size >= count)
    return np.pad(coefficients, ((0, 0), (0, nodes - count), (0, nodes - count)))


def _padded(coefficients: np.ndarray) -> np.ndarray:
    """Coefficients with zeros, up to the next class of nodes and of pairs."""
    pairs, count = (len(coefficients) - 1) // 2, coefficients.shape[-1]
    most = next(size for size in (*_PAIRS, pairs) if size >= pairs)
    nodes = next(size for size in (*_NODES, count) if size >= count)
    padded = np.zeros((1 + 2 * most, nodes, nodes))
    padded[: 1 + pairs, :count, :count] = coefficients[: 1 + pairs]
    padded[1 + most : 1 + most + pairs, :count, :count] = coefficients[1 + pairs :]
    return padded


def _aligned(shape: tuple[int, int], dtype: str) -> np.ndarray:
    """An empty array that JAX takes as it is: at a multiple of 64 bytes."""
    size = shape[0] * shape[1] * np.dtype(dtype).itemsize
    raw = np.empty(size + 64, np.uint8)
    offset = -raw.ctypes.data % 64
    return raw[offset : offset + size].view(dtype).reshape(shape)
