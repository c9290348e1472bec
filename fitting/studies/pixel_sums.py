"""An image's normal equations as sums over its pixels, in NumPy, by blocks of rows: nothing is compiled."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from fitting.parameters import one_blas_thread
from newtonjax.numerics import chebyshev, require_memory

# Pixels of a block, about: its tables stay in the cache.
_BLOCK = 1 << 16

# Background, modulus and phase two by two.
_PAIRS = [(a, b) for a in range(3) for b in range(a + 1)]

# From a block of the image [rows, columns] and its rows to the pixels' weights.
Weigh = Callable[[np.ndarray, slice], np.ndarray]


class Equations(NamedTuple):
    """As `newtonjax.NormalEquations`, of the misfit S = Σ w (I - d)² / 2."""

    misfit: float
    gradient: Float[np.ndarray, " numbers"]
    matrix: Float[np.ndarray, "numbers numbers"]


class _Block(NamedTuple):
    """Rows of an image, and the image there.

    - `factors`: what a change of background, modulus and phase does to it.
    - `bends`: what two changes do together, of modulus and phase and of the phase twice, by their place in `_PAIRS`.
    """

    rows: slice
    image: Float[np.ndarray, "rows columns"]
    factors: tuple[np.ndarray, np.ndarray, np.ndarray]
    bends: dict[int, np.ndarray]


def equations(
    table: Float[np.ndarray, "3 count count"],
    changes: Float[np.ndarray, "numbers 3 count count"],
    shape: tuple[int, int],
    weigh: Weigh,
    data: Float[np.ndarray, "rows columns"] | None = None,
    second: Float[np.ndarray, "numbers numbers 3 count count"] | None = None,
) -> Equations:
    """Misfit, gradient and Gauss and Newton's matrix of an image, from its coefficients and their derivatives.

    As `newtonjax.normal_equations` has them: products of two tangents are summed by weights on 2 n - 1 nodes, exact to
    rounding. Without `data` misfit and gradient are 0. With the coefficients' `second` derivatives too the matrix is
    that of the misfit's own, Σ w (∂I ∂I + (I - d) ∂²I).
    """
    count = table.shape[-1]
    fine = 2 * count - 1
    # Both bases, and what passes by while they are made.
    basis_bytes = 3.0 * 8.0 * fine * sum(shape)
    require_memory(f"a study of {shape[0]} x {shape[1]} pixels", basis_bytes, "allowed: a smaller shape")
    along_y, along_x = (chebyshev.basis(n, fine) for n in shape)
    moments, sums, misfit = np.zeros((len(_PAIRS), fine, fine)), np.zeros((3, count, count)), 0.0
    with one_blas_thread():
        for rows, image, factors, bends in _blocks(table, shape):
            weight = weigh(image, rows)
            by_rows = along_y[:, rows]
            weighted = [weight * factor for factor in factors]
            residual = None if data is None else image - data[rows]
            for k, (a, b) in enumerate(_PAIRS):
                each = weighted[a] * factors[b]
                if second is not None and k in bends:
                    each += weight * residual * bends[k]
                moments[k] += by_rows @ (each @ along_x.T)
            if residual is not None:
                misfit += 0.5 * float(np.vdot(weight * residual, residual))
                for k, factor in enumerate(weighted):
                    sums[k] += by_rows[:count] @ ((factor * residual) @ along_x[:count].T)
    gradient = np.tensordot(changes.reshape(len(changes), -1), sums.ravel(), 1)
    matrix = _matrix(moments, changes)
    if second is not None:
        matrix += np.tensordot(second, sums, 3)
    return Equations(misfit, gradient, matrix)


def image_of(table: Float[np.ndarray, "3 count count"], shape: tuple[int, int]) -> Float[np.ndarray, "rows columns"]:
    """The image of coefficients."""
    with one_blas_thread():
        return np.concatenate([block.image for block in _blocks(table, shape)])


def slopes_of(
    table: Float[np.ndarray, "3 count count"],
    changes: Float[np.ndarray, "numbers 3 count count"],
    shape: tuple[int, int],
) -> Float[np.ndarray, "numbers rows columns"]:
    """The image's derivatives, from those of its coefficients."""
    images = np.empty((len(changes), *shape))
    along_y, along_x = (chebyshev.basis(n, table.shape[-1]) for n in shape)
    with one_blas_thread():
        for rows, _, factors, _ in _blocks(table, shape):
            for image, change in zip(images, changes, strict=True):
                image[rows] = sum(
                    f * (along_y[:, rows].T @ part @ along_x) for f, part in zip(factors, change, strict=True)
                )
    return images


def _blocks(table: Float[np.ndarray, "3 count count"], shape: tuple[int, int]) -> Iterator[_Block]:
    along_y, along_x = (chebyshev.basis(n, table.shape[-1]) for n in shape)
    step = max(1, _BLOCK // shape[1])
    for first in range(0, shape[0], step):
        rows = slice(first, min(first + step, shape[0]))
        background, modulus, phase = along_y[:, rows].T @ table @ along_x
        angle = 2 * np.pi * (phase - np.round(phase))
        cosine, turning = np.cos(angle), -2 * np.pi * np.sin(angle)
        fringes = modulus * cosine
        bends = {_PAIRS.index((2, 1)): turning, _PAIRS.index((2, 2)): -4 * np.pi**2 * fringes}
        yield _Block(rows, background + fringes, (np.ones_like(phase), cosine, modulus * turning), bends)


def _matrix(moments, changes) -> Float[np.ndarray, "numbers numbers"]:
    """Σ over pixels of products of two tangents, from the moments of the factors' products."""
    numbers, _, count, _ = changes.shape
    fine = moments.shape[-1]
    onto = chebyshev.values(count, fine)  # to the finer nodes, where products of two fields are exact
    at_fine = (onto @ changes @ onto.T).transpose(1, 0, 2, 3).reshape(3, numbers, -1)
    back = chebyshev.analysis(fine)
    total = np.zeros((numbers, numbers))
    for (a, b), moment in zip(_PAIRS, moments, strict=True):
        part = (at_fine[a] * (back.T @ moment @ back).ravel()) @ at_fine[b].T
        total += part if a == b else part + part.T
    return total
