"""Aiming: the ray of a beam that lands on a given point of the screen, its tube, and the caustics it crossed."""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Complex, Float

from newtonjax.numerics import as_complex, module_of
from newtonjax.rays.tracing import Route, Setting, trace, up_to_rests
from newtonjax.rays.tube import Shot, shoot
from newtonjax.scene import dot

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


def _largest(vector: Float[Any, "2 ..."]) -> Float[Any, "..."]:
    return module_of(vector).maximum(abs(vector[0]), abs(vector[1]))


def _solve(matrix: tuple[Float[Array, "2 ..."], Float[Array, "2 ..."]], right: Float[Array, "2 ..."]):
    (a, b), (c, d) = matrix
    determinant = a * d - b * c
    safe = jnp.where(determinant == 0, 1.0, determinant)
    return jnp.stack([d * right[0] - b * right[1], a * right[1] - c * right[0]]) / safe


def is_small(change: Float[Any, "2 ..."], point: Float[Any, "2 ..."]) -> Bool[Any, "..."]:
    """Whether Newton's method ends after a step of this size."""
    return _largest(change) <= _RELATIVE * _largest(point) + _ABSOLUTE


class Aimed(NamedTuple):
    """Launch coordinates [m] of a ray; whether it lands where it should; or whether light gets there that was missed.

    `lost` says that the search ended with a ray that reaches the screen elsewhere: the target lies beyond a caustic,
    where no ray lands, or several. `shot` is the ray with its tube.
    """

    start: Float[Array, "2 ..."]
    lands: Bool[Array, "..."] | np.ndarray  # of a tangent: float0
    lost: Bool[Array, "..."] | np.ndarray
    shot: Shot


@jax.custom_jvp
def aim(route: Route, setting: Setting, target: Float[Array, "2 ..."]) -> Aimed:
    """The rays that land on targets [m], as `aim_without_derivative`.

    Derivatives follow from the implicit function theorem: forward to any order, reverse once (a Hessian is `jacfwd` of
    `grad`).
    """
    return aim_without_derivative(route, setting, target, jax.lax.scan)


def aim_without_derivative(
    route: Route, setting: Setting, target: Float[Array, "2 ..."], go_along: Callable[..., Any] = up_to_rests
) -> Aimed:
    """The rays that land on targets [m], by Newton's method; rays may have any axes behind their coordinates.

    Where none is found the axis stands in, so that what is computed from it stays finite. `go_along`: as of `shoot`.
    """
    on_axis = jnp.zeros_like(target)
    no = on_axis[0] != 0
    nothing = jax.eval_shape(lambda start: shoot(route, setting, start, go_along), on_axis)
    shot = jax.tree.map(lambda like: jnp.zeros(like.shape, like.dtype), nothing)

    def step(state):
        start, ended, lands, strays, _, count, _ = state
        # One text of the ray for all steps and for the result, since it is what there is to compile: those that have
        # ended are shot again, and once more when all have.
        shot = shoot(route, setting, start, go_along)
        miss = target - shot.landing.point
        move = _solve(shot.slope, miss)
        # At grazing incidence a small step is a long way on the screen: both are to be small.
        small = is_small(move, start) & is_small(miss, target)
        next_start, alive = start + move, shot.landing.alive
        hits = small & alive & jnp.isfinite(next_start[0]) & jnp.isfinite(next_start[1])
        ends = ~ended & (small | (count == _STEPS - 1))
        return (
            jnp.where(ended, start, jnp.where(ends & ~hits, 0.0, next_start)),
            ended | ends,
            jnp.where(ends, hits, lands),
            jnp.where(ends, alive & ~hits, strays),
            ended.all(),
            count + 1,
            shot,
        )

    begin = (on_axis, no, no, no, jnp.zeros((), bool), 0, shot)
    start, _, lands, strays, _, _, shot = jax.lax.while_loop(lambda state: ~state[4], step, begin)
    return Aimed(start, lands, strays, shot)


@aim.defjvp
def _aim_jvp(primals, tangents) -> tuple[Aimed, Aimed]:
    route, setting, target = primals
    aimed = aim(route, setting, target)
    _, drift = jax.jvp(lambda r, s: trace(r, s, aimed.start)[0].point, (route, setting), tangents[:2])
    move = jnp.where(aimed.lands, _solve(aimed.shot.slope, tangents[2] - drift), 0.0)
    _, along = jax.jvp(shoot, (route, setting, aimed.start), (*tangents[:2], move))
    still = np.zeros(aimed.lands.shape, jax.dtypes.float0)
    return aimed, Aimed(move, still, still, along)


def arrive(
    route: Route, setting: Setting, target: Float[Array, "2 ..."], search: Callable[..., Aimed] = aim
) -> Arrival:
    """A beam, or several side by side, at points of the screen (the target, in metres); `search` finds its rays."""
    start, lands, strays, shot = search(route, setting, target)
    landing = shot.landing
    (a, b), (c, d) = shot.slope
    spread, miss = a * d - b * c, target - landing.point
    reaches = _largest(miss) <= 1e-6 * (_largest(target) + _largest(landing.point) + 1e-6)
    arrives = lands & landing.alive & reaches & (spread != 0)
    area = jnp.where(arrives, jnp.abs(spread), 1.0)
    field = shot.field * as_complex(1 / jnp.sqrt(area))
    # Fermat: what the aim still misses changes the path by its component along the ray, and no more.
    along_x, along_y = setting.across()
    along = dot(miss[0] * along_x + miss[1] * along_y, landing.direction)
    return Arrival(
        jnp.where(arrives, landing.path + setting.exit_index * along, 0.0),
        jnp.moveaxis(jnp.where(arrives, field, 0.0), (0, 1), (-2, -1)),
        jax.lax.stop_gradient(shot.quarter_turns),
        arrives,
        jnp.moveaxis(start, 0, -1),
        strays,
    )


def arrive_without_derivative(routes: Route, setting: Setting, points: Float[Array, "n 2"]) -> Arrival:
    """`arrive_all`, bit for bit, in a time that rests at the end of the routes add nothing to."""
    return arrive_all(routes, setting, points, aim_without_derivative)


def arrive_all(
    routes: Route, setting: Setting, points: Float[Array, "n 2"], search: Callable[..., Aimed] = aim
) -> Arrival:
    """Every beam at every point of the screen [m]; the arrival's numbers are [beams, n]."""
    # Numbers of interactions first, those of beams and points last.
    routes = jax.tree.map(lambda leaf: jnp.moveaxis(leaf, 0, -1)[..., None], routes)
    setting = jax.tree.map(lambda leaf: jnp.asarray(leaf)[..., None, None], setting)
    targets = jnp.broadcast_to(points.T[:, None], (2, routes.action.shape[1], len(points)))
    return arrive(routes, setting, targets, search)
