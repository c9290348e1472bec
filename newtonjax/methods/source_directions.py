"""Directions of a source as tilts of the light, and what rays of all of them make at nodes of an image."""

from dataclasses import replace
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from newtonjax.fields import intensity, node_arrivals, node_fields, pack
from newtonjax.methods.gap_paths import of_points
from newtonjax.methods.many_beams import profile_of
from newtonjax.methods.many_wavelengths import one_line
from newtonjax.scene import Camera, Directions, Scene, directions_of, gap_opd, launch_frame, node_points, tilt_towards

# Nodes to a side at which sums over directions are compared; azimuths of a disc for each of its radii.
_NODES, _AZIMUTHS = 9, 4
# Order at which the profile of a gap is compared with rays, and those that a plan tries.
_ORDER = 4
ORDERS = (2, 3, 4, 6, 8)


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
