"""Path differences in a gap over an image, and over the directions of a source."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from newtonjax.numerics import is_concrete, module_of, namespace, unchecked
from newtonjax.scene import (
    Camera,
    Channels,
    Directions,
    Gap,
    Lines,
    Scene,
    Surface,
    channels_of,
    directions_of,
    gap_between,
    order_for,
)

# Points to a side at which the range of path differences is looked for.
RANGE_POINTS = 33


def path_range(gap: Gap, camera: Camera, wavenumber) -> tuple[Any, Any]:
    """Bounds of the path difference over an image [turns]: of a grid of points, and what may lie between these."""
    x, y = (module_of(ends).linspace(ends[0], ends[1], RANGE_POINTS) for ends in camera.ends())
    turns = gap.opd(x[None, :], y[:, None]) * wavenumber
    xp = module_of(turns)
    turns = xp.broadcast_to(turns, (RANGE_POINTS, RANGE_POINTS))
    return bounds_between(turns[None])


def turns_at_pixels(gap: Gap, wavenumber, x: Float[Any, "1 columns"], y: Float[Any, "rows 1"]):
    """The path difference at every pixel [turns], for look-ups in tables.

    What a branch gives is stored: fused with look-ups, its arithmetic would be done over for every number of a table.
    """

    def of(profile):
        return jnp.broadcast_to(gap.opd(x, y, profile) * wavenumber, (len(y), x.shape[1]))

    return jax.lax.cond(gap.is_shallow(x, y), lambda: of(Surface.shallow_sag), lambda: of(Surface.sag))


def bounds_between(turns: Float[Any, "pairs rows columns"]) -> tuple[Any, Any]:
    """Of smooth functions known on a grid: between points they pass what these have by a part of their bending."""
    xp = module_of(turns)
    turns = turns if xp is np else jax.lax.stop_gradient(turns)
    bending = xp.maximum(abs(xp.diff(turns, 2, axis=1)).max(), abs(xp.diff(turns, 2, axis=2)).max())
    return turns.min() - bending, turns.max() + bending


def parallel(scene: Scene) -> Scene:
    """The scene in light of the mean direction."""
    return unchecked(scene, light=unchecked(scene.light, extent=None))


def of_points(camera: Camera) -> Camera:
    """The camera of pixels that take the light at their centres."""
    return unchecked(camera, aperture=None, blur=None)


def source_points(scene: Scene, camera: Camera, tolerance: float) -> Directions:
    """Directions over whose squared sines fringes of equal thickness are summed, errors within a tolerance of them."""
    extent = scene.light.extent
    if extent is None:
        return directions_of(None, 1)
    radians, grazing = 0.0, 1
    if is_concrete(scene, camera):
        gap, corner = gap_between(scene), 2.0 if extent.shape == "square" else 1.0
        turns = np.abs(path_range(gap, camera, 1 / scene.wavelength)).max()
        sine = scene.media[0] / gap.refractive_index * extent.sine
        if not corner * sine * sine < 1:
            raise ValueError(
                f"light.extent of sine {extent.sine:.3g} is totally reflected at the gap; use a smaller one"
            )
        ratio = channels_of(scene.light, None).lines.ratios.max()
        radians = 2 * np.pi * turns * ratio * (1 - np.sqrt(1 - corner * sine * sine))
        grazing = grazing_order(extent.shape, float(sine), tolerance)
    return directions_of(extent, min(max(order_for(extent, radians, tolerance) + 2, grazing), 64))


def grazing_order(shape: str, sine: float, tolerance: float) -> int:
    """The order of a quadrature that bears the branch point of the root of 1 - sin²θ.

    Of n nodes errors fall as ρ^(-2n), ρ the sum of the half axes of the ellipse about the nodes' interval [-1, 1] that
    meets the point (Trefethen, Approximation Theory and Approximation Practice, theorem 19.3).
    """
    if not sine:
        return 1
    # The nodes lie in the squared sine of a disc; in the sine along an edge of a square.
    place = 2 / sine**2 - 1 if shape == "disc" else 2 * np.sqrt(1 / sine**2 - 1) - 1
    return int(np.ceil(-np.log(tolerance) / (2 * np.log(place + np.sqrt(place**2 - 1)))))


def channels_over_source(scene: Scene, camera: Camera, tolerance: float = 1e-7) -> Channels:
    """What channels take of each line and direction: in a gap a direction acts as a line of a longer wave.

    The path difference 2 n t cos θ is that of normal incidence at cos θ of the wavenumber. Amplitudes are those of
    normal incidence.
    """
    channels = channels_of(scene.light, camera.response)
    if scene.light.extent is None:
        return channels
    directions, gap = source_points(scene, camera, tolerance), gap_between(scene).refractive_index
    lines, powers = channels
    xp = namespace(scene, directions)
    index = scene.media[0] / gap
    cosines = xp.sqrt(1 - directions.squares() * (index * index))
    weights = directions.weights

    def beside(numbers, factors):
        return None if numbers is None else (numbers[..., :, None] * factors).reshape(*numbers.shape[:-1], -1)

    widths = (beside(width, cosines) for width in lines.widths)
    return Channels(
        Lines(beside(lines.shares, weights), beside(lines.ratios, cosines), *widths), beside(powers, weights)
    )
