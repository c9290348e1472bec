"""Finding rings without help, from coarse to fine, on block means of a photograph."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from scipy import fft

from fitting.matched import Rings, polish, search, settle
from fitting.photo import Photograph
from fitting.smoothing import flatten, noise_variance, reduce, taper
from fitting.tiles import from_tiles

# Pixels to a side of the image on which rings are looked for first, and of the one on which they are judged.
_COARSEST, _LARGEST = 128, 640
# Fringes up to so many cycles a pixel are resolved: of an image whose candidates are weighed, and of block means.
_RESOLVED, _BLOCKED = 0.2, 0.25
# Rings that explain as much of the fringes' power need no second opinion; nor a finer look, if they are resolved.
_GOOD, _ENOUGH = 0.3, 0.25
# Tiles to a side that are looked at for what block means hide.
_SAMPLED = 8


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


def view_of(photograph: Photograph, factor: int | None = None) -> View:
    """Block means of the lit field's box; without a factor, those of at most 640 blocks to a side."""
    rows, columns = box_of(photograph)
    if factor is None:
        factor = max(1, -(-max(rows.stop - rows.start, columns.stop - columns.start) // _LARGEST))
    means, share = photograph.codes.means(factor, (rows, columns), photograph.lit)
    return View(means, share >= 0.5, factor, (columns.start, rows.start), photograph.codes.shape)


def find_rings(photograph: Photograph) -> Rings:
    """Rings in a photograph, without a start value: centre inside or outside of the frame, any phase and contrast.

    Candidates are found on the coarsest image and followed to the one that resolves them. Where these explain little,
    the fringes may be too fine for it everywhere: then wave vectors of tiles give another candidate, and the better
    match wins. Finer block means are looked at where the rings call for them, or where there are none and the blocks
    hide more than they show.
    """
    view = view_of(photograph)
    best = _found(view)
    if not view.resolves(best) and best.match > _ENOUGH:
        return follow(photograph, best)
    if best.match > _ENOUGH or view.factor == 1 or not _hides(photograph, view.factor):
        return best
    rows, columns = box_of(photograph)
    fine = from_tiles(*_fine_tiles(photograph))
    if fine is None:
        return best
    fine = fine.on_pixels(1, (columns.start, rows.start))
    return max(best, follow(photograph, fine), key=lambda rings: rings.match)


def follow(photograph: Photograph, rings: Rings) -> Rings:
    """The rings next to a given scale and centre."""
    view = _resolving(photograph, rings)
    return view.placed(polish(view.fringes, view.shown(rings)))


def settled(photograph: Photograph, rings: Rings) -> Rings:
    """Rings of a given scale and centre with the phase and match that the photograph gives them."""
    view = _resolving(photograph, rings)
    return view.placed(settle(view.fringes, view.shown(rings)))


def plane_wave(photograph: Photograph) -> float:
    """Share of the fringe power that straight, evenly spaced fringes explain."""
    fringes = view_of(photograph).fringes
    small = reduce(fringes, max(1, max(fringes.shape) // (2 * _COARSEST)))
    power = np.abs(np.asarray(fft.rfft2(small, tuple(2 * n for n in small.shape)))) ** 2
    return float(2 * power.max() / ((small**2).sum() * np.count_nonzero(small) + 1e-30))


def _found(view: View) -> Rings:
    """The best rings of a view, on the photograph."""
    best = settle(view.fringes, _from_coarsest(view.fringes))
    if best.match > _GOOD:
        return view.placed(best)
    fringes = view.fringes
    fine = from_tiles(lambda y, x, size: fringes[y : y + size, x : x + size], fringes.shape)
    if fine is not None:
        best = max(best, polish(fringes, fine), key=lambda rings: rings.match)
    return view.placed(best)


def _from_coarsest(fringes: np.ndarray) -> Rings:
    factor = max(1, -(-max(fringes.shape) // _COARSEST))
    candidates = [rings.on_pixels(factor) for rings in search(reduce(fringes, factor))]
    while True:
        small = reduce(fringes, factor)
        candidates = [polish(small, rings.on_blocks(factor)).on_pixels(factor) for rings in candidates]
        candidates = sorted(candidates, key=lambda rings: -rings.match)
        if factor == 1 or candidates[0].finest(fringes.shape) * factor < _RESOLVED:
            return candidates[0]
        candidates = candidates[: 3 if factor > 3 else 2]
        factor = factor // 2


def _resolving(photograph: Photograph, rings: Rings) -> View:
    """The coarsest view, of at most 640 blocks to a side unless the rings are finer, that resolves them."""
    view = view_of(photograph)
    if view.resolves(rings):
        return view
    finest = view.shown(rings).finest(view.means.shape) / view.factor
    return view_of(photograph, max(1, int(_BLOCKED / finest)))


def _fine_tiles(photograph: Photograph) -> tuple[Callable[[int, int, int], np.ndarray], tuple[int, int]]:
    """What cuts tiles out of the lit box at full resolution, their mean taken off, and the box's shape."""
    rows, columns = box_of(photograph)

    def tile_of(y: int, x: int, size: int) -> np.ndarray:
        part = (slice(rows.start + y, rows.start + y + size), slice(columns.start + x, columns.start + x + size))
        light, lit = photograph.codes.light(part), photograph.lit[part]
        return np.where(lit, light - light[lit].mean(), 0.0) if lit.mean() > 0.5 else np.zeros((size, size))

    return tile_of, (rows.stop - rows.start, columns.stop - columns.start)


def _hides(photograph: Photograph, factor: int) -> bool:
    """Whether block means lose more than half of the variance that they show, beyond white noise, in some tiles."""
    tile_of, shape = _fine_tiles(photograph)
    size = 32 // factor * factor
    lost = shown = 0.0
    for y, x in product(*(np.linspace(0, n - size, _SAMPLED).astype(int) for n in shape)):
        tile = tile_of(y, x, size)
        means = reduce(tile, factor)
        noise = noise_variance(tile, tile != 0) * (1 - 1 / factor**2)
        lost += max(float(np.var(tile) - np.var(means)) - noise, 0.0)
        shown += float(np.var(means))
    return lost > 0.5 * shown
