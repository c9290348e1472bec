"""What a call takes: a scene, a camera, a method; anything else is refused in one line."""

import numpy as np

from newtonjax.camera import Camera
from newtonjax.methods import AbstractMethod
from newtonjax.scene import Scene


def require_bench(scene, camera) -> None:
    """Raise ValueError for what is no scene or no camera."""
    if not isinstance(scene, Scene):
        raise ValueError(f"scene is {_shown(scene)}; allowed: a Scene, such as newton_rings(1.0)")
    require_camera(camera)


def require_camera(camera) -> None:
    """Raise ValueError for what is no camera."""
    if not isinstance(camera, Camera):
        hint = " (a scene file without [camera] has none)" if camera is None else ""
        raise ValueError(f"camera is {_shown(camera)}{hint}; allowed: a Camera, such as Camera((512, 512), 5e-6)")


def require_method(method, kind: type[AbstractMethod] = AbstractMethod) -> None:
    """Raise ValueError for what is no method, or not of a kind; None passes."""
    if method is not None and not isinstance(method, kind):
        named = "Chebyshev(), ClosedForm() or Traced()" if kind is AbstractMethod else f"{kind.__name__}()"
        raise ValueError(f"method is {_shown(method)}; allowed: a method such as {named}")


def require_tolerance(tolerance) -> None:
    """Raise ValueError for what is no positive number."""
    if not (isinstance(tolerance, int | float | np.number) and 0 < float(tolerance) < np.inf):
        raise ValueError(f"tolerance is {_shown(tolerance)}; allowed: a positive number, such as 1e-3")


def require_whole(name: str, value) -> None:
    """Raise ValueError for what is no whole number from 1 on; None passes."""
    if value is not None and not (isinstance(value, int | np.integer) and value >= 1):
        raise ValueError(f"{name} is {_shown(value)}; allowed: 1 or more")


def unreached(method: AbstractMethod) -> ValueError:
    """What to raise where a beam does not arrive."""
    return ValueError(
        f"{type(method).__name__} cannot honour a beam that does not reach the whole image (it misses a surface, "
        "is totally reflected, or ends at a focus); use Traced()"
    )


def _shown(value) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
