"""The gap between two facing surfaces: thickness, and the fringes of equal thickness that it makes."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Array, Bool, Float

from newtonjax.numerics import Scalar, is_concrete, namespace
from newtonjax.scene.scene import Scene
from newtonjax.scene.surfaces import Surface
from newtonjax.scene.vectors import frame


def gap_of(scene: Scene) -> int | None:
    """The surface above the gap in which the scene's two beams differ by one round trip, or None."""
    if len(scene.beams) != 2:
        return None
    short, long = sorted(scene.beams, key=len)
    for upper in range(len(scene.surfaces) - 1):
        once = f"T{upper} T{upper + 1}"
        if (
            scene.view == "transmitted"
            and "R" not in short
            and long == short.replace(once, f"T{upper} R{upper + 1} R{upper} T{upper + 1}")
        ):
            return upper
        if (
            scene.view == "reflected"
            and long == short.replace(f"R{upper}", f"T{upper} R{upper + 1} T{upper}")
            and short.count("R") == 1
        ):
            return upper
    return None


def required_gap(scene: Scene) -> int:
    """As `gap_of`. Raises ValueError where the beams do not differ by one round trip in one gap."""
    upper = gap_of(scene)
    if upper is None:
        raise ValueError(
            f"the scene follows the beams {', '.join(map(repr, scene.beams))}; "
            "allowed: two that differ by one round trip in one gap"
        )
    return upper


# Height over the vertex plane of a surface at points: one of the methods of `Surface` that give it.
Profile = Callable[[Surface, Float[Any, "..."], Float[Any, "..."]], Float[Any, "..."]]


def height(
    surface: Surface, x: Float[Any, "..."], y: Float[Any, "..."], profile: Profile = Surface.sag
) -> Float[Any, "..."]:
    """Z of a surface over the point (x, y) [m]: an upright one, or a plane of any tilt, which costs no square root."""
    vertex = surface.vertex
    dx, dy = x - vertex[0], y - vertex[1]
    axis = frame(surface.tilt)[2]
    plane = vertex[2] - (axis[0] / axis[2] * dx + axis[1] / axis[2] * dy)
    if surface.is_plane():
        return namespace(plane).asarray(plane)
    return plane + profile(surface, dx, dy)


def _slopes(surface: Surface, x: Float[Any, "..."], y: Float[Any, "..."]) -> tuple[Any, Any]:
    """Slopes of `height` along x and y, of an upright sphere or a plane."""
    dx, dy, axis = x - surface.vertex[0], y - surface.vertex[1], frame(surface.tilt)[2]
    along_x, along_y = -axis[0] / axis[2], -axis[1] / axis[2]
    if surface.is_plane():
        return along_x, along_y
    xp, c = namespace(surface, x, y), surface.curvature
    inside = 1 - c * c * (dx * dx + dy * dy)
    steepness = c / xp.sqrt(xp.where(inside > 0, inside, 1.0))
    return along_x + steepness * dx, along_y + steepness * dy


class Gap(NamedTuple):
    """The faces above and below a gap, and the refractive index of what fills it."""

    above: Surface
    below: Surface
    refractive_index: Scalar

    def is_shallow(self, x: Float[Any, "..."], y: Float[Any, "..."]) -> Bool[Array, ""]:
        """Whether `Surface.shallow_sag` holds for both faces at all points of a grid."""

        def of(surface: Surface):
            dx, dy = x - surface.vertex[0], y - surface.vertex[1]
            return surface.is_shallow((dx * dx).max() + (dy * dy).max())

        return of(self.above) & of(self.below)

    def opd(self, x: Float[Any, "..."], y: Float[Any, "..."], profile: Profile = Surface.sag) -> Float[Any, "..."]:
        """2 n t(x, y): the round trip through the gap along z [m]."""
        return 2 * self.refractive_index * (height(self.above, x, y, profile) - height(self.below, x, y, profile))


def gap_slopes(gap: Gap, x: Float[Any, "..."], y: Float[Any, "..."]) -> tuple[Any, Any]:
    """How the thickness of a gap between upright spheres and planes grows along x and y at a point."""
    above, below = _slopes(gap.above, x, y), _slopes(gap.below, x, y)
    return above[0] - below[0], above[1] - below[1]


def gap_between(scene: Scene) -> Gap:
    """The gap of a scene. Raises ValueError as `required_gap`."""
    upper = required_gap(scene)
    return Gap(scene.surfaces[upper], scene.surfaces[upper + 1], scene.media[upper + 1])


def gap_opd(
    scene: Scene, x: Float[Any, "..."], y: Float[Any, "..."], profile: Profile = Surface.sag
) -> Float[Any, "..."]:
    """`Gap.opd` of a scene's gap [m]."""
    return gap_between(scene).opd(x, y, profile)


def focus_height(scene: Scene, upper: int) -> Scalar:
    """Z of the plane in which the viewer sees the face under the gap: its paraxial image on the viewer's side.

    Imaged through every surface on the way by n'/s' = n/s + (n' - n) c, distances counted along the light.
    """
    down = scene.view == "transmitted"
    object_z = scene.surfaces[upper + 1].vertex[2]
    way = range(upper + 2, len(scene.surfaces)) if down else range(upper, -1, -1)
    sign = -1.0 if down else 1.0
    for k in way:
        surface = scene.surfaces[k]
        n1, n2 = (scene.media[k], scene.media[k + 1]) if down else (scene.media[k + 1], scene.media[k])
        s = sign * (object_z - surface.vertex[2])
        image = n2 * s / (n1 + (n2 - n1) * sign * surface.mean_curvature() * s)
        object_z = surface.vertex[2] + sign * image
    return object_z


def has_tilted_sphere(scene: Scene) -> bool:
    """Whether a face of the gap is tilted and no plane: it has no closed form of its height over the plane."""
    upper = required_gap(scene)
    faces = scene.surfaces[upper : upper + 2]
    return any(is_known_nonzero(f.tilt) and (f.is_shaped() or is_known_nonzero(f.curvature)) for f in faces)


def is_known_nonzero(value) -> bool:
    """Whether any number of a value is known and not 0."""
    return is_concrete(value) and bool(np.any(np.asarray(value) != 0))


def gap_height(scene: Scene) -> float:
    """Height of the upper face's vertex over the lower one's [m]."""
    upper = required_gap(scene)
    return float(scene.surfaces[upper].vertex[2] - scene.surfaces[upper + 1].vertex[2])
