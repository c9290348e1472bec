"""The frequencies of fringes in tiles of a pupil, up to their sign."""

from typing import NamedTuple

import numpy as np
from scipy import fft

from fitting.irregularity.disc import Disc

# A tile is used if its peak holds this share of the window's power, with so many fringes in the window, and if this
# share of the window lies in the pupil.
_SHARE, _FRINGES, _INSIDE = 0.15, 1.3, 0.4
# Fewer of the tiles than this share show no form: a quarter of white noise looks like fringes.
_LEAST = 0.4
# Windows that are transformed together: those of a large picture would take 400 MB at once.
_AT_A_TIME = 64
# Half of the main lobe of a Hann window in its transform padded to twice the length.
_LOBE = 3


class Tiles(NamedTuple):
    """Frequencies in tiles.

    - `u`, `v` [n]: centres; `slopes` [n, 2]: turns a pupil radius along u and v, the sign of each tile open.
    - `weights` [n]: the share of the window's power in its peak; `window`: its side in pupil radii.
    """

    u: np.ndarray
    v: np.ndarray
    slopes: np.ndarray
    weights: np.ndarray
    window: float


def frequencies(disc: Disc, side: int) -> Tiles:
    """The fringes' frequencies in `side` x `side` tiles, in windows of twice their distance."""
    width = max(2 * round(2 / side / disc.pixel), 8)
    centres = -1 + 2 * (np.arange(side) + 0.5) / side
    v, u = (grid.ravel() for grid in np.meshgrid(centres, centres, indexing="ij"))
    light, weights = (_windows(field, disc, u, v, width) for field in (disc.light, disc.weights))
    inside = weights.mean(axis=(1, 2)) > _INSIDE
    u, v, light, weights = u[inside], v[inside], light[inside], weights[inside]
    hann = np.hanning(width + 2)[1:-1].astype(np.float32)
    fringes = _without_plane(light, weights * np.outer(hann, hann))
    length = int(fft.next_fast_len(2 * width) or 2 * width)
    parts = [_peaks(_power(fringes[at : at + _AT_A_TIME], length)) for at in range(0, len(fringes), _AT_A_TIME)]
    bins, share = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    slopes = bins / (length * disc.pixel)
    usable = (share > _SHARE) & (np.hypot(*bins.T) * width / length > _FRINGES)
    if usable.sum() < _LEAST * len(usable):
        usable[:] = False
    return Tiles(u[usable], v[usable], slopes[usable], share[usable], width * disc.pixel)


def _windows(field: np.ndarray, disc: Disc, u: np.ndarray, v: np.ndarray, width: int) -> np.ndarray:
    """Square cuts [n, width, width] around points; zero beyond the picture."""
    padded = np.pad(field, width)
    rows, columns = (
        np.round((points - axis[0]) / disc.pixel).astype(int) + width - width // 2
        for points, axis in ((v, disc.v), (u, disc.u))
    )
    views = np.lib.stride_tricks.sliding_window_view(padded, (width, width))
    limit = views.shape
    return views[np.clip(rows, 0, limit[0] - 1), np.clip(columns, 0, limit[1] - 1)]


def _without_plane(light: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """The windows times their weights, less the plane that fits each best."""
    count, width = light.shape[:2]
    axis = np.linspace(-1, 1, width, dtype=np.float32)
    plane = np.stack([np.ones((width, width), np.float32), *np.meshgrid(axis, axis)]).reshape(3, -1)
    flat, lit = weights.reshape(count, -1), light.reshape(count, -1)
    normal = np.einsum("np,ip,jp->nij", flat, plane, plane, optimize=True) + 1e-6 * np.eye(3, dtype=np.float32)
    right = (flat * lit) @ plane.T
    level = np.linalg.solve(normal, right[:, :, None])[:, :, 0] @ plane
    return (flat * (lit - level)).reshape(light.shape)


def _power(fringes: np.ndarray, length: int) -> np.ndarray:
    """The power [n, length, length / 2 + 1] of windows, padded with zeros."""
    return np.square(np.abs(np.asarray(fft.rfft2(fringes, (length, length)))))


def _peaks(power: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The strongest frequency of each window in bins along u and v [n, 2], and the share of the power about it."""
    count, length, half = power.shape
    # Whole columns beside the first stand for two.
    double = np.full(half, 2.0)
    double[0] = 1.0
    total = np.maximum((power * double).sum(axis=(1, 2)), 1e-30)
    place = power.reshape(count, -1).argmax(axis=1)
    row, column = place // half, place % half
    reach = np.arange(-_LOBE, _LOBE + 1)
    rows = (row[:, None, None] + reach[None, :, None]) % length
    columns = column[:, None, None] + reach[None, None, :]
    # Negative columns are those of the opposite frequency.
    mirrored = np.where(columns < 0, -rows % length, rows)
    lobe = power[np.arange(count)[:, None, None], mirrored, np.clip(np.abs(columns), 0, half - 1)]
    share = 2 * lobe.sum(axis=(1, 2)) / total
    middle = np.log(lobe[:, _LOBE, _LOBE] + 1e-30)
    shift = [
        _vertex(np.log(before + 1e-30), middle, np.log(after + 1e-30))
        for before, after in (
            (lobe[:, _LOBE, _LOBE - 1], lobe[:, _LOBE, _LOBE + 1]),
            (lobe[:, _LOBE - 1, _LOBE], lobe[:, _LOBE + 1, _LOBE]),
        )
    ]
    signed = np.where(row > length // 2, row - length, row)
    return np.column_stack([column + shift[0], signed + shift[1]]), np.minimum(share, 1.0)


def _vertex(before: np.ndarray, middle: np.ndarray, after: np.ndarray) -> np.ndarray:
    bend = before - 2 * middle + after
    return np.clip(np.where(bend < 0, (before - after) / 2 / np.where(bend < 0, bend, -1.0), 0.0), -0.5, 0.5)
