"""Sums over the pixels of an image, in one pass over blocks of rows: what its derivatives need, and no table of them.

Block by block only sums over rows are taken, a matrix product a table; what they leave is summed along x at the end.
"""

from collections.abc import Callable
from itertools import combinations_with_replacement
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from newtonjax.fields.fringes import without_turns
from newtonjax.fields.row_strips import row
from newtonjax.numerics import chebyshev, cosine_and_sine, fenced, fraction

# Rows of a block: its tables stay in the cache.
_ROWS = 128


class Products(NamedTuple):
    """What Gauss and Newton's equations of an image take from its pixels, of weights w and residuals r.

    - `misfit`: Σ w r².
    - `slopes` [fields, count, count]: Σ w r f T_k(y) T_l(x), f the image's slope in a field.
    - `pairs` [pairs, 2 count - 1, 2 count - 1]: Σ w f g T_k T_l, of fields two by two in the order of `pairs_of`.
    """

    misfit: Float[Array, ""]
    slopes: Float[Array, "fields count count"]
    pairs: Float[Array, "pairs fine fine"]


class _Block(NamedTuple):
    """Rows of an image from `first` on, with the basis along y; `once` is 1 where no block was before."""

    first: Array
    along_y: Float[Array, "degrees rows"]
    once: Float[Array, " rows"]

    def cut(self, table: Float[Array, "all columns"]) -> Float[Array, "rows columns"]:
        return jax.lax.dynamic_slice_in_dim(table, self.first, self.along_y.shape[1])

    def over_rows(self, table: Float[Array, "rows *columns"], degrees: int) -> Float[Array, "degrees all"]:
        """Σ over the rows of T_k(y) times the table."""
        return jnp.matmul(self.along_y[:degrees] * self.once, table.reshape(len(table), -1), precision="highest")


def pairs_of(fields: int) -> list[tuple[int, int]]:
    """Fields two by two, each with itself too."""
    return list(combinations_with_replacement(range(fields), 2))


def slope_sums(
    coefficients: Float[Array, "fields count count"], weights: Float[Array, "rows columns"]
) -> Float[Array, "fields count count"]:
    """Σ over the pixels of weights times the image's slope in every coefficient."""
    count, (rows, columns), coefficients = coefficients.shape[-1], weights.shape, without_turns(coefficients)
    way = row(columns, count)

    def of_block(block: _Block) -> list[Array]:
        weight = block.cut(weights)
        slopes = _slopes(list(way.tables(coefficients[1:], block.along_y)))
        return [block.over_rows(weight * slope, count) for slope in slopes]

    by_fields = _total(of_block, rows, count)
    plain = jnp.matmul(jnp.asarray(chebyshev.basis(rows, count), weights.dtype), weights, precision="highest")
    return _along_x([plain, *by_fields], columns)


def product_sums(
    coefficients: Float[Array, "fields count count"],
    shape: tuple[int, int],
    data: Float[Array, "rows columns"] | None = None,
    weights: Float[Array, "rows columns"] | None = None,
) -> Products:
    """The sums of weights times slopes two by two, and times residuals image - data; without data these are 0."""
    (fields, count, _), coefficients = coefficients.shape, without_turns(coefficients)
    fine, pairs, way = 2 * count - 1, (fields - 1) // 2, row(shape[1], count)

    def of_block(block: _Block) -> tuple[list[Array], list[Array], list[Array]]:
        background, *waves = way.tables(coefficients, block.along_y[:count])
        slopes = fenced(coefficients, _slopes, waves)
        weight = jnp.ones_like(background) if weights is None else block.cut(weights)
        factors = [weight, *(weight * slope for slope in slopes)]
        products = [factors[a] * slopes[b - 1] if b else weight for a, b in pairs_of(fields)]
        moments = [block.over_rows(product, fine) for product in products]
        if data is None:
            return [], [], moments
        residual = background + sum(map(jnp.multiply, waves[:pairs], slopes)) - block.cut(data)
        squares = block.over_rows(weight * residual * residual, 1)
        return [squares], [block.over_rows(residual * factor, count) for factor in factors], moments

    squares, gradient, moments = _total(of_block, shape[0], fine)
    zeros = jnp.zeros_like(coefficients)
    return Products(
        squares[0].sum() if squares else jnp.zeros((), zeros.dtype),
        _along_x(gradient, shape[1]) if gradient else zeros,
        _along_x(moments, shape[1]),
    )


def _slopes(fields: list[Array]) -> list[Array]:
    """By how much the image changes per unit of each of the fields (moduli, phases), at their pixels."""
    moduli, phases = fields[: len(fields) // 2], fields[len(fields) // 2 :]
    waves = [cosine_and_sine(fraction(phase)) for phase in phases]
    by_phase = [-2 * jnp.pi * modulus * sine for modulus, (_, sine) in zip(moduli, waves, strict=True)]
    return [cosine for cosine, _ in waves] + by_phase


def _along_x(over_rows: list[Array], columns: int) -> Float[Array, "tables degrees degrees"]:
    """Tables [degrees, columns] that are summed over rows, summed along x times as many basis functions."""
    along_x = jnp.asarray(chebyshev.basis(columns, len(over_rows[0])), over_rows[0].dtype)
    return jnp.stack([jnp.matmul(table, along_x.T, precision="highest") for table in over_rows])


def _total(of_block: Callable[[_Block], Any], rows: int, degrees: int) -> Any:
    """The sum of what is made of every block of an image's rows."""
    height = min(_ROWS, rows)
    first = np.minimum(np.arange(-(-rows // height)) * height, rows - height)
    before = np.concatenate([[0], first[:-1] + height])
    basis = chebyshev.basis(rows, degrees)
    along_y = np.stack([basis[:, start : start + height] for start in first])
    once = (first[:, None] + np.arange(height) >= before[:, None]).astype(float)
    blocks = _Block(*map(jnp.asarray, (first, along_y, once)))
    begin = jax.tree.map(lambda leaf: leaf[0], blocks)
    if len(first) == 1:
        return of_block(begin)
    nothing = jax.tree.map(lambda like: jnp.zeros(like.shape, like.dtype), jax.eval_shape(of_block, begin))

    def add(total, block):
        return jax.tree.map(jnp.add, total, of_block(block)), None

    return jax.lax.scan(add, nothing, blocks)[0]
