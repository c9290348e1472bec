"""A picture on its pupil: light, weights and the coordinates of the unit disc."""

from typing import NamedTuple

import numpy as np

# Light beyond this share of the pupil's radius is not used: the edge's own diffraction and blur lie there.
EDGE = 0.97


class Pupil(NamedTuple):
    """A circle in the image: `x`, `y` of its centre from the middle of the first pixel, and its `radius` [px]."""

    x: float
    y: float
    radius: float

    def reduced(self, factor: int) -> "Pupil":
        """The same circle in block means over `factor` x `factor` pixels."""
        shift = (factor - 1) / 2
        return Pupil((self.x - shift) / factor, (self.y - shift) / factor, self.radius / factor)


class Disc(NamedTuple):
    """The pixels around a pupil, with its coordinates.

    - `light` [rows, columns], float32, its mean over the disc taken out, in units of its standard deviation there.
    - `weights` [rows, columns], float32: 1 where a pixel is used, 0 where not.
    - `u` [columns], `v` [rows]: from -1 to 1 over the pupil.
    - `pixel`: the side of a pixel in pupil radii.
    """

    light: np.ndarray
    weights: np.ndarray
    u: np.ndarray
    v: np.ndarray
    pixel: float

    @property
    def pixels(self) -> float:
        """How many pixels are used."""
        return float(self.weights.sum(dtype=float))


def disc_of(image: np.ndarray, mask: np.ndarray, pupil: Pupil, edge: float = EDGE) -> Disc:
    """The disc of a picture [rows, columns] within `edge` pupil radii; pixels that `mask` leaves out weigh nothing."""
    rows, columns = (
        slice(max(int(np.ceil(middle - pupil.radius)), 0), max(min(int(middle + pupil.radius) + 1, size), 0))
        for middle, size in zip((pupil.y, pupil.x), image.shape, strict=True)
    )
    u = (np.arange(columns.start, columns.stop) - pupil.x) / pupil.radius
    v = (np.arange(rows.start, rows.stop) - pupil.y) / pupil.radius
    inside = np.square(v)[:, None] + np.square(u) <= edge**2
    used = inside & mask[rows, columns]
    light = np.where(used, image[rows, columns], 0.0).astype(np.float32)
    count = max(int(used.sum()), 1)
    mean = light.sum(dtype=float) / count
    spread = np.sqrt(max(np.square(light, dtype=float).sum() / count - mean**2, 1e-30))
    light = np.where(used, (light - np.float32(mean)) / np.float32(spread), np.float32(0.0))
    return Disc(light, used.astype(np.float32), u, v, 1 / pupil.radius)


def reduced(image: np.ndarray, mask: np.ndarray, factor: int) -> tuple[np.ndarray, np.ndarray]:
    """Means over blocks of `factor` x `factor` pixels, and which blocks hold used pixels for more than half."""
    if factor == 1:
        return image, mask
    rows, columns = (size // factor * factor for size in image.shape)
    used = mask[:rows, :columns]
    counts = sums_of(used, factor)
    sums = sums_of(np.where(used, image[:rows, :columns], image.dtype.type(0)), factor)
    return sums / np.maximum(counts, 1), counts > factor * factor / 2


def sums_of(values: np.ndarray, factor: int, dtype: type | None = None) -> np.ndarray:
    """Sums over blocks of `factor` x `factor`, what is beyond the last whole block left out; of True a count.

    Rows are added first, along which the memory lies: a tenth of the time of both at once.
    """
    rows, columns = (size // factor for size in values.shape)
    strips = values[: rows * factor, : columns * factor].reshape(rows, factor, columns * factor)
    is_short = values.dtype == bool and factor <= np.iinfo(np.uint8).max
    added = strips.view(np.uint8).sum(axis=1, dtype=np.uint8) if is_short else strips.sum(axis=1, dtype=dtype)
    return added.reshape(rows, columns, factor).sum(axis=2)


def around(image: np.ndarray, mask: np.ndarray, pupil: Pupil) -> tuple[np.ndarray, np.ndarray, Pupil]:
    """Picture, mask and pupil of the square about the pupil alone: a form costs what is lit, not the frame."""
    box, square = square_about(pupil)
    return image[box], mask[box], square


def square_about(pupil: Pupil) -> tuple[tuple[slice, slice], Pupil]:
    """Rows and columns about a pupil, and the pupil there."""
    rows, columns = (
        slice(max(int(middle - pupil.radius), 0), max(int(middle + pupil.radius) + 2, 0))
        for middle in (pupil.y, pupil.x)
    )
    return (rows, columns), Pupil(pupil.x - columns.start, pupil.y - rows.start, pupil.radius)
