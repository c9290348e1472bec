"""Arrays of any kind as channels of codes, with what is masked in them."""

from typing import Any, NamedTuple

import numpy as np
from scipy import ndimage

from fitting.photo.codes import SATURATED
from fitting.photo.smoothing import smooth
from newtonjax.numerics import shown

_ALLOWED = "an array of real numbers, [rows, columns] or with 1 to 4 channels, 16 pixels up"
_FEWEST = 16
# Two levels are looked for in every so many-th row and column before all are compared.
_SAMPLED = 37
_LARGEST = 1e15
# Channels are compared on so many blocks of 2 x 2 pixels to a side.
_COMPARED = 720


class Planes(NamedTuple):
    """Codes [rows, columns, channels] of an image, and what they can be.

    - `visible`: False where an alpha channel is 0 or the array is masked, [rows, columns].
    - `top`: the largest code there may be; infinite for floats, and for two levels, which are 0 and 1.
    - `channels`: how many differ and hold light: 1 or 3.
    - `may_be_bytes`: whether integers of more than 16 bits hold none above 255: counts of light, or codes of 8 bits.
    """

    codes: np.ndarray
    visible: np.ndarray
    top: float
    channels: int
    may_be_bytes: bool = False

    @property
    def has_two_levels(self) -> bool:
        """Whether the image is one of two levels."""
        return np.issubdtype(self.codes.dtype, np.integer) and not np.isfinite(self.top)


def array_of(source: Any, name: str) -> np.ndarray:
    """A plain array of numbers out of what was given, of its values alone.

    Raises ValueError for ragged lists, text, complex numbers, Python's objects, and what has no values.
    """
    try:
        # Subclasses have sides of their own: a matrix of NumPy has two, whatever it is indexed with.
        array = np.asarray(source.data if isinstance(source, np.ma.MaskedArray) else source)
    except (ValueError, TypeError) as error:
        raise ValueError(f"{name} is {_kind(source)} that makes no array; allowed: {_ALLOWED}") from error
    kind = array.dtype
    if not (np.issubdtype(kind, np.integer) or np.issubdtype(kind, np.floating) or kind.kind == "b"):
        raise ValueError(f"{name} is {_kind(source)} of type {str(kind)[:40]}; allowed: {_ALLOWED}")
    return array


def planes_of(source: Any) -> Planes:
    """The channels of an array: integers, floats, or True and False; a masked array's mask goes with them.

    Raises ValueError for anything else.
    """
    raw = array_of(source, "image")
    if raw.ndim not in (2, 3) or min(raw.shape[:2]) < _FEWEST:
        raise ValueError(f"an image of shape {raw.shape} was given; allowed: {_ALLOWED}")
    if raw.ndim == 3 and raw.shape[2] not in (1, 2, 3, 4):
        raise ValueError(f"an image with {raw.shape[2]} channels was given; allowed: 1 to 4")
    codes = raw[:, :, None] if raw.ndim == 2 else raw
    if np.issubdtype(codes.dtype, np.floating) and codes.dtype.itemsize not in (4, 8):
        codes = codes.astype(np.float32 if codes.dtype.itemsize < 4 else np.float64)
    _refuse_beyond_single(codes)
    visible = _visible(source, codes)
    channels = 3 if codes.shape[2] >= 3 and not _is_grey(codes) else 1
    if channels == 1 and (levels := _two_levels(codes[:, :, 0])) is not None:
        return Planes((codes[:, :, :1] == levels[1]).view(np.uint8), visible, np.inf, 1)
    is_wide = np.issubdtype(codes.dtype, np.integer) and codes.dtype.itemsize > 2
    return Planes(codes, visible, _top(codes), channels, is_wide and bool(codes.max() <= 255))


def _refuse_beyond_single(codes: np.ndarray) -> None:
    """Raise ValueError for numbers so large that light in 32 bits, and its squares, would overflow."""
    if codes.dtype == np.float64:
        largest = max(abs(extreme(codes, where=np.isfinite(codes), initial=0.0)) for extreme in (np.min, np.max))
        if largest > _LARGEST:
            raise ValueError(f"the image holds numbers up to {largest:.2g} in size; allowed: up to {_LARGEST:g}")


def _kind(source: Any) -> str:
    return f"an array of shape {source.shape}" if hasattr(source, "shape") else shown(source)


def _visible(source: Any, codes: np.ndarray) -> np.ndarray:
    visible = np.ones(codes.shape[:2], bool)
    if isinstance(source, np.ma.MaskedArray) and source.mask is not np.ma.nomask:
        masked = np.asarray(np.ma.getmaskarray(source))
        visible &= ~(masked if masked.ndim == 2 else np.any(masked, axis=2))
    if codes.shape[2] in (2, 4):
        visible &= codes[:, :, -1] > 0
    return visible


def _is_grey(codes: np.ndarray) -> bool:
    """Whether three channels are one; a few rows tell it of most images."""
    for part in (codes[::64], codes):
        red, green, blue = (part[:, :, k] for k in range(3))
        if not (np.array_equal(red, green) and np.array_equal(green, blue)):
            return False
    return True


def _two_levels(plane: np.ndarray) -> tuple[Any, Any] | None:
    """The two values that integers or truths take; None for one, for more and for floats."""
    if np.issubdtype(plane.dtype, np.floating):
        return None
    levels = np.unique(plane[::_SAMPLED, ::_SAMPLED])
    if len(levels) > 2:
        return None
    low, high = plane.min(), plane.max()
    if low == high or not np.all((plane == low) | (plane == high)):
        return None
    return low, high


def _top(codes: np.ndarray) -> float:
    """The largest code of an integer image: by its type, or of 16 bits where that is wider and none is larger."""
    if not np.issubdtype(codes.dtype, np.integer):
        return np.inf
    if codes.dtype.itemsize <= 2:
        return float(np.iinfo(codes.dtype).max)
    return 65535.0 if codes.max() <= 65535 else float(np.iinfo(codes.dtype).max)


def clearest_channel(planes: Planes) -> int:
    """The channel with most fringe contrast over noise that is not saturated."""
    channels = range(planes.channels)
    return max(channels, key=lambda c: _merit(planes.codes[:, :, c], planes.top)) if planes.channels > 1 else 0


def _merit(plane: np.ndarray, top: float) -> float:
    """Contrast at fringe scales over pixel noise, less what is saturated; on every so many-th block of 2 x 2."""
    step = 2 * max(1, max(plane.shape) // _COMPARED)
    rows, columns = (n // 2 * 2 for n in plane.shape)
    corners = [plane[j:rows:step, i:columns:step] for j in (0, 1) for i in (0, 1)]
    saturated = np.mean([np.mean(~below(corner, SATURATED * top)) for corner in corners])
    blocks = np.mean([np.nan_to_num(corner.astype(np.float32)) for corner in corners], axis=0)
    band = ndimage.gaussian_filter(blocks, 1.0) - smooth(blocks, max(blocks.shape) / 25)
    contrast = np.percentile(np.abs(band), 75)
    slope = np.diff(blocks, axis=1)
    noise = np.median(np.abs(slope[1:] - slope[:-1])) / 2
    return float(contrast / (noise + 0.02 * contrast + 1e-30) * np.sqrt(contrast) * (1 - saturated) ** 4)


def below(plane: np.ndarray, level: float) -> np.ndarray:
    """Where codes are below a level; of integers without a copy of them as floats."""
    if not np.isfinite(level):
        return ~(plane >= level)
    return ~(plane >= (np.ceil(level).astype(plane.dtype) if np.issubdtype(plane.dtype, np.integer) else level))
