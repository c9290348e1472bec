"""Zernike polynomials in Noll's order, rms normalization (Noll 1976, J. Opt. Soc. Am. 66, 207), as Chebyshev products.

On the unit disc the mean of Z_i Z_j is 1 for i = j and 0 for others, so a coefficient is the rms of its term. Term 1 is
piston, 2 and 3 tilt along u and v, 4 power, 5 and 6 astigmatism, 7 and 8 coma, 11 spherical.
"""

from functools import cache
from math import factorial

import numpy as np
from numpy.polynomial import chebyshev

# Up to radial order 7, in whole orders.
TERMS = 36
ORDERS = (3, 6, 10, 15, 21, 28, 36)
# Numbers of terms of an answer: power and astigmatism are always among them.
REPORTED = ORDERS[1:]
SIDE = 8


def noll(term: int) -> tuple[int, int]:
    """Radial order n and azimuthal order m of a term from 1 on; m < 0 for the sine."""
    n = 0
    while term > (n + 1) * (n + 2) // 2:
        n += 1
    within = term - n * (n + 1) // 2
    m = 2 * (within // 2) if n % 2 == 0 else 2 * ((within - 1) // 2) + 1
    return n, m if term % 2 == 0 else -m


def polar_values(term: int, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """One term at points of the plane, from its definition in polar coordinates."""
    n, m = noll(term)
    r, angle = np.hypot(u, v), np.arctan2(v, u)
    k = abs(m)
    radial = np.zeros_like(r)
    for s in range((n - k) // 2 + 1):
        below = factorial(s) * factorial((n + k) // 2 - s) * factorial((n - k) // 2 - s)
        radial += (-1) ** s * factorial(n - s) / below * r ** (n - 2 * s)
    turn = np.cos(k * angle) if m >= 0 else np.sin(k * angle)
    return np.sqrt(n + 1) * (np.sqrt(2) if m else 1.0) * radial * turn


@cache
def products() -> np.ndarray:
    """Coefficients [36, 8, 8] of the terms over T_a(v) T_b(u): polynomials of degree 7, so exact."""
    nodes = np.cos(np.pi * (np.arange(SIDE) + 0.5) / SIDE)
    u, v = np.meshgrid(nodes, nodes)
    inverse = np.linalg.inv(chebyshev.chebvander(nodes, SIDE - 1))
    return np.stack([inverse @ polar_values(term, u, v) @ inverse.T for term in range(1, TERMS + 1)])


@cache
def slopes() -> tuple[np.ndarray, np.ndarray]:
    """Coefficients of the derivatives of the terms along u and along v, as `products`."""
    rise = np.zeros((2, TERMS, SIDE, SIDE))
    rise[0, :, :, :-1] = chebyshev.chebder(products(), axis=2)
    rise[1, :, :-1, :] = chebyshev.chebder(products(), axis=1)
    return rise[0], rise[1]


def at_points(coefficients: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Polynomials [terms, 8, 8] at points [n]: [n, terms]."""
    basis = chebyshev.chebvander(v, SIDE - 1)[:, :, None] * chebyshev.chebvander(u, SIDE - 1)[:, None, :]
    return basis.reshape(len(u), -1) @ coefficients.reshape(len(coefficients), -1).T


def terms_at(u: np.ndarray, v: np.ndarray, count: int = TERMS) -> np.ndarray:
    """The first `count` terms at points [n]: [n, count]."""
    return at_points(products()[:count], u, v)


def on_grid(coefficients: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """The sum of the terms on a grid of columns `u` and rows `v`: [rows, columns], in the type of `u`."""
    square = np.tensordot(coefficients, products()[: len(coefficients)], 1)
    rows = chebyshev.chebvander(v, SIDE - 1) @ square
    return rows.astype(u.dtype) @ chebyshev.chebvander(u, SIDE - 1).astype(u.dtype).T
