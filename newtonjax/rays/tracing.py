"""One ray along one word: a scan over its interactions, geometry first, then the field along it."""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Complex, Float, Int

from newtonjax.numerics import functions, namespace
from newtonjax.rays.fresnel import complex_cosine, reflect_field, refract, transmit_field
from newtonjax.rays.wavefront import Frame, Wavefront, field_of, launched
from newtonjax.scene import (
    REFLECT,
    REST,
    Direction,
    Face,
    Height,
    Light,
    Scene,
    Vectors,
    dot,
    exit_medium,
    field_at_launch,
    frame,
    imaged_plane,
    itinerary,
    launch_frame,
    table_size,
    tables,
)


class Route(NamedTuple):
    """What one beam meets, per interaction.

    `beyond` is the index on the far side, also of a reflecting face; `down`: whether that side lies below it.
    """

    face: Face
    before: Float[Array, " interactions"]
    beyond: Float[Array, " interactions"]
    action: Int[Array, " interactions"]
    down: Bool[Array, " interactions"]


class Setting(NamedTuple):
    """What all beams share.

    Launch frame, and frame of the plane that is imaged on the screen (origin, x, y, z); the magnification (1 without a
    collecting lens); the field launched on the axis; the index at the screen; centre, axis and radius of a shield's
    hole, which is infinite and in the screen where there is no shield; the wavefront, None of plane waves.
    """

    launch: Frame
    screen: Frame
    magnification: Float[Array, ""]
    field: Complex[Array, "3 vectors"]
    exit_index: Float[Array, ""]
    hole: tuple[Array, Array, Array]
    wavefront: Wavefront | None = None

    def across(self) -> Float[Array, "2 3 ..."]:
        """By how much the point moves in space that is seen one metre further along the screen's x and y."""
        _, x, y, _ = self.screen
        return jnp.stack([x, y]) / self.magnification


class Ray(NamedTuple):
    """A ray between interactions; its optical path [m] counts from the launch plane."""

    position: Float[Array, "3"]
    direction: Float[Array, "3"]
    path: Float[Array, ""]
    alive: Bool[Array, ""]


class Leg(NamedTuple):
    """The way to one interaction: where it began, its direction and signed length [m], the normal at its end.

    `height`: of a shape at its end; None in a bench of spheres.
    """

    position: Float[Array, "3"]
    direction: Float[Array, "3"]
    length: Float[Array, ""]
    normal: Float[Array, "3"]
    height: Height | None


class Landing(NamedTuple):
    """Where a ray meets the plane that is imaged on the screen.

    Coordinates on the screen [m], direction, optical path [m], the last surface point and the signed length from it.
    """

    point: Float[Array, "2"]
    direction: Float[Array, "3"]
    path: Float[Array, ""]
    alive: Bool[Array, ""]
    position: Float[Array, "3"]
    length: Float[Array, ""]


def gather(scene: Scene, interactions: int | None = None) -> tuple[Route, Setting]:
    """A scene's numbers for the tracer: routes stacked over beams, and what the beams share.

    Rays start on the plane across the light through the first vertex. Every route has as many `interactions`, padded
    with rests; None is the longest word's number. NumPy where all numbers are known, so that nothing is compiled.

    Raises ValueError for all orders of a gap, which no number of rays follows, and for a source of some extent.
    """
    if scene.light.extent is not None:
        raise ValueError("light.extent: rays are traced in one direction; use OverSource(), or extent=None")
    if scene.all_orders is not None:
        raise ValueError("rays cannot follow all orders in the gap; use ClosedForm(), or all_orders=None for the beams")
    xp, count = namespace(scene), len(scene.surfaces)
    table = tables(scene.beams, count, interactions)
    # Of the class: equinox makes a module of an instance's method each time that it is named, in 20 microseconds.
    size = table_size(scene.surfaces)
    faces = jax.tree.map(lambda *numbers: xp.stack(numbers), *(type(s).face(s, size) for s in scene.surfaces))
    media = xp.asarray(scene.media)
    routes = Route(
        jax.tree.map(lambda numbers: numbers[table["surface"]], faces),
        media[table["before"]],
        media[table["beyond"]],
        xp.asarray(table["action"], dtype=np.int32),
        xp.asarray(table["beyond"] > table["before"]),
    )
    origin, magnification = imaged_plane(scene)
    screen = _frame_at(xp, origin, frame(scene.screen.tilt))
    setting = Setting(
        _frame_at(xp, faces.vertex[0], launch_frame(scene.light)),
        screen,
        xp.asarray(magnification, dtype=float),
        xp.asarray(field_at_launch(scene.light)),
        xp.asarray(media[exit_medium(itinerary(scene.beams[0], count), count)]),
        _hole(xp, scene, screen),
        _wavefront(xp, scene, media[0]),
    )
    return routes, setting


def towards(setting: Setting, light: Light) -> Setting:
    """The setting of the same scene in light of another direction, of known numbers."""
    launch = _frame_at(np, setting.launch[0], launch_frame(light))
    return setting._replace(launch=launch, field=np.asarray(field_at_launch(light)))


def _wavefront(xp, scene: Scene, index) -> Wavefront | None:
    curvature = scene.light.curvature
    return None if curvature is None else Wavefront(xp.asarray(curvature), index)


def _hole(xp, scene: Scene, screen):
    """Of the shield. Without one an infinite hole in the screen: whether there is a shield changes no program."""
    shield = scene.shield
    if shield is None:
        return screen[0], screen[3], xp.asarray(np.inf)
    return xp.asarray(shield.vertex), xp.asarray(frame(shield.tilt)[2]), xp.asarray(shield.radius, dtype=float)


def _passes(setting: Setting, ray: Ray) -> Bool[Any, "..."]:
    """Whether the straight line on which a ray leaves goes through the hole of the shield."""
    centre, axis, radius = setting.hole
    offset = ray.position - centre
    point = offset - dot(axis, offset) / dot(axis, ray.direction) * ray.direction
    return ray.alive & (dot(point, point) <= radius * radius)


def _frame_at(xp, origin, directions: tuple[Direction, Direction, Direction]):
    x, y, z = directions
    return xp.asarray(origin), xp.asarray(x), xp.asarray(y), xp.asarray(z)


def interact(ray: Ray, stop: Route) -> tuple[Ray, Leg]:
    """A ray to and through one interaction."""
    distance, normal, meets, height = stop.face.meet(ray.position, ray.direction)
    # A ray that has turned round would meet the face from its other side, and run backwards.
    faces = (dot(normal, ray.direction) < 0) == stop.down
    xp = functions(normal, ray.position)
    normal = xp.where(dot(normal, ray.direction) > 0, -normal, normal)
    is_reflected, rests = stop.action == REFLECT, stop.action == REST
    refracted, cos_i, _, passes = refract(stop.before, stop.beyond, ray.direction, normal)
    thrown_back = ray.direction + 2 * cos_i * normal
    length = xp.where(rests, 0.0, distance)
    after = Ray(
        ray.position + length * ray.direction,
        xp.where(rests, ray.direction, xp.where(is_reflected, thrown_back, refracted)),
        ray.path + stop.before * length,
        ray.alive & (rests | (meets & faces & (passes | is_reflected))),
    )
    return after, Leg(ray.position, ray.direction, length, normal, height)


def trace(route: Route, setting: Setting, start: Float[Array, "2 ..."]) -> tuple[Landing, Leg]:
    """The ray that starts at (u, v) [m] on the launch plane, to the screen; also its legs [interactions].

    A leg's length is negative where a surface or a virtual screen lies behind the ray.
    """
    ray, legs = jax.lax.scan(interact, launch(setting, start), route)
    return land(setting, ray), legs


def up_to_rests(step: Callable, begin: Any, route: Route) -> tuple[Any, None]:
    """As `jax.lax.scan` over a route whose end may be rests: these are left out, and change nothing.

    How many interactions there are is data then, so that there is no reverse derivative.
    """
    number, *axes = route.action.shape
    place = jnp.arange(1, number + 1).reshape(number, *[1] * len(axes))
    longest = jnp.max(jnp.where(route.action == REST, 0, place))

    def one_more(at, state):
        return step(state, jax.tree.map(lambda leaf: leaf[at], route))[0]

    return jax.lax.fori_loop(0, longest, one_more, begin), None


def launch(setting: Setting, start: Float[Array, "2 ..."]) -> Ray:
    """The ray at (u, v) [m] of the launch plane."""
    position, direction, path = launched(setting.launch, setting.wavefront, start)
    zero = jnp.zeros_like(start[0])
    return Ray(position, jnp.broadcast_to(direction, position.shape), zero + path, zero == 0)


def launched_field(setting: Setting, direction: Vectors) -> Complex[Any, "3 vectors ..."]:
    """The field vectors of launched rays of a direction."""
    return field_of(setting.launch, setting.wavefront, setting.field, direction)


def land(setting: Setting, ray: Ray) -> Landing:
    """A ray that has left the stack, on the screen."""
    vertex, screen_x, screen_y, screen_z = setting.screen
    offset = ray.position - vertex
    length = -dot(screen_z, offset) / dot(screen_z, ray.direction)
    point = offset + length * ray.direction
    return Landing(
        setting.magnification * functions(point, screen_x).stack([dot(screen_x, point), dot(screen_y, point)]),
        ray.direction,
        ray.path + setting.exit_index * length,
        _passes(setting, ray),
        ray.position,
        length,
    )


def carry_field(route: Route, setting: Setting, legs: Leg) -> Complex[Array, "3 vectors"]:
    """The field vectors at the end of the legs, in units in which their square is the tube's flux."""
    field = launched_field(setting, legs.direction[0])
    return jax.lax.scan(lambda field, both: (passed(*both, field), None), field, (route, legs))[0]


def passed(stop: Route, leg: Leg, field):
    """The field vectors behind one interaction."""
    behind = jnp.where(stop.action == REST, field, transmitted(stop, leg, field))
    return jnp.where(stop.action == REFLECT, reflected(stop, leg, field), behind)


def transmitted(stop: Route, leg: Leg, field):
    """The field vectors beyond one interaction."""
    n1, n2 = stop.before, stop.beyond
    _, cos_i, cos_t, _ = refract(n1, n2, leg.direction, leg.normal)
    return transmit_field(n1, n2, leg.direction, leg.normal, cos_i, cos_t, field)


def reflected(stop: Route, leg: Leg, field):
    """The field vectors that one interaction throws back."""
    n1, n2 = stop.before, stop.beyond
    cos_i, cos_t = -dot(leg.direction, leg.normal), complex_cosine(n1, n2, leg.direction, leg.normal)
    return reflect_field(n1, n2, leg.direction, leg.normal, cos_i, cos_t, field)
