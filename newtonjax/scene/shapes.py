"""What a surface is more than a sphere: its height, and where rays meet it. Numbers alone, the same for every kind.

A conic, or an arc turned about an axis; powers of the radius; and a figure on top, a table of Chebyshev products. What
a surface does not have is 0, so that one compiled program serves all of them.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from newtonjax.numerics import Jet, namespace, value_of
from newtonjax.scene.polynomials import EDGE, chebyshev_table, powers
from newtonjax.scene.vectors import Vectors, dot

# Powers of the radius: r⁴, r⁶, ... r¹⁸, and r³, r⁵, ... r¹⁷.
TERMS = 8
# Newton's method ends when all rays move aside by this at most [m], where second derivatives say the height there to
# rounding. Most figures take one step, 1 mm of asphere at a radius of 10 mm four; so many are the most.
_NEAR, _STEPS = 1e-10, 8
# A step is no longer than the distance from the axis, and this [m]; a ray that is farther off at the end misses [m].
_STEP, _MISS = 1e-4, 1e-12


class Height(NamedTuple):
    """Of a surface over a point of its vertex plane [m], with its first and second derivatives there."""

    z: Any
    by_x: Any
    by_y: Any
    by_xx: Any
    by_xy: Any
    by_yy: Any

    def beside(self, move_x, move_y) -> "Height":
        """So far aside [m], to second order."""
        by_x = self.by_xx * move_x + self.by_xy * move_y
        by_y = self.by_xy * move_x + self.by_yy * move_y
        z = self.z + (self.by_x + by_x / 2) * move_x + (self.by_y + by_y / 2) * move_y
        return Height(z, self.by_x + by_x, self.by_y + by_y, *self[3:])


class Shape(NamedTuple):
    """The numbers of a surface that is no sphere, or of many along further axes.

    - `present`: 1, or 0 for a sphere among other surfaces.
    - `curvature`: at the vertex, along the toroid's first direction [1/m].
    - `x`, `y`: the surface's own directions across its axis.
    - `conic`: constant.
    - `toric`: 1 for a toroid; `across`: its other curvature [1/m]; `along`: cosine and sine of its first direction.
    - `radial`: coefficients of r⁴, r⁶, ... and of r³, r⁵, ... side by side.
    - `table`: of the figure, Chebyshev coefficients [in y, in x] in metres.
    - `scale`: of x and y in the figure's polynomials [1/m]; `radius`: of its disc [m], infinite without.
    """

    present: Float[Any, "..."]
    curvature: Float[Any, "..."]
    x: Float[Any, "3 ..."]
    y: Float[Any, "3 ..."]
    conic: Float[Any, "..."]
    toric: Float[Any, "..."]
    across: Float[Any, "..."]
    along: Float[Any, "2 ..."]
    radial: Float[Any, "terms 2 ..."]
    table: Float[Any, "nodes nodes ..."]
    scale: Float[Any, "2 ..."]
    radius: Float[Any, "..."]

    def height(self, x: Float[Any, "..."], y: Float[Any, "..."]) -> Height:
        """Over the point (x, y) [m] of the surface's own directions."""
        parts = self._base(x, y), self._radial(x, y), self._figure(x, y)
        return Height(*(base + radial + figure for base, radial, figure in zip(*parts, strict=True)))

    def _base(self, x, y) -> Height:
        """Conic or toroid: κ z² - 2 z + w = 0.

        A conic has κ = (1 + k) c and w = c r² (ISO 10110-12). An arc of height h across, turned about an axis at 1/c,
        has κ = c and w = c s² + 2 h - c h², so that either curvature may be 0 and equal ones make the sphere.
        """
        xp, c, (cosine, sine) = namespace(self, x, y), self.curvature, self.along
        s, t = cosine * x + sine * y, cosine * y - sine * x
        root = _root(xp, 1 - self.across * self.across * t * t)
        h, by_t, by_tt = self.across * t * t / (1 + root), self.across * t / root, self.across / (root * root * root)
        flat, is_toric = 1 - c * h, self.toric > 0
        w = c * s * s + xp.where(is_toric, h * (1 + flat), c * t * t)
        w_t = 2 * xp.where(is_toric, by_t * flat, c * t)
        w_tt = 2 * xp.where(is_toric, by_tt * flat - c * by_t * by_t, c)
        steep = (1 + self.conic) * c
        root = _root(xp, 1 - steep * w)
        slope = 0.5 / root
        bend = steep * slope / (2 * root * root)
        w_s = 2 * c * s
        z_s, z_t = slope * w_s, slope * w_t
        z_ss, z_st, z_tt = slope * 2 * c + bend * w_s * w_s, bend * w_s * w_t, slope * w_tt + bend * w_t * w_t
        twice = 2 * cosine * sine * z_st
        return Height(
            w / (1 + root),
            cosine * z_s - sine * z_t,
            sine * z_s + cosine * z_t,
            cosine * cosine * z_ss - twice + sine * sine * z_tt,
            cosine * sine * (z_ss - z_tt) + (cosine * cosine - sine * sine) * z_st,
            sine * sine * z_ss + twice + cosine * cosine * z_tt,
        )

    def _radial(self, x, y) -> Height:
        """Q² P(q) + r q O(q) with q = r², by derivatives in q; r is no divisor of what is left."""
        q = x * x + y * y
        (p, o), (p1, o1), (p2, o2) = powers(self.radial, q)
        xp = namespace(self, x, y)
        r = _root(xp, q, 0.0)
        # Twice the first derivative by q, and four times r times the second.
        slope = 2 * q * (2 * p + q * p1) + r * (3 * o + 2 * q * o1)
        bend = 4 * (2 * p + q * (4 * p1 + 2 * q * p2)) + _over(namespace(self, x, y), r) * (
            3 * o + q * (12 * o1 + 8 * q * o2)
        )
        return Height(
            q * (q * p + r * o), x * slope, y * slope, slope + x * x * bend, x * y * bend, slope + y * y * bend
        )

    def _figure(self, x, y) -> Height:
        sx, sy = self.scale
        table = chebyshev_table(self.table, x * sx, y * sy)
        return Height(
            table[0, 0],
            sx * table[0, 1],
            sy * table[1, 0],
            sx * sx * table[0, 2],
            sx * sy * table[1, 1],
            sy * sy * table[2, 0],
        )

    def has(self, x: Float[Any, "..."], y: Float[Any, "..."]) -> Bool[Any, "..."]:
        """Whether there is a surface over (x, y): within the figure's domain, and before the equator of its base."""
        c, across, (cosine, sine), x, y, (sx, sy), conic, toric, radius = map(
            value_of,
            (self.curvature, self.across, self.along, x, y, self.scale, self.conic, self.toric, self.radius),
        )
        s, t, r2 = cosine * x + sine * y, cosine * y - sine * x, x * x + y * y
        xp = jnp if isinstance(r2, jax.Array) else np
        toroid = (abs(c * s) < 1) & (abs(across * t) < 1)
        bent = xp.where(toric > 0, toroid, (1 + conic) * c * c * r2 < 1)
        return bent & (abs(x * sx) <= EDGE) & (abs(y * sy) <= EDGE) & (r2 <= radius**2 * EDGE)

    def meet(self, x: Float[Any, "..."], y: Float[Any, "..."], direction: tuple[Any, Any, Any]):
        """How far a ray that stands at (x, y) of the vertex plane goes to the surface, its height there, and whether.

        `direction`: parts along the surface's own x and y, and its axis. Newton's method from the conic, or from the
        plane for a toroid; derivatives are those of the implicit function.
        """
        numbers = (self, x, y, direction)
        if any(isinstance(leaf, Jet) for leaf in jax.tree.leaves(numbers)):
            way = self.start(x, y, direction)
            for _ in range(_STEPS // 2):
                way = way + _step(numbers, way)[0]
            height = self.height(x + way * direction[0], y + way * direction[1])
        else:
            way, height = _meet(numbers)
        miss = value_of(way * direction[2] - height.z)
        return way, height, self.has(x + way * direction[0], y + way * direction[1]) & (abs(miss) <= _MISS)

    def start(self, x, y, direction):
        """How far it is to the conic alone, as `Face.intersect` goes to a sphere."""
        dx, dy, along = direction
        xp, r2 = namespace(self, x, y, direction), x * x + y * y
        c = self.curvature * xp.where(self.toric > 0, 0.0, 1.0)
        b = c * (x * dx + y * dy) - along
        root = _root(xp, b * b - c * c * (1 + self.conic * along * along) * r2)
        return c * r2 / (xp.where(along > 0, root, -root) - b)

    def normal(self, axis: Vectors, height: Height) -> Vectors:
        """The unit normal, on the axis's side."""
        xp, length2 = namespace(self, axis, height), 1 + height.by_x * height.by_x + height.by_y * height.by_y
        return (axis - height.by_x * self.x - height.by_y * self.y) * (1 / xp.sqrt(length2))

    def change_of_normal(self, height: Height, axis: Vectors, normal: Vectors, change: Vectors) -> Vectors:
        """As `Face.change_of_normal`."""
        move_x, move_y = dot(self.x, change), dot(self.y, change)
        steeper_x = height.by_xx * move_x + height.by_xy * move_y
        steeper_y = height.by_xy * move_x + height.by_yy * move_y
        turned = -(steeper_x * self.x[:, None] + steeper_y * self.y[:, None])
        cosine = dot(normal, axis)  # the gradient's length is one over its size
        return cosine * (turned - dot(normal, turned) * normal[:, None])

    def beside(self, axes: int) -> "Shape":
        """With so many axes behind the numbers, for those of points."""
        return jax.tree.map(lambda leaf: leaf.reshape(*leaf.shape, *[1] * axes), self)


def _root(xp, square, otherwise: float = 1.0):
    """The square root; of what is not positive a constant, with no slope."""
    positive = square > 0
    return xp.where(positive, xp.sqrt(xp.where(positive, square, 1.0)), otherwise)


def _over(xp, r):
    """1/r; 0 on the axis, where what it multiplies vanishes with x² / r."""
    return xp.where(r > 0, 1 / xp.where(r > 0, r, 1.0), 0.0)


def _at(numbers, way) -> Height:
    """The height where a ray is after so much of its way."""
    shape, x, y, (dx, dy, _) = numbers
    return shape.height(x + way * dx, y + way * dy)


def _step(numbers, way) -> tuple[Any, Height]:
    """A step of Newton's method, and the height from which it is made."""
    _, x, y, (dx, dy, along) = numbers
    xp, height = namespace(numbers, way), _at(numbers, way)
    step = (way * along - height.z) / _slope(xp, height, (dx, dy, along))
    longest = value_of(abs(x) + abs(y) + _STEP)
    return -xp.where(abs(step) <= longest, step, xp.where(step > 0, longest, -longest)), height


def _slope(xp, height: Height, direction):
    """Of the ray's distance over the surface, by its length; 1 for a ray that grazes."""
    slope = direction[2] - height.by_x * direction[0] - height.by_y * direction[1]
    return xp.where(slope == 0, 1.0, slope)


@jax.custom_jvp
def _meet(numbers) -> tuple[Any, Height]:
    """Not one step where all surfaces are spheres: their height stays 0."""
    shape, *ray = numbers
    is_sphere = shape.present == 0
    way = shape.start(*ray)
    level = jax.tree.map(lambda like: jnp.zeros(like.shape, like.dtype), jax.eval_shape(shape.height, *ray[:2]))

    def step(state):
        way, _, _, count = state
        step, height = _step(numbers, way)
        move_x, move_y = step * ray[2][0], step * ray[2][1]
        near = (abs(move_x) + abs(move_y) <= _NEAR) | is_sphere
        return way + step, height.beside(move_x, move_y), near.all(), count + 1

    state = (way, level, is_sphere.all(), 0)
    return jax.lax.while_loop(lambda state: ~state[2] & (state[3] < _STEPS), step, state)[:2]


@_meet.defjvp
def _meet_jvp(primals, tangents):
    """At a fixed way along the ray the miss changes by what the way makes up for."""
    way, height = _meet(*primals)

    def miss(numbers):
        _, _, _, (_, _, along) = numbers
        return way * along - _at(numbers, way).z

    missing = jax.jvp(miss, primals, tangents)[1]
    longer = -missing / _slope(jnp, height, primals[0][3])
    _, change = jax.jvp(_at, (*primals, way), (*tangents, longer))
    return (way, height), (longer, change)
