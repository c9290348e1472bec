"""What every way to compute an image answers for itself."""

import abc
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import ClassVar

import jax
from jaxtyping import Array, Float

from newtonjax.fields import ErrorEstimate
from newtonjax.methods.pictures import AbstractPicture, AtPixels
from newtonjax.numerics import afresh, shown
from newtonjax.scene import Camera, Scene, itinerary

# Costs are counted in passes of `cos_turns` over 1024 x 1024 pixels (0.6 ms on two cores). The numbers of all methods
# were fitted together to timings of such images: what a call costs by itself, and one ray through one surface. That
# plans made with them are fast is what `experiments/accuracy/planner.py` checks.
PASS_PIXELS = 1024 * 1024
CALL, INTERACTION = 0.6, 1.3e-3
# Rays at every pixel are worked through one block after another: one costs more than one of a small grid's.
_BLOCKS = 1.5


class CannotHonourError(ValueError):
    """A part of a scene that a method does not know: `part` names it, `demand` says what the method takes instead."""

    def __init__(self, method: str, part: str, demand: str, way_out: str):
        super().__init__(f"{method} cannot honour {part}: {demand}; use {way_out}")
        self.part, self.demand = part, demand


@dataclass(frozen=True, repr=False)
class AbstractMethod(abc.ABC):
    """A way to compute images: a frozen dataclass, so that it may be a static argument; to JAX a tree without leaves.

    A subclass is a dataclass with `repr=False`: shown as it is called, without what is at its default.

    - `needs_float64`: whether a transformation in float32 would round its optical paths.
    - `traces_rays`: whether it follows rays, so that its image has what a formula for the gap alone leaves out.
    - `needs_every_beam`: whether each beam must reach the whole image.
    - `sees_through_lens`: whether its pixels may look at any points of the screen, as through a `CameraLens`.
    - `float32_error`: what its pixels in float32 are away from those in float64, over the peak.
    """

    needs_float64: ClassVar[bool] = True
    traces_rays: ClassVar[bool] = True
    needs_every_beam: ClassVar[bool] = True
    sees_through_lens: ClassVar[bool] = False
    float32_error: ClassVar[float] = 0.0

    def __init_subclass__(cls):
        jax.tree_util.register_static(cls)

    def __repr__(self) -> str:
        changed = (field.name for field in fields(self) if getattr(self, field.name) != field.default)
        return f"{type(self).__name__}({', '.join(f'{name}={getattr(self, name)!r}' for name in changed)})"

    @abc.abstractmethod
    def check(self, scene: Scene) -> None:
        """Raise CannotHonourError, a ValueError, where the method cannot honour a part of the scene."""

    @abc.abstractmethod
    def image(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns *channels"]:
        """Irradiance at every pixel over the incident one; what each channel takes, of a camera with a response."""

    @abc.abstractmethod
    def opd(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns"]:
        """Optical path difference of the scene's two beams at every pixel [m]."""

    @abc.abstractmethod
    def error(self, scene: Scene, camera: Camera) -> ErrorEstimate:
        """Bounds of this method's error; infinite where the image is not to be used."""

    def passes(self, scene: Scene, camera: Camera) -> float:
        """Cost of an image in passes of a cosine: as of a ray of each beam at every pixel, unless it does with less."""
        return CALL + _BLOCKS * INTERACTION * interactions(scene) * pass_share(camera) * PASS_PIXELS

    @property
    def generality(self) -> tuple[int, int]:
        """Of two methods the greater one serves all scenes that the other one serves. Rays at every pixel: (2, 0)."""
        return 2, 0

    def picture(self, scene: Scene, camera: Camera) -> AbstractPicture:
        """The image of known numbers, ready for its pixels. Raises ValueError where a beam does not reach it all."""
        scene, camera = afresh(scene, camera)
        return AtPixels(scene, camera, self.image)

    def opd_picture(self, scene: Scene, camera: Camera) -> AbstractPicture:
        """`picture` of the path difference [m]."""
        scene, camera = afresh(scene, camera)
        return AtPixels(scene, camera, self.opd)

    def refusal(self, scene: Scene) -> CannotHonourError | None:
        """What `check` raises of a scene, or None."""
        try:
            self.check(scene)
        except CannotHonourError as error:
            return error
        return None

    def check_camera(self, camera: Camera) -> None:
        """Raise CannotHonourError for a camera's lens that the method does not know."""
        if camera.lens is not None and not self.sees_through_lens:
            name, way_out = type(self).__name__, "Chebyshev() or Traced()"
            raise CannotHonourError(name, "camera.lens", "it takes an even grid", way_out)

    def require_parts(self, verb: str) -> None:
        """Raise ValueError where only one whole image at a time can be computed, which the verb does not do."""
        del verb  # of a pixel by itself there is nothing to refuse

    def bytes_per_pixel(self) -> int:
        """Of memory while an image of known numbers is computed: the image alone, unless a method says more."""
        return 4 if is_single() else 8

    def shared_bytes(self, shape: tuple[int, int]) -> int:
        """Of memory for what all blocks of an image share."""
        del shape
        return 0

    def for_scenes(self, planned: Sequence["AbstractMethod"]) -> "AbstractMethod":
        """What to compute all scenes with, of which some were planned: this is the most general of their methods."""
        del planned
        return self

    def describe(self) -> str:
        """Its name, and what an image depends on."""
        return type(self).__name__


def is_single() -> bool:
    """Whether JAX is set to float32."""
    return not jax.config.read("jax_enable_x64")


def interactions(scene: Scene) -> int:
    """How often the rays of all beams meet a surface."""
    return sum(len(itinerary(word, len(scene.surfaces)).surface) for word in scene.beams)


def pass_share(camera: Camera) -> float:
    """Pixels of a camera over those of a pass."""
    return camera.shape[0] * camera.shape[1] / PASS_PIXELS


def require_two_beams(scene: Scene) -> None:
    if len(scene.beams) != 2:
        raise ValueError(f"a path difference is between two beams; this scene has {len(scene.beams)}")


def require_method(method, kind: type[AbstractMethod] = AbstractMethod) -> None:
    """Raise ValueError for what is no method, or not of a kind; None passes."""
    if method is not None and not isinstance(method, kind):
        named = "Chebyshev(), ClosedForm() or Traced()" if kind is AbstractMethod else f"{kind.__name__}()"
        raise ValueError(f"method is {shown(method)}; allowed: a method such as {named}")


def unreached(method: AbstractMethod) -> ValueError:
    """What to raise where a beam does not arrive."""
    return ValueError(
        f"{type(method).__name__} cannot honour a beam that does not reach the whole image (it misses a surface or "
        "its disc, is totally reflected, or ends at a focus); use Traced()"
    )
