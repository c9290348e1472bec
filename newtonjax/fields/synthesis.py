"""The image of smooth fields, I = background + Σ modulus cos 2π phase, with derivatives that cost what they should.

Left to itself JAX turns the transpose of a sum over basis functions into a reduction for each of them, and fuses the
image into whatever sums it up; either costs ten to twenty images. Here the tangent is a linear primitive whose
transpose is a few matrix products, and both are linear in turn: every order and mode of differentiation works.
"""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import ShapedArray
from jax.extend.core import Primitive
from jax.interpreters import ad, batching, mlir
from jaxtyping import Array, Float

from newtonjax.fields.fringes import combine, slopes, without_turns
from newtonjax.fields.row_strips import AbstractRow, Strips, fractions, row, single_row
from newtonjax.fields.sums import slope_sums
from newtonjax.numerics import chebyshev, fenced

# Up to so many tangents times nodes they are computed side by side, which the compiler fuses; beyond one by one.
_SIDE_BY_SIDE = 40


@partial(jax.custom_jvp, nondiff_argnums=(1,))
def synthesize(
    coefficients: Float[Array, "fields count count"], shape: tuple[int, int]
) -> Float[Array, "rows columns"]:
    """The image of fields (background, moduli, phases [turns]) given by their Chebyshev coefficients."""
    way, along_y = _over(shape, coefficients.shape[-1])
    return image_of(way, coefficients, along_y)


@synthesize.defjvp
def _synthesize_jvp(shape, primals, tangents):
    (coefficients,), (change,) = primals, tangents
    return synthesize(coefficients, shape), _push.bind(coefficients, change[None], shape=shape)[0]


@partial(jax.custom_jvp, nondiff_argnums=(1,))
def synthesize_single(
    coefficients: Float[Array, "fields count count"], shape: tuple[int, int]
) -> Float[Array, "rows columns"]:
    """`synthesize` in float32; its derivatives are those of float64, rounded."""
    way = single_row(shape[1], coefficients.shape[-1])
    if way is None:
        return synthesize(coefficients, shape).astype(jnp.float32)
    along_y = chebyshev.basis(shape[0], coefficients.shape[-1])
    return image_of(way, coefficients, along_y)


@synthesize_single.defjvp
def _synthesize_single_jvp(shape, primals, tangents):
    change = jax.jvp(lambda coefficients: synthesize(coefficients, shape), primals, tangents)[1]
    return synthesize_single(*primals, shape), change.astype(jnp.float32)


def _over(shape: tuple[int, int], count: int) -> tuple[AbstractRow, np.ndarray]:
    """The way over a row, and the basis along y, of an image in float64."""
    return row(shape[1], count), chebyshev.basis(shape[0], count)


def image_of(way: AbstractRow, coefficients, along_y) -> Float[Array, "rows columns"]:
    """The image at rows of pixels, by a way over each of them."""
    terms = terms_of(way, coefficients, along_y)
    return way.flat(fenced(coefficients, lambda terms: combine(way.fields(terms)), terms))


def terms_of(way: AbstractRow, coefficients, along_y) -> Array:
    """The terms of all fields, in float32 where the pixels are."""
    terms = way.terms(without_turns(coefficients), jnp.asarray(along_y, coefficients.dtype))
    return fractions(terms) if isinstance(way, Strips) and way.single else terms


def _pushed(coefficients, changes, *, shape):
    """Changes of the image [n, rows, columns] for changes of the coefficients [n, fields, count, count]."""
    factors = slopes(chebyshev.expand(without_turns(coefficients), shape))

    def image_change(change):
        background, *waves = chebyshev.expand(change, shape)
        return background + sum(factor * wave for factor, wave in zip(factors, waves, strict=True))

    side_by_side = len(changes) * coefficients.shape[-1] <= _SIDE_BY_SIDE
    return jax.vmap(image_change)(changes) if side_by_side else jax.lax.map(image_change, changes)


def _pulled(coefficients, weights, *, shape):  # noqa: ARG001 (the weights have it)
    """The transpose: sums of weights [n, rows, columns] times the image's slope in every coefficient."""
    if len(weights) == 1:
        return slope_sums(coefficients, weights[0])[None]
    return jax.lax.map(lambda weight: slope_sums(coefficients, weight), weights)


def _plainly_pulled(coefficients, weights, *, shape):
    like = jax.ShapeDtypeStruct((len(weights), *coefficients.shape), coefficients.dtype)
    return jax.linear_transpose(lambda changes: _pushed(coefficients, changes, shape=shape), like)(weights)[0]


def _linear_primitive(name: str, compute, result_shape, differentiable) -> Primitive:
    """A primitive f(coefficients, operand) that is linear in the operand, whose first axis is a batch."""
    primitive = Primitive(name)

    def jvp(primals, tangents, *, shape):
        (at, operand), (move, change) = primals, tangents
        value = primitive.bind(at, operand, shape=shape)
        parts = [] if isinstance(change, ad.Zero) else [primitive.bind(at, change, shape=shape)]
        if not isinstance(move, ad.Zero):
            parts.append(jax.jvp(lambda c: differentiable(c, operand, shape=shape), (at,), (move,))[1])
        return value, sum(parts[1:], parts[0])

    def batched(arguments, axes, *, shape):
        (at, operand), (at_axis, axis) = arguments, axes
        if at_axis is None:
            operand = jnp.moveaxis(operand, axis, 0)
            flat = primitive.bind(at, operand.reshape(-1, *operand.shape[2:]), shape=shape)
            return flat.reshape(*operand.shape[:2], *flat.shape[1:]), 0
        at = jnp.moveaxis(at, at_axis, 0)
        batch = jnp.broadcast_to(operand, (len(at), *operand.shape)) if axis is None else jnp.moveaxis(operand, axis, 0)
        return jax.lax.map(lambda pair: primitive.bind(*pair, shape=shape), (at, batch)), 0

    primitive.def_impl(jax.jit(compute, static_argnames="shape"))
    primitive.def_abstract_eval(
        lambda at, operand, *, shape: ShapedArray(result_shape(at, operand, shape), operand.dtype)
    )
    mlir.register_lowering(primitive, mlir.lower_fun(compute, multiple_results=False))
    ad.primitive_jvps[primitive] = jvp
    batching.primitive_batchers[primitive] = batched
    return primitive


_push = _linear_primitive("fringe_push", _pushed, lambda _, changes, shape: (changes.shape[0], *shape), _pushed)
_pull = _linear_primitive("fringe_pull", _pulled, lambda at, sums, _: (sums.shape[0], *at.shape), _plainly_pulled)
ad.primitive_transposes[_push] = lambda sums, at, _, *, shape: (None, _pull.bind(at, sums, shape=shape))
ad.primitive_transposes[_pull] = lambda sums, at, _, *, shape: (None, _push.bind(at, sums, shape=shape))
