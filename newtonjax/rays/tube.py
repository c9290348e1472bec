"""A ray with its neighbours: by how much position and direction change with the launch coordinates.

The derivatives are written out surface by surface (Igehy, Tracing ray differentials, SIGGRAPH 1999). They are a few
lines where automatic differentiation has each operation of the tracer twice, and compile in a third of the time. Rays
may have any axes behind their coordinates.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Complex, Float

from newtonjax.numerics import module_of
from newtonjax.rays.fresnel import refract
from newtonjax.rays.tracing import Landing, Leg, Route, Setting, interact, land, launch, launched_field, passed
from newtonjax.rays.wavefront import spreading
from newtonjax.scene import REFLECT, REST, Vectors, dot


class Tube(NamedTuple):
    """Derivatives of a ray's position and direction by the two launch coordinates, which are the second axis."""

    position: Float[Array, "3 2 ..."]
    direction: Float[Array, "3 2 ..."]


class Shot(NamedTuple):
    """A ray through all interactions to the screen, with what its tube tells.

    - `landing`: on the screen.
    - `field`: field vectors, in units in which their square is the tube's flux.
    - `quarter_turns`: caustics crossed.
    - `slope`: of the landing's two coordinates by the two of the launch plane.
    """

    landing: Landing
    field: Complex[Array, "3 vectors ..."]
    quarter_turns: Float[Array, "..."]
    slope: tuple[Float[Array, "2 ..."], Float[Array, "2 ..."]]


def shoot(
    route: Route, setting: Setting, start: Float[Array, "2 ..."], go_along: Callable[..., Any] = jax.lax.scan
) -> Shot:
    """The ray that starts at (u, v) [m] on the launch plane, with its tube.

    `go_along` works through the route: `jax.lax.scan`, or `up_to_rests` where no reverse derivative is asked for.
    """
    _, across_x, across_y, _ = setting.launch
    ray = launch(setting, start)
    across = jnp.broadcast_to(jnp.stack([across_x, across_y], axis=1), (3, *start.shape))
    field = launched_field(setting, ray.direction)
    field = jnp.broadcast_to(field, (*field.shape[:2], *start.shape[1:]))

    def step(state, stop):
        ray, tube, field, turns = state
        after, leg = interact(ray, stop)
        turns = turns + foci(leg.direction, leg.length, *tube)
        return (after, _behind(tube, stop, leg), passed(stop, leg, field), turns), None

    spread = spreading(setting.launch, setting.wavefront, ray.direction)
    begin = (ray, Tube(across, spread), field, jnp.zeros_like(start[0]))
    (ray, tube, field, turns), _ = go_along(step, begin, route)
    landing = land(setting, ray)
    turns = turns + foci(landing.direction, landing.length, *tube)
    return Shot(landing, field, turns, _slope(setting, landing, tube))


def _moved(tube: Tube, length, direction, normal) -> Float[Array, "3 2 ..."]:
    """The derivative of where rays meet a plane that is so far along them.

    The neighbours' way is longer by what keeps them on the plane.
    """
    aside = tube.position + length * tube.direction
    return aside - dot(normal, aside) / dot(normal, direction) * direction


def _behind(tube: Tube, stop: Route, leg: Leg) -> Tube:
    """The tube behind an interaction."""
    direction, normal = leg.direction[:, None], leg.normal[:, None]
    position = _moved(tube, leg.length, direction, normal)
    turn = stop.face.change_of_normal(leg.height, leg.normal, position)
    _, cos_i, cos_t, _ = refract(stop.before, stop.beyond, leg.direction, leg.normal)
    eta, reflects = stop.before / stop.beyond, stop.action == REFLECT
    change = -dot(normal, tube.direction) - dot(direction, turn)  # of the cosine of incidence
    # d' = scale d + along n in either case; the cosine of refraction changes by η² cos_i / cos_t times that.
    scale = jnp.where(reflects, 1.0, eta)
    along = jnp.where(reflects, 2 * cos_i, eta * cos_i - cos_t)
    steeper = jnp.where(reflects, 2.0, eta - eta * eta * cos_i / cos_t)
    rests = stop.action == REST
    return Tube(
        jnp.where(rests, tube.position, position),
        jnp.where(rests, tube.direction, scale * tube.direction + along * turn + steeper * change * normal),
    )


def _slope(setting: Setting, landing: Landing, tube: Tube) -> Any:
    _, x, y, z = setting.screen
    point = _moved(tube, landing.length, landing.direction[:, None], z[:, None])
    return setting.magnification * dot(x, point), setting.magnification * dot(y, point)


def foci(direction: Vectors, length, d_position: Float[Any, "3 2 ..."], d_direction: Float[Any, "3 2 ..."]):
    """Foci passed on one leg: zeros of the tube's cross-section, a quadratic in the length.

    Rays are normal to a wavefront, so that both zeros are real; rounding that makes them complex is clipped, which
    keeps the double zero of an axial focus. Legs that run backwards give their foci back. The derivatives by the launch
    coordinates are along the second axis.
    """
    xp = module_of(d_position)

    def area(a, b):
        """Of the parallelogram, seen along the ray."""
        x, y, z = direction
        return x * (a[1] * b[2] - a[2] * b[1]) + y * (a[2] * b[0] - a[0] * b[2]) + z * (a[0] * b[1] - a[1] * b[0])

    (pu, pv), (du, dv) = ((part[:, 0], part[:, 1]) for part in (d_position, d_direction))
    a, b, c = area(du, dv), area(pu, dv) + area(du, pv), area(pu, pv)
    root = xp.sqrt(xp.maximum(b * b - 4 * a * c, 0.0))
    q = -0.5 * (b + xp.where(b < 0, -root, root))
    # t lies between 0 and the length: compared as fractions, so that a or q may vanish.
    passed = _between(xp, c, q, length) + _between(xp, q, a, length)
    return xp.where(length < 0, -1.0, 1.0) * passed


def _between(xp, numerator, denominator, length):
    t = numerator / xp.where(denominator == 0, 1.0, denominator)
    inside = (t * xp.sign(length) > 0) & (abs(t) < abs(length)) & (denominator != 0)
    return xp.where(inside, 1.0, 0.0)
