"""One channel of a photograph as its codes, the linear light that they stand for, and which of them are usable."""

import functools
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import ndimage

from fitting.photo.smoothing import smooth

# Rows of light that are made at a time: a band stays in the processor's cache.
_BAND = 64
# A code this near the top of its range no longer follows the light.
SATURATED = 0.98
# The stop's edge is where light has fallen to this share of the field's; where this has fallen to that share of its
# brightest part, it ends without one.
_EDGE, _FAINTEST = 0.35, 0.08
# A surround is black to this share of the light, over this share of the frame, and no narrower than one part in so many
# of it: of 300 made frames full of rings of 1.5 orders and more at most 0.143 of one is so (of one order 0.2).
_BLACK, _SURROUND, _NARROWEST = 0.03, 0.19, 16
# What is near the edge: widths of the blur, and the least share of the field in it; and rounds that look for more.
_NEARBY, _BESIDE, _ROUNDS = 5.0, 0.02, 12


@dataclass(frozen=True)
class Curve:
    """Linear light of a code: the code over `top`, through sRGB (`exponent` None) or a power, over `unit`.

    `fitted`: an exponent found from the fringes, on top of that.
    """

    top: float
    exponent: float | None
    unit: float = 1.0
    fitted: float = 1.0

    def __call__(self, codes: np.ndarray) -> np.ndarray:
        """Light of codes, float64, of their shape; 0 for a code that is no number."""
        share = codes.astype(float)
        if not np.issubdtype(codes.dtype, np.integer):
            share[~np.isfinite(share)] = 0.0
        share /= self.top
        if self.exponent is None:
            # IEC 61966-2-1: linear below 0.04045, else ((c + 0.055) / 1.055)^2.4.
            bent = ((np.maximum(share, 0.04045) + 0.055) / 1.055) ** 2.4
            light = np.where(share <= 0.04045, share / 12.92, bent)
        else:
            light = share if self.exponent == 1.0 else np.maximum(share, 0.0) ** self.exponent
        light = light / self.unit
        return light if self.fitted == 1.0 else np.sign(light) * np.abs(light) ** self.fitted


@dataclass(frozen=True)
class Codes:
    """The codes [rows, columns] of one channel, of any integer or float type, and the curve that makes them light.

    Codes of 8 and 16 bits become light through a table of all of them.
    """

    codes: np.ndarray
    curve: Curve

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        rows, columns = self.codes.shape
        return rows, columns

    def light(self, part=(slice(None), slice(None))) -> np.ndarray:
        """Light of a part of the codes, named by slices, float64."""
        codes = self.codes[part]
        return self.curve(codes) if self._table is None else self._table[codes.view(self._index)]

    def light_where(self, mask: np.ndarray, part=(slice(None), slice(None))) -> np.ndarray:
        """Light of the pixels of a part where a mask of its shape is True, float64."""
        return Codes(self.codes[part][mask][:, None], self.curve).light()[:, 0]

    def rows(self, start: int, stop: int, columns: slice = slice(None)) -> np.ndarray:
        """Light of a band of rows, float32 [rows, columns]."""
        codes = self.codes[start:stop, columns]
        if self._single is None:
            return self.curve(codes).astype(np.float32)
        # In half the time of an index.
        return np.take(self._single, codes.view(self._index))

    def whole(self) -> np.ndarray:
        """Light of all codes, float32 [rows, columns]."""
        light = np.empty(self.shape, np.float32)
        for start in range(0, self.shape[0], _BAND):
            light[start : start + _BAND] = self.rows(start, start + _BAND)
        return light

    def between(self, low: float, high: float) -> np.ndarray:
        """Where the light lies between two levels, bool [rows, columns]."""
        if self._table is not None:
            inside = (self._table >= low) & (self._table <= high)
            return np.ones(self.shape, bool) if inside.all() else inside[self.codes.view(self._index)]
        bands = [self.curve(self.codes[k : k + _BAND]) for k in range(0, self.shape[0], _BAND)]
        return np.concatenate([(band >= low) & (band <= high) for band in bands])

    def means(
        self, factor: int, box: tuple[slice, slice] = (slice(None), slice(None)), mask: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Mean light over a mask's pixels in blocks of `factor` to a side, and the share of these in each block.

        The blocks [rows, columns], float64, begin at the box's corner; what is left at its far edges is cut off. A
        block without any has a mean of 0.
        """
        (top, bottom, _), (first, last, _) = (part.indices(n) for part, n in zip(box, self.shape, strict=True))
        rows, columns = (bottom - top) // factor, (last - first) // factor
        across = slice(first, first + columns * factor)
        sums, counts = np.empty((rows, columns)), np.full((rows, columns), float(factor**2))
        step = max(1, _BAND // factor)
        for start in range(0, rows, step):
            low, high = (top + factor * min(k, rows) for k in (start, start + step))
            light = self.rows(low, high, across)
            if mask is not None:
                used = mask[low:high, across]
                light *= used
                counts[start : start + step] = _sums(used.view(np.uint8), factor, np.uint16)
            sums[start : start + step] = _sums(light, factor, np.float32)
        return sums / np.maximum(counts, 1.0), counts / factor**2

    def is_uniform(self, mask: np.ndarray) -> bool:
        """Whether all codes where a mask is True are one; a sample tells it of most photographs."""
        sample = thin(mask)
        return _is_one(self.codes[sample][mask[sample]]) and _is_one(self.codes[mask])

    @property
    def _index(self) -> type:
        return np.uint8 if self.codes.dtype.itemsize == 1 else np.uint16

    @cached_property
    def _table(self) -> np.ndarray | None:
        if not np.issubdtype(self.codes.dtype, np.integer) or self.codes.dtype.itemsize > 2:
            return None
        every = np.arange(2 ** (8 * self.codes.dtype.itemsize), dtype=self._index)
        return self.curve(every.view(self.codes.dtype))

    @cached_property
    def _single(self) -> np.ndarray | None:
        return None if self._table is None else self._table.astype(np.float32)


def _sums(band: np.ndarray, factor: int, kind: type) -> np.ndarray:
    """Sums over blocks of a band whose sides are multiples of `factor`."""
    lines = band.reshape(-1, factor, band.shape[1]).sum(axis=1, dtype=kind)
    return functools.reduce(np.add, (lines[:, k::factor] for k in range(factor)))


def _is_one(values: np.ndarray) -> bool:
    """Whether all values are the same; those of one bit have no differences."""
    return not values.size or bool(values.min() == values.max())


def thin(mask: np.ndarray, pixels: int = 200_000) -> tuple[slice, slice]:
    """Every so many rows and columns, so that about so many of a mask's pixels are left for a statistic."""
    step = max(1, int(np.sqrt(np.count_nonzero(mask) / pixels)))
    return slice(None, None, step), slice(None, None, step)


def saturation(plane: np.ndarray, top: float) -> float:
    """The code from which on light is no longer followed."""
    return min(SATURATED * top, _pile_up(plane))


def _pile_up(code: np.ndarray) -> float:
    """The code at which light piled up, below the top of its type (12 bits in 16, a clipped array); else infinite.

    At an unclipped crest the last two codes hold pixels as sqrt(1) to sqrt(2) - sqrt(1).
    """
    code = code[thin(np.isfinite(code))]
    finite = code[np.isfinite(code)]
    if finite.size == 0:
        return np.inf
    at = finite == finite.max()
    below = finite[~at]
    if at.mean() < 0.02 or below.size == 0:
        return np.inf
    return float(finite.max()) if at.sum() > 6 * (below == below.max()).sum() else np.inf


def not_wild(codes: Codes, lit: np.ndarray) -> np.ndarray:
    """False for pixels further outside of the middle 99 % than these are wide: hot, dead or struck, as no rings are."""
    sample = thin(lit, 40_000)
    if not lit[sample].any():
        return np.ones(codes.shape, bool)
    low, high = np.percentile(codes.light_where(lit[sample], sample), [0.5, 99.5])
    return np.ones(codes.shape, bool) if high == low else codes.between(2 * low - high, 2 * high - low)


def lit_field(codes: Codes) -> tuple[np.ndarray, np.ndarray | None]:
    """The part of the frame inside the field stop, and what beyond it is lit, but more weakly; None for nothing.

    Everything is inside, unless one bright region stands in a dark surround.

    Wide dark rings are no surround: there are other bright ones beyond them, or the dark is a small part of the frame,
    or it is far from even (numbers from real stops and from rendered rings of 0.1 to 10 m).
    """
    everything = np.ones(codes.shape, bool)
    width = max(2.0, min(codes.shape) / 40)
    factor = max(1, int(width / 4))
    width /= factor
    blurred = smooth(codes.means(factor)[0], width)
    if np.ptp(blurred) == 0:
        return everything, None
    bright = blurred > _threshold(blurred)
    high, low = blurred[bright].mean(), blurred[~bright].mean()
    field = _largest(np.asarray(ndimage.binary_fill_holes(bright)))
    dark = np.asarray(ndimage.binary_erosion(~field, iterations=round(2 * width), border_value=1), bool)
    rows, columns = (np.minimum(np.arange(n) // factor, m - 1) for n, m in zip(codes.shape, field.shape, strict=True))
    is_one = low <= 0.5 * high and dark.mean() >= 0.15 and (bright & ~field).sum() <= 0.01 * bright.sum()
    if not is_one or np.subtract(*np.percentile(blurred[dark], [90, 10])) > 0.65 * (high - low):
        unlit = _unlit(blurred, width)
        return (everything if unlit is None else ~unlit[:, columns][rows]), None
    # Near halfway down the edge lies the stop; the blur's width further in, light is no longer cut.
    field = _largest(np.asarray(ndimage.binary_fill_holes(blurred > low + _EDGE * (high - low))))
    black = min(low, float(np.percentile(blurred[dark], 10)))
    wider = _grown(field, blurred - black, _FAINTEST * (high - black), _NEARBY * width)
    field, wider = (ndimage.binary_erosion(one, iterations=round(width), border_value=1) for one in (field, wider))
    # Whole rows at a time: both indices at once take ten times as long.
    bright, dim = (one[:, columns][rows] for one in (field, wider & ~field))
    return bright, dim


def _unlit(light: np.ndarray, width: float) -> np.ndarray | None:
    """What is black at the frame's border, where wide rings cut the field in several; None where that is no surround.

    Of rings that fill a frame, of one order and more, less than `_SURROUND` is as near to black: between two of them
    light is that of a dark ring in a tenth of their distance. `light` is smoothed over `width` [blocks].
    """
    low, high = np.percentile(light, [2, 98])
    size = max(2, min(light.shape) // _NARROWEST)
    padded = np.pad(light < low + _BLACK * (high - low), size, mode="edge")
    black = ndimage.binary_opening(padded, np.ones((size, size)))[size:-size, size:-size]
    labels = np.zeros(black.shape, np.int32)
    ndimage.label(black, output=labels)
    at_border = np.unique(np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]]))
    black = np.isin(labels, at_border[at_border > 0])
    if black.mean() < _SURROUND:
        return None
    return np.asarray(ndimage.binary_dilation(black, iterations=round(2 * width)))


def _grown(field: np.ndarray, light: np.ndarray, faintest: float, width: float) -> np.ndarray:
    """A field and what is lit beyond it, where light falls off by more than it does at a stop.

    The stop is looked for next to the field again, by the light that the field has nearby, until nothing is added.
    `light`: above the dark surround; below `faintest` nothing is part of it; `width` [blocks]: of what is nearby.
    """
    for _ in range(_ROUNDS):
        near = smooth(field.astype(float), width)
        nearby = smooth(np.where(field, light, 0.0), width) / np.maximum(near, _BESIDE)
        wider = _largest(field | ((near > _BESIDE) & (light > np.maximum(_EDGE * nearby, faintest))))
        added, field = np.count_nonzero(wider & ~field), wider
        if added < 1e-3 * field.size:
            break
    return np.asarray(ndimage.binary_fill_holes(field))


def reasons_left_out(
    allowed: np.ndarray, lit: np.ndarray, usable: np.ndarray, dim: np.ndarray | None
) -> dict[str, int]:
    """Pixels that are not usable, by the first reason; `allowed`: what is neither masked, hot nor dead."""
    inside, bright, used = (int(np.count_nonzero(one)) for one in (allowed, lit, usable))
    weak = 0 if dim is None else int(np.count_nonzero(dim))
    return {
        "masked, hot or dead": allowed.size - inside,
        "dark": inside - bright - weak,
        "lit weakly": weak,
        "saturated": bright - used,
    }


def _threshold(values: np.ndarray) -> float:
    """The level that divides values into two kinds with the largest variance between these (Otsu 1979)."""
    counts, edges = np.histogram(values, 256)
    middles = (edges[:-1] + edges[1:]) / 2
    below = np.cumsum(counts)[:-1]
    total = np.cumsum(counts * middles)
    above = values.size - below
    between = below * above * ((total[-1] - total[:-1]) / np.maximum(above, 1) - total[:-1] / below) ** 2
    return float(middles[np.argmax(between)])


def _largest(field: np.ndarray) -> np.ndarray:
    labels = np.zeros(field.shape, np.int32)
    ndimage.label(field, output=labels)
    count = int(labels.max())
    if count < 2:
        return field
    return labels == 1 + int(np.argmax(ndimage.sum_labels(field, labels, range(1, count + 1))))
