"""Light of a source that is no point, as a sum of images over its directions: for any bench and any method."""

from dataclasses import dataclass, replace
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from newtonjax.fields import ErrorEstimate
from newtonjax.methods.base import AbstractMethod
from newtonjax.methods.nodes import Chebyshev
from newtonjax.methods.pictures import AtPixels
from newtonjax.methods.source_directions import all_directions, error_of_order, tilted, tilts_of
from newtonjax.numerics import require_whole
from newtonjax.scene import Camera, Scene


@dataclass(frozen=True, repr=False)
class OverSource(AbstractMethod):
    """The images of another method, summed over the directions of `light.extent`.

    - `method`: for light of one direction.
    - `order`: of the quadrature: a disc has 4 order² directions, a square as many, a map one for each cell.
    """

    method: AbstractMethod = Chebyshev()  # noqa: RUF009 (frozen)
    order: int = 4

    def __post_init__(self):
        require_whole("order", self.order, 1, 64)

    def check(self, scene: Scene) -> None:
        light = replace(scene.light, extent=None, tilt=(1e-6, 1e-6))
        self.method.check(replace(scene, light=light))

    def check_camera(self, camera: Camera) -> None:
        self.method.check_camera(camera)

    def passes(self, scene: Scene, camera: Camera) -> float:
        count = len(all_directions(scene, self.order).weights)
        return count * self.method.passes(scene, camera)

    def bytes_per_pixel(self) -> int:
        return 16 + self.method.bytes_per_pixel()

    def describe(self) -> str:
        return f"{self.method.describe()}, over a source of order {self.order}"

    def image(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns *channels"]:
        tilts, weights = tilts_of(scene, self.order)

        def add(total, direction):
            tilt, weight = direction
            return total + weight * self.method.image(tilted(scene, tilt), camera), None

        zeros = jnp.zeros(camera.image_shape)
        return jax.lax.scan(add, zeros, (jnp.asarray(tilts), jnp.asarray(weights)))[0]

    def picture(self, scene: Scene, camera: Camera) -> Any:
        return AtPixels(scene, camera, self._of_known)

    def _of_known(self, scene: Scene, camera: Camera) -> Any:
        """The images of known numbers one after the other, all by the programs of one."""
        total: Any = 0.0
        for tilt, weight in zip(*tilts_of(scene, self.order), strict=True):
            total = total + float(weight) * self.method.picture(tilted(scene, tilt), camera).image()
        return total

    def opd(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns"]:
        return self.method.opd(tilted(scene, scene.light.tilt), camera)

    def opd_picture(self, scene: Scene, camera: Camera) -> Any:
        return self.method.opd_picture(tilted(scene, scene.light.tilt), camera)

    def error(self, scene: Scene, camera: Camera) -> ErrorEstimate:
        """That of the method in the mean direction, and of the sum in the mean line.

        Raises ValueError where the phase takes too many directions to say what the sum errs by.
        """
        phase, error = self.method.error(tilted(scene, scene.light.tilt), camera)
        return ErrorEstimate(phase, error + error_of_order(scene, camera)(self.order))
