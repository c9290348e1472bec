"""Directions of a source as tilts of the light, and what rays of all of them make at nodes of an image."""

from dataclasses import replace
from functools import cache
from itertools import islice
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from newtonjax.fields import (
    Beats,
    beats,
    intensity,
    node_arrivals,
    node_arrivals_in,
    node_fields,
    pack,
)
from newtonjax.methods.gap_paths import of_points, parallel
from newtonjax.methods.many_beams import profile_of
from newtonjax.methods.many_wavelengths import one_line
from newtonjax.methods.node_waves import NodeLight, of_one_direction
from newtonjax.numerics import unchecked
from newtonjax.rays import towards
from newtonjax.scene import (
    Camera,
    Directions,
    Scene,
    channels_of,
    directions_of,
    gap_opd,
    launch_frame,
    node_points,
    order_for,
    tilt_towards,
)

# Nodes to a side at which sums over directions are compared; azimuths of a disc for each of its radii.
_NODES, _AZIMUTHS = 9, 4
# Order at which the profile of a gap is compared with rays, and those that a plan tries.
_ORDER = 4
ORDERS = (2, 3, 4, 6, 8)
# Directions of which rays are traced, by the sine of the source: rings (radius in the unit disc, number) for
# polynomials of degree 2 and 4 (Ramos-López et al., Optimal sampling patterns for Zernike polynomials, 2016).
_RINGS = ((0.02, ((0.0, 1), (0.82, 5))), (np.inf, ((0.0, 1), (0.54, 5), (0.93, 9))))
# What the sum over the source may err by.
_SUMMED = 1e-6
# What may hide between nodes.
_BETWEEN = 1.5


def tilted(scene: Scene, tilt: Any) -> Scene:
    """The scene in light of one direction."""
    return replace(scene, light=replace(scene.light, tilt=tilt, extent=None))


def all_directions(scene: Scene, order: int) -> Directions:
    """Of a scene's source: 4 order² of a disc or a square."""
    return directions_of(scene.light.extent, order, _AZIMUTHS * order)


def tilts_of(scene: Scene, order: int) -> tuple[Any, Any]:
    """Tilts of the light [rad], [directions, 2], and weights: irradiance counts on the plane across its mean direction.

    Light of one direction counts on the plane across itself.
    """
    directions, frame = all_directions(scene, order), launch_frame(scene.light)
    xp = np if isinstance(directions.x, np.ndarray) and isinstance(frame[2], np.ndarray) else jnp
    tilts = [tilt_towards(frame, x, y) for x, y in zip(directions.x, directions.y, strict=True)]
    return xp.stack(tilts), directions.weights / xp.sqrt(1 - directions.squares())


def summed_at_nodes(scene: Scene, camera: Camera, order: int) -> Float[np.ndarray, " nodes"]:
    """The intensity of the mean line at nodes of the image, by rays of all directions; of known numbers."""
    total = np.zeros(_NODES**2)
    line = one_line(scene)
    for tilt, weight in zip(*tilts_of(scene, order), strict=True):
        bench = pack(tilted(line, tilt))
        total += weight * intensity(node_fields(bench, node_arrivals(bench, camera, _NODES)))
    return total


def light_at_nodes(scene: Scene, camera: Camera, nodes: int) -> NodeLight:
    """The light of a known scene at nodes x nodes points: rays of a few directions, polynomials in their sines between.

    That of one direction where its source is a point, or a map, whose cells are too many.
    """
    extent = scene.light.extent
    if extent is None or extent.radiances is not None:
        bench = pack(parallel(scene))
        return of_one_direction(beats(node_arrivals(bench, camera, nodes), bench.pairs, bench.source))
    reach = float(extent.sine) * (np.sqrt(2.0) if extent.shape == "square" else 1.0)
    places, polynomials, rim = _between(next(rings for limit, rings in _RINGS if reach <= limit))
    few = _in_directions(scene, camera, nodes, reach * places)
    parts = few.background, few.envelope, few.turns
    ratio = channels_of(scene.light, None).lines.ratios.max()
    spread = 2 * np.pi * ratio * float(np.ptp(np.tensordot(rim, few.turns, 1), axis=0).max())
    directions = all_directions(scene, max(2, order_for(extent, spread, _SUMMED)))
    sines = np.stack([directions.x, directions.y], axis=1)
    matrix = _monomials(sines / (reach or 1.0), len(places)) @ polynomials
    background, envelope, turns = (np.tensordot(matrix, part, 1) for part in parts)
    weights = directions.weights / np.sqrt(1 - directions.squares())
    arrives = np.broadcast_to(few.arrives.all(axis=0), background.shape)
    return NodeLight(background, envelope, turns, arrives, weights, sines)


@cache
def _between(rings: tuple[tuple[float, int], ...]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Directions in the unit disc; from values there to a polynomial's coefficients, and to its values at the rim."""
    angles = [2 * np.pi * np.arange(number) / number for _, number in rings]
    circles = [np.stack([np.cos(angle), np.sin(angle)], axis=1) for angle in angles]
    places = np.concatenate([radius * circle for (radius, _), circle in zip(rings, circles, strict=True)])
    polynomials = np.linalg.inv(_monomials(places, len(places)))
    return places, polynomials, _monomials(circles[-1], len(places)) @ polynomials


def _monomials(places: Float[np.ndarray, "n 2"], terms: int) -> Float[np.ndarray, "n terms"]:
    """The first so many of 1, y, x, y², xy, x², …"""
    x, y = places.T
    powers = ((k, total - k) for total in range(terms) for k in range(total + 1))
    return np.stack([x**k * y**j for k, j in islice(powers, terms)], axis=1)


def error_between_directions(scene: Scene, camera: Camera, light: NodeLight) -> float:
    """What polynomials between the directions of `light_at_nodes` err by over the peak, against rays at the rim.

    0 of a point, and infinite of a map, in whose light fringes are those of its mean direction.
    """
    if scene.light.extent is None:
        return 0.0
    if scene.light.extent.radiances is not None:
        return np.inf
    rim = (light.sines**2).sum(axis=1).argmax()
    places = [rim, (light.sines @ light.sines[rim]).argmin()]
    rays = _in_directions(scene, camera, round(light.turns.shape[-1] ** 0.5), light.sines[places])
    size = abs(rays.envelope)
    ratio = channels_of(scene.light, None).lines.ratios.max()
    of_phase = 2 * np.pi * ratio * abs(light.turns[places] - rays.turns) * size
    change = (of_phase + abs(light.envelope[places] - rays.envelope)).sum(axis=1)
    change = change + abs(light.background[places] - rays.background)
    peak = (rays.background + size.sum(axis=1)).max(axis=-1)
    return _BETWEEN * float((change.max(axis=-1) / peak).max())


def _in_directions(scene: Scene, camera: Camera, nodes: int, sines) -> Beats:
    """By rays in directions of these sines about the mean one, [directions, ...]."""
    bench, frame = pack(parallel(scene)), launch_frame(scene.light)
    tilts = (np.asarray(tilt_towards(frame, x, y)) for x, y in sines)
    settings = [towards(bench.setting, unchecked(scene.light, tilt=tilt)) for tilt in tilts]
    arrivals = node_arrivals_in(bench, settings, camera, nodes)
    by_beam = jax.tree.map(lambda leaf: np.moveaxis(leaf, 0, 1), arrivals)
    background, envelope, turns, arrives = beats(by_beam, bench.pairs, bench.source)
    return Beats(background, np.moveaxis(envelope, 0, 1), np.moveaxis(turns, 0, 1), arrives)


def error_of_profile(scene: Scene, camera: Camera) -> float:
    """By how much the profile of the gap is off the rays of all directions, over the peak, at nodes; 1.5 between them.

    Of two beams in the mean line.
    """
    line = replace(one_line(scene), light=replace(one_line(scene).light, extent=scene.light.extent))
    points = node_points(camera, _NODES)
    turns = np.broadcast_to(gap_opd(line, points[:, 0], points[:, 1]), len(points)) / line.wavelength
    formula = profile_of(line, replace(of_points(camera), response=None)).at(turns)[0]
    rays = summed_at_nodes(scene, camera, _ORDER)
    return 1.5 * float(abs(formula - rays).max() / rays.max())
