"""All that a picture says of a form near a reference phase: moments against Chebyshev products, in one pass.

With c = cos 2πφ, s = sin 2πφ of the reference phase φ, a picture B + M cos 2π(φ + δ) is B·1 + (M cos 2πδ) c -
(M sin 2πδ) s: three smooth fields. Their sums of squares and their products with the light follow from eight tables of
moments, so no pixel is needed again while the form changes by less than half a turn.
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from fitting.irregularity.disc import Disc
from fitting.irregularity.zernike import on_grid

# Total degree of the fields of c and s: 12 leaves chi-squared 0.15 % high with 36 terms, 22 is singular on a disc.
DEGREE = 16
# Rows of a picture at a time: what fits in a processor's cache.
_ROWS = 64


class Normal(NamedTuple):
    """Normal equations of the fields of c and s, the background eliminated.

    - `matrix` [2k, 2k], `light` [2k]: of the fields of c, then of s, over `powers(DEGREE)`.
    - `square`: the sum of squares of the light that the background leaves.
    - `pixels`: their number; `background`: its coefficients without fringes, and with them `through` [b, 2k] less.
    """

    matrix: np.ndarray
    light: np.ndarray
    square: float
    pixels: float
    background: np.ndarray
    through: np.ndarray


@cache
def powers(degree: int) -> np.ndarray:
    """Pairs (a, b) of T_a(v) T_b(u) with a + b <= degree: [k, 2]."""
    return np.array([(a, total - a) for total in range(degree + 1) for a in range(total + 1)])


def products_at(u: np.ndarray, v: np.ndarray, degree: int) -> np.ndarray:
    """The Chebyshev products of total degree `degree` at points [n]: [n, k]."""
    pairs = powers(degree)
    return chebyshev.chebvander(v, degree)[:, pairs[:, 0]] * chebyshev.chebvander(u, degree)[:, pairs[:, 1]]


def normal_equations(disc: Disc, phase: np.ndarray, background: int) -> Normal:
    """The normal equations near the form `phase` [terms], with a background of that total degree."""
    ones, c, s, cc, cs, d, dc, ds, dd = _tables(disc, phase)
    pairs, few = powers(DEGREE), powers(background)
    grams = [_gram(table, pairs, pairs) for table in (cc, cs, ones - cc)]
    matrix = np.block([[grams[0], grams[1]], [grams[1], grams[2]]])
    across = np.hstack([_gram(table, few, pairs) for table in (c, s)])
    light = np.concatenate([table[pairs[:, 0], pairs[:, 1]] for table in (dc, ds)])
    light_few = d[few[:, 0], few[:, 1]]
    solved = np.linalg.solve(_gram(ones, few, few), np.column_stack([across, light_few]))
    through, constant = solved[:, :-1], solved[:, -1]
    square = float(dd - light_few @ constant)
    reduced = matrix - across.T @ through
    return Normal(reduced, light - across.T @ constant, square, float(ones[0, 0]), constant, through)


def _tables(disc: Disc, phase: np.ndarray) -> list:
    """Moments [33, 33] of w {1, c, s, c², cs, d, dc, ds} over T_a(v) T_b(u), and the sum of w d²."""
    degree = 2 * DEGREE
    across = chebyshev.chebvander(disc.u, degree).astype(np.float32)
    down = chebyshev.chebvander(disc.v, degree)
    sums, square = np.zeros((8, degree + 1, degree + 1)), 0.0
    u = disc.u.astype(np.float32)
    for start in range(0, len(disc.v), _ROWS):
        part = slice(start, start + _ROWS)
        turns = on_grid(phase, u, disc.v[part])
        turns -= np.round(turns)
        turns *= np.float32(2 * np.pi)
        w, d = disc.weights[part], disc.light[part]
        c, s = np.cos(turns) * w, np.sin(turns) * w
        fields = np.stack([w, c, s, c * c, c * s, d, d * c, d * s])
        lines = fields.reshape(-1, len(u)) @ across
        sums += down[part].T @ lines.reshape(8, -1, degree + 1).astype(float)
        square += float(np.vdot(d, d))
    return [*sums, square]


@cache
def _places(first: int, second: int) -> tuple[np.ndarray, ...]:
    """Where in a table, flat, the four products T_a T_a' = (T_{a+a'} + T_{|a-a'|})/2 of all pairs stand."""
    first_powers, second_powers = powers(first)[:, None, :], powers(second)[None, :, :]
    width = 2 * DEGREE + 1
    rows, columns = ((first_powers + second_powers)[:, :, k] for k in (0, 1))
    rows_less, columns_less = (np.abs(first_powers - second_powers)[:, :, k] for k in (0, 1))
    pairs = (rows, columns), (rows, columns_less), (rows_less, columns), (rows_less, columns_less)
    return tuple(row * width + column for row, column in pairs)


def _gram(table: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    flat = table.ravel()
    degrees = int(first.sum(axis=1).max()), int(second.sum(axis=1).max())
    return np.add.reduce([flat[place] for place in _places(*degrees)]) / 4
