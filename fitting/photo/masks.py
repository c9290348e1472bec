"""Masks as users give them."""

from pathlib import Path

import numpy as np

from fitting.photo.arrays import array_of
from fitting.photo.image_file import load


def checked_mask(mask: str | Path | np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """A mask from an array, or from an image file: True where it is brighter than half of its brightest pixel.

    Black is not 0 in a JPEG, whose edges ring by some codes.

    Raises FileNotFoundError, and ValueError for what is no mask of that shape.
    """
    if isinstance(mask, str | Path):
        codes = load(mask).codes
        grey = codes if codes.ndim == 2 else codes[:, :, : 3 if codes.shape[2] >= 3 else 1].max(axis=2)
        usable = grey > grey.max() / 2
    else:
        usable = array_of(mask, "mask").astype(bool)
    if usable.shape != shape:
        raise ValueError(f"mask has shape {usable.shape}; allowed: the image's, {shape}")
    return usable
