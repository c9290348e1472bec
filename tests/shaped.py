"""Surfaces that are no spheres at 50 digits, by their textbook formulas in polar coordinates, and the same of ours."""

from dataclasses import dataclass
from functools import cache
from typing import Any

import mpmath
import numpy as np
import oracles
from mpmath import mpf

import newtonjax as nj

# Noll (1976), table I: radial and angular degree of Z1 to Z15, sines with negative degree.
NOLL = [(0, 0), (1, 1), (1, -1), (2, 0), (2, -2), (2, 2), (3, -1), (3, 1), (3, -3), (3, 3)]
NOLL += [(4, 0), (4, 2), (4, -2), (4, 4), (4, -4)]


@cache
def radial_terms(n, m):
    """Of R_n^m: (power, coefficient)."""
    factorial = mpmath.factorial
    return [
        (
            n - 2 * s,
            (-1) ** s
            * factorial(n - s)
            / (factorial(s) * factorial((n + abs(m)) // 2 - s) * factorial((n - abs(m)) // 2 - s)),
        )
        for s in range((n - abs(m)) // 2 + 1)
    ]


def zernike(n, m, rho, theta):
    """Of rms 1 on the unit disc."""
    radial = sum(coefficient * rho**power for power, coefficient in radial_terms(n, m))
    angular = mpmath.sin(-m * theta) if m < 0 else mpmath.cos(m * theta)
    return mpmath.sqrt((n + 1) * (1 if m == 0 else 2)) * radial * angular


@dataclass
class Shape:
    """A surface by `Surface`'s words: `sag` and what `oracles.Face` asks."""

    curvature: float
    vertex: list
    tilt: tuple = (0.0, 0.0)
    conic: float = 0.0
    asphere: tuple = ()
    odd_asphere: tuple = ()
    curvature_across: float | None = None
    axis: float = 0.0
    zernike: tuple = ()
    radius: float = 1.0
    own: Any = None

    def sag(self, x, y):
        c, r2 = mpf(self.curvature), x * x + y * y
        z = c * r2 / (1 + mpmath.sqrt(1 - (1 + mpf(self.conic)) * c * c * r2))
        if self.curvature_across is not None:
            cosine, sine = mpmath.cos(mpf(self.axis)), mpmath.sin(mpf(self.axis))
            s, t = cosine * x + sine * y, cosine * y - sine * x
            across = mpf(self.curvature_across)
            arc = (1 - mpmath.sqrt(1 - (across * t) ** 2)) / across if across else mpf(0)
            # The arc's point goes round the axis, which is 1/c behind the vertex.
            z = 1 / c - mpmath.sign(c) * mpmath.sqrt((1 / c - arc) ** 2 - s * s) if c else arc
        r = mpmath.sqrt(r2)
        z += sum(mpf(a) * r ** (4 + 2 * k) for k, a in enumerate(self.asphere))
        z += sum(mpf(a) * r ** (3 + 2 * k) for k, a in enumerate(self.odd_asphere))
        rho, theta = r / mpf(self.radius), mpmath.atan2(y, x) if r else mpf(0)
        z += sum(mpf(a) * zernike(*NOLL[k], rho, theta) for k, a in enumerate(self.zernike))
        return z + (self.own(x, y) if self.own else 0)

    def meet(self, point, direction):
        """Distance along the ray, and the normal, by Newton's method with differences of 1e-20 m."""
        axes = [oracles.turn(unit, self.tilt) for unit in ([1, 0, 0], [0, 1, 0], [0, 0, 1])]
        offset = [p - q for p, q in zip(point, self.vertex, strict=True)]
        x, y, z = (mpmath.fdot(axis, offset) for axis in axes)
        dx, dy, dz = (mpmath.fdot(axis, direction) for axis in axes)
        way, h = -z / dz, mpf("1e-20")
        for _ in range(60):
            at = x + way * dx, y + way * dy
            miss = z + way * dz - self.sag(*at)
            by_x = (self.sag(at[0] + h, at[1]) - self.sag(at[0] - h, at[1])) / (2 * h)
            by_y = (self.sag(at[0], at[1] + h) - self.sag(at[0], at[1] - h)) / (2 * h)
            if abs(miss) < mpf("1e-35"):
                break
            way -= miss / (dz - by_x * dx - by_y * dy)
        length = mpmath.sqrt(1 + by_x**2 + by_y**2)
        return way, [(c - by_x * a - by_y * b) / length for a, b, c in zip(*axes, strict=True)]

    def ours(self):
        """The same in the library's words."""
        words = {
            "conic": self.conic or None,
            "asphere": self.asphere or None,
            "odd_asphere": self.odd_asphere or None,
            "curvature_across": self.curvature_across,
            "axis": self.axis or None,
            "figure": nj.Zernike(self.zernike, self.radius) if self.zernike else None,
        }
        return nj.Surface(self.curvature, tuple(map(float, self.vertex)), self.tilt, **words)


ASPHERE, ODD = (2e2, -3e6, 1e11), (0.3, 2e4)
FIGURE = (0.0, 3e-8, -2e-8, 1e-7, 2e-7, -1.5e-7, 4e-8, 5e-8, -6e-8, 3e-8, 7e-8, 1e-8, -2e-8, 3e-8, 2e-8)
# What each kind is, about a sphere of 0.1 m.
KINDS = {
    "conic": {"conic": -1.7},
    "ellipsoid": {"conic": 0.8},
    "asphere": {"asphere": ASPHERE},
    "odd asphere": {"odd_asphere": ODD},
    "toroid": {"curvature_across": 8.0, "axis": 0.4},
    "cylinder": {"curvature_across": 0.0, "axis": -0.7},
    "cylinder on a plane": {"curvature": 0.0, "curvature_across": 5.0},
    "zernike": {"zernike": FIGURE, "radius": 5e-3},
    "zernike on a plane": {"curvature": 0.0, "zernike": FIGURE, "radius": 5e-3},
    "all": {"conic": -0.5, "asphere": ASPHERE, "odd_asphere": ODD, "zernike": FIGURE, "radius": 5e-3},
}


def shape(kind, vertex=(0.0, 0.0, 0.0), tilt=(0.0, 0.0)):
    words = {"curvature": 10.0, **KINDS[kind]}
    return Shape(vertex=[mpf(v) for v in vertex], tilt=tilt, **words)


def rays(count=30, seed=3):
    """Origins within 3 mm of the axis at 20 mm, directions within 0.1 rad of -z."""
    rng = np.random.default_rng(seed)
    origin = np.column_stack([rng.uniform(-2e-3, 2e-3, (count, 2)), np.full(count, 20e-3)])
    direction = np.column_stack([rng.uniform(-0.1, 0.1, (count, 2)), -np.ones(count)])
    return origin, direction / np.linalg.norm(direction, axis=1, keepdims=True)
