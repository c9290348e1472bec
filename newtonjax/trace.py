"""One ray along one word: a scan over its interactions, geometry first, then the field along it."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Complex, Float, Int

from newtonjax.beams import REFLECT, REST, exit_medium, itinerary, tables
from newtonjax.fresnel import complex_cosine, reflect_field, refract, transmit_field
from newtonjax.imaging import imaged_plane
from newtonjax.light import field_at_launch, launch_frame
from newtonjax.scene import Scene
from newtonjax.surfaces import Direction, dot, frame, intersect


class Route(NamedTuple):
    """What one beam meets, per interaction.

    `beyond` is the index on the far side, also of a reflecting face; `down`: whether that side lies below it.
    """

    curvature: Float[Array, " interactions"]
    vertex: Float[Array, "interactions 3"]
    axis: Float[Array, "interactions 3"]
    before: Float[Array, " interactions"]
    beyond: Float[Array, " interactions"]
    action: Int[Array, " interactions"]
    down: Bool[Array, " interactions"]


class Setting(NamedTuple):
    """What all beams share.

    Launch frame, and frame of the plane that is imaged on the screen (origin, x, y, z); the magnification (1 without a
    collecting lens); the launched field; the index at the screen; centre, axis and radius of a shield's hole, or None.
    """

    launch: tuple[Array, Array, Array, Array]
    screen: tuple[Array, Array, Array, Array]
    magnification: Float[Array, ""]
    field: Complex[Array, "3 polarizations"]
    exit_index: Float[Array, ""]
    hole: tuple[Array, Array, Array] | None

    def across(self) -> Float[Array, "2 3"]:
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
    """The way to one interaction: where it began, its direction and signed length [m], the normal at its end."""

    position: Float[Array, "3"]
    direction: Float[Array, "3"]
    length: Float[Array, ""]
    normal: Float[Array, "3"]


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


def gather(scene: Scene) -> tuple[Route, Setting]:
    """A scene's numbers for the tracer: routes stacked over beams, and what the beams share.

    Rays start on the plane across the light through the first vertex.
    """
    table = tables(scene.beams, len(scene.surfaces))
    curvature = jnp.stack([jnp.asarray(s.curvature, dtype=float) for s in scene.surfaces])
    vertex = jnp.stack([jnp.asarray(s.vertex) for s in scene.surfaces])
    axis = jnp.stack([frame(s.tilt)[2] for s in scene.surfaces])
    media = jnp.asarray(scene.media)
    routes = Route(
        curvature[table["surface"]],
        vertex[table["surface"]],
        axis[table["surface"]],
        media[table["before"]],
        media[table["beyond"]],
        jnp.asarray(table["action"]),
        jnp.asarray(table["beyond"] > table["before"]),
    )
    origin, magnification = imaged_plane(scene)
    setting = Setting(
        _frame_at(vertex[0], launch_frame(scene.light)),
        _frame_at(origin, frame(scene.screen.tilt)),
        jnp.asarray(magnification, dtype=float),
        field_at_launch(scene.light),
        media[exit_medium(itinerary(scene.beams[0], len(scene.surfaces)), len(scene.surfaces))],
        _hole(scene),
    )
    return routes, setting


def _hole(scene: Scene):
    shield = scene.shield
    if shield is None:
        return None
    return jnp.asarray(shield.vertex), jnp.asarray(frame(shield.tilt)[2]), jnp.asarray(shield.radius, dtype=float)


def _passes(setting: Setting, ray: Ray) -> Bool[Array, ""]:
    """Whether the straight line on which a ray leaves goes through the hole of the shield, if there is one."""
    if setting.hole is None:
        return ray.alive
    centre, axis, radius = setting.hole
    offset = ray.position - centre
    point = offset - dot(axis, offset) / dot(axis, ray.direction) * ray.direction
    return ray.alive & (dot(point, point) <= radius * radius)


def _frame_at(origin, directions: tuple[Direction, Direction, Direction]) -> tuple[Array, Array, Array, Array]:
    x, y, z = directions
    return jnp.asarray(origin), jnp.asarray(x), jnp.asarray(y), jnp.asarray(z)


def _interact(ray: Ray, stop: Route) -> tuple[Ray, Leg]:
    distance, normal, meets = intersect(stop.curvature, stop.axis, ray.position - stop.vertex, ray.direction)
    # A ray that has turned round would meet the face from its other side, and run backwards.
    faces = (dot(normal, ray.direction) < 0) == stop.down
    normal = jnp.where(dot(normal, ray.direction) > 0, -normal, normal)
    is_reflected, rests = stop.action == REFLECT, stop.action == REST
    refracted, cos_i, _, passes = refract(stop.before, stop.beyond, ray.direction, normal)
    reflected = ray.direction + 2 * cos_i * normal
    length = jnp.where(rests, 0.0, distance)
    after = Ray(
        ray.position + length * ray.direction,
        jnp.where(rests, ray.direction, jnp.where(is_reflected, reflected, refracted)),
        ray.path + stop.before * length,
        ray.alive & (rests | (meets & faces & (passes | is_reflected))),
    )
    return after, Leg(ray.position, ray.direction, length, normal)


def trace(route: Route, setting: Setting, start: Float[Array, "2"]) -> tuple[Landing, Leg]:
    """The ray that starts at (u, v) [m] on the launch plane, to the screen; also its legs [interactions].

    A leg's length is negative where a surface or a virtual screen lies behind the ray.
    """
    origin, across_x, across_y, direction = setting.launch
    zero = jnp.zeros_like(start[0])
    ray = Ray(origin + start[0] * across_x + start[1] * across_y, direction, zero, zero == 0)
    ray, legs = jax.lax.scan(_interact, ray, route)
    vertex, screen_x, screen_y, screen_z = setting.screen
    offset = ray.position - vertex
    length = -dot(screen_z, offset) / dot(screen_z, ray.direction)
    point = offset + length * ray.direction
    landing = Landing(
        setting.magnification * jnp.stack([dot(screen_x, point), dot(screen_y, point)]),
        ray.direction,
        ray.path + setting.exit_index * length,
        _passes(setting, ray),
        ray.position,
        length,
    )
    return landing, legs


def carry_field(route: Route, setting: Setting, legs: Leg) -> Complex[Array, "3 polarizations"]:
    """The field vectors at the end of the legs, in units in which their square is the tube's flux."""

    def step(field, stop_and_leg):
        stop, leg = stop_and_leg
        n1, n2 = stop.before, stop.beyond
        _, cos_i, cos_t, _ = refract(n1, n2, leg.direction, leg.normal)
        through = transmit_field(n1, n2, leg.direction, leg.normal, cos_i, cos_t, field)
        cos_c = complex_cosine(n1, n2, leg.direction, leg.normal)
        back = reflect_field(n1, n2, leg.direction, leg.normal, cos_i, cos_c, field)
        kept = jnp.where(stop.action == REST, field, through)
        return jnp.where(stop.action == REFLECT, back, kept), None

    return jax.lax.scan(step, setting.field, (route, legs))[0]
