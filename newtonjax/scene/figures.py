"""Figures: what a surface departs by from its base. A kind of figure is a class in a file of its own."""

import abc
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from newtonjax.numerics import (
    Scalar,
    as_scalar,
    as_vector,
    chebyshev,
    finite,
    is_concrete,
    namespace,
    positive,
    require,
    require_number,
    shown,
    x64,
)

# Chebyshev polynomials to a side of a figure's table: one compiled program for each of these sizes.
SIZES = (8, 16, 32, 64)
# Of a figure whose numbers are traced, so that how smooth it is has no value yet.
_TRACED = 32
# A table holds a figure where its last two shells are below this [m], or so much of the largest.
_TAIL, _RELATIVE = 3e-17, 3e-15


class AbstractFigure(eqx.Module):
    """A height over the base of a surface, sag(x, y), on the disc of `radius` about its vertex; beyond it is no glass.

    Subclass it with your own `sag`, an analytic function on the square around the disc, and hand it to
    `Surface(figure=...)`. It is sampled at Chebyshev nodes, so that rays meet it as they meet every other kind, and its
    numbers may be differentiated.

        class Ripple(nj.AbstractFigure):
            radius: float
            height: float

            def sag(self, x, y):
                return self.height * jnp.cos(2 * jnp.pi * x / 2e-3)
    """

    radius: eqx.AbstractVar[Scalar]

    @abc.abstractmethod
    def sag(self, x: Float[Any, "..."], y: Float[Any, "..."]) -> Float[Any, "..."]:
        """Height [m] over the points (x, y) [m] of the surface's own directions."""

    def table(self, size: int) -> Float[Any, "size size"]:
        """Coefficients [in y, in x] of Chebyshev products on the square around the disc, from `size`² samples."""
        at = chebyshev.nodes(size) * self.radius
        x, y = (part.ravel() for part in namespace(at).meshgrid(at, at))
        if not is_concrete(self):
            return chebyshev.coefficients(jnp.asarray(self.sag(x, y)))
        # Known numbers stay known, and are of 64 bits, within a program and whatever JAX is set to.
        with x64():
            return chebyshev.coefficients(np.asarray(self.sag(x, y), dtype=float))

    def size(self) -> int:
        """The smallest of `SIZES` that holds the figure to rounding.

        Raises ValueError for one that none of them holds, or that is not finite.
        """
        if not is_concrete(self):
            return _TRACED
        left_out = np.inf
        for size in SIZES:
            shells = np.asarray(chebyshev.shells(np.asarray(self.table(size), dtype=float)))
            if not np.isfinite(shells).all():
                raise ValueError(
                    f"{type(self).__name__}.sag is not finite everywhere; allowed: a height on the square around its "
                    f"disc of {float(self.radius):.4g} m"
                )
            left_out = shells[-2:].sum()
            if left_out <= _TAIL + _RELATIVE * shells.max():
                return size
        raise ValueError(
            f"{type(self).__name__}.sag is not smooth: {SIZES[-1]} x {SIZES[-1]} Chebyshev polynomials leave "
            f"{left_out:.2g} m of it; allowed: a smooth function on the square around its disc; for measured "
            "heights take HeightMap"
        )


class ChebyshevFigure(AbstractFigure):
    """Σ coefficients[j, i] T_j(y/radius) T_i(x/radius) [m], on the disc of `radius`.

    - `coefficients`: [m], in y along the first axis, up to 64 x 64.
    - `radius`: of the disc [m].
    """

    coefficients: Float[Any, "ny nx"] = eqx.field(converter=as_vector)
    radius: Scalar = eqx.field(converter=as_scalar)

    def __check_init__(self):
        require_number("figure.radius", self.radius, "a positive radius in metres", positive)
        require("figure.coefficients", self.coefficients, "finite heights in metres, [in y, in x]", finite)
        if np.ndim(self.coefficients) != 2 or not 0 < max(np.shape(self.coefficients)) <= SIZES[-1]:
            raise ValueError(
                f"figure.coefficients is {shown(self.coefficients)}; allowed: a table [in y, in x] of up to "
                f"{SIZES[-1]} x {SIZES[-1]} heights"
            )

    def sag(self, x: Float[Any, "..."], y: Float[Any, "..."]) -> Float[Any, "..."]:
        u, v, (rows, columns) = x / self.radius, y / self.radius, self.coefficients.shape
        along_x, along_y = _polynomials(u, columns), _polynomials(v, rows)
        return sum(self.coefficients[j, i] * (along_y[j] * along_x[i]) for j in range(rows) for i in range(columns))

    def size(self) -> int:
        return next(size for size in SIZES if size >= max(np.shape(self.coefficients)))


def _polynomials(u, count: int) -> list[Any]:
    """T_0(u), ... T_{count-1}(u)."""
    values = [1.0 + 0.0 * u, u]
    while len(values) < count:
        values.append(2 * u * values[-1] - values[-2])
    return values
