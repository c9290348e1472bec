"""Forbes' polynomials: aspheres by their departure from a conic, or from a sphere with slopes that are orthogonal."""

from math import sqrt
from typing import Any

import equinox as eqx
import numpy as np
from jaxtyping import Float

from newtonjax.numerics import (
    Scalar,
    as_scalar,
    as_vector,
    finite,
    is_concrete,
    module_of,
    positive,
    require,
    require_number,
    shown,
)
from newtonjax.scene.figures import AbstractFigure

MOST_TERMS = 20
KINDS = ("con", "bfs")


class Forbes(AbstractFigure):
    """Departure by Forbes' polynomials (Forbes 2007, Opt. Express 15, 5218), on the disc of `radius`.

    With u = r/radius, "con" is u⁴ Σ coefficients[m] Q_m^con(u²) over the conic of its surface, and "bfs"
    u² (1 - u²) / sqrt(1 - c² r²) Σ coefficients[m] Q_m^bfs(u²) over a sphere that it meets at the vertex and at the
    rim, whose curvature c is the surface's.

    - `coefficients`: [m], up to 20.
    - `radius`: of the disc [m].
    - `kind`: "con" or "bfs".
    - `curvature`: c of "bfs" [1/m]; the square around the disc lies before the equator of that sphere.
    """

    coefficients: Float[Any, " terms"] = eqx.field(converter=as_vector)
    radius: Scalar = eqx.field(converter=as_scalar)
    kind: str = eqx.field(static=True, default="con")
    curvature: Scalar = eqx.field(converter=as_scalar, default=0.0)

    def __check_init__(self):
        require_number("forbes radius", self.radius, "a positive radius in metres", positive)
        require_number("forbes curvature", self.curvature, "a finite number in 1/m", finite)
        require("forbes", self.coefficients, "finite heights in metres", finite)
        if np.ndim(self.coefficients) != 1 or not 1 <= len(self.coefficients) <= MOST_TERMS:
            raise ValueError(f"forbes is {shown(self.coefficients)}; allowed: 1 to {MOST_TERMS} heights in metres")
        if self.kind not in KINDS:
            raise ValueError(f"forbes kind is {shown(self.kind)}; allowed: 'con' or 'bfs'")
        if self.kind == "con" and not (is_concrete(self.curvature) and float(self.curvature) == 0):
            raise ValueError("forbes curvature goes with kind='bfs'; departures of kind 'con' are from any conic")
        if is_concrete(self) and 2 * (float(self.curvature) * float(self.radius)) ** 2 >= 1:
            raise ValueError(
                f"forbes curvature is {shown(self.curvature)} 1/m; allowed: up to {0.5**0.5 / float(self.radius):.4g} "
                "1/m, so that the square around the disc is on the sphere"
            )

    def sag(self, x: Float[Any, "..."], y: Float[Any, "..."]) -> Float[Any, "..."]:
        r2 = x * x + y * y
        t = r2 / (self.radius * self.radius)
        if self.kind == "con":
            return t * t * _sum(self.coefficients, _jacobi(t, len(self.coefficients)))
        upright = module_of(t).sqrt(1 - self.curvature * self.curvature * r2)
        return t * (1 - t) / upright * _sum(self.coefficients, _slope_orthogonal(t, len(self.coefficients)))


def _sum(coefficients, polynomials: list[Any]) -> Any:
    return sum(coefficient * polynomial for coefficient, polynomial in zip(coefficients, polynomials, strict=True))


def _jacobi(t, count: int) -> list[Any]:
    """Q_m^con(t) = P_m^(0,4)(2 t - 1), by their recurrence (DLMF 18.9.2)."""
    s = 2 * t - 1
    values = [1.0 + 0.0 * t, 3 * s - 2]
    for n in range(2, count):
        twice = 2 * n + 4
        middle = (twice - 1) * (twice * (twice - 2) * s - 16) * values[-1]
        values.append((middle - 2 * (n - 1) * (n + 3) * twice * values[-2]) / (2 * n * (n + 4) * (twice - 2)))
    return values[:count]


def _slope_orthogonal(t, count: int) -> list[Any]:
    """Q_m^bfs(t): what makes the slopes of t (1 - t) P_m orthonormal (Forbes 2010, Opt. Express 18, 19700).

    P_m are Jacobi's polynomials of ∓1/2, with f_m Q_m = P_m - g_{m-1} Q_{m-1} - h_{m-2} Q_{m-2}.
    """
    p, values = [2.0 + 0.0 * t, 6 - 8 * t], [1.0 + 0.0 * t]
    f, g, h = [2.0], [-0.5], [0.0]
    for m in range(1, count):
        f.append(sqrt(m * (m + 1) + 3 - g[-1] ** 2 - h[-1] ** 2))
        values.append((p[m] - g[-1] * values[-1] - h[-1] * values[m - 2]) / f[m])
        h.append(-m * (m + 1) / (2 * f[m - 1]))
        g.append(-(1 + g[-1] * h[-1]) / f[m])
        p.append((2 - 4 * t) * p[m] - p[m - 1])
    return values
