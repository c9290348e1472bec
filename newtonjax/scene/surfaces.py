"""Surfaces: their height, and where rays meet them. A sphere is one number, the curvature, and 0 is the plane.

What else a surface may have are fields that are None unless used; their numbers and formulas are those of `Shape`. A
bench of spheres and planes has none of them, and compiles and runs as if they did not exist.
"""

from typing import Any, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Bool, Float

from newtonjax.numerics import (
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
    shown,
    value_of,
)
from newtonjax.scene.figures import SIZES, AbstractFigure
from newtonjax.scene.shapes import TERMS, Height, Shape
from newtonjax.scene.vectors import Vectors, dot, frame

SHALLOW = 1e-3  # the series' first term left out is then 4e-17 of the sag

# Coefficients of powers of the radius, [m] over metres to the power.
Terms = tuple[Scalar, ...] | Float[Any, " terms"]


class Surface(eqx.Module):
    """A surface through its vertex: a sphere of given curvature, a plane where that is 0, unless more is said.

    The axis is +z turned by `tilt` about the vertex, first about x, then about y; the sag rises along the axis for a
    positive curvature. With r² = x² + y² in the turned directions, and what is None left out,

        sag = c r² / (1 + sqrt(1 - (1 + k) c² r²)) + Σ even[i] r^(4 + 2 i) + Σ odd[i] r^(3 + 2 i) + figure.sag(x, y)

    (ISO 10110-12). A toroid's first term is an arc turned about an axis instead.

    - `curvature`: 1/radius [1/m], positive where the centre lies on the +z side.
    - `vertex`: (x, y, z) [m].
    - `tilt`: rotations about x and y [rad].
    - `conic`: constant k: 0 for a sphere, -1 for a paraboloid, below it a hyperboloid, above an ellipsoid.
    - `asphere`, `odd_asphere`: coefficients of r⁴, r⁶, ... and of r³, r⁵, ..., up to 8 each [m^(1 - power)].
    - `curvature_across`: of a toroid [1/m], across the direction along which `curvature` holds; that circle is turned
      about the axis at 1/curvature. Either may be 0: a cylinder.
    - `axis`: angle of the toroid's first direction from x towards y [rad]; None is 0.
    - `figure`: an `AbstractFigure` on top, such as `Zernike`, or one of your own; it ends the surface at its domain.
    """

    curvature: Scalar = eqx.field(converter=as_scalar, default=0.0)
    vertex: Vector3 = eqx.field(converter=as_vector, default=(0.0, 0.0, 0.0))
    tilt: Vector2 = eqx.field(converter=as_vector, default=(0.0, 0.0))
    conic: Scalar | None = eqx.field(converter=as_scalar, default=None)
    asphere: Terms | None = eqx.field(converter=lambda v: v if v is None else as_vector(v), default=None)
    odd_asphere: Terms | None = eqx.field(converter=lambda v: v if v is None else as_vector(v), default=None)
    curvature_across: Scalar | None = eqx.field(converter=as_scalar, default=None)
    axis: Scalar | None = eqx.field(converter=as_scalar, default=None)
    figure: AbstractFigure | None = None

    def __check_init__(self):
        require_number("curvature", self.curvature, "a finite number in 1/m", finite)
        for name, value, size, allowed in (
            ("vertex", self.vertex, 3, "three finite lengths in metres, (x, y, z)"),
            ("tilt", self.tilt, 2, "two finite angles in radians, about x and about y"),
        ):
            require(name, value, allowed, finite)
            require_size(name, value, size, allowed)
        if self.is_shaped():
            self._check_shape()

    def _check_shape(self) -> None:
        for name, allowed in (
            ("conic", "a finite number, or None"),
            ("curvature_across", "a finite number in 1/m, or None"),
            ("axis", "a finite angle in radians, or None"),
        ):
            if getattr(self, name) is not None:
                require_number(name, getattr(self, name), allowed, finite)
        for name, first in (("asphere", 4), ("odd_asphere", 3)):
            if (terms := getattr(self, name)) is None:
                continue
            allowed = f"1 to {TERMS} finite coefficients of r^{first}, r^{first + 2}, ..., or None"
            require(name, terms, allowed, finite)
            if not 1 <= (np.shape(terms) or (0,))[-1] <= TERMS:
                raise ValueError(f"{name} is {shown(terms)}; allowed: {allowed}")
        if self.conic is not None and self.curvature_across is not None:
            raise ValueError("conic and curvature_across are both given; allowed: one of them, a toroid has no conic")
        if self.axis is not None and self.curvature_across is None:
            raise ValueError("axis is given without curvature_across; a surface of one curvature has no axis to turn")
        if not isinstance(self.figure, AbstractFigure | None):
            raise ValueError(f"figure is {shown(self.figure)}; allowed: a figure such as Zernike, or None")

    def is_shaped(self) -> bool:
        """Whether it has anything that a sphere has not, be it 0."""
        return bool(Surface.shape_words(self))

    def shape_words(self) -> list[str]:
        """Names of what it has that a sphere has not."""
        numbers = vars(self)  # of an attribute equinox asks first whether it is a method, for 2 us
        words = ("conic", "asphere", "odd_asphere", "curvature_across", "axis", "figure")
        return [word for word in words if numbers[word] is not None]

    def is_plane(self) -> bool:
        """Whether it is known to be a plane; of a batch, all of it."""
        if self.is_shaped():
            return False
        return is_concrete(self.curvature) and bool(np.all(np.asarray(self.curvature) == 0))

    def mean_curvature(self) -> Scalar:
        """At the vertex of its base [1/m]."""
        return self.curvature if self.curvature_across is None else (self.curvature + self.curvature_across) / 2

    def face(self, size: int | None = None) -> "Face":
        """What rays need of it; `size` of figures' tables, as `table_size` says of a bench. NumPy for known numbers."""
        xp = namespace(self)
        directions = frame(self.tilt)
        shape = None if size is None else _shape_of(self, xp, size, directions)
        return Face(xp.asarray(self.curvature, dtype=float), xp.asarray(self.vertex), directions[2], shape)

    def sag(self, x: Float[Any, "..."], y: Float[Any, "..."]) -> Float[Any, "..."]:
        """Height over the vertex plane [m] at (x, y) [m] of the turned directions.

        Beyond the equator of a sphere (c² r² > 1) there is no height; the equator's is returned.
        """
        if self.is_shaped():
            shape = _shape_of(self, namespace(self), figure_size((self,)), frame(self.tilt))
            zero = 0.0 * (x + y)
            return shape.beside(np.ndim(zero)).height(x + zero, y + zero).z
        xp, r2 = namespace(self.curvature, x, y), x * x + y * y
        inside = 1 - self.curvature * self.curvature * r2
        root = xp.sqrt(xp.where(inside > 0, inside, 1.0))
        return self.curvature * r2 / (1 + xp.where(inside > 0, root, 0.0))

    def shallow_sag(self, x: Float[Any, "..."], y: Float[Any, "..."]) -> Float[Any, "..."]:
        """`sag` where `is_shallow`: a sphere's series, equal to rounding, without a square root and a division."""
        if self.is_shaped():
            return self.sag(x, y)
        r2 = x * x + y * y
        u = self.curvature * self.curvature * r2
        return self.curvature * r2 * (1 / 2 + u * (1 / 8 + u * (1 / 16 + u * (5 / 128 + u * (7 / 256)))))

    def is_shallow(self, r2: Float[Any, "..."]) -> Bool[Any, "..."]:
        """Whether `shallow_sag` holds at squared radius r2 [m²]: c² r² is at most 1e-3."""
        return self.curvature * self.curvature * r2 <= SHALLOW

    def parabola(self, x: Float[Any, "..."], y: Float[Any, "..."]) -> Float[Any, "..."]:
        """The first term of a sphere's `sag`, c r² / 2 [m]."""
        return self.curvature * (x * x + y * y) / 2


def _shape_of(surface: Surface, xp, size: int, directions) -> Shape:
    # Of the class or its numbers: to name a method of a module takes equinox 20 us, a number 2 us.
    numbers = vars(surface)

    def number(value, otherwise=0.0):
        return xp.asarray(otherwise if value is None else value, dtype=float)

    def padded(terms):
        terms = () if terms is None else terms
        return xp.stack([number(terms[k] if k < len(terms) else None) for k in range(TERMS)])

    figure, axis, curvature = numbers["figure"], number(numbers["axis"]), number(numbers["curvature"])
    across = numbers["curvature_across"]
    radius = None if figure is None else number(figure.radius)
    table = np.zeros((size, size)) if figure is None else type(figure).table(figure, size)
    return Shape(
        number(float(Surface.is_shaped(surface))),
        curvature,
        xp.asarray(directions[0]),
        xp.asarray(directions[1]),
        number(numbers["conic"]),
        number(float(across is not None)),
        number(across, curvature),
        xp.stack([xp.cos(axis), xp.sin(axis)]),
        xp.stack([padded(numbers["asphere"]), padded(numbers["odd_asphere"])], axis=1),
        xp.asarray(table, dtype=float),
        xp.stack([0.0 * axis if radius is None else 1 / radius] * 2),
        number(radius, np.inf),
    )


def table_size(surfaces: tuple[Surface, ...]) -> int | None:
    """`figure_size` of a bench; None where all are spheres and planes."""
    return figure_size(surfaces) if any(Surface.is_shaped(surface) for surface in surfaces) else None


def figure_size(surfaces: tuple[Surface, ...]) -> int:
    """Chebyshev polynomials to a side of the tables that hold the figures of all surfaces."""
    figures = [vars(surface)["figure"] for surface in surfaces]
    return max([SIZES[0], *(type(figure).size(figure) for figure in figures if figure is not None)])


class Face(NamedTuple):
    """The numbers of a surface that rays meet, or of many along leading axes.

    - `curvature`: at the vertex [1/m].
    - `vertex`: [m].
    - `axis`: unit vector along which the sag rises.
    - `shape`: what it is more than a sphere; None where no surface of the bench is more.
    """

    curvature: Float[Any, "..."]
    vertex: Float[Any, "... 3"]
    axis: Float[Any, "... 3"]
    shape: Shape | None = None

    def intersect(self, position: Vectors, direction: Vectors) -> tuple[Float[Any, "..."], Vectors, Bool[Any, "..."]]:
        """Signed distance to the surface, its unit normal there, and whether the ray meets it at all."""
        return self.meet(position, direction)[:3]

    def meet(self, position: Vectors, direction: Vectors) -> tuple[Any, Any, Any, Height | None]:
        """`intersect`, and the height of a shape there.

        The ray first slides to the vertex plane (point o from the vertex, a·o = 0); from there, with B = c o·d - a·d,
        the distance to a sphere is c o·o / (-B ± sqrt(B² - c² o·o)) with the sign of a·d: the crossing on the vertex's
        side, without cancellation, and 0 for the plane. It is negative behind the origin.
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
        sphere = (slide + beyond, normal, meets)
        shape = self.shape
        if shape is None:
            return *sphere, None
        way = dot(shape.x, direction), dot(shape.y, direction), along
        beyond, height, meets = shape.meet(dot(shape.x, point), dot(shape.y, point), way)
        numbers = slide + beyond, shape.normal(self.axis, height), meets
        present, xp = value_of(shape.present) > 0, functions(beyond, sphere[0])
        return *(xp.where(present, a, b) for a, b in zip(numbers, sphere, strict=True)), height

    def change_of_normal(self, height: Height | None, normal: Vectors, change: Vectors) -> Vectors:
        """By how much a unit normal changes with its place on the surface; it may point to either side."""
        up = dot(normal, self.axis) > 0
        xp, shape = functions(self.curvature), self.shape
        sphere = xp.where(up, -self.curvature, self.curvature) * change
        if shape is None or height is None:
            return sphere
        return xp.where(shape.present > 0, shape.change_of_normal(height, self.axis, normal, change), sphere)
