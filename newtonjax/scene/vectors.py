"""Directions in space: their products, and frames that are turned."""

from typing import Any, no_type_check

from jaxtyping import Float, Num

from newtonjax.numerics import Jet, namespace

Direction = Float[Any, "3"]
# Of one ray, or of many along the last axes.
Vectors = Float[Any, "3 ..."]


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
