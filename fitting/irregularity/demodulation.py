"""The phase that a form leaves over, tile by tile, and the form made better by it."""

from typing import NamedTuple

import numpy as np

from fitting.irregularity.disc import Disc, sums_of
from fitting.irregularity.zernike import on_grid, terms_at

# Tiles over a diameter; each looks at itself and its eight neighbours.
_SIDE = 36
_INFORMATION = 0.08
# Turns within which a tile confirms a form; least scale of outliers.
CONFIRMED = 0.12
_LEAST, _MEDIANS = 0.08, 2.5


class Remainder(NamedTuple):
    """What a form leaves over in tiles [n].

    - `u`, `v`: centres; `turns`: the phase, up to whole turns; `weights`: the share of a tile's variance about its mean
      that fringes of this phase explain.
    """

    u: np.ndarray
    v: np.ndarray
    turns: np.ndarray
    weights: np.ndarray

    @property
    def agreement(self) -> float:
        """The share of the tiles whose phase confirms the form; 0.24 of those that hold noise alone do."""
        near = np.abs(self.turns - np.round(self.turns)) < CONFIRMED
        return float(near.mean()) if len(near) else 0.0


def remainder_of(disc: Disc, form: np.ndarray) -> Remainder:
    """Fits of 1, cos φ and sin φ in tiles of a thirty-sixth of a diameter."""
    step = max(round(2 / _SIDE / disc.pixel), 2)
    u = disc.u.astype(np.float32)
    turns = on_grid(form, u, disc.v)
    turns = (turns - np.round(turns)) * np.float32(2 * np.pi)
    w, d = disc.weights, disc.light
    c, s = np.cos(turns) * w, np.sin(turns) * w
    sums = np.stack([_boxes(field, step) for field in (w, c, s, c * c, c * s, d, d * c, d * s, d * d)])
    ones, c1, s1, cc, cs, d1, dc, ds, dd = sums.reshape(9, -1)
    rows, columns = sums.shape[1:]
    ends = [axis[: size * step].reshape(size, step).mean(axis=1) for axis, size in ((disc.v, rows), (disc.u, columns))]
    v, u = (grid.ravel() for grid in np.meshgrid(*ends, indexing="ij"))
    used = (ones > 0.5 * 9 * step * step) & (np.square(u) + np.square(v) < 1)
    ones = np.maximum(ones, 1.0)
    cc, cs, ss = cc - c1 * c1 / ones, cs - c1 * s1 / ones, ones - cc - s1 * s1 / ones
    dc, ds, dd = dc - d1 * c1 / ones, ds - d1 * s1 / ones, dd - d1 * d1 / ones
    determinant = cc * ss - cs * cs
    smaller = (cc + ss) / 2 - np.sqrt(np.square((cc - ss) / 2) + cs * cs)
    used &= smaller > _INFORMATION * ones
    cc, cs, ss, dc, ds, dd, determinant = (x[used] for x in (cc, cs, ss, dc, ds, dd, determinant))
    cosine, sine = (ss * dc - cs * ds) / determinant, (cc * ds - cs * dc) / determinant
    share = np.clip((cosine * dc + sine * ds) / np.maximum(dd, 1e-30), 0, 1)
    # The signs of B + M cos 2π(φ + δ) = B + M cos δ c - M sin δ s.
    return Remainder(u[used], v[used], np.arctan2(-sine, cosine) / (2 * np.pi), share)


def demodulated(disc: Disc, form: np.ndarray, rounds: int = 3) -> tuple[np.ndarray, float]:
    """A form [terms] made better by the phase that it leaves over, and the share of tiles that confirm it."""
    p, best = np.array(form), (-1.0, np.array(form))
    for _ in range(rounds):
        remainder = remainder_of(disc, p)
        if len(remainder.u) < len(p):
            break
        change = _change(remainder, len(p))
        p = p + change
        agreement = remainder_of(disc, p).agreement
        if agreement > best[0]:
            best = agreement, p
        if np.abs(change[1:]).max() < 0.05:
            break
    return best[1], best[0]


def _change(remainder: Remainder, terms: int) -> np.ndarray:
    """The terms of the phase in tiles: first from steps between neighbours, modulo turns, then from the phase."""
    values = terms_at(remainder.u, remainder.v, terms)
    first, second = _neighbours(remainder)
    steps = remainder.turns[first] - remainder.turns[second]
    steps -= np.round(steps)
    weight = np.sqrt(remainder.weights[first] * remainder.weights[second])
    change = np.zeros(terms)
    change[1:] = robust(values[first, 1:] - values[second, 1:], steps, weight)
    for _ in range(3):
        residual = remainder.turns - values @ change
        angle = np.angle((remainder.weights * np.exp(2j * np.pi * residual)).sum()) / (2 * np.pi)
        residual = residual - angle
        residual -= np.round(residual)
        change[0] += angle
        change = change + robust(values, residual, remainder.weights)
    return change


def robust(design: np.ndarray, target: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Least squares with Huber's weights, a small ridge for what tiles do not determine."""
    solution, robust = np.zeros(design.shape[1]), weight
    for _ in range(4):
        normal = design.T @ (robust[:, None] * design)
        normal += 1e-4 * np.trace(normal) / len(normal) * np.eye(len(normal))
        solution = np.linalg.solve(normal, design.T @ (robust * target))
        size = np.abs(target - design @ solution)
        scale = max(_MEDIANS * float(np.median(size)), _LEAST)
        robust = weight * np.minimum(1.0, scale / np.maximum(size, 1e-12))
    return solution


def _neighbours(remainder: Remainder) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of tiles side by side."""
    step = min(np.min(np.diff(np.unique(np.round(axis, 6)))) for axis in (remainder.u, remainder.v))
    columns, rows = (np.round((axis - axis.min()) / step).astype(int) for axis in (remainder.u, remainder.v))
    table = np.full((rows.max() + 2, columns.max() + 2), -1)
    table[rows, columns] = np.arange(len(rows))
    pairs = [(table[:, :-1], table[:, 1:]), (table[:-1], table[1:])]
    neighbours = [
        (first[(first >= 0) & (second >= 0)], second[(first >= 0) & (second >= 0)]) for first, second in pairs
    ]
    return np.concatenate([first for first, _ in neighbours]), np.concatenate([second for _, second in neighbours])


def _boxes(field: np.ndarray, step: int) -> np.ndarray:
    """Sums over tiles of `step` x `step` pixels and their eight neighbours."""
    padded = np.pad(sums_of(field, step, float), 1)
    lines = padded[:-2] + padded[1:-1] + padded[2:]
    return lines[:, :-2] + lines[:, 1:-1] + lines[:, 2:]
