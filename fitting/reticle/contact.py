"""Rings around and in a spot: what tells a lens's contact, and a lit field of fringes, from a disc."""

import numpy as np
from scipy import ndimage

# Sectors around the middle of the spot; samples in its radius, and from where to where it is looked at, in radii.
_SECTORS, _STEPS, _REACH = 32, 50, (0.1, 3.5)
# A swing of the light is of so much of its range; a disc has one, a ring two, the end of the lit field another one.
_SWING, _MOST_SWINGS = 0.25, 3
# Inside of a spot, out to so many radii, the light swings by so much of its range where fringes cross it: of discs and
# rings at most once in most directions, of a telephone's lit fields more than three times.
_INSIDE, _SWING_INSIDE = 0.94, 0.1
# Sectors that must be inside of the frame.
_SEEN = 8


def is_contact(image: np.ndarray, start: np.ndarray) -> bool:
    """Whether the light in most directions from the middle of a spot swings more often than that of a disc or a ring.

    `start`: x, y, radius, with which a fit of the disc starts.
    """
    light = _light(image, start)
    profile = np.nanmedian(light[:, np.isfinite(light).sum(axis=0) >= _SEEN], axis=0)
    return _swings(profile, _SWING * float(np.ptp(profile))) > _MOST_SWINGS


def is_field_of_fringes(image: np.ndarray, start: np.ndarray) -> bool:
    """Whether the light inside of a spot swings, in most directions, more often than that of a disc or a ring.

    `start`: x, y, radius, with which a fit of the disc starts. Each direction counts by itself: the middle of the
    fringes need not be that of the field.
    """
    light = _light(image, start)
    least = _SWING_INSIDE * float(np.nanmax(light) - np.nanmin(light))
    inside = light[:, : round((_INSIDE - _REACH[0]) * _STEPS)]
    profiles = inside[np.isfinite(inside).all(axis=1)]
    counts = [_swings(profile, least) for profile in profiles]
    return len(counts) >= _SEEN and float(np.median(counts)) > _MOST_SWINGS


def _light(image: np.ndarray, start: np.ndarray) -> np.ndarray:
    """The smoothed light [sector, distance] from the middle of a spot outwards; NaN outside of the frame."""
    x, y, radius = start[:3]
    reach = np.arange(_REACH[0], _REACH[1], 1 / _STEPS) * radius
    angle = 2 * np.pi * np.arange(_SECTORS) / _SECTORS
    rows, columns = y + reach * np.sin(angle)[:, None], x + reach * np.cos(angle)[:, None]
    smooth = ndimage.gaussian_filter(image, max(radius / _STEPS, 1.0))
    return ndimage.map_coordinates(smooth, [rows, columns], order=1, cval=np.nan)


def _swings(profile: np.ndarray, least: float) -> int:
    """How often a profile rises or falls by at least so much, in turns."""
    count, way, low, high = 0, 0, profile[0], profile[0]
    for level in profile:
        low, high = min(low, level), max(high, level)
        turn = 1 if way <= 0 and level - low > least else -1 if way >= 0 and high - level > least else 0
        if turn:
            count, way, low, high = count + 1, turn, level, level
    return count
