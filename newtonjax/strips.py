"""Pixels in float32 from fields in float64: polynomials in strips of rows, without their whole turns."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from numpy.polynomial.chebyshev import cheb2poly, chebvander

from newtonjax import chebyshev
from newtonjax.synthesis import combine, synthesize

# Strips of rows, of a polynomial of this degree in each column: so many for each node, and of so many rows at most.
_DEGREE, _STRIPS_A_NODE, _ROWS = 4, 2, 256


def strips(rows: int, count: int, first: int = 0, of: int | None = None) -> tuple[np.ndarray, np.ndarray]:
    """How fields of `count` Chebyshev coefficients in y become powers of u in [-1, 1] in strips of rows.

    For `rows` rows from `first` on, `of` so many in the image. Returns the matrix [degree + 1, strips, count], and u of
    a strip's rows; the last strip may reach beyond the image.
    """
    total = rows if of is None else of
    height = max(min(total // (_STRIPS_A_NODE * count), _ROWS, rows), 1)
    number = -(-rows // height)
    step = 2 / max(total - 1, 1)
    offset = np.arange(height) - (height - 1) / 2
    half = max(height - 1, 1) / 2 * step
    at = step * (first + height * np.arange(number) + (height - total) / 2)
    points = at[:, None] + half * chebyshev.nodes(_DEGREE + 1)
    powers = np.zeros((_DEGREE + 1, _DEGREE + 1))
    for k in range(_DEGREE + 1):
        powers[: k + 1, k] = cheb2poly(np.eye(_DEGREE + 1)[k])[: k + 1]
    local = powers @ chebyshev.analysis(_DEGREE + 1)
    return np.einsum("pi,sik->psk", local, chebvander(points, count - 1)), offset * step / half


@partial(jax.custom_jvp, nondiff_argnums=(1,))
def synthesize_single(
    coefficients: Float[Array, "fields count count"], shape: tuple[int, int]
) -> Float[Array, "rows columns"]:
    """`synthesize` in float32; its derivatives are those of float64, rounded."""
    count = coefficients.shape[-1]
    matrix, u = strips(shape[0], count)
    along_x = jnp.asarray(chebyshev.basis(shape[1], count))
    return synthesize_strips(coefficients, jnp.asarray(matrix), jnp.asarray(u), along_x)[: shape[0]]


@synthesize_single.defjvp
def _synthesize_single_jvp(shape, primals, tangents):
    change = jax.jvp(lambda coefficients: synthesize(coefficients, shape), primals, tangents)[1]
    return synthesize_single(*primals, shape), change.astype(jnp.float32)


def synthesize_strips(
    coefficients: Float[Array, "fields count count"],
    matrix: Float[Array, "powers strips count"],
    u: Float[Array, " height"],
    along_x: Float[Array, "count columns"],
) -> Float[Array, "rows columns"]:
    """The image of fields in float32, from `strips`; with the rows that the last strip has too many.

    A strip's polynomials are made in float64, whole turns are taken off their constant terms, and what is left is
    rounded: beyond that a pixel costs a short polynomial a field, in half of the memory.
    """
    fields, count, _ = coefficients.shape
    columns = along_x.shape[1]
    at_columns = (jnp.moveaxis(coefficients, 0, 1).reshape(-1, count) @ along_x).reshape(count, -1)
    local = (matrix.reshape(-1, count) @ at_columns).reshape(*matrix.shape[:2], fields, columns)
    phases = 1 + (fields - 1) // 2
    constant = local[0]
    constant = jnp.concatenate([constant[:, :phases], constant[:, phases:] - jnp.round(constant[:, phases:])], axis=1)
    rounded = jnp.concatenate([constant[None], local[1:]]).astype(jnp.float32)
    rise = u.astype(jnp.float32)[None, :, None]

    def at_pixels(terms):
        values = []
        for field in range(fields):
            total = jnp.zeros_like(rise) + terms[-1, :, field][:, None]
            for power in terms[-2::-1]:
                total = total * rise + power[:, field][:, None]
            values.append(total)
        return combine(values).reshape(-1, columns)

    # A branch keeps the compiler from computing the strips' terms anew at every pixel.
    shape = (matrix.shape[1] * len(u), columns)
    known = jnp.isfinite(rounded[0, 0, 0, 0])
    return jax.lax.cond(known, at_pixels, lambda _: jnp.full(shape, jnp.nan, jnp.float32), rounded)
