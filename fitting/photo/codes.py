"""One channel of a photograph as its codes, and the linear light that they stand for, made in bands of rows."""

import functools
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

# Rows of light that are made at a time: a band stays in the processor's cache.
_BAND = 64


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
        return self._single[codes.view(self._index)]

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

    def raised(self, exponent: float) -> "Codes":
        """The same codes with their light raised to an exponent."""
        return replace(self, curve=replace(self.curve, fitted=self.curve.fitted * exponent))

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
