"""The image of smooth fields, I = background + Σ modulus cos 2π phase, with derivatives that cost what they should.

Left to itself JAX turns the transpose of a sum over basis functions into a reduction for each of them, and fuses the
image into whatever sums it up; either costs ten to twenty images. Here the tangent is a linear primitive whose
transpose is a few matrix products, and both are linear in turn: every order and mode of differentiation works.
"""

from functools import partial

import jax
import jax.numpy as jnp
from jax.core import ShapedArray
from jax.extend.core import Primitive
from jax.interpreters import ad, batching, mlir
from jaxtyping import Array, Float

from newtonjax import chebyshev
from newtonjax.turns import cos_turns, sin_turns

# Up to so many tangents times nodes they are computed side by side, which the compiler fuses; beyond one by one.
_SIDE_BY_SIDE = 40


@partial(jax.custom_jvp, nondiff_argnums=(1,))
def synthesize(
    coefficients: Float[Array, "fields count count"], shape: tuple[int, int]
) -> Float[Array, "rows columns"]:
    """The image of fields (background, moduli, phases [turns]) given by their Chebyshev coefficients."""
    count = coefficients.shape[-1]
    return synthesize_on(coefficients, *(jnp.asarray(chebyshev.basis(n, count), coefficients.dtype) for n in shape))


def synthesize_on(
    coefficients: Float[Array, "fields count count"],
    along_y: Float[Array, "count rows"],
    along_x: Float[Array, "count columns"],
) -> Float[Array, "rows columns"]:
    """`synthesize` at rows and columns of pixels, by JAX's own derivatives."""
    # A branch keeps the compiler from fusing the image into a sum over it, which would not be vectorized.
    return jax.lax.cond(
        jnp.isfinite(coefficients[0, 0, 0]),
        lambda: combine(chebyshev.expand_on(coefficients, along_y, along_x)),
        lambda: jnp.full((along_y.shape[1], along_x.shape[1]), jnp.nan, coefficients.dtype),
    )


@synthesize.defjvp
def _synthesize_jvp(shape, primals, tangents):
    (coefficients,), (change,) = primals, tangents
    return synthesize(coefficients, shape), _push.bind(coefficients, change[None], shape=shape)[0]


def combine(fields: list[Array]) -> Array:
    """Background + Σ modulus cos 2π phase, of fields in a row."""
    background, moduli, phases = split(fields)
    for size, turns in zip(moduli, phases, strict=True):
        background = background + size * cos_turns(turns)
    return background


def split(fields):
    """Background, moduli and phases out of fields in a row."""
    pairs = (len(fields) - 1) // 2
    return fields[0], fields[1 : 1 + pairs], fields[1 + pairs :]


def slopes(fields: list[Array]) -> list[Array]:
    """By how much the image changes per unit of each field but the background, where it is 1."""
    _, moduli, phases = split(fields)
    by_phase = [-2 * jnp.pi * size * sin_turns(turns) for size, turns in zip(moduli, phases, strict=True)]
    return [cos_turns(turns) for turns in phases] + by_phase


def _pushed(coefficients, changes, *, shape):
    """Changes of the image [n, rows, columns] for changes of the coefficients [n, fields, count, count]."""
    factors = slopes(chebyshev.expand(coefficients, shape))

    def one(change):
        background, *others = chebyshev.expand(change, shape)
        return background + sum(factor * other for factor, other in zip(factors, others, strict=True))

    few = len(changes) * coefficients.shape[-1] <= _SIDE_BY_SIDE
    return jax.vmap(one)(changes) if few else jax.lax.map(one, changes)


def _pulled(coefficients, weights, *, shape):
    """The transpose: sums of weights [n, rows, columns] times the image's slope in every coefficient."""
    along_y, along_x = (jnp.asarray(chebyshev.basis(n, coefficients.shape[-1]), coefficients.dtype) for n in shape)
    factors = slopes(chebyshev.expand(coefficients, shape))

    def one(weight):
        sums = [weight @ along_x.T] + [(weight * factor) @ along_x.T for factor in factors]
        return jnp.einsum("ky,fyl->fkl", along_y, jnp.stack(sums), precision="highest")

    return one(weights[0])[None] if len(weights) == 1 else jax.lax.map(one, weights)


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

    def batch(arguments, axes, *, shape):
        (at, operand), (at_axis, axis) = arguments, axes
        if at_axis is None:
            operand = jnp.moveaxis(operand, axis, 0)
            flat = primitive.bind(at, operand.reshape(-1, *operand.shape[2:]), shape=shape)
            return flat.reshape(*operand.shape[:2], *flat.shape[1:]), 0
        at = jnp.moveaxis(at, at_axis, 0)
        many = jnp.broadcast_to(operand, (len(at), *operand.shape)) if axis is None else jnp.moveaxis(operand, axis, 0)
        return jax.lax.map(lambda both: primitive.bind(*both, shape=shape), (at, many)), 0

    primitive.def_impl(jax.jit(compute, static_argnames="shape"))
    primitive.def_abstract_eval(
        lambda at, operand, *, shape: ShapedArray(result_shape(at, operand, shape), operand.dtype)
    )
    mlir.register_lowering(primitive, mlir.lower_fun(compute, multiple_results=False))
    ad.primitive_jvps[primitive] = jvp
    batching.primitive_batchers[primitive] = batch
    return primitive


_push = _linear_primitive("fringe_push", _pushed, lambda _, changes, shape: (changes.shape[0], *shape), _pushed)
_pull = _linear_primitive("fringe_pull", _pulled, lambda at, sums, _: (sums.shape[0], *at.shape), _plainly_pulled)
ad.primitive_transposes[_push] = lambda sums, at, _, *, shape: (None, _pull.bind(at, sums, shape=shape))
ad.primitive_transposes[_pull] = lambda sums, at, _, *, shape: (None, _push.bind(at, sums, shape=shape))
