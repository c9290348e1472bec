"""How smooth fields go over a row of pixels: as sums over degrees, or as short polynomials in strips of columns.

Both are linear in the fields' coefficients, so both have a transpose: sums of a table of pixels times every basis
function. Interpolating in y first leaves one polynomial in x per row. Summed term by term its cost grows with the
nodes; in strips it does not.
"""

import abc
from functools import lru_cache

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from numpy.polynomial.chebyshev import cheb2poly, chebvander

from newtonjax.numerics import chebyshev

# Degree of a strip's polynomials, in float64 and in float32, and columns of a strip: at most, and at least.
_DEGREE, _DEGREE_SINGLE, _WIDEST, _NARROWEST = 8, 6, 64, 8
# Up to so many nodes a sum over degrees costs no more than strips; in float32 there are as many strips as for these.
_FEW, _STRIPS_SINGLE = 5, 11


class AbstractRow(eqx.Module):
    """How fields of some Chebyshev coefficients in x are evaluated at the pixels of a row."""

    @abc.abstractmethod
    def terms(self, coefficients: Float[Array, "fields count count"], along_y: Float[Array, "count rows"]) -> Array:
        """What each field [fields, ...] has at the rows, few numbers each, from which `field` makes its pixels."""

    @abc.abstractmethod
    def field(self, terms: Array) -> Float[Array, "rows *columns"]:
        """The pixels of one field from its terms, its columns in strips or not."""

    def fields(self, terms: Array) -> list[Float[Array, "rows *columns"]]:
        """The pixels of all fields."""
        return [self.field(field) for field in terms]

    @abc.abstractmethod
    def flat(self, field: Float[Array, "rows *columns"]) -> Float[Array, "rows columns"]:
        """A field without what reaches beyond the image."""

    @abc.abstractmethod
    def tables(
        self, coefficients: Float[Array, "fields count count"], along_y: Float[Array, "count rows"]
    ) -> Float[Array, "fields rows columns"]:
        """The pixels of all fields by matrix products: cheaper than `fields` where each is stored in any case."""


class Degrees(AbstractRow):
    """Sums over the degrees in x, term by term: never stored, they fuse into whatever uses them."""

    along_x: Float[Array | np.ndarray, "count columns"]

    def terms(self, coefficients, along_y):
        return jnp.einsum("fkl,kh->flh", coefficients, along_y, precision="highest")

    def field(self, terms):
        along_x = jnp.asarray(self.along_x, terms.dtype)
        total = terms[0][:, None] * along_x[0][None]
        for degree in range(1, len(along_x)):
            total = total + terms[degree][:, None] * along_x[degree][None]
        return total

    def flat(self, field):
        return field

    def tables(self, coefficients, along_y):
        fields, count, _ = coefficients.shape
        rows = jnp.einsum("fkl,kh->fhl", coefficients, along_y, precision="highest")
        along_x = jnp.asarray(self.along_x, rows.dtype)
        return jnp.matmul(rows.reshape(-1, count), along_x, precision="highest").reshape(fields, along_y.shape[1], -1)


class Strips(AbstractRow):
    """Polynomials in strips of columns: in each the same powers of u in [-1, 1].

    - `matrix`: from the coefficients in x to the powers of every strip [count, strips * powers].
    - `u`: of a strip's columns; the last strip may reach beyond the image.
    - `columns`: of the image. Static.
    - `single`: pixels in float32; whole turns are taken off the phases in float64 before. Static.
    """

    matrix: Float[Array | np.ndarray, "count terms"]
    u: Float[Array | np.ndarray, " width"]
    columns: int = eqx.field(static=True)
    single: bool = eqx.field(static=True, default=False)

    @property
    def number(self) -> int:
        """How many strips a row has."""
        return -(-self.columns // len(self.u))

    def terms(self, coefficients, along_y):
        fields, count, _ = coefficients.shape
        rows = jnp.einsum("fkl,kh->fhl", coefficients, along_y, precision="highest")
        powers = jnp.matmul(rows.reshape(-1, count), jnp.asarray(self.matrix, rows.dtype), precision="highest")
        return powers.reshape(fields, along_y.shape[1], self.number, -1)

    def field(self, terms):
        u = jnp.asarray(self.u, terms.dtype)
        total = jnp.broadcast_to(terms[..., -1, None], (*terms.shape[:-1], len(u)))
        for power in range(terms.shape[-1] - 2, -1, -1):
            total = total * u + terms[..., power, None]
        return total

    def flat(self, field):
        return field.reshape(len(field), -1)[:, : self.columns]

    def tables(self, coefficients, along_y):
        terms = self.terms(coefficients, along_y)
        powers = jnp.vander(jnp.asarray(self.u, terms.dtype), terms.shape[-1], increasing=True).T
        pixels = jnp.matmul(terms.reshape(-1, terms.shape[-1]), powers, precision="highest")
        return pixels.reshape(*terms.shape[:2], -1)[..., : self.columns]


def fractions(terms: Float[Array, "fields ..."]) -> Float[Array, "fields ..."]:
    """Terms of fields (background, moduli, phases) in float32, the phases without their strips' whole turns."""
    pairs = (len(terms) - 1) // 2
    turns = jnp.round(terms[1 + pairs :, ..., :1])
    phases = jnp.concatenate([terms[1 + pairs :, ..., :1] - turns, terms[1 + pairs :, ..., 1:]], axis=-1)
    return jnp.concatenate([terms[: 1 + pairs], phases]).astype(jnp.float32)


def row(columns: int, count: int) -> AbstractRow:
    """The way over a row of so many pixels that costs least in float64.

    Strips' polynomials are exact up to nine nodes, and err by less than a thousandth of the last coefficients beyond.
    """
    width = _width(columns, count)
    if count <= _FEW or width is None:
        return Degrees(_degrees(columns, count))
    return Strips(*_powers(columns, count, width, min(count - 1, _DEGREE)), columns)


def single_row(columns: int, count: int) -> Strips | None:
    """`row` in float32; None where the image is too small for strips, which must hold few turns each."""
    width = _width(columns, max(count, _STRIPS_SINGLE))
    if width is None:
        return None
    return Strips(*_powers(columns, count, width, min(count - 1, _DEGREE_SINGLE)), columns, single=True)


def _width(columns: int, count: int) -> int | None:
    """Columns of a strip, so that there are about as many strips as nodes: whole vectors, and no columns in vain."""
    most = min(columns // max(count - 1, 1), _WIDEST) // _NARROWEST * _NARROWEST
    divisors = [width for width in range(most, most // 2, -1) if width % _NARROWEST == 0 and columns % width == 0]
    return next(iter(divisors), most) or None


@lru_cache(maxsize=32)
def _degrees(columns: int, count: int) -> np.ndarray:
    return chebyshev.basis(columns, count)


@lru_cache(maxsize=32)
def _powers(columns: int, count: int, width: int, degree: int) -> tuple[np.ndarray, np.ndarray]:
    """How Chebyshev coefficients become powers of u in strips [count, strips * (degree + 1)], and a strip's u."""
    number, step = -(-columns // width), 2 / max(columns - 1, 1)
    offset, half = np.arange(width) - (width - 1) / 2, max(width - 1, 1) / 2 * step
    centres = step * (width * np.arange(number) + (width - columns) / 2)
    points = centres[:, None] + half * chebyshev.nodes(degree + 1)
    powers = np.zeros((degree + 1, degree + 1))
    for k in range(degree + 1):
        powers[: k + 1, k] = cheb2poly(np.eye(degree + 1)[k])[: k + 1]
    local = powers @ chebyshev.analysis(degree + 1)
    matrix = np.einsum("pi,sil->lsp", local, chebvander(points, count - 1))
    return matrix.reshape(count, -1), offset * step / half
