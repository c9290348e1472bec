"""Smooth fields on a grid of Chebyshev nodes over an image, and at every pixel."""

from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from numpy.polynomial.chebyshev import chebvander

from newtonjax.numerics.quantities import module_of


def nodes(count: int) -> np.ndarray:
    """Chebyshev points of the first kind in [-1, 1], ascending."""
    return -np.cos(np.pi * (np.arange(count) + 0.5) / count)


def node_grid(count: int) -> tuple[np.ndarray, np.ndarray]:
    """X and y in [-1, 1] of a square grid of nodes, row by row."""
    at = nodes(count)
    y, x = np.meshgrid(at, at, indexing="ij")
    return x.ravel(), y.ravel()


def analysis(count: int) -> np.ndarray:
    """The matrix that takes values at the nodes to Chebyshev coefficients (a discrete cosine transform)."""
    order = np.arange(count)[:, None]
    matrix = 2 / count * np.cos(order * np.arccos(nodes(count))[None])
    matrix[0] /= 2
    return matrix


def values(count: int, at: int) -> np.ndarray:
    """The matrix that takes Chebyshev coefficients to values at the nodes of another grid [at, count]."""
    return chebvander(nodes(at), count - 1)


def basis(pixels: int, count: int, first: int = 0, rows: int | None = None) -> np.ndarray:
    """T_0 … T_{count-1} [count, pixels] at pixel centres, the first and the last at -1 and 1; or at `rows` of them.

    A NumPy array, which becomes a constant: computed in the kernel it would be fused into every pixel.
    """
    pixel = first + np.arange(pixels if rows is None else rows)
    return chebvander((2 * pixel - (pixels - 1)) / max(pixels - 1, 1), count - 1).T.copy()


def coefficients(values: Float[Any, "... n"]) -> Float[Any, "... count count"]:
    """Chebyshev coefficients [..., in y, in x] of fields given at the nodes (row by row); NumPy makes NumPy."""
    count = round(values.shape[-1] ** 0.5)
    grid = values.reshape(*values.shape[:-1], count, count)
    if isinstance(grid, np.ndarray):
        matrix = analysis(count)
        return matrix @ grid @ matrix.T
    matrix = jnp.asarray(analysis(count), dtype=values.dtype)
    return jnp.einsum("ki,...ij,lj->...kl", matrix, grid, matrix, precision="highest")


def shells(coefficients: Float[Any, "... count count"]) -> Float[Any, "... count"]:
    """Sum of absolute coefficients by the larger of their two degrees."""
    count = coefficients.shape[-1]
    degree = np.maximum.outer(np.arange(count), np.arange(count))
    size = abs(coefficients)
    sums = [size.sum(axis=(-2, -1), where=degree == k) for k in range(count)]
    return module_of(coefficients).stack(sums, axis=-1)


def expand(coefficients: Float[Array, "fields count count"], shape: tuple[int, int]) -> list[Float[Array, "..."]]:
    """The fields at every pixel, as `expand_on`."""
    count = coefficients.shape[-1]
    return expand_on(coefficients, *(jnp.asarray(basis(n, count), dtype=coefficients.dtype) for n in shape))


def expand_on(
    coefficients: Float[Array, "fields count count"],
    along_y: Float[Array, "count rows"],
    along_x: Float[Array, "count columns"],
) -> list[Float[Array, "rows columns"]]:
    """The fields at rows and columns of pixels, written as sums over x-degrees that fuse into whatever uses them.

    Interpolating in y first leaves one short polynomial in x per row. Summed term by term it is never stored, which a
    matrix product would be: at 1024 x 1024 that is three times faster.
    """
    count = coefficients.shape[-1]
    rows = jnp.einsum("fkl,kh->flh", coefficients, along_y, precision="highest")

    def at_pixels(row):
        total = row[0][:, None] * along_x[0][None]
        for degree in range(1, count):
            total = total + row[degree][:, None] * along_x[degree][None]
        return total

    return [at_pixels(row) for row in rows]
