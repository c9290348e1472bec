"""Parts of a photograph as block means, as a search looks at them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import fft

from fitting.photo.matched_filter import Rings
from fitting.photo.reading import Photograph
from fitting.photo.smoothing import block_means, flatten, taper

# Blocks to a side on which rings are judged, and cycles of the finest fringe that block means tell.
_LARGEST, _BLOCKED = 640, 0.25
# Blocks to a side of the image in which a plane wave is looked for.
_COARSE = 256


@dataclass(frozen=True)
class View:
    """The box of a photograph's lit field as means over blocks of `factor` pixels a side.

    `corner` (x, y): the first pixel of the box; `frame`: the photograph's shape. A block's mean is over its lit pixels,
    and it counts where these are at least half of it.
    """

    means: np.ndarray
    mask: np.ndarray
    factor: int
    corner: tuple[int, int]
    frame: tuple[int, int]

    @cached_property
    def fringes(self) -> np.ndarray:
        """Fringes alone, of even strength, 0 where masked and softened at the frame's edges [rows, columns]."""
        down, across = (
            taper(n)[start + self.factor // 2 :: self.factor][:count]
            for n, start, count in zip(self.frame, self.corner[::-1], self.means.shape, strict=True)
        )
        return flatten(self.means, self.mask, (down, across))

    def shown(self, rings: Rings) -> Rings:
        """Rings of the photograph, on the blocks."""
        return rings.on_blocks(self.factor, self.corner)

    def placed(self, rings: Rings) -> Rings:
        """Rings of the blocks, on the photograph."""
        return rings.on_pixels(self.factor, self.corner)

    def resolves(self, rings: Rings) -> bool:
        """Whether block means tell the finest fringe of the photograph's rings."""
        return self.factor == 1 or self.shown(rings).finest(self.means.shape) < _BLOCKED


def box_of(photograph: Photograph) -> tuple[slice, slice]:
    """Rows and columns between which the lit field lies."""
    ends = [np.flatnonzero(photograph.lit.any(axis=axis)) for axis in (1, 0)]
    rows, columns = (slice(int(at[0]), int(at[-1]) + 1) if len(at) else slice(0, 0) for at in ends)
    return rows, columns


def view_of(photograph: Photograph, factor: int | None = None, mask: np.ndarray | None = None) -> View:
    """Block means of the lit field's box; without a factor, those of at most 640 blocks to a side.

    `mask`: the pixels that count, in place of the lit ones.
    """
    rows, columns = box_of(photograph)
    if factor is None:
        factor = max(1, -(-max(rows.stop - rows.start, columns.stop - columns.start) // _LARGEST))
    means, share = photograph.codes.means(factor, (rows, columns), photograph.lit if mask is None else mask)
    return View(means, share >= 0.5, factor, (columns.start, rows.start), photograph.codes.shape)


def resolving_view(photograph: Photograph, rings: Rings, view: View | None = None) -> View:
    """The coarsest view, of at most 640 blocks to a side unless the rings are finer, that resolves them.

    `view`: the photograph's of 640 blocks, where there is one.
    """
    view = view_of(photograph) if view is None else view
    if view.resolves(rings):
        return view
    finest = view.shown(rings).finest(view.means.shape) / view.factor
    return view_of(photograph, max(1, int(_BLOCKED / finest)))


def plane_wave(view: View) -> float:
    """Share of the fringe power that straight, evenly spaced fringes explain."""
    small = block_means(view.fringes, max(1, max(view.fringes.shape) // _COARSE))
    power = np.abs(np.asarray(fft.rfft2(small, tuple(2 * n for n in small.shape)))) ** 2
    return float(2 * power.max() / ((small**2).sum() * np.count_nonzero(small) + 1e-30))
