"""The fields of a bench whose numbers are jets: exact derivatives at points of its screen, in NumPy.

Rays go through the tracer's own formulas (`rays.interact`, `rays.land`, `fresnel`), one beam after the other and all
points side by side, so that nothing is compiled. Level 0 of the jets is the launch plane's: its two tangents are the
tube of rays. The other levels are the caller's.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Bool, Float

from newtonjax.fields.at_points import Fields, pairs
from newtonjax.numerics import Jet, chebyshev, jets, value_of, without_tangents
from newtonjax.rays import (
    Landing,
    Leg,
    Ray,
    Route,
    Setting,
    foci,
    gather,
    interact,
    is_small,
    land,
    launched,
    launched_field,
    reflected,
    transmitted,
)
from newtonjax.scene import REFLECT, Camera, Scene, Source, itinerary, node_pixels, points_of, source_of
from newtonjax.scene import corners as _corners

_STEPS = 25


class Courses(NamedTuple):
    """A bench of two beams for `fields`: what each beam meets, and what they share; numbers [..., benches, 1].

    `routes`: by beam its interactions one by one, the longer beam second.
    """

    routes: tuple[list[Route], list[Route]]
    setting: Setting
    source: Source


class JetFields(NamedTuple):
    """As `fields.Fields` of two beams, numbers [benches, points]; background, envelope and phase are jets."""

    background: Jet
    envelope: Jet
    phase: Jet
    rounding: Float[np.ndarray, "benches points"]
    arrives: Bool[np.ndarray, "benches points"]


class _Arrived(NamedTuple):
    """As `rays.Arrival`."""

    path: Jet
    field: Jet
    quarter_turns: Float[np.ndarray, "benches points"]
    arrives: Bool[np.ndarray, "benches points"]


def node_points(camera: Camera, count: int) -> Jet | Float[np.ndarray, "2 n"]:
    """As `scene.node_points`, [2, n]; the camera's numbers may be jets."""
    return jets.stack(list(points_of(camera, *node_pixels(camera.shape, count))))


def courses(scenes: Sequence[Scene]) -> Courses:
    """Benches of one structure side by side; numbers may be jets, which have level 0 for the launch plane.

    Raises ValueError for light of more than one line.
    """
    if any(scene.light.spectrum is not None for scene in scenes):
        raise ValueError("light.spectrum in a study; allowed: one line so far, `spectrum` None")
    gathered = [gather(scene) for scene in scenes]
    scene = scenes[0]
    ((first, second),) = pairs(scene)

    def beside(*numbers):
        number = jets.stack(numbers, axis=-1)
        return number.reshape(*number.shape, 1)

    def stop(beam: int, k: int) -> Route:
        routes = [routes for routes, _ in gathered]
        face, before, beyond = jax.tree.map(
            lambda *numbers: beside(*(number[beam, k] for number in numbers)),
            *((route.face, route.before, route.beyond) for route in routes),
        )
        return Route(face, before, beyond, routes[0].action[beam, k], routes[0].down[beam, k])

    def stops(beam: int) -> list[Route]:
        return [stop(beam, k) for k in range(len(itinerary(scene.beams[beam], len(scene.surfaces)).surface))]

    setting = jax.tree.map(beside, *(setting for _, setting in gathered))
    source = jax.tree.map(
        lambda *numbers: beside(*map(jets.asarray, numbers)), *(source_of(scene.light) for scene in scenes)
    )
    return Courses((stops(first), stops(second)), setting, source)


def at_nodes(benches: Sequence[tuple[Scene, Camera]], count: int, levels: int) -> JetFields:
    """The fields at `count` x `count` nodes of each bench's image; they arrive only if those at the corners do."""
    points = jets.stack([node_points(camera, count) for _, camera in benches], axis=1)
    if not isinstance(points, Jet):
        points = Jet(points.reshape((1,) * levels + points.shape), levels)
    bench = courses([scene for scene, _ in benches])
    fields_by_bench = fields(bench, points)
    if benches[0][0].shield is None:
        return fields_by_bench
    # A hole's edge may lie between the outer nodes and the frame.
    corners = np.array([_corners(jax.tree.map(value_of, camera)) for _, camera in benches])
    at_corners = fields(bench, Jet(corners.transpose(2, 0, 1).reshape((1,) * levels + (2, len(benches), 4)), levels))
    return fields_by_bench._replace(arrives=fields_by_bench.arrives & at_corners.arrives.all(axis=1, keepdims=True))


def fields(bench: Courses, points: Jet) -> JetFields:
    """The fields at points [2, benches, points] of the screen [m]."""
    # What a ray that does not land computes is left out afterwards.
    with np.errstate(all="ignore"):
        first, second = (_arrive(route, bench.setting, points) for route in bench.routes)
        shares = bench.source.shares
        mutual = 2 * _weighted(second.field * first.field.conj(), shares)
        envelope, turns = bench.source.fringes(mutual, second.path - first.path)
        longest = np.maximum(abs(first.path.value), abs(second.path.value)) / value_of(bench.source.wavelength)
        return JetFields(
            background=_weighted(_square(first.field) + _square(second.field), shares),
            envelope=envelope,
            phase=turns - (second.quarter_turns - first.quarter_turns) / 4,
            rounding=8 * np.finfo(float).eps * longest,
            arrives=first.arrives & second.arrives,
        )


def values_of(fields_by_bench: JetFields) -> Fields:
    """The fields of the first bench by themselves."""
    return Fields(
        fields_by_bench.background.value[0],
        fields_by_bench.envelope.value[:1],
        fields_by_bench.phase.value[:1],
        fields_by_bench.rounding[0],
        fields_by_bench.arrives[0],
    )


def coefficients(fields_by_bench: JetFields) -> Jet:
    """Chebyshev coefficients [benches, 3, n, n] of background, modulus and phase, as `fields.polar` has them."""
    envelope = fields_by_bench.envelope
    largest = np.take_along_axis(envelope.value, abs(envelope.value).argmax(axis=-1, keepdims=True), axis=-1)
    size = abs(largest)
    unit = np.where(size > 0, largest / np.where(size > 0, size, 1.0), 1.0)
    turned = envelope * unit.conj()
    slope = turned.imag / jets.where(turned.real == 0, 1.0, turned.real)
    angle = (jets.arctan(slope) + np.angle(unit)) * (1 / (2 * np.pi))
    modulus = turned.real * jets.sqrt(slope * slope + 1)
    table = jets.stack([fields_by_bench.background, modulus, fields_by_bench.phase + angle], axis=1)
    count = round(table.shape[-1] ** 0.5)
    onto = chebyshev.analysis(count)
    grid = table.reshape(*table.shape[:-1], count, count)
    return Jet(onto @ grid.parts @ onto.T, grid.levels)


def _square(field: Jet) -> Jet:
    return field.real * field.real + field.imag * field.imag


def _weighted(products: Jet, weights) -> Jet:
    """Summed over directions, and over components with their shares."""
    each = products.sum(0)
    return weights[0] * each[0] + weights[1] * each[1]


def _shoot(route: list[Route], setting: Setting, start) -> tuple[Any, list[Any]]:
    nothing: Any = np.zeros(())
    position, direction, path = launched(setting.launch, setting.wavefront, start)
    ray = Ray(position, direction, nothing + path, nothing == 0)
    legs = []
    for stop in route:
        ray, leg = interact(ray, stop)
        legs.append(leg)
    return land(setting, ray), legs


def _values(tree):
    """With all tangents left out."""
    return jax.tree.map(without_tangents, tree)


def _without_tube(number) -> Any:
    """With the tangents of the launch plane left out."""
    return number.at_level(0, 0) if isinstance(number, Jet) else number


def _launched(at: np.ndarray, levels: int) -> Jet:
    """Launch coordinates with tangents by themselves, at level 0."""
    by_itself = np.eye(2).reshape(2, 2, *[1] * (at.ndim - 1)) * np.ones(at.shape[1:])
    return jets.variable(at, by_itself, 0, levels)


def _jacobian(point: Jet) -> list[list[np.ndarray]]:
    """Of the two coordinates by the two of the launch plane."""
    values = (0,) * (point.levels - 1)
    return [[point.parts[(1 + j, *values, i)] for j in range(2)] for i in range(2)]


def _solve(matrix: list[list[np.ndarray]], right):
    (a, b), (c, d) = matrix
    determinant = a * d - b * c
    inverse = 1 / np.where(determinant == 0, 1.0, determinant)
    return [right[0] * (d * inverse) - right[1] * (b * inverse), right[1] * (a * inverse) - right[0] * (c * inverse)]


def _aim(route: list[Route], setting: Setting, points: Jet) -> tuple[np.ndarray, np.ndarray, list[list[np.ndarray]]]:
    """Launch coordinates of the rays that land on the points, as `aiming.aim`; whether they do; and the slope there."""
    route, setting, target = _values(route), _values(setting), points.value
    start = np.zeros(target.shape)
    settled = lands = np.zeros(target.shape[1:], bool)
    slope, last = [], False
    for _ in range(_STEPS):
        landing, _ = _shoot(route, setting, _launched(start, points.levels))
        slope, miss = _jacobian(landing.point), target - landing.point.value
        move = np.stack(_solve(slope, miss))
        small = is_small(move, start) & is_small(miss, target)
        lands = np.where(settled, lands, small & landing.alive)
        # A ray that has settled takes the last step too, after which only rounding is left.
        start = np.where(lands | ~settled, start + move, start)
        if last:
            break
        settled = settled | small
        last = bool(settled.all())
    lands = lands & np.isfinite(start).all(axis=0)
    return np.where(lands, start, 0.0), lands, slope


def _arrive(route: list[Route], setting: Setting, points: Jet) -> _Arrived:
    levels = points.levels
    at, lands, slope = _aim(route, setting, points)
    start = Jet(at.reshape((1,) * levels + at.shape), levels)
    # Each step with the value's slope gets the tangents of one more order (Griewank and Walther 2008, chapter 15).
    for _ in range(1, levels):
        landing, _ = _shoot(route, setting, start)
        start = start + jets.stack(_solve(slope, points - landing.point))
    landing, legs = _shoot(route, setting, start + (_launched(at, levels) - at))
    (a, b), (c, d) = ([landing.point[i].at_level(0, 1 + j) for j in range(2)] for i in range(2))
    spread = a * d - b * c
    target, point = points.value, landing.point.value
    reaches = abs(target - point).max(axis=0) <= 1e-6 * (abs(target).max(axis=0) + abs(point).max(axis=0) + 1e-6)
    arrives = lands & landing.alive & reaches & (spread.value != 0)
    field = launched_field(setting, _without_tube(legs[0].direction))
    for stop, leg in zip(route, legs, strict=True):
        leg = jax.tree.map(_without_tube, leg)
        field = reflected(stop, leg, field) if stop.action == REFLECT else transmitted(stop, leg, field)
    field = field * (1 / jets.sqrt(jets.where(arrives, abs(spread), 1.0))).astype(complex)
    path = _without_tube(landing.path)
    return _Arrived(
        jets.where(arrives, path, 0.0), jets.where(arrives, field, 0.0), _quarter_turns(landing, legs), arrives
    )


def _quarter_turns(landing: Landing, legs: list[Leg]) -> Float[np.ndarray, "benches points"]:
    """Caustics crossed on the way."""

    def tube(number) -> Float[np.ndarray, "3 2 ..."]:
        if not isinstance(number, Jet):
            return np.zeros((len(number), 2, *number.shape[1:]))
        by_launch = number.parts[(slice(None), *[0] * (number.levels - 1))]
        return np.moveaxis(by_launch[1:] if len(by_launch) > 1 else np.zeros((2, *number.shape)), 0, 1)

    ways = [
        (landing.direction, landing.length, landing.position),
        *((leg.direction, leg.length, leg.position) for leg in legs),
    ]
    return np.asarray(sum(foci(value_of(d), value_of(length), tube(p), tube(d)) for d, length, p in ways))
