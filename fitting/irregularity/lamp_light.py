"""A picture of the light without fringes, and a picture of fringes with that light taken out."""

from typing import Any, NamedTuple

import numpy as np
from scipy import ndimage

from fitting.irregularity.disc import Pupil
from fitting.photo import read
from fitting.plate_reasons import PlateReason

# The lamp's picture is smoothed so far [px]; darker than this share of its median it is left out.
_SMOOTH, _DARK = 2.0, 0.1
# What may have changed in the light from one picture to the next, as a share.
CHANGE_SD = 0.005


class Lamp(NamedTuple):
    """A picture of the light, and how it is read."""

    picture: Any
    transfer: Any
    page: int | None


def without_lamp(
    image: np.ndarray, usable: np.ndarray, pupil: Pupil, lamp: Lamp, warnings: list[str]
) -> tuple[np.ndarray, np.ndarray, float]:
    """The picture over its light, the pixels that may be used, and how uneven the light still is.

    Raises ValueError where the two pictures have other shapes.
    """
    light = read(lamp.picture, lamp.transfer, None, lamp.page).image
    if light.shape != image.shape:
        raise ValueError(
            f"light_picture has {light.shape} pixels, the picture {image.shape}; give one of the same camera"
        )
    rows, columns = np.indices(image.shape)
    inside = np.hypot(columns - pupil.x, rows - pupil.y) <= pupil.radius
    # Dark beyond the rim is not smoothed into the aperture.
    lit = ndimage.gaussian_filter(np.where(inside, light, 0.0), _SMOOTH)
    lit = lit / np.maximum(ndimage.gaussian_filter(inside.astype(float), _SMOOTH), 1e-3)
    middle = float(np.median(lit[inside])) if inside.any() else 1.0
    bright = lit > _DARK * middle
    share = float(1 - bright[inside].mean()) if inside.any() else 0.0
    if share > 0:
        warnings.append(PlateReason.PLATE_LIGHT_DARK(share=share))
    even = image * middle / np.where(bright & inside, lit, middle)
    return even, usable & (bright | ~inside), CHANGE_SD
