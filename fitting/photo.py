"""Photographs: from a file or an array to a linear grey image, a mask, and what was decided on the way."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy import ndimage

from fitting.image_file import load
from fitting.smoothing import reduce, smooth, thin

_CHANNELS = ("red", "green", "blue")
# A code this near the top of its range no longer follows the light.
_SATURATED = 0.98


@dataclass(frozen=True)
class Photograph:
    """An image made ready for a fit.

    - `image` [rows, columns]: linear in the light, largest unmasked value about 1.
    - `mask` [rows, columns]: True where a pixel may be used.
    - `lit` [rows, columns]: as `mask`, with saturated pixels: bright they are, and a search that took them for nothing
      would find the rings of the mask.
    - `channel`: which was taken; `transfer`: how codes became light; `warnings`: what a person should know.
    """

    image: np.ndarray
    mask: np.ndarray
    lit: np.ndarray
    channel: str
    transfer: str
    warnings: list[str] = field(default_factory=list)


def read(
    source: str | Path | np.ndarray, transfer: str | float | None = None, mask: np.ndarray | None = None
) -> Photograph:
    """A photograph from a file or an array [rows, columns] or [rows, columns, channels].

    Without `transfer`, 8-bit codes are taken as sRGB, 16-bit files and floats as linear; it may be "linear", "srgb" or
    an exponent. Of a colour image the channel with most fringe contrast over noise that is not saturated is taken.
    Masked are pixels that are saturated (at the top of the type, or where codes pile up below it), outside of the lit
    field, transparent, masked in the array, far outside of all others (hot or dead), and where `mask` is False.

    Raises FileNotFoundError, and ValueError for what is no image.
    """
    picture = np.ma.asarray(load(source) if isinstance(source, str | Path) else source)
    planes, top = _planes(picture.data)
    curve, name = _transfer(transfer, top)
    count = planes.shape[2]
    channel = max(range(count), key=lambda c: _merit(planes[:, :, c], top)) if count > 1 else 0
    code = planes[:, :, channel]
    saturated = code >= min(_SATURATED * top, _pile_up(code))
    light = curve(np.where(np.isfinite(code), code, 0.0) / (top if np.isfinite(top) else 1.0))
    lit = np.isfinite(code) & _opaque(picture)
    lit &= ~_wild(light, lit) & _lit(light)
    warnings = []
    if mask is not None:
        mask = np.asarray(mask, dtype=bool)
        if mask.shape != code.shape:
            raise ValueError(f"mask has shape {mask.shape}; allowed: the image's, {code.shape}")
        lit &= mask
    usable = lit & ~saturated
    share = float(np.mean(saturated))
    if share > 0.02:
        warnings.append(f"{share:.0%} of the pixels are saturated and were left out; expose less")
    sample = thin(usable)
    known = light[sample][usable[sample]]
    scale = float(np.percentile(known, 99.5)) if known.size else 0.0
    labels = _CHANNELS if planes.shape[2] == 3 else ("grey",)
    return Photograph(light / (scale or 1.0), usable, lit, labels[channel], name, warnings)


def read_mask(path: str | Path) -> np.ndarray:
    """A mask from an image file: True where it is not black. Raises FileNotFoundError, and ValueError for no image."""
    codes = np.asarray(load(path))
    return codes > 0 if codes.ndim == 2 else np.any(codes[:, :, : 3 if codes.shape[2] >= 3 else 1] > 0, axis=2)


def _opaque(picture: np.ma.MaskedArray) -> np.ndarray:
    """False where an alpha channel is 0, or a masked array is masked."""
    hidden = np.ma.getmaskarray(picture)
    hidden = hidden if picture.ndim == 2 else np.any(hidden, axis=2)
    return ~hidden & (picture.data[:, :, -1] > 0) if picture.ndim == 3 and picture.shape[2] in (2, 4) else ~hidden


def _pile_up(code: np.ndarray) -> float:
    """The code at which light piled up, below the top of its type (12 bits in 16, a clipped array); else infinite.

    At an unclipped crest the last two codes hold pixels as sqrt(1) to sqrt(2) - sqrt(1).
    """
    code = code[thin(np.isfinite(code))]
    known = code[np.isfinite(code)]
    if known.size == 0:
        return np.inf
    at = known == known.max()
    below = known[~at]
    if at.mean() < 0.02 or below.size == 0:
        return np.inf
    return float(known.max()) if at.sum() > 6 * (below == below.max()).sum() else np.inf


def _wild(light: np.ndarray, lit: np.ndarray) -> np.ndarray:
    """Pixels further outside of the middle 99 % than these are wide: hot, dead or struck ones, which no rings make."""
    sample = thin(lit, 40_000)
    if not lit[sample].any():
        return np.zeros(light.shape, bool)
    low, high = np.percentile(light[sample][lit[sample]], [0.5, 99.5])
    if high == low:
        return np.zeros(light.shape, bool)
    return (light > 2 * high - low) | (light < 2 * low - high)


def _planes(raw: np.ndarray) -> tuple[np.ndarray, float]:
    if raw.ndim not in (2, 3) or min(raw.shape[:2]) < 16:
        raise ValueError(
            f"an image of shape {raw.shape} was given; allowed: [rows, columns] or with channels, 16 pixels up"
        )
    if raw.ndim == 3 and raw.shape[2] not in (1, 2, 3, 4):
        raise ValueError(f"an image with {raw.shape[2]} channels was given; allowed: 1 to 4")
    if not (np.issubdtype(raw.dtype, np.integer) or np.issubdtype(raw.dtype, np.floating)):
        raise ValueError(f"an image of type {raw.dtype} was given; allowed: integers or floats")
    top = _top(raw)
    planes = raw[:, :, None] if raw.ndim == 2 else raw[:, :, : 3 if raw.shape[2] >= 3 else 1]
    planes = planes.astype(float)
    if (
        planes.shape[2] == 3
        and np.array_equal(planes[..., 0], planes[..., 1])
        and np.array_equal(planes[..., 1], planes[..., 2])
    ):
        planes = planes[:, :, :1]
    return planes, top


def _top(raw: np.ndarray) -> float:
    """The largest code of an integer image: of 8 bits or 16, by its type, or by its values where that is wider."""
    if not np.issubdtype(raw.dtype, np.integer):
        return np.inf
    if raw.dtype.itemsize <= 2:
        return float(np.iinfo(raw.dtype).max)
    return 255.0 if raw.max() <= 255 else 65535.0 if raw.max() <= 65535 else float(np.iinfo(raw.dtype).max)


def _transfer(transfer: str | float | None, top: float):
    if transfer is None:
        transfer = "srgb" if top <= 255 else "linear"
    if transfer == "linear":
        return (lambda code: code), "linear"
    if transfer == "srgb":
        # IEC 61966-2-1: linear below 0.04045, else ((c + 0.055) / 1.055)^2.4.
        return (lambda c: np.where(c <= 0.04045, c / 12.92, ((np.maximum(c, 0.04045) + 0.055) / 1.055) ** 2.4)), "srgb"
    try:
        exponent = float(transfer)
    except (TypeError, ValueError):
        exponent = np.nan
    if not 0.1 <= exponent <= 10:
        raise ValueError(f"transfer is {transfer!r}; allowed: 'linear', 'srgb', or an exponent from 0.1 to 10")
    return (lambda code: np.maximum(code, 0.0) ** exponent), f"exponent {exponent:g}"


def _merit(plane: np.ndarray, top: float) -> float:
    """Contrast at fringe scales over pixel noise, less what is saturated."""
    plane = np.nan_to_num(plane)
    reduced = plane[: plane.shape[0] // 2 * 2, : plane.shape[1] // 2 * 2]
    reduced = (reduced[::2, ::2] + reduced[1::2, ::2] + reduced[::2, 1::2] + reduced[1::2, 1::2]) / 4
    band = ndimage.gaussian_filter(reduced, 1.0) - ndimage.gaussian_filter(reduced, max(reduced.shape) / 25)
    contrast = np.percentile(np.abs(band), 75)
    noise = np.median(np.abs(np.diff(reduced, axis=1) - np.roll(np.diff(reduced, axis=1), 1, axis=0))) / 2
    saturated = np.mean(plane >= _SATURATED * top)
    return float(contrast / (noise + 0.02 * contrast + 1e-30) * np.sqrt(contrast) * (1 - saturated) ** 4)


def _lit(light: np.ndarray) -> np.ndarray:
    """The part of the frame inside the field stop: everything, unless one bright region stands in a dark surround.

    Wide dark rings are no surround: there are other bright ones beyond them, or the dark is a small part of the frame,
    or it is far from even (numbers from real stops and from rendered rings of 0.1 to 10 m).
    """
    from skimage.filters import threshold_otsu

    everything = np.ones(light.shape, bool)
    width = max(2.0, min(light.shape) / 40)
    factor = max(1, int(width / 4))
    width /= factor
    blurred = smooth(reduce(light, factor), width)
    if np.ptp(blurred) == 0:
        return everything
    bright = blurred > threshold_otsu(blurred)
    high, low = blurred[bright].mean(), blurred[~bright].mean()
    field = _largest(np.asarray(ndimage.binary_fill_holes(bright)))
    dark = np.asarray(ndimage.binary_erosion(~field, iterations=round(2 * width), border_value=1), bool)
    if low > 0.5 * high or dark.mean() < 0.15 or (bright & ~field).sum() > 0.01 * bright.sum():
        return everything
    if np.subtract(*np.percentile(blurred[dark], [90, 10])) > 0.65 * (high - low):
        return everything
    # Near halfway down the edge lies the stop; the blur's width further in, light is no longer cut.
    field = _largest(np.asarray(ndimage.binary_fill_holes(blurred > low + 0.35 * (high - low))))
    field = ndimage.binary_erosion(field, iterations=round(width), border_value=1)
    rows, columns = (np.minimum(np.arange(n) // factor, m - 1) for n, m in zip(light.shape, field.shape, strict=True))
    return field[np.ix_(rows, columns)]


def _largest(field: np.ndarray) -> np.ndarray:
    labels = np.zeros(field.shape, np.int32)
    ndimage.label(field, output=labels)
    count = int(labels.max())
    if count < 2:
        return field
    return labels == 1 + int(np.argmax(ndimage.sum_labels(field, labels, range(1, count + 1))))
