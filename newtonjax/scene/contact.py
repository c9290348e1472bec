"""The gap of a sphere pressed on a plate: Hertz's flattened contact."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float


@jax.custom_jvp
def hertz_gap(r2: Float[Array, "..."], a2: Float[Array, "..."]) -> Float[Array, "..."]:
    """Twice the sphere's radius times the gap [m²] at squared distances r2 [m²], for a squared contact radius a2 [m²].

    Outside of the disc r² - 2 a² + (2/π) [(2 a² - r²) asin(a/r) + a sqrt(r² - a²)], zero inside (Hertz 1882; Johnson,
    Contact Mechanics, 1985, eq. 3.42a). A negative a2 is a sphere lifted by |a2| / radius: r² - 2 a2, which meets the
    pressed one at zero with the same slope. Value and first derivatives are finite everywhere, the centre, the disc's
    edge and a2 = 0 included. Valid while a and r are small against the radius.
    """
    sine, cosine, disc, clipped = _angle(r2, a2)
    pressed = clipped - 2 * disc + (2 / jnp.pi) * ((2 * disc - clipped) * jnp.arcsin(sine) + clipped * sine * cosine)
    return jnp.where(a2 > 0, pressed, r2 - 2 * a2)


@hertz_gap.defjvp
def _slope(primals, tangents):
    # In the derivative the terms that are infinite at the edge cancel.
    (r2, a2), (along, pressing) = primals, tangents
    sine, cosine, *_ = _angle(r2, a2)
    angle = (2 / jnp.pi) * jnp.arcsin(sine)
    outwards = jnp.where(a2 > 0, 1 - angle + (2 / jnp.pi) * sine * cosine, 1.0)
    return hertz_gap(r2, a2), outwards * along + jnp.where(a2 > 0, 2 * angle - 2, -2.0) * pressing


def _angle(r2, a2):
    """Sine and cosine of asin(a/r), the disc's a², and r² but at least a²: inside of the disc all is as at its edge."""
    disc = jnp.maximum(a2, jnp.finfo(jnp.result_type(float)).tiny)
    clipped = jnp.maximum(r2, disc)
    return jnp.sqrt(disc / clipped), jnp.sqrt(1 - disc / clipped), disc, clipped
