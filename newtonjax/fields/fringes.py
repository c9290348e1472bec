"""An image and its slopes at pixels, from smooth fields there: I = background + Σ modulus cos 2π phase."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from newtonjax.numerics import cos_turns, sin_turns


def split(fields):
    """Background, moduli and phases out of fields in a row."""
    pairs = (len(fields) - 1) // 2
    return fields[0], fields[1 : 1 + pairs], fields[1 + pairs :]


def without_turns(coefficients: Float[Array, "fields count count"]) -> Float[Array, "fields count count"]:
    """Chebyshev coefficients of the fields, the phases without the whole turns of their constants.

    Behind a thick plate these are tens of thousands: what they would round away is more than all other rounding.
    """
    first = 1 + (len(coefficients) - 1) // 2
    return coefficients.at[first:, 0, 0].add(-jnp.round(coefficients[first:, 0, 0]))


def combine(fields: list[Array]) -> Array:
    """Background + Σ modulus cos 2π phase, of fields in a row."""
    background, moduli, phases = split(fields)
    for size, turns in zip(moduli, phases, strict=True):
        background = background + size * cos_turns(turns)
    return background


def slopes(fields: list[Array]) -> list[Array]:
    """By how much the image changes per unit of each field but the background, where it is 1."""
    _, moduli, phases = split(fields)
    by_phase = [-2 * jnp.pi * size * sin_turns(turns) for size, turns in zip(moduli, phases, strict=True)]
    return [cos_turns(turns) for turns in phases] + by_phase
