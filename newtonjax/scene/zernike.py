"""Zernike figures, in the orders of Noll and of ANSI, normalized to rms."""

from functools import cache
from math import factorial, sqrt
from typing import Any

import equinox as eqx
import numpy as np
from jaxtyping import Float

from newtonjax.numerics import Scalar, as_scalar, as_vector, chebyshev, finite, positive, require, require_number, shown
from newtonjax.scene.figures import SIZES, AbstractFigure

# Radial degrees up to 15, which a table of 16 x 16 holds.
MOST_TERMS = 136


class Zernike(AbstractFigure):
    """Σ coefficients[k] Z_k(x/radius, y/radius) [m], each polynomial of rms 1 on the disc.

    Z = N R_n^|m|(ρ) cos mθ, or sin |m|θ for negative m, with N² = n + 1 for m = 0 and 2 (n + 1) else (Noll 1976, eqs.
    1 and 2; ANSI Z80.28); θ counts from x towards y.

    - `coefficients`: rms of each term [m], up to 136: the first is piston, Z1 in Noll's order and Z0 in ANSI's.
    - `radius`: of the disc [m].
    - `order`: "noll" or "ansi".
    """

    coefficients: Float[Any, " terms"] = eqx.field(converter=as_vector)
    radius: Scalar = eqx.field(converter=as_scalar)
    order: str = eqx.field(static=True, default="noll")

    def __check_init__(self):
        require_number("zernike_radius", self.radius, "a positive radius in metres", positive)
        require("zernike", self.coefficients, "finite heights in metres", finite)
        if np.ndim(self.coefficients) != 1 or not 1 <= len(self.coefficients) <= MOST_TERMS:
            raise ValueError(
                f"zernike is {shown(self.coefficients)}; allowed: 1 to {MOST_TERMS} heights in metres, piston first"
            )
        if self.order not in ("noll", "ansi"):
            raise ValueError(f"zernike_order is {shown(self.order)}; allowed: 'noll' or 'ansi'")

    def sag(self, x: Float[Any, "..."], y: Float[Any, "..."]) -> Float[Any, "..."]:
        terms = (polynomial(*degrees(k, self.order), x / self.radius, y / self.radius) for k in range(self._count))
        return sum(coefficient * term for coefficient, term in zip(self.coefficients, terms, strict=True))

    def table(self, size: int) -> Float[Any, "size size"]:
        """Exact, whatever the coefficients are: polynomials of a lower degree than `size` are what its samples say."""
        tables = _tables(self._count, size, self.order)
        return sum(self.coefficients[k] * tables[k] for k in range(self._count))

    def size(self) -> int:
        degree = degrees(self._count - 1, self.order)[0]
        return next(size for size in SIZES if size > degree)

    @property
    def _count(self) -> int:
        return np.shape(self.coefficients)[-1]


def degrees(k: int, order: str) -> tuple[int, int]:
    """Radial and angular degree (n, m) of the k-th polynomial, counted from 0; sines have negative m.

    In ANSI's order k = (n (n + 2) + m) / 2. In Noll's, j = k + 1, |m| grows within each n, and even j are cosines.
    """
    n = int((sqrt(8 * k + 1) - 1) / 2)
    place = k - n * (n + 1) // 2
    if order == "ansi":
        return n, 2 * place - n
    size = n % 2 + 2 * ((place + 1 - n % 2) // 2)
    return n, size if (k + 1) % 2 == 0 else -size


def polynomial(n: int, m: int, u: Float[Any, "..."], v: Float[Any, "..."]) -> Any:
    """Z_n^m at (u, v) on the unit disc, normalized to rms 1; a polynomial everywhere, also at the centre."""
    size, q = abs(m), u * u + v * v
    powers = [
        (-1) ** s * factorial(n - s) / (factorial(s) * factorial((n + size) // 2 - s) * factorial((n - size) // 2 - s))
        for s in range((n - size) // 2 + 1)
    ]
    radial = powers[0] + 0.0 * q
    for coefficient in powers[1:]:
        radial = radial * q + coefficient
    cosine, sine = 1.0 + 0.0 * u, 0.0 * u
    for _ in range(size):  # ρ^m cos mθ and ρ^m sin mθ
        cosine, sine = cosine * u - sine * v, cosine * v + sine * u
    return sqrt((n + 1) * (1 if m == 0 else 2)) * radial * (sine if m < 0 else cosine)


@cache
def _tables(count: int, size: int, order: str) -> Float[np.ndarray, "count size size"]:
    at = chebyshev.nodes(size)
    u, v = (part.ravel() for part in np.meshgrid(at, at))
    return chebyshev.coefficients(np.stack([polynomial(*degrees(k, order), u, v) for k in range(count)]))
