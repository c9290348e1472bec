"""Aiming: the ray of a beam that lands on a given point of the screen, its tube, and the caustics it crossed."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Complex, Float

from newtonjax.quantities import as_complex, namespace
from newtonjax.surfaces import Vectors, dot
from newtonjax.trace import Landing, Leg, Route, Setting, carry_field, trace

# Newton's method converges quadratically: once a step is this small against the point, what remains is its square
# (1e-8, and a path is stationary there: 1e-16). The second number [m] is for targets on the axis, the third bounds the
# steps where no ray lands.
_RELATIVE, _ABSOLUTE, _STEPS = 1e-4, 1e-10, 25


class Arrival(NamedTuple):
    """One beam at one point of the screen.

    - `path`: optical path from the launch plane [m].
    - `field`: complex field vectors; the sum of their squares is the irradiance over the incident one.
    - `quarter_turns`: caustics crossed; each takes a quarter turn off the phase.
    - `arrives`: False where no ray of the beam lands (it misses a surface, is totally reflected, or no aim was found).
    - `start`, `lost`: as in `Aimed`.
    """

    path: Float[Array, ""]
    field: Complex[Array, "3 2"]
    quarter_turns: Float[Array, ""]
    arrives: Bool[Array, ""]
    start: Float[Array, "2"]
    lost: Bool[Array, ""] | np.ndarray


def _differential(function, start: Float[Array, "2"]):
    """The function at a point, and its derivatives with respect to the two launch coordinates (last axis)."""
    return jax.vmap(lambda e: jax.jvp(function, (start,), (e,)), out_axes=(None, -1))(jnp.eye(2, dtype=start.dtype))


def _solve(matrix: Float[Array, "2 2"], right: Float[Array, "2"]) -> Float[Array, "2"]:
    (a, b), (c, d) = matrix
    determinant = a * d - b * c
    safe = jnp.where(determinant == 0, 1.0, determinant)
    return jnp.stack([d * right[0] - b * right[1], a * right[1] - c * right[0]]) / safe


def is_small(change: Float[Any, "2 ..."], point: Float[Any, "2 ..."]) -> Bool[Any, "..."]:
    """Whether Newton's method ends after a step of this size."""
    return abs(change).max(axis=0) <= _RELATIVE * abs(point).max(axis=0) + _ABSOLUTE


class Aimed(NamedTuple):
    """Launch coordinates [m] of a ray; whether it lands where it should; or whether light gets there that was missed.

    `lost` says that the search ended with a ray that reaches the screen elsewhere: the target lies beyond a caustic,
    where no ray lands, or several.
    """

    start: Float[Array, "2"]
    found: Bool[Array, ""] | np.ndarray  # of a tangent: float0
    lost: Bool[Array, ""] | np.ndarray


@jax.custom_jvp
def aim(route: Route, setting: Setting, target: Float[Array, "2"]) -> Aimed:
    """The ray that lands on the target [m], by Newton's method.

    Where none is found the axis stands in, so that what is computed from it stays finite. Derivatives follow from the
    implicit function theorem: forward to any order, reverse once (a Hessian is `jacfwd` of `grad`).
    """

    def landed(start):
        landing, _ = trace(route, setting, start)
        return landing.point, landing.alive

    def step(state):
        start, _, _, count = state
        (point, alive), (slope, _) = _differential(landed, start)
        move = _solve(slope, target - point)
        # At grazing incidence a small step is a long way on the screen: both are to be small.
        small = is_small(move, start) & is_small(target - point, target)
        return start + move, small, alive, count + 1

    def wants_more(state):
        return ~state[1] & (state[3] < _STEPS)

    no = jnp.zeros((), bool)
    start, small, alive, _ = jax.lax.while_loop(wants_more, step, (jnp.zeros_like(target), no, no, 0))
    found = small & alive & jnp.isfinite(start).all()
    return Aimed(jnp.where(found, start, 0.0), found, alive & ~found)


@aim.defjvp
def _aim_jvp(primals, tangents) -> tuple[Aimed, Aimed]:
    route, setting, target = primals
    start, found, lost = aim(route, setting, target)
    _, slope = _differential(lambda s: trace(route, setting, s)[0].point, start)
    _, drift = jax.jvp(lambda r, s: trace(r, s, start)[0].point, (route, setting), tangents[:2])
    move = jnp.where(found, _solve(slope, tangents[2] - drift), 0.0)
    still = np.zeros(found.shape, jax.dtypes.float0)
    return Aimed(start, found, lost), Aimed(move, still, still)


def arrive(route: Route, setting: Setting, target: Float[Array, "2"]) -> Arrival:
    """One beam at one point of the screen (the target, in metres)."""
    start, found, lost = aim(route, setting, target)
    (landing, legs), (d_landing, d_legs) = _differential(lambda s: trace(route, setting, s), start)
    spread = d_landing.point[0, 0] * d_landing.point[1, 1] - d_landing.point[0, 1] * d_landing.point[1, 0]
    miss = target - landing.point
    reaches = jnp.abs(miss).max() <= 1e-6 * (jnp.abs(target).max() + jnp.abs(landing.point).max() + 1e-6)
    arrives = found & landing.alive & reaches & (spread != 0)
    area = jnp.where(arrives, jnp.abs(spread), 1.0)
    field = carry_field(route, setting, legs) * as_complex(1 / jnp.sqrt(area))
    # Fermat: what the aim still misses changes the path by its component along the ray, and no more.
    along = dot(miss @ setting.across(), landing.direction)
    return Arrival(
        jnp.where(arrives, landing.path + setting.exit_index * along, 0.0),
        jnp.where(arrives, field, 0.0),
        caustics(landing, legs, d_landing, d_legs),
        arrives,
        start,
        lost,
    )


def arrive_all(routes: Route, setting: Setting, points: Float[Array, "n 2"]) -> Arrival:
    """Every beam at every point of the screen [m]; the arrival's numbers are [beams, n]."""
    at_points = jax.vmap(arrive, in_axes=(None, None, 0))
    return jax.vmap(at_points, in_axes=(0, None, None))(routes, setting, points)


def caustics(landing: Landing, legs: Leg, d_landing: Landing, d_legs: Leg) -> Float[Array, ""]:
    """Foci passed on the way to the screen."""
    last = foci(landing.direction, landing.length, d_landing.position, d_landing.direction)
    before = jax.vmap(foci)(legs.direction, legs.length, d_legs.position, d_legs.direction)
    return jax.lax.stop_gradient(last + before.sum())


def foci(direction: Vectors, length, d_position: Float[Any, "3 ... 2"], d_direction: Float[Any, "3 ... 2"]):
    """Foci passed on one leg: zeros of the tube's cross-section, a quadratic in the length.

    Rays are normal to a wavefront, so that both zeros are real; rounding that makes them complex is clipped, which
    keeps the double zero of an axial focus. Legs that run backwards give their foci back. The derivatives by the launch
    coordinates are along the last axis.
    """
    xp = namespace(direction, length, d_position, d_direction)

    def cross(a, b):
        return dot(direction, xp.cross(a, b, axis=0))

    (pu, pv), (du, dv) = ((part[..., 0], part[..., 1]) for part in (d_position, d_direction))
    a, b, c = cross(du, dv), cross(pu, dv) + cross(du, pv), cross(pu, pv)
    root = xp.sqrt(xp.maximum(b * b - 4 * a * c, 0.0))
    q = -0.5 * (b + xp.where(b < 0, -root, root))
    # t lies between 0 and the length: compared as fractions, so that a or q may vanish.
    passed = _between(xp, c, q, length) + _between(xp, q, a, length)
    return xp.where(length < 0, -1.0, 1.0) * passed


def _between(xp, numerator, denominator, length):
    t = numerator / xp.where(denominator == 0, 1.0, denominator)
    inside = (t * xp.sign(length) > 0) & (abs(t) < abs(length)) & (denominator != 0)
    return xp.where(inside, 1.0, 0.0)
