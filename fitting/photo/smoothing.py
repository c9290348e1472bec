"""Views of an image that are quick to take: flattened, blurred, thinned, reduced."""

import functools

import numpy as np
from numpy.polynomial.chebyshev import chebvander
from scipy import ndimage


def flatten(image: np.ndarray, mask: np.ndarray, window: tuple[np.ndarray, np.ndarray] | None = None) -> np.ndarray:
    """Fringes alone: a masked polynomial background taken off, the local strength divided out, a soft window on.

    Zero where masked. The background has degree 4: with less, a bright middle passes for the first ring. `window`: of
    the rows and of the columns; without it the image's edges are softened.
    """
    rows, columns = image.shape
    sample = thin(mask, 40_000)
    step = sample[0].step
    used = mask[sample]
    design_y, design_x = (chebvander(np.linspace(-1, 1, n), 4) for n in (rows, columns))
    pairs = [(j, i) for j in range(5) for i in range(5 - j)]
    design = np.stack([np.outer(design_y[::step, j], design_x[::step, i])[used] for j, i in pairs])
    weights = np.zeros((5, 5))
    # Normal equations do for a start; a least norm where the mask leaves the polynomial undetermined.
    weights[tuple(np.transpose(pairs))] = np.linalg.lstsq(design @ design.T, design @ image[sample][used], rcond=1e-12)[
        0
    ]
    fringes = np.where(mask, image - design_y @ weights @ design_x.T, 0.0)
    width = min(rows, columns) / 8
    power = smooth(fringes**2, width) / (smooth(mask.astype(float), width) + 1e-6)
    floor = 0.05 * np.median(power[mask])
    down, across = window or (taper(rows), taper(columns))
    return (fringes / np.sqrt(np.maximum(power, 0) + floor + 1e-30) * down[:, None] * across).astype(np.float32)


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


def taper(n: int) -> np.ndarray:
    """A window of so many pixels that rises from 0 to 1 over 8 % of them at either end."""
    edge = np.clip(np.minimum(np.arange(n) + 0.5, n - np.arange(n) - 0.5) / (0.08 * n), 0, 1)
    return np.sin(np.pi / 2 * edge) ** 2


def thin(mask: np.ndarray, pixels: int = 200_000) -> tuple[slice, slice]:
    """Every so many rows and columns, so that about so many of a mask's pixels are left for a statistic."""
    step = max(1, int(np.sqrt(np.count_nonzero(mask) / pixels)))
    return slice(None, None, step), slice(None, None, step)


def median(values: np.ndarray) -> float:
    """The middle one of values, the upper one of an even number: in a third of the time that both take."""
    middle = values.size // 2
    return float(np.partition(values, middle, axis=None)[middle]) if values.size else float("nan")


def pixels_of(mask: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Columns and rows of some of a mask's pixels, spread over all of it."""
    sample = thin(mask, 20_000)
    rows, columns = np.nonzero(mask[sample])
    return columns * sample[1].step, rows * sample[0].step


def block_means(image: np.ndarray, factor: int) -> np.ndarray:
    """Means over blocks of so many pixels a side; what is left at the far edges is cut off."""
    if factor == 1:
        return image
    rows, columns = (n // factor * factor for n in image.shape)
    # Slices, added one by one: a mean over two short axes takes up to seven times as long.
    lines = functools.reduce(np.add, (image[k:rows:factor, :columns] for k in range(factor)))
    return functools.reduce(np.add, (lines[:, k::factor] for k in range(factor))) / factor**2


def noise_variance(image: np.ndarray, mask: np.ndarray) -> float:
    """Variance of a pixel's noise, from differences of four neighbours: whatever is smooth drops out."""
    four = image[1:, 1:] - image[1:, :-1] - image[:-1, 1:] + image[:-1, :-1]
    unmasked = mask[1:, 1:] & mask[1:, :-1] & mask[:-1, 1:] & mask[:-1, :-1]
    if unmasked.sum() < 16:
        return 0.0
    return float(1.4826 * median(np.abs(four[unmasked]))) ** 2 / 4
