"""Rings whose fringes are too fine for a coarse image, from the wave vectors of small tiles."""

from collections.abc import Callable

import numpy as np
from scipy import fft

from fitting.photo.matched_filter import Rings

# Pixels to a side of a tile, and tiles to a side of the image.
_TILE, _ACROSS = 64, 10
# Proposals that are looked at together: their table stays in the processor's cache.
_TOGETHER = 500


def from_tiles(tile_of: Callable[[int, int, int], np.ndarray], shape: tuple[int, int]) -> Rings | None:
    """A candidate from the wave vectors of tiles: these are 2 k (x - c), linear in the place, up to their signs.

    `tile_of(y, x, size)` returns the image's pixels [size, size] from a corner, 0 where there are none. Every two
    tiles, with either sign, propose scale and centre; the proposal that most tiles agree with is refined by least
    squares over these. None where no three agree.
    """
    size = min(_TILE, *shape)
    places, waves = waves_of(tile_of, shape, size)
    first, second = np.triu_indices(len(places), 1)
    apart = places[second] - places[first]
    length2 = (apart**2).sum(axis=1)
    slopes = np.concatenate([((s * waves[second] - waves[first]) * apart).sum(axis=1) / length2 for s in (1.0, -1.0)])
    tile = np.concatenate([first, first])
    curved = np.abs(slopes) > 0.2 / (np.hypot(*shape) / 2) ** 2
    slopes, tile = slopes[curved], tile[curved]
    if len(slopes) == 0:
        return None
    zeros = waves[tile] - slopes[:, None] * places[tile]
    signs, agreeing = _most_agreed(slopes, zeros, places, waves, 1.5 / size)
    if agreeing.sum() < 3:
        return None
    signed = signs[:, None] * waves
    middle, mean = places[agreeing].mean(axis=0), signed[agreeing].mean(axis=0)
    from_middle = places[agreeing] - middle
    slope = float((from_middle * (signed[agreeing] - mean)).sum() / (from_middle**2).sum())
    if slope == 0:
        return None
    x, y = (float(value) for value in middle - mean / slope)
    return Rings(abs(slope) / 2, (x, y), 0.0, 0.0)


def waves_of(tile_of, shape: tuple[int, int], size: int) -> tuple[np.ndarray, np.ndarray]:
    """Middles (x, y) [px] of the tiles that hold something, and the strongest wave vector of each [cycles per px]."""
    down, across = (np.unique(np.linspace(0, n - size, _ACROSS).round().astype(int)).tolist() for n in shape)
    corners = [(x, y) for y in down for x in across]
    tiles = np.stack([tile_of(y, x, size) for x, y in corners]).astype(np.float32)
    window = np.hanning(size + 2)[1:-1].astype(np.float32)
    power = np.abs(np.asarray(fft.rfft2(tiles * np.outer(window, window), (2 * size,) * 2))) ** 2
    down, across = fft.fftfreq(2 * size), fft.rfftfreq(2 * size)
    power[:, np.hypot(down[:, None], across[None]) < 1.5 / size] = 0.0
    power = power.reshape(len(tiles), -1)
    at, is_used = power.argmax(axis=1), power.max(axis=1) > 0
    waves = np.stack([across[at % len(across)], down[at // len(across)]], axis=1)
    return (np.array(corners) + (size - 1) / 2)[is_used], waves[is_used]


def _most_agreed(slopes, zeros, places, waves, near: float) -> tuple[np.ndarray, np.ndarray]:
    """The tiles' signs and which agree, by the proposal slope x + zero that most tiles agree with to `near`."""
    best, most = (np.ones(len(places)), np.zeros(len(places), bool)), -1
    for k in range(0, len(slopes), _TOGETHER):
        slope, zero = slopes[k : k + _TOGETHER, None], zeros[k : k + _TOGETHER]
        predicted = [slope * places[:, axis] + zero[:, axis : axis + 1] for axis in (0, 1)]
        sign = np.where(predicted[0] * waves[:, 0] + predicted[1] * waves[:, 1] < 0, -1.0, 1.0)
        agree = np.abs(sign * waves[:, 0] - predicted[0]) < near
        agree &= np.abs(sign * waves[:, 1] - predicted[1]) < near
        counts = agree.sum(axis=1)
        at = int(np.argmax(counts))
        if counts[at] > most:
            most, best = int(counts[at]), (sign[at], agree[at])
    return best
