"""What stands between the bench and the screen: a shield with a round hole, and a collecting lens."""

import equinox as eqx
import numpy as np

from newtonjax.quantities import (
    Scalar,
    Vector2,
    Vector3,
    as_scalar,
    as_vector,
    finite,
    is_concrete,
    namespace,
    positive,
    require,
)
from newtonjax.surfaces import Direction, Surface, frame


class Shield(eqx.Module):
    """An opaque plane with a round hole on the way to the screen (Debelov and Dolgov 2021, figure 5).

    A ray counts if the straight line on which it leaves the last surface passes through the hole. The image has an
    edge then, which `Traced` and `Splat` draw; a derivative does not see the edge move.

    - `radius`: of the hole [m].
    - `vertex`: its centre (x, y, z) [m].
    - `tilt`: of the plane about x and y [rad].
    """

    radius: Scalar = eqx.field(converter=as_scalar)
    vertex: Vector3 = eqx.field(converter=as_vector, default=(0.0, 0.0, 0.0))
    tilt: Vector2 = eqx.field(converter=as_vector, default=(0.0, 0.0))

    def __check_init__(self):
        require("shield.radius", self.radius, "a positive radius in metres", positive)
        require("shield.vertex", self.vertex, "finite lengths in metres", finite)
        require("shield.tilt", self.tilt, "finite angles in radians", finite)


class CollectingLens(eqx.Module):
    """An ideal thin lens before the screen, its axis along the screen's normal.

    It images one plane on the screen, 1/a + 1/b = 1/f, with the magnification -b/a. All paths from a point to its
    image are equal, so that what is seen is the interference in that plane, which may be virtual. Its rim cuts nothing
    (a `Shield` does).

    - `focal_length`: [m], in the medium of the screen.
    - `vertex`: its middle (x, y, z) [m].
    """

    focal_length: Scalar = eqx.field(converter=as_scalar)
    vertex: Vector3 = eqx.field(converter=as_vector)

    def __check_init__(self):
        require("collecting_lens.focal_length", self.focal_length, "a positive length in metres", positive)
        require("collecting_lens.vertex", self.vertex, "finite lengths in metres", finite)


def check_focus(lens: CollectingLens, screen: Surface, view: str) -> None:
    """Raise ValueError where a lens cannot image any plane at a distance on the screen."""
    behind = float(_from_to(lens, screen) @ _way(screen, view))
    if behind <= 0 or abs(behind / float(lens.focal_length) - 1) < 1e-9:
        raise ValueError(
            f"collecting_lens: the screen is {behind:.6g} m behind it; allowed: a positive distance other than the "
            f"focal length of {float(lens.focal_length):.6g} m, in which it would show directions, not a plane"
        )


def _from_to(lens: CollectingLens, screen: Surface) -> Direction:
    xp = namespace(lens.vertex, screen.vertex)
    return xp.asarray(screen.vertex) - xp.asarray(lens.vertex)


def _way(screen: Surface, view: str) -> Direction:
    axis = frame(screen.tilt)[2]
    return axis if view == "reflected" else -axis


def imaged_plane(scene) -> tuple[Vector3, Scalar]:
    """The point that is seen at the screen's origin, and the magnification (`scene`: a `Scene`).

    Without a collecting lens these are the screen's own vertex, and 1. The plane is parallel to the screen.
    """
    lens, screen = scene.collecting_lens, scene.screen
    if lens is None:
        return screen.vertex, 1.0
    x, y, _ = frame(screen.tilt)
    forth, offset = _way(screen, scene.view), _from_to(lens, screen)
    behind = offset @ forth
    before = behind * lens.focal_length / (behind - lens.focal_length)
    magnification = -behind / before
    aside = ((offset @ x) * x + (offset @ y) * y) / magnification
    return lens.vertex - before * forth + aside, magnification


def lens_to_image(distance: Scalar, focal_length: Scalar) -> Scalar:
    """Distance [m] before which a lens must stand to image a plane, enlarged, on a screen so far from that plane.

    a = (L - sqrt(L² - 4 L f)) / 2 solves 1/a + 1/(L - a) = 1/f. Raises ValueError where the screen is nearer than 4 f.
    """
    require(
        "collecting_lens",
        focal_length,
        f"a positive focal length of at most a quarter of the way from the rings to the screen, {distance} m",
        lambda f: positive(f) and (not is_concrete(distance) or bool(np.all(4 * f <= distance))),
    )
    return (distance - (distance * (distance - 4 * focal_length)) ** 0.5) / 2
