"""Directions of a source as tilts of the light, and what rays of all of them make at nodes of an image."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import islice
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from newtonjax.fields import (
    Beats,
    beats,
    node_arrivals,
    node_arrivals_in,
    pack,
)
from newtonjax.methods.gap_paths import of_points, parallel
from newtonjax.methods.many_beams import profile_of
from newtonjax.methods.many_wavelengths import one_line
from newtonjax.methods.node_waves import NodeLight, of_one_direction
from newtonjax.numerics import namespace, unchecked
from newtonjax.rays import towards
from newtonjax.scene import (
    Camera,
    Directions,
    Scene,
    channels_of,
    directions_of,
    gap_opd,
    grey,
    launch_frame,
    node_points,
    order_for,
    tilt_towards,
)

# Background [n], and complex amplitudes of the fringes [pairs, n], at nodes.
Sum = tuple[Any, Any]
# Nodes to a side at which sums over directions are compared; azimuths of a disc for each of its radii.
_NODES, _AZIMUTHS = 9, 4
# Those of sums that a plan tries.
ORDERS = (2, 3, 4, 6, 8)
# Directions of which rays are traced, by the sine of the source: rings (radius in the unit disc, number) for
# polynomials of degree 2 and 4 (Ramos-López et al., Optimal sampling patterns for Zernike polynomials, 2016).
_RINGS = ((0.02, ((0.0, 1), (0.82, 5))), (np.inf, ((0.0, 1), (0.54, 5), (0.93, 9))))
# What the sum over the source may err by, and polynomials that take the place of rays; else the largest order of rays.
_SUMMED, _SMOOTH, _MOST_RAYS = 1e-6, 5e-5, 16
# Further nodes that a phase takes that is quadratic in their place.
_BEYOND = 2
# What may hide between nodes.
_BETWEEN = 1.5


def tilted(scene: Scene, tilt: Any) -> Scene:
    """The scene in light of one direction."""
    return replace(scene, light=replace(scene.light, tilt=tilt, extent=None))


def all_directions(scene: Scene, order: int) -> Directions:
    """Of a scene's source: 4 order² of a disc or a square."""
    return directions_of(scene.light.extent, order, _AZIMUTHS * order)


def tilts_of(scene: Scene, order: int) -> tuple[Any, Any]:
    """Tilts of the light [rad], [directions, 2], and weights."""
    directions, frame = all_directions(scene, order), launch_frame(scene.light)
    xp = np if isinstance(directions.x, np.ndarray) and isinstance(frame[2], np.ndarray) else jnp
    tilts = [tilt_towards(frame, x, y) for x, y in zip(directions.x, directions.y, strict=True)]
    return xp.stack(tilts), _on_mean_plane(directions)


def summed_at_nodes(scene: Scene, camera: Camera, order: int) -> Float[np.ndarray, " nodes"]:
    """The intensity of the mean line at nodes of the image, by rays of all directions; of known numbers."""
    background, waves = _sum_of_rays(scene, camera, order)
    return background + waves.real.sum(axis=0)


def _sum_of_rays(scene: Scene, camera: Camera, order: int) -> Sum:
    directions = all_directions(scene, order)
    rays = _in_directions(scene, camera, _NODES, _sines(directions))
    return NodeLight(*rays, _on_mean_plane(directions), _sines(directions)).summed()


def _sums_over_source(scene: Scene, camera: Camera) -> tuple[Callable[[int], Sum], int, float]:
    """The light at nodes by orders, an order that resolves the phase, and by how much such sums err over the peak.

    Two orders that leave the phase unresolved may agree, and both be wrong. Where rays at the rim are as polynomials
    between few directions have them, these are summed, else rays.

    Raises ValueError where the phase takes too many directions.
    """
    if scene.light.extent is None or scene.light.extent.radiances is not None:
        return lambda order: _sum_of_rays(scene, camera, order), 1, 0.0
    resolving = 1
    for _, rings in _RINGS:
        few = _of_few_directions(scene, camera, _NODES, rings)
        resolving = few.order(scene)
        light = few.light(all_directions(scene, resolving))
        error = error_between_directions(scene, camera, light)
        if light.arrives.all() and error <= _SMOOTH:
            return lambda order, few=few: few.light(all_directions(scene, order)).summed(), resolving, error
    if resolving > _MOST_RAYS:
        raise ValueError(
            f"a source of {_MOST_RAYS} x {_MOST_RAYS} directions or more does not resolve the phase of its light; "
            "give a smaller source, or a thinner gap"
        )
    return lambda order: _sum_of_rays(scene, camera, order), resolving, 0.0


def error_of_order(scene: Scene, camera: Camera) -> Callable[[int], float]:
    """By how much sums over the directions of an order err over the peak, at nodes; half as much again between them.

    Of the mean line, wherever the fringes lie. Raises ValueError as `_sums_over_source`.
    """
    summed, resolving, error = _sums_over_source(scene, camera)
    background, waves = summed(resolving)
    peak = (background + abs(waves).sum(axis=0)).max()

    def of(order: int) -> float:
        level, amplitudes = summed(order)
        change = abs(level - background) + abs(amplitudes - waves).sum(axis=0)
        return error + _BETWEEN * float(change.max() / peak)

    return of


def light_at_nodes(scene: Scene, camera: Camera, nodes: int) -> NodeLight:
    """The light of a known scene at nodes x nodes points: rays of a few directions, polynomials in their sines between.

    That of one direction where its source is a point, or a map, whose cells are too many.
    """
    extent = scene.light.extent
    if extent is None or extent.radiances is not None:
        bench = pack(parallel(scene))
        return of_one_direction(beats(node_arrivals(bench, camera, nodes), bench.pairs, bench.source))
    reach = _reach(extent)
    few = _of_few_directions(scene, camera, nodes, next(rings for limit, rings in _RINGS if reach <= limit))
    return few.light(all_directions(scene, few.order(scene)))


class _FewDirections(NamedTuple):
    """Rays of a few directions, and polynomials between these: to coefficients, and to values at the rim.

    - `reach`: sine of the rim.
    """

    rays: Beats
    reach: float
    polynomials: Float[np.ndarray, "terms rays"]
    rim: Float[np.ndarray, "rim rays"]

    def order(self, scene: Scene) -> int:
        """Of a quadrature that resolves the phase over the source."""
        extent: Any = scene.light.extent
        ratio = channels_of(scene.light, None).lines.ratios.max()
        turns = float(np.ptp(np.tensordot(self.rim, self.rays.turns, 1), axis=0).max())
        order = max(2, order_for(extent, 2 * np.pi * turns * float(ratio), _SUMMED))
        # Nodes lie in the squared sine of a disc, in which phases are nearly linear; in the sine itself of a square.
        return order + (_BEYOND if extent.shape == "square" else 0)

    def light(self, directions: Directions) -> NodeLight:
        """Of many directions."""
        sines = _sines(directions)
        matrix = _monomials(sines / (self.reach or 1.0), len(self.polynomials)) @ self.polynomials
        background, envelope, turns = (np.tensordot(matrix, part, 1) for part in self.rays[:3])
        arrives = np.broadcast_to(self.rays.arrives.all(axis=0), background.shape)
        return NodeLight(background, envelope, turns, arrives, _on_mean_plane(directions), sines)


def _of_few_directions(scene: Scene, camera: Camera, nodes: int, rings: tuple[tuple[float, int], ...]):
    places, polynomials, rim = _between(rings)
    reach = _reach(scene.light.extent)
    return _FewDirections(_in_directions(scene, camera, nodes, reach * places), reach, polynomials, rim)


def _reach(extent: Any) -> float:
    """The largest sine of a source."""
    return float(extent.sine) * (np.sqrt(2.0) if extent.shape == "square" else 1.0)


def _sines(directions: Directions) -> Float[np.ndarray, "directions 2"]:
    return np.stack([directions.x, directions.y], axis=1)


def _on_mean_plane(directions: Directions) -> Float[Any, " directions"]:
    """Weights of light of unit irradiance across itself: a source's counts on the plane across its mean direction."""
    return directions.weights / namespace(directions).sqrt(1 - directions.squares())


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
    formula = profile_of(line, grey(of_points(camera))).at(turns)[0]
    summed, resolving, error = _sums_over_source(scene, camera)
    background, waves = summed(resolving)
    rays = background + waves.real.sum(axis=0)
    return error + _BETWEEN * float(abs(formula - rays).max() / rays.max())
