"""Surfaces: their height, and where rays meet them. Spheres and planes are one type, curvature 0 is the plane.

Here is what the kind of a surface decides, but for the closed form's height in float32 (docs/extending.md). Another
kind is a field and its formulas in these classes: rays and formulas ask `Surface` and `Face` by name, no subclass.
"""

from typing import Any, NamedTuple, no_type_check

import equinox as eqx
import numpy as np
from jaxtyping import Bool, Float, Num

from newtonjax.numerics import (
    Jet,
    Scalar,
    Vector2,
    Vector3,
    as_scalar,
    as_vector,
    finite,
    functions,
    is_concrete,
    namespace,
    require,
    require_number,
    require_size,
)

SHALLOW = 1e-3  # the series' first term left out is then 4e-17 of the sag

Direction = Float[Any, "3"]
# Of one ray, or of many along the last axes.
Vectors = Float[Any, "3 ..."]


class Surface(eqx.Module):
    """A sphere of given curvature through its vertex, or a plane where the curvature is 0.

    The axis is +z turned by `tilt` about the vertex, first about x, then about y; the sag rises along the axis
    for a positive curvature: sag(r) = c r² / (1 + sqrt(1 - c² r²)).

    - `curvature`: 1/radius [1/m], positive where the centre lies on the +z side.
    - `vertex`: (x, y, z) [m].
    - `tilt`: rotations about x and y [rad].
    """

    curvature: Scalar = eqx.field(converter=as_scalar, default=0.0)
    vertex: Vector3 = eqx.field(converter=as_vector, default=(0.0, 0.0, 0.0))
    tilt: Vector2 = eqx.field(converter=as_vector, default=(0.0, 0.0))

    def __check_init__(self):
        require_number("curvature", self.curvature, "a finite number in 1/m", finite)
        for name, value, size, allowed in (
            ("vertex", self.vertex, 3, "three finite lengths in metres, (x, y, z)"),
            ("tilt", self.tilt, 2, "two finite angles in radians, about x and about y"),
        ):
            require(name, value, allowed, finite)
            require_size(name, value, size, allowed)

    def face(self) -> "Face":
        """What rays need of it. NumPy for known numbers."""
        xp = namespace(self.curvature, self.vertex, self.tilt)
        return Face(xp.asarray(self.curvature, dtype=float), xp.asarray(self.vertex), frame(self.tilt)[2])

    def is_plane(self) -> bool:
        """Whether it is known to be a plane; of a batch, all of it."""
        return is_concrete(self.curvature) and bool(np.all(np.asarray(self.curvature) == 0))

    def sag(self, r2: Float[Any, "..."]) -> Float[Any, "..."]:
        """Height over the vertex plane [m] at squared radius r2 [m²]: c r² / (1 + sqrt(1 - c² r²)).

        Beyond the sphere's equator (c² r² > 1) there is no height; the equator's is returned.
        """
        xp = namespace(self.curvature, r2)
        inside = 1 - self.curvature * self.curvature * r2
        root = xp.sqrt(xp.where(inside > 0, inside, 1.0))
        return self.curvature * r2 / (1 + xp.where(inside > 0, root, 0.0))

    def shallow_sag(self, r2: Float[Any, "..."]) -> Float[Any, "..."]:
        """`sag` where `is_shallow`: its series, equal to rounding, without a square root and a division."""
        u = self.curvature * self.curvature * r2
        return self.curvature * r2 * (1 / 2 + u * (1 / 8 + u * (1 / 16 + u * (5 / 128 + u * (7 / 256)))))

    def is_shallow(self, r2: Float[Any, "..."]) -> Bool[Any, "..."]:
        """Whether `shallow_sag` holds at squared radius r2 [m²]: c² r² is at most 1e-3."""
        return self.curvature * self.curvature * r2 <= SHALLOW

    def parabola(self, r2: Float[Any, "..."]) -> Float[Any, "..."]:
        """The first term of `sag`, c r² / 2 [m]."""
        return self.curvature * r2 / 2


def frame(tilt) -> tuple[Direction, Direction, Direction]:
    """The turned x, y and z directions: R_y(tilt[1]) R_x(tilt[0]) applied to the unit vectors."""
    xp = namespace(tilt)
    sx, cx, sy, cy = xp.sin(tilt[0]), xp.cos(tilt[0]), xp.sin(tilt[1]), xp.cos(tilt[1])
    return (
        xp.stack([cy, xp.zeros_like(sx), -sy]),
        xp.stack([sx * sy, cx, sx * cy]),
        xp.stack([cx * sy, -sx, cx * cy]),
    )


@no_type_check  # the inner loop of all; what calls it is checked
def dot(a: Num[Any, "3 ..."], b: Num[Any, "3 ..."]) -> Num[Any, "..."]:
    """A · b, its sum written out so that it fuses with its neighbours (in jets it is one as well)."""
    if a.ndim != b.ndim:
        return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    product = a * b  # at once: JAX takes two thirds of its time to trace these lines for what is indexed
    if isinstance(product, Jet):
        return product.sum(axis=0)
    return product[0] + product[1] + product[2]


class Face(NamedTuple):
    """The numbers of a surface that rays meet, or of many along leading axes.

    - `curvature`: at the vertex [1/m].
    - `vertex`: [m].
    - `axis`: unit vector along which the sag rises.
    """

    curvature: Float[Any, "..."]
    vertex: Float[Any, "... 3"]
    axis: Float[Any, "... 3"]

    def intersect(self, position: Vectors, direction: Vectors) -> tuple[Float[Any, "..."], Vectors, Bool[Any, "..."]]:
        """Signed distance to the surface, its unit normal there, and whether the ray meets it at all.

        The ray first slides to the vertex plane (point o from the vertex, a·o = 0); from there, with B = c o·d - a·d,
        the distance is c o·o / (-B ± sqrt(B² - c² o·o)) with the sign of a·d: the crossing on the vertex's side of the
        sphere, without cancellation, and 0 for the plane. It is negative behind the origin.
        """
        curvature, origin = self.curvature, position - self.vertex
        along = dot(self.axis, direction)
        slide = -dot(self.axis, origin) / along
        point = origin + slide * direction
        b = curvature * dot(point, direction) - along
        rho2 = dot(point, point)
        discriminant = b * b - curvature * curvature * rho2
        meets = discriminant > 0
        xp = functions(discriminant)
        root = xp.sqrt(xp.where(meets, discriminant, 1.0))
        beyond = curvature * rho2 / (xp.where(along > 0, root, -root) - b)
        normal = self.axis - curvature * (point + beyond * direction)
        return slide + beyond, normal, meets

    def change_of_normal(self, normal: Vectors, change: Vectors) -> Vectors:
        """By how much a unit normal changes with its place on the surface; it may point to either side."""
        up = dot(normal, self.axis) > 0
        return functions(self.curvature).where(up, -self.curvature, self.curvature) * change
