"""Rings around and in a spot: what tells a lens's contact from a disc."""

import numpy as np
from scipy import ndimage

# Sectors around the middle of the spot; samples in its radius, and from where to where it is looked at, in radii.
_SECTORS, _STEPS, _REACH = 32, 50, (0.1, 3.5)
# A swing of the light is of so much of its range; a disc has one, a ring two, the end of the lit field another one.
_SWING, _MOST_SWINGS = 0.25, 3
# Sectors that must be inside of the frame.
_SEEN = 8


def is_contact(image: np.ndarray, start: np.ndarray) -> bool:
    """Whether the light in most directions from the middle of a spot swings more often than that of a disc or a ring.

    `start`: x, y, radius, with which a fit of the disc starts.
    """
    x, y, radius = start[:3]
    reach = np.arange(_REACH[0], _REACH[1], 1 / _STEPS) * radius
    angle = 2 * np.pi * np.arange(_SECTORS) / _SECTORS
    rows, columns = y + reach * np.sin(angle)[:, None], x + reach * np.cos(angle)[:, None]
    smooth = ndimage.gaussian_filter(image, max(radius / _STEPS, 1.0))
    light = ndimage.map_coordinates(smooth, [rows, columns], order=1, cval=np.nan)
    profile = np.nanmedian(light[:, np.isfinite(light).sum(axis=0) >= _SEEN], axis=0)
    return _swings(profile, _SWING * float(np.ptp(profile))) > _MOST_SWINGS


def _swings(profile: np.ndarray, least: float) -> int:
    """How often a profile rises or falls by at least so much, in turns."""
    count, way, low, high = 0, 0, profile[0], profile[0]
    for level in profile:
        low, high = min(low, level), max(high, level)
        turn = 1 if way <= 0 and level - low > least else -1 if way >= 0 and high - level > least else 0
        if turn:
            count, way, low, high = count + 1, turn, level, level
    return count
