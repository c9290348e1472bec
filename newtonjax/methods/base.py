"""What every way to compute an image answers."""

import abc

import equinox as eqx
from jaxtyping import Array, Float

from newtonjax.numerics import shown
from newtonjax.scene import (
    Camera,
    Scene,
)


class AbstractMethod(eqx.Module):
    """A way to compute images. Immutable and hashable: it may be a static argument."""

    @abc.abstractmethod
    def check(self, scene: Scene) -> None:
        """Raise ValueError, naming the part, where the method cannot honour a part of the scene."""

    @abc.abstractmethod
    def image(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns"]:
        """Irradiance at every pixel over the incident one."""

    @abc.abstractmethod
    def opd(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns"]:
        """Optical path difference of the scene's two beams at every pixel [m]."""


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
        f"{type(method).__name__} cannot honour a beam that does not reach the whole image (it misses a surface, "
        "is totally reflected, or ends at a focus); use Traced()"
    )
