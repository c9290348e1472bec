"""Parts of a photograph as block means, as a search looks at them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial.chebyshev import chebvander
from scipy import fft

from fitting.photo.codes import thin
from fitting.photo.matched_filter import Rings
from fitting.photo.reading import Photograph
from fitting.photo.smoothing import block_means, smooth

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
        finest = self.shown(rings).finest(self.means.shape)
        return self.factor == 1 or finest < _BLOCKED


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


def taper(n: int) -> np.ndarray:
    """A window of so many pixels that rises from 0 to 1 over 8 % of them at either end."""
    edge = np.clip(np.minimum(np.arange(n) + 0.5, n - np.arange(n) - 0.5) / (0.08 * n), 0, 1)
    return np.sin(np.pi / 2 * edge) ** 2


def pixels_of(mask: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Columns and rows of some of a mask's pixels, spread over all of it."""
    sample = thin(mask, 20_000)
    rows, columns = np.nonzero(mask[sample])
    return columns * sample[1].step, rows * sample[0].step


def orders_of(photograph: Photograph, rings: Rings) -> float:
    """Fringes of the rings over the photograph's usable pixels."""
    x, y = pixels_of(photograph.mask)
    return rings.scale * float(np.ptp((x - rings.centre[0]) ** 2 + (y - rings.centre[1]) ** 2)) if len(x) else 0.0
