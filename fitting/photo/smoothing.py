"""Views of an image that are quick to take: flattened, blurred, thinned, reduced."""

import functools

import numpy as np
from scipy import ndimage


def smooth(image: np.ndarray, width: float) -> np.ndarray:
    """A Gaussian blur of a standard deviation of many pixels, taken on a grid coarse enough to be quick."""
    factor = max(1, int(width / 4))
    padded = np.pad(image, [(0, -n % factor) for n in image.shape], mode="edge")
    small = ndimage.gaussian_filter(block_means(padded, factor), width / factor, mode="nearest")
    for axis, n in enumerate(image.shape):
        at = (np.arange(n) + 0.5) / factor - 0.5
        low = np.clip(np.floor(at).astype(int), 0, small.shape[axis] - 2) if small.shape[axis] > 1 else np.zeros(n, int)
        part = np.clip(at - low, 0, 1).reshape([-1 if a == axis else 1 for a in range(2)])
        high = np.minimum(low + 1, small.shape[axis] - 1)
        small = np.take(small, low, axis) * (1 - part) + np.take(small, high, axis) * part
    return small


def block_means(image: np.ndarray, factor: int) -> np.ndarray:
    """Means over blocks of so many pixels a side; what is left at the far edges is cut off."""
    if factor == 1:
        return image
    rows, columns = (n // factor * factor for n in image.shape)
    # Slices, added one by one: a mean over two short axes takes up to seven times as long.
    lines = functools.reduce(np.add, (image[k:rows:factor, :columns] for k in range(factor)))
    return functools.reduce(np.add, (lines[:, k::factor] for k in range(factor))) / factor**2
