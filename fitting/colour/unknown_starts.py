"""Where a fit of several pictures under one unknown light begins: their rates by likeness, the gap by trials."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy import ndimage

from fitting.colour.amplitudes import background
from fitting.colour.profiles import Profiles

# Of the logarithm of a ratio of rates: a search may see the rings of another channel. Steps of so many turns at the
# rim of fringes of so long waves [m].
_REACH, _TURNS, _WAVE = 0.35, 0.1, 550e-9
# Differences of the gaps that are tried [m], and ratios and differences that are followed.
_DIFFERENCES, _LIKELIEST = (np.arange(-0.6e-6, 0.61e-6, 0.04e-6), 4)
# Bins that are compared, evenly over the rings.
_COMPARED = 240


class Likeness(NamedTuple):
    """Logarithm of a second picture's rate over the first's, and its gap at the centre less the first's [m]."""

    ratio: float
    difference: float


def likenesses(first: Profiles, second: Profiles, rate: float, ratio: float) -> list[Likeness]:
    """What makes two pictures' rings most alike, the best first.

    The light of a ring is a function of its gap alone, the same in both pictures: no spectrum is assumed.
    `rate` of the first picture [m per px²]; `ratio`: logarithm of that of the searches' scales.
    """
    turns = 2 * rate * float(first.squares.max()) / _WAVE
    count = max(int(np.ceil(_REACH * turns / _TURNS)), 20)
    ratios = ratio + np.linspace(-_REACH, _REACH, 2 * count + 1)
    compared = np.unique(np.linspace(0, len(second.squares) - 1, _COMPARED).astype(int))
    squares = second.squares[compared]
    smooth, unlike = background(squares, 3), np.zeros((len(ratios), len(_DIFFERENCES)))
    for channel, (values, weight) in enumerate(zip(second.means, second.weight, strict=True)):
        root = np.sqrt(weight[compared])
        basis = np.linalg.qr(smooth * root[:, None])[0]
        for row, log_ratio in enumerate(ratios):
            at = squares * np.exp(log_ratio) + _DIFFERENCES[:, None] / rate
            # Where the first picture has no ring, the second is not compared.
            overlap = root * ((at >= first.squares[0]) & (at <= first.squares[-1]))
            rings = np.interp(at, first.squares, first.means[channel]) * overlap
            target = values[compared] * overlap
            rings, target = (table - (table @ basis) @ basis.T for table in (rings, target))
            along = np.maximum((rings * target).sum(axis=1), 0.0) ** 2
            both = (rings**2).sum(axis=1) * (target**2).sum(axis=1)
            unlike[row] += 1 - along / np.maximum(both, 1e-30)
    return [Likeness(float(ratios[row]), float(_DIFFERENCES[column])) for row, column in valleys(unlike)[:_LIKELIEST]]


def valleys(table: Float[np.ndarray, "*shape"]) -> list[tuple[int, ...]]:
    """Places of the local minima of a table, the lowest first."""
    lowest = np.argwhere(table == ndimage.minimum_filter(table, 3, mode="nearest"))
    return sorted((tuple(int(at) for at in place) for place in lowest), key=lambda place: float(table[place]))
