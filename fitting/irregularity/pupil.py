"""The pupil of a picture: the circle through the edge of its light."""

import numpy as np
from scipy import ndimage, optimize

from fitting.irregularity.disc import Pupil, sums_of
from fitting.photo import Photograph

# Longest side of the picture in which the edge is looked for [px]; rays from the middle; fringes are closed over
# this share of the side; an edge further from the circle than so many medians is none.
_SIDE, _RAYS, _CLOSED, _OUTLIER = 400, 240, 0.08, 4.0
# The dark ends where a ray last has this share of the light; its edge is at half of that which it has so much further
# in, as a share of the radius.
_FAINT, _FURTHER_IN = 0.15, 0.06
# Of a picture with this share of its pixels lit no edge is seen.
_FULL = 0.97


def usable_pixels(photograph: Photograph, has_mask: bool) -> np.ndarray:
    """The pixels that a form may use, [rows, columns]: those at the rim too, which a search for rings leaves out."""
    codes, mask = photograph.codes, photograph.mask
    if has_mask or not mask.any():
        return mask
    return mask | (~photograph.lit & codes.between(-np.inf, float(codes.light_where(mask).max())))


def pupil_of(photograph: Photograph) -> tuple[Pupil, float | None]:
    """The pupil and the standard deviation of its radius [px], the scatter of its edge about the circle.

    Without an edge the largest circle in the frame, and None: a form on it is one of that circle.
    """
    rows, columns = photograph.codes.shape
    if photograph.lit.mean() > _FULL:
        return Pupil((columns - 1) / 2, (rows - 1) / 2, (min(rows, columns) - 1) / 2), None
    factor = max(max(rows, columns) // _SIDE, 1)
    light, _ = photograph.codes.means(factor)
    blurred = ndimage.gaussian_filter(light, 1.0)
    size = max(int(_CLOSED * max(light.shape)), 3)
    # Dark fringes are filled, which a blur would let eat into the edge.
    even = ndimage.grey_closing(blurred, (size, size), mode="nearest")
    lit = sums_of(photograph.lit, factor) > factor**2 / 2
    high = float(np.median(even[lit]))
    low = float(np.percentile(even, 2))
    middle = np.array(ndimage.center_of_mass(lit))[::-1]
    x, y = _edges(even, middle, low, _FAINT * (high - low))
    circle, scatter = _circle(x, y, middle)
    centre = circle[:2] * factor + (factor - 1) / 2
    return Pupil(*map(float, (*centre, circle[2] * factor))), max(float(scatter) * factor, 0.5)


def _edges(light: np.ndarray, middle: np.ndarray, low: float, faint: float) -> tuple[np.ndarray, np.ndarray]:
    """Where rays from the middle fall to half of the light that they have a little further in; `low` is the dark.

    Light may be uneven: that of one ray says nothing of another's edge. Beyond its last light of `faint` a ray is dark.
    """
    angles = 2 * np.pi * np.arange(_RAYS) / _RAYS
    r = np.arange(0.0, max(light.shape), 0.5)
    x, y = (start + np.outer(wave(angles), r) for start, wave in zip(middle, (np.cos, np.sin), strict=True))
    inside = (x >= 0) & (x <= light.shape[1] - 1) & (y >= 0) & (y <= light.shape[0] - 1)
    values = np.where(inside, ndimage.map_coordinates(light, [y, x], order=1, mode="nearest"), np.inf) - low
    rays = np.arange(_RAYS)
    first = _last_fall(values, np.full(_RAYS, faint))
    level = values[rays, np.maximum((1 - _FURTHER_IN) * first, 0).astype(int)] / 2
    last = _last_fall(values, level)
    before, after = values[rays, last], values[rays, np.minimum(last + 1, len(r) - 1)]
    valid = (first > 0) & (last > 0) & np.isfinite(before) & np.isfinite(after) & (before > after)
    at = r[last[valid]] + 0.5 * (before - level)[valid] / (before - after)[valid]
    return middle[0] + at * np.cos(angles[valid]), middle[1] + at * np.sin(angles[valid])


def _last_fall(values: np.ndarray, level: np.ndarray) -> np.ndarray:
    """The last place of each ray before it falls below a level inside the frame; 0 where there is none."""
    falls = (values[:, :-1] >= level[:, None]) & (values[:, 1:] < level[:, None]) & np.isfinite(values[:, :-1])
    return np.where(falls.any(axis=1), falls.shape[1] - 1 - falls[:, ::-1].argmax(axis=1), 0)


def _circle(x: np.ndarray, y: np.ndarray, middle: np.ndarray) -> tuple[np.ndarray, float]:
    """Centre and radius of the circle through most points, and the scatter of those about it."""
    if len(x) < 8:
        return np.array([*middle, np.nan]), np.nan
    near = np.ones(len(x), bool)
    circle = np.array([*middle, np.median(np.hypot(x - middle[0], y - middle[1]))])
    for _ in range(4):
        fit = optimize.least_squares(
            lambda c, x=x[near], y=y[near]: np.hypot(x - c[0], y - c[1]) - c[2], circle, loss="soft_l1"
        )
        circle = fit.x
        distance = np.abs(np.hypot(x - circle[0], y - circle[1]) - circle[2])
        near = distance <= max(_OUTLIER * float(np.median(distance)), 0.25)
    residual = np.hypot(x[near] - circle[0], y[near] - circle[1]) - circle[2]
    return circle, float(np.sqrt(np.mean(np.square(residual))))
