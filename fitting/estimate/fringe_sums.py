"""One pass over a reduced photograph: its fringe moments and normal equations, or its residuals from a fit.

The phase is reduced to one turn in float64; cosines, products and matrix products are float32; what is added up over
rows is float64. That leaves 1e-7 of the sums. Background, contrast and phase come as tables of Chebyshev coefficients
over the grid's box.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Float64

from fitting.model import BACKGROUND, ENVELOPE, degrees
from fitting.photo import DEGREES, NODES, Grid, Reduced
from newtonjax.numerics import chebyshev

_ANALYSIS = chebyshev.analysis(NODES)
_CHUNK = 64
# Blocks from which on two threads share a pass; below, handing out costs as much as it gains.
_SHARED = 500_000
# Blocks to a side at which a phase is looked at to count fringes.
_SAMPLES = 65
# Tukey's biweights end at so many standard deviations.
TUKEY = 6.0


class Sums(NamedTuple):
    """Sums over blocks about a reference phase.

    - `table` [8, 33, 33]: Σ q T_j(y) T_i(x) for q = w, w cos, w sin, w cos2, w sin2, w d, w d cos, w d sin.
    - `square`: Σ w d²; `reference` [nodes]: the phase at the grid's nodes [turns].
    """

    table: Float64[np.ndarray, "8 33 33"]
    square: float
    reference: Float64[np.ndarray, " nodes"]


class Image(NamedTuple):
    """A fitted image: background (degree 6) and contrast (degree 16), tables [in y, in x]."""

    background: Float64[np.ndarray, "low low"]
    contrast: Float64[np.ndarray, "high high"]


class Residuals(NamedTuple):
    """Light less fit of every block, the weights it gives them, and the sine of the phase; Σ w r²."""

    value: Float[np.ndarray, "rows columns"]
    weights: Float[np.ndarray, "rows columns"]
    sine: Float[np.ndarray, "rows columns"]
    square: float


# The phase [turns] of rows of a grid's blocks.
PhaseAt = Callable[[Grid, slice], np.ndarray]


def table_of(values: Float64[np.ndarray, " nodes"]) -> Float64[np.ndarray, "17 17"]:
    """Chebyshev coefficients [in y, in x] of a field given at the nodes."""
    return _ANALYSIS @ values.reshape(NODES, NODES) @ _ANALYSIS.T


def fringe_count(reduced: Reduced, phase: np.ndarray) -> float:
    """Fringes across the used blocks, from the phase at the nodes [turns]."""
    grid, used = reduced.grid, reduced.used
    along_y, along_x = grid.along_y, grid.along_x
    rows, columns = (np.linspace(0, n - 1, min(n, _SAMPLES)).round().astype(int) for n in used.shape)
    turns = along_y[rows, :NODES] @ table_of(phase) @ along_x[columns, :NODES].T
    turns = turns[used[np.ix_(rows, columns)]]
    return float(np.ptp(turns)) if turns.size else 0.0


def sums(reduced: Reduced, reference: Float64[np.ndarray, " nodes"], phase_at: PhaseAt | None = None) -> Sums:
    """Moments of a reduced photograph with its own weights about a phase given at the nodes [turns].

    `phase_at`: the same phase of rows of blocks, where the nodes do not resolve it.
    """
    return Pass(reduced, reference, phase_at).sums()


def residuals(
    reduced: Reduced,
    reference: Float64[np.ndarray, " nodes"],
    image: Image,
    scale: float | None = None,
    phase_at: PhaseAt | None = None,
) -> Residuals:
    """What a fit leaves over, without moments; `scale`: standard deviation for Tukey's weights, none without."""
    work = Pass(reduced, reference, phase_at, image, scale, wanted=False)
    work.sums()
    return work.residuals()


class Pass:
    """What the chunks of one pass share."""

    def __init__(self, reduced: Reduced, reference, phase_at, image=None, scale=None, wanted: bool = True):
        grid, dtype = reduced.grid, reduced.light.dtype
        self.reduced, self.phase_at, self.image, self.scale, self.wanted = reduced, phase_at, image, scale, wanted
        self.reference, self.left = reference, 0.0
        self.along_x = grid.along_x.astype(dtype)
        self.phase_rows = grid.along_y[:, :NODES] @ table_of(reference)
        self.phase_columns = np.ascontiguousarray(grid.along_x[:, :NODES].T)
        self.out = np.empty((3 if image is not None else 0, *reduced.light.shape), dtype)
        if image is not None:
            low = len(image.background)
            self.smooth = (grid.along_y[:, :low] @ image.background).astype(dtype)
            self.swing = (grid.along_y[:, :NODES] @ image.contrast).astype(dtype)
            self.low, self.high = (np.ascontiguousarray(self.along_x[:, :n].T) for n in (low, NODES))

    def turns(self, rows: slice) -> np.ndarray:
        grid = self.reduced.grid
        if self.phase_at is not None:
            return self.phase_at(grid, rows)
        return self.phase_rows[rows] @ self.phase_columns

    def sums(self) -> Sums:
        starts = range(0, len(self.reduced.light), _CHUNK)
        # Blocks beyond a chunk's reach are shared out; the sums are added up in order, whoever made them.
        parts = _pool().map(self.chunk, starts) if self.reduced.light.size > _SHARED else map(self.chunk, starts)
        table, square, self.left = np.zeros((8, DEGREES, DEGREES)), 0.0, 0.0
        for part in parts:
            table, square, self.left = table + part[0], square + part[1], self.left + part[2]
        table[3], table[4] = 2 * table[3] - table[0], 2 * table[4]
        return Sums(table, square, self.reference)

    def residuals(self) -> Residuals:
        value, weights, sine = self.out
        return Residuals(value, weights, sine, self.left)

    def chunk(self, first: int):
        """Sums of one chunk of rows: the table, Σ w d², Σ w r²."""
        rows = slice(first, min(first + _CHUNK, len(self.reduced.light)))
        light, weights = self.reduced.light[rows], self.reduced.weights[rows]
        turns = self.turns(rows)
        turns = turns - np.floor(turns)
        angle = (2 * np.pi * turns).astype(light.dtype)
        cosine, sine = np.cos(angle), np.sin(angle)
        left = 0.0
        if self.image is not None:
            residual = light - self.smooth[rows] @ self.low - (self.swing[rows] @ self.high) * cosine
            if self.scale:
                share = residual * self.reduced.inverse_sd[rows] * light.dtype.type(1 / (TUKEY * self.scale))
                share = np.maximum(1 - share * share, light.dtype.type(0))
                weights = weights * share * share
            for table, value in zip(self.out, (residual, weights, sine), strict=True):
                table[rows] = value
            left = _dot(weights * residual, residual)
        if not self.wanted:
            return 0.0, 0.0, left
        weighted = weights * light
        even, odd = weights * cosine, weights * sine
        products = np.stack(
            [weights, even, odd, even * cosine, even * sine, weighted, weighted * cosine, weighted * sine]
        )
        across = (products.reshape(-1, light.shape[1]) @ self.along_x).reshape(8, -1, DEGREES)
        table = self.reduced.grid.along_y[rows].T @ across.astype(float)
        return table, _dot(weighted, light), left


def _dot(one: np.ndarray, other: np.ndarray) -> float:
    """A sum of products: along rows as they are, over rows in float64."""
    return float(np.einsum("ij,ij->i", one, other).sum(dtype=float))


@cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(2, thread_name_prefix="fringe-sums")


class Normal(NamedTuple):
    """Normal equations Σ w (…): of the envelope's coefficients, the background's, and both crossed.

    Envelope: coefficients of T cos 2πφ0, then of -T sin 2πφ0, T up to total degree 16; background up to 6.
    """

    fringes: Float64[np.ndarray, "envelope envelope"]
    smooth: Float64[np.ndarray, "low low"]
    crossed: Float64[np.ndarray, "low envelope"]
    of_fringes: Float64[np.ndarray, " envelope"]
    of_smooth: Float64[np.ndarray, " low"]
    square: float
    reference: Float64[np.ndarray, " nodes"]


@cache
def _pairs(left: int, right: int) -> tuple[np.ndarray, np.ndarray]:
    """Where the sums T_a T_b = (T_{a+b} + T_{|a-b|}) / 2 along x lie in a flat table of pairs in y [left, right]."""
    (jl, il), (jr, ir) = degrees(left).T[:, :, None], degrees(right).T[:, None, :]
    row = (jl * (right + 1) + jr) * (2 * ENVELOPE + 1)
    return row + il + ir, row + abs(il - ir)


def _gram(table: np.ndarray, left: int, right: int) -> np.ndarray:
    # One axis after the other: pairs in y are far fewer than pairs of products.
    jl, jr = np.arange(left + 1)[:, None], np.arange(right + 1)
    flat = (table[jl + jr] + table[abs(jl - jr)]).ravel()
    above, below = _pairs(left, right)
    return (np.take(flat, above) + np.take(flat, below)) / 4


def normal_equations(sums: Sums) -> Normal:
    """Normal equations of an image's coefficients, from its moments."""
    w, wc, ws, wc2, ws2, wd, wdc, wds = sums.table
    low, high = degrees(BACKGROUND).T, degrees(ENVELOPE).T
    flat, even, odd = (_gram(table, ENVELOPE, ENVELOPE) for table in (w, wc2, ws2))
    count = len(flat)
    fringes = np.empty((2 * count, 2 * count))
    fringes[:count, :count], fringes[count:, count:] = (flat + even) / 2, (flat - even) / 2
    fringes[:count, count:] = fringes[count:, :count] = -odd / 2
    return Normal(
        fringes,
        _gram(w, BACKGROUND, BACKGROUND),
        np.concatenate([_gram(wc, BACKGROUND, ENVELOPE), -_gram(ws, BACKGROUND, ENVELOPE)], axis=1),
        np.concatenate([wdc[tuple(high)], -wds[tuple(high)]]),
        wd[tuple(low)],
        sums.square,
        sums.reference,
    )


def image_of(background: np.ndarray, modulus: np.ndarray) -> Image:
    """Tables of an image's coefficients, from its background's and the contrast at the nodes."""
    low = degrees(BACKGROUND)
    table = np.zeros((BACKGROUND + 1,) * 2)
    table[tuple(low.T)] = background
    return Image(table, table_of(modulus))
