"""What stands between the bench and the screen: a shield with a round hole, and a collecting lens."""

import equinox as eqx
import numpy as np

from newtonjax.numerics import (
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
    require_number,
    require_size,
)
from newtonjax.scene.surfaces import Surface
from newtonjax.scene.vectors import Direction, frame


class Shield(eqx.Module):
    """An opaque plane with a round hole on the way to the screen (Debelov and Dolgov 2021, figure 5).

    A ray counts if the straight line on which it leaves the last surface passes through the hole, which stands between
    there and the screen, or its collecting lens; light on its way in is not cut. The image has an edge then, which
    `Traced` and `Splat` draw; a derivative does not see the edge move.

    - `radius`: of the hole [m].
    - `vertex`: its centre (x, y, z) [m].
    - `tilt`: of the plane about x and y [rad].
    """

    radius: Scalar = eqx.field(converter=as_scalar)
    vertex: Vector3 = eqx.field(converter=as_vector, default=(0.0, 0.0, 0.0))
    tilt: Vector2 = eqx.field(converter=as_vector, default=(0.0, 0.0))

    def __check_init__(self):
        require_number("shield.radius", self.radius, "a positive radius in metres", positive)
        require("shield.vertex", self.vertex, "three finite lengths in metres", finite)
        require_size("shield.vertex", self.vertex, 3, "three lengths in metres, (x, y, z)")
        require("shield.tilt", self.tilt, "two finite angles in radians", finite)
        require_size("shield.tilt", self.tilt, 2, "two finite angles in radians, about x and about y")


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
        require_number("collecting_lens.focal_length", self.focal_length, "a positive length in metres", positive)
        require("collecting_lens.vertex", self.vertex, "three finite lengths in metres", finite)
        require_size("collecting_lens.vertex", self.vertex, 3, "three lengths in metres, (x, y, z)")


def check_way(scene) -> None:
    """Raise ValueError where shield or collecting lens does not stand between the bench and its screen.

    The order is: last surface, shield, lens, screen. `scene`: a `Scene` of known numbers.
    """
    way, lens, shield = _way(scene.screen, scene.view), scene.collecting_lens, scene.shield
    face = scene.surfaces[-1 if scene.view == "transmitted" else 0].vertex @ way
    screen = scene.screen.vertex @ way
    tiny = 1e-9 * (1e-3 + abs(face))
    if lens is not None:
        if lens.vertex @ way < face - tiny:
            raise ValueError(_misplaced("collecting_lens", face - lens.vertex @ way, "inside of the bench"))
        behind = float(screen - lens.vertex @ way)
        if behind <= 0 or abs(behind / float(lens.focal_length) - 1) < 1e-9:
            raise ValueError(
                f"collecting_lens: the screen is {behind:.6g} m behind it; allowed: a positive distance other than the "
                f"focal length of {float(lens.focal_length):.6g} m, in which it would show directions, not a plane"
            )
    if shield is not None:
        # A virtual screen, drawn back to inside of the bench, has no shield beyond it.
        end = lens.vertex @ way if lens is not None else screen if screen > face else np.inf
        if shield.vertex @ way < face - tiny:
            raise ValueError(_misplaced("shield", face - shield.vertex @ way, "inside of the bench"))
        if shield.vertex @ way > end + tiny:
            raise ValueError(_misplaced("shield", shield.vertex @ way - end, "beyond screen or collecting lens"))


def _misplaced(part: str, by: float, where: str) -> str:
    return f"{part} stands {by:.4g} m {where}; allowed: between the last surface and the screen, or its lens"


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


def _metres(distance: Scalar) -> str:
    return f", {float(distance):.4g} m" if is_concrete(distance) else ""


def lens_to_image(distance: Scalar, focal_length: Scalar) -> Scalar:
    """Distance [m] before which a lens must stand to image a plane, enlarged, on a screen so far from that plane.

    a = (L - sqrt(L² - 4 L f)) / 2 solves 1/a + 1/(L - a) = 1/f; at L = 4 f its derivative has no bound.

    Raises ValueError where the screen is nearer than 4 f.
    """
    require(
        "collecting_lens",
        focal_length,
        f"a positive focal length of at most a quarter of the way from gap to screen{_metres(distance)}",
        lambda f: positive(f) and (not is_concrete(distance) or bool(np.all(4 * f <= distance))),
    )
    return (distance - (distance * (distance - 4 * focal_length)) ** 0.5) / 2
