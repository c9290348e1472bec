"""Rays at every pixel."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int, Shaped

from newtonjax.fields import ErrorEstimate, fields_at, intensity, opd_at, packed, path_difference
from newtonjax.methods.base import AbstractMethod, CannotHonourError, require_two_beams
from newtonjax.methods.many_wavelengths import by_channels, require_points
from newtonjax.numerics import is_concrete, require_concrete, require_whole, x64
from newtonjax.rays import Arrival
from newtonjax.scene import Camera, Scene, points_of

# Nodes to a side at which rays are looked at for folds and rounding.
_NODES = 17


@dataclass(frozen=True, repr=False)
class Traced(AbstractMethod):
    """Rays aimed and traced at every pixel: the reference, and the way where fields are not smooth.

    A beam adds nothing to a pixel where none of its rays lands; where several do, at a caustic, one is followed, and
    `plan` says so. Works `chunk` pixels at a time, in constant memory.
    """

    needs_every_beam: ClassVar[bool] = False
    sees_through_lens: ClassVar[bool] = True

    chunk: int = 16384

    def __post_init__(self):
        if self.chunk is None:
            raise ValueError("chunk is None; allowed: 1 pixel or more")
        require_whole("chunk", self.chunk)

    def check(self, scene: Scene) -> None:
        """Every scene in parallel light is honoured."""
        if scene.light.extent is not None:
            raise CannotHonourError("Traced", "light.extent", "it takes light of one direction", "OverSource(Traced())")

    def bytes_per_pixel(self) -> int:
        return 32

    def error(self, scene: Scene, camera: Camera) -> ErrorEstimate:
        """Rounding alone; infinite where a caustic ends in the image: of several rays of a beam one is traced there.

        Seen at 17 x 17 nodes, where the search for a ray ends with one that reaches the screen elsewhere. Raises
        ValueError for traced values.
        """
        require_concrete("Traced().error", scene, camera)
        bench = packed.pack(scene)
        beams = packed.node_arrivals(bench, camera, _NODES)
        rounding = float(packed.node_fields(bench, beams).rounding.max())
        return ErrorEstimate(np.inf, np.inf) if beams.lost.any() else ErrorEstimate(rounding, 2 * np.pi * rounding)

    def image(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns *channels"]:
        require_points(camera, "Traced()")
        if camera.response is not None:
            return by_channels(self.image, scene, camera)
        if is_concrete(scene, camera):
            return self._by_blocks(scene, camera, lambda bench, beams: intensity(packed.node_fields(bench, beams)))
        return at_every_pixel(lambda points: intensity(fields_at(scene, points)), camera, self.chunk)

    def opd(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns"]:
        require_two_beams(scene)
        if is_concrete(scene, camera):
            return self._by_blocks(scene, camera, lambda bench, beams: path_difference(beams, bench.pairs)[0])
        return at_every_pixel(lambda points: opd_at(scene, points)[0], camera, self.chunk)

    def _by_blocks(self, scene: Scene, camera: Camera, function) -> Float[Array, "rows columns"]:
        with x64():
            return jnp.asarray(by_blocks(packed.pack(scene), camera, self.chunk, function))


def by_blocks(
    bench: packed.Packed, camera: Camera, chunk: int, function: Callable[[packed.Packed, Arrival], np.ndarray]
) -> Shaped[np.ndarray, "rows columns"]:
    """A function of a bench of known numbers and of its arriving beams, at every pixel, `chunk` pixels at a time."""
    rows, columns = camera.shape

    def block(first: int) -> np.ndarray:
        pixel = np.arange(first, min(first + chunk, rows * columns))
        points = np.stack(points_of(camera, *_places(pixel, columns)), axis=1)
        return function(bench, packed.arrivals(bench, points))

    return np.concatenate([block(first) for first in range(0, rows * columns, chunk)]).reshape(rows, columns)


def _places(pixel: Int[Any, " n"], columns: int) -> tuple[Float[Any, " n"], Float[Any, " n"]]:
    """Columns and rows of pixels that are counted row by row."""
    return (pixel % columns).astype(float), (pixel // columns).astype(float)


def at_every_pixel(
    function: Callable[[Float[Array, "chunk 2"]], Shaped[Array, " chunk"]], camera: Camera, chunk: int
) -> Shaped[Array, "rows columns"]:
    """A function of screen points [m] at every pixel, `chunk` pixels at a time."""
    rows, columns = camera.shape
    count = min(chunk, rows * columns)
    chunks = -(-rows * columns // count)

    def block(start):
        pixel = jnp.minimum(start + jnp.arange(count), rows * columns - 1)
        return function(jnp.stack(points_of(camera, *_places(pixel, columns)), axis=1))

    flat = jax.lax.map(block, jnp.arange(chunks) * count)
    return flat.ravel()[: rows * columns].reshape(rows, columns)
