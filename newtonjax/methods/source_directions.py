"""Directions of a source as tilts of the light, and what rays of all of them make at nodes of an image."""

from dataclasses import replace
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float
from numpy.polynomial.chebyshev import chebvander

from newtonjax.fields import Beats, Packed, beats, intensity, node_arrivals, node_fields, pack
from newtonjax.methods.gap_paths import of_points, parallel
from newtonjax.methods.many_beams import profile_of
from newtonjax.methods.many_wavelengths import one_line
from newtonjax.methods.node_waves import NodeLight, of_one_direction
from newtonjax.numerics import chebyshev
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
# Directions to a side of which rays are traced where polynomials go between them, by the sine of the source; and what
# the sum over it may err by.
_SIDES, _SUMMED = ((0.02, 3), (np.inf, 5)), 1e-6
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
        return of_one_direction(_beats(pack(parallel(scene)), camera, nodes))
    sine = float(extent.sine)
    side = next(count for limit, count in _SIDES if sine <= limit)
    at = sine * chebyshev.nodes(side)
    few = _in_directions(scene, camera, nodes, [(x, y) for x in at for y in at])
    parts = [np.stack(part) for part in zip(*few, strict=True)]
    ratio = channels_of(scene.light, None).lines.ratios.max()
    spread = 2 * np.pi * ratio * float(np.ptp(parts[2], axis=0).max())
    directions = all_directions(scene, max(2, order_for(extent, spread, _SUMMED)))
    sines = np.stack([directions.x, directions.y], axis=1)
    analysis = chebyshev.analysis(side)
    of_x, of_y = (chebvander(part / (sine or 1.0), side - 1) @ analysis for part in sines.T)
    matrix = (of_x[:, :, None] * of_y[:, None, :]).reshape(len(sines), -1)
    background, envelope, turns = (np.tensordot(matrix, part, 1) for part in parts[:3])
    weights = directions.weights / np.sqrt(1 - directions.squares())
    arrives = np.broadcast_to(parts[3].all(axis=0), background.shape)
    return NodeLight(background, envelope, turns, arrives, weights, sines)


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
    nodes, error = round(light.turns.shape[-1] ** 0.5), 0.0
    ratio = channels_of(scene.light, None).lines.ratios.max()
    for k, rays in zip(places, _in_directions(scene, camera, nodes, light.sines[places]), strict=True):
        size = abs(rays.envelope)
        change = 2 * np.pi * ratio * abs(light.turns[k] - rays.turns) * size
        change = (change + abs(light.envelope[k] - rays.envelope)).sum(axis=0)
        change = change + abs(light.background[k] - rays.background)
        error = max(error, float(change.max() / (rays.background + size.sum(axis=0)).max()))
    return _BETWEEN * error


def _beats(bench: Packed, camera: Camera, nodes: int) -> Beats:
    return beats(node_arrivals(bench, camera, nodes), bench.pairs, bench.source)


def _in_directions(scene: Scene, camera: Camera, nodes: int, sines) -> list[Beats]:
    """By rays in directions of these sines about the mean one."""
    bench, frame = pack(parallel(scene)), launch_frame(scene.light)
    light = replace(scene.light, extent=None)
    # Not `replace`, whose checks of the same numbers take a third of the time of the rays.
    tilts = (np.asarray(tilt_towards(frame, x, y)) for x, y in sines)
    lights = (eqx.tree_at(lambda light: light.tilt, light, tilt) for tilt in tilts)
    benches = (bench._replace(setting=towards(bench.setting, light)) for light in lights)
    return [_beats(turned, camera, nodes) for turned in benches]


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
