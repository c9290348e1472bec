"""Directions of a source as tilts of the light, and what rays of all of them make at nodes of an image."""

from dataclasses import replace
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float
from numpy.polynomial.chebyshev import chebvander

from newtonjax.fields import Beats, beats, intensity, node_arrivals, node_fields, pack
from newtonjax.methods.gap_paths import of_points, parallel
from newtonjax.methods.many_beams import profile_of
from newtonjax.methods.many_wavelengths import one_line
from newtonjax.methods.node_waves import NodeLight, of_one_direction
from newtonjax.numerics import chebyshev
from newtonjax.numerics import nodes as nodes_of
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
# Directions to a side of which rays are traced where polynomials go between them, and what the sum may err by.
_SIDE, _SUMMED = 3, 1e-6
# Angles of the rim where these are compared with rays, and what may hide between nodes.
_RIM, _BETWEEN = (0.4, 3.6), 1.5


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
        return of_one_direction(_beats(parallel(scene), camera, nodes))
    few = [_beats(tilted(scene, tilt), camera, nodes) for tilt in _few_tilts(scene)]
    parts = [np.stack(part) for part in zip(*few, strict=True)]
    ratio = channels_of(scene.light, None).lines.ratios.max()
    spread = 2 * np.pi * ratio * float(np.ptp(parts[2], axis=0).max())
    order = max(2, order_for(extent, spread, _SUMMED))
    directions = all_directions(scene, order)
    matrix = _between(scene, directions.x, directions.y)
    background, envelope, turns = (np.tensordot(matrix, part, 1) for part in parts[:3])
    weights = directions.weights / np.sqrt(1 - directions.squares())
    arrives = np.broadcast_to(parts[3].all(axis=0), background.shape)
    return NodeLight(background, envelope, turns, arrives, weights)


def error_between_directions(scene: Scene, camera: Camera, nodes: int) -> float:
    """What polynomials between the directions of `light_at_nodes` err by over the peak, against rays at the rim.

    Infinite of a map, in whose light fringes are those of its mean direction.
    """
    if scene.light.extent is not None and scene.light.extent.radiances is not None:
        return np.inf
    sine, rim = _sine(scene), np.array(_RIM)
    x, y = sine * np.cos(rim), sine * np.sin(rim)
    few = [_beats(tilted(scene, tilt), camera, nodes) for tilt in _few_tilts(scene)]
    matrix = _between(scene, x, y)
    *parts, _ = (np.tensordot(matrix, np.stack(part), 1) for part in zip(*few, strict=True))
    ratio = channels_of(scene.light, None).lines.ratios.max()
    frame, error = launch_frame(scene.light), 0.0
    for background, envelope, turns, *at in zip(*parts, x, y, strict=True):
        rays = _beats(tilted(scene, tilt_towards(frame, *at)), camera, nodes)
        size = abs(rays.envelope)
        change = 2 * np.pi * ratio * abs(turns - rays.turns) * size
        change = abs(background - rays.background) + (change + abs(envelope - rays.envelope)).sum(axis=0)
        error = max(error, float(change.max() / (rays.background + size.sum(axis=0)).max()))
    return _BETWEEN * error


def _beats(scene: Scene, camera: Camera, nodes: int) -> Beats:
    bench = pack(scene)
    return beats(node_arrivals(bench, camera, nodes), bench.pairs, bench.source)


def _few_tilts(scene: Scene) -> list[Any]:
    """Tilts of the light [rad] from a grid of directions about its source."""
    frame, at = launch_frame(scene.light), nodes_of(_SIDE) * _sine(scene)
    return [tilt_towards(frame, x, y) for x in at for y in at]


def _sine(scene: Scene) -> float:
    extent = scene.light.extent
    return 0.0 if extent is None else float(extent.sine)


def _between(scene: Scene, x, y) -> Float[np.ndarray, "directions few"]:
    """From values in the directions of `_few_tilts` to those in others."""
    sine = _sine(scene) or 1.0
    of_x, of_y = (chebvander(at / sine, _SIDE - 1) @ chebyshev.analysis(_SIDE) for at in (x, y))
    return (of_x[:, :, None] * of_y[:, None, :]).reshape(len(x), -1)


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
