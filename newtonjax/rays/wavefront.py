"""The light that is launched: rays of plane or of spherical waves, with their fields, and how they spread."""

from typing import Any, NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Complex, Float

from newtonjax.numerics import functions
from newtonjax.scene import Vectors, dot

# An origin, and the directions x, y, z; what is launched may be of NumPy and of jets too.
Frame = tuple[Array, Array, Array, Array]


class Wavefront(NamedTuple):
    """Spherical waves about a point of the light's axis: curvature at the launch plane [1/m], and the medium.

    The curvature is above 0 for light that spreads, below 0 for light that is gathered.
    """

    curvature: Float[Array, ""]
    refractive_index: Float[Array, ""]


def launched(launch: Any, wavefront: Wavefront | None, start: Float[Any, "2 ..."]) -> tuple[Vectors, Vectors, Any]:
    """Position, direction and optical path [m] of the rays at (u, v) [m] of the launch plane.

    The path counts from the wavefront through the plane's origin: sqrt(D² + u² + v²) - D at a distance D = 1/c of the
    source is c (u² + v²) / (1 + sqrt(1 + c² (u² + v²))), which has its derivative in c at plane waves too.
    """
    origin, across_x, across_y, axis = launch
    aside = start[0] * across_x + start[1] * across_y
    position = origin + aside
    if wavefront is None:
        return position, axis, 0.0
    curvature = wavefront.curvature
    square = start[0] * start[0] + start[1] * start[1]
    length = functions(curvature, square).sqrt(1 + curvature * curvature * square)
    direction = (axis + curvature * aside) / length
    ahead = curvature * square / (1 + length)
    return position, direction, wavefront.refractive_index * ahead


def field_of(launch: Any, wavefront: Wavefront | None, field, direction: Vectors) -> Complex[Any, "3 vectors ..."]:
    """The field vectors of rays of a direction, in units in which their square is the flux per area of the plane.

    That of a point source falls with the cube of the cosine to the axis. The vectors are those on the axis, turned by
    the least angle that makes them perpendicular to the ray.
    """
    if wavefront is None:
        return field
    axis = launch[3]
    cosine = dot(axis, direction)
    scale = cosine * functions(cosine).sqrt(cosine)
    along, share = direction[:, None].astype(field.dtype), 1 / (1 + cosine)
    turned = (axis + direction)[:, None] * share
    field = field - turned.astype(field.dtype) * dot(along, field)[None]
    return field * scale.astype(field.dtype)


def spreading(launch: Any, wavefront: Wavefront | None, direction: Vectors) -> Float[Array, "3 2 ..."]:
    """The derivatives of the direction by the launch coordinates [1/m], which are the second axis."""
    _, across_x, across_y, axis = launch
    across = jnp.broadcast_to(jnp.stack([across_x, across_y], axis=1), (3, 2, *direction.shape[1:]))
    if wavefront is None:
        return jnp.zeros_like(across)
    ray = direction[:, None]
    return wavefront.curvature * dot(axis, direction) * (across - ray * dot(ray, across)[None])
