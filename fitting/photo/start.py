"""Finding rings without help, from coarse to fine, on block means of a photograph."""

from collections.abc import Callable
from itertools import product

import numpy as np

from fitting.photo.evidence import noise_variance
from fitting.photo.few_fringes import MANY, with_background
from fitting.photo.matched_filter import Rings, from_coarsest, polish, settle
from fitting.photo.reading import Photograph
from fitting.photo.smoothing import block_means
from fitting.photo.tiles import from_tiles
from fitting.photo.view import View, box_of, orders_of, resolving_view, view_of

# Rings that explain as much of the fringes' power need no second opinion; nor a finer look, if they are resolved.
_GOOD, _ENOUGH = 0.3, 0.25
# Tiles to a side that are looked at for what block means hide.
_SAMPLED = 8


def find_rings(photograph: Photograph) -> Rings:
    """Rings in a photograph, without a start value: centre inside or outside of the frame, any phase and contrast.

    Candidates are found on the coarsest image and followed to the one that resolves them. Where these explain little,
    the fringes may be too fine for it everywhere: then wave vectors of tiles give another candidate, and the better
    match wins. Finer block means are looked at where the rings call for them, or where there are none and the blocks
    hide more than they show. A few fringes are fitted together with the light behind them.
    """
    return search_of(photograph)[0]


def search_of(photograph: Photograph) -> tuple[Rings, View]:
    """The same, and the view that the search began on."""
    best, view = _by_matching(photograph)
    return with_background(photograph, best) if orders_of(photograph, best) < MANY else best, view


def follow(photograph: Photograph, rings: Rings) -> Rings:
    """The rings next to a given scale and centre."""
    view = resolving_view(photograph, rings)
    return view.placed(polish(view.fringes, view.shown(rings)))


def settled(photograph: Photograph, rings: Rings) -> Rings:
    """Rings of a given scale and centre with the phase and match that the photograph gives them."""
    view = resolving_view(photograph, rings)
    return view.placed(settle(view.fringes, view.shown(rings)))


def _by_matching(photograph: Photograph) -> tuple[Rings, View]:
    """The best match of all that coarse images, tiles of them and tiles of the photograph propose."""
    best, view = _best_of_view(photograph)
    if not view.resolves(best) and best.match > _ENOUGH:
        return follow(photograph, best), view
    if best.match > _ENOUGH or view.factor == 1 or not _blocks_hide_fringes(photograph, view.factor):
        return best, view
    rows, columns = box_of(photograph)
    fine = from_tiles(*_fine_tiles(photograph))
    if fine is None:
        return best, view
    fine = fine.on_pixels(1, (columns.start, rows.start))
    return max(best, follow(photograph, fine), key=lambda rings: rings.match), view


def _best_of_view(photograph: Photograph) -> tuple[Rings, View]:
    """The best rings of a photograph's coarse view, and the view."""
    view = view_of(photograph)
    best = settle(view.fringes, from_coarsest(view.fringes))
    if best.match > _GOOD:
        return view.placed(best), view
    fringes = view.fringes
    fine = from_tiles(lambda y, x, size: fringes[y : y + size, x : x + size], fringes.shape)
    if fine is not None:
        best = max(best, polish(fringes, fine), key=lambda rings: rings.match)
    return view.placed(best), view


def _fine_tiles(photograph: Photograph) -> tuple[Callable[[int, int, int], np.ndarray], tuple[int, int]]:
    """What cuts tiles out of the lit box at full resolution, their mean taken off, and the box's shape."""
    rows, columns = box_of(photograph)

    def tile_of(y: int, x: int, size: int) -> np.ndarray:
        part = (slice(rows.start + y, rows.start + y + size), slice(columns.start + x, columns.start + x + size))
        light, lit = photograph.codes.light(part), photograph.lit[part]
        return np.where(lit, light - light[lit].mean(), 0.0) if lit.mean() > 0.5 else np.zeros((size, size))

    return tile_of, (rows.stop - rows.start, columns.stop - columns.start)


def _blocks_hide_fringes(photograph: Photograph, factor: int) -> bool:
    """Whether block means lose more than half of the variance that they show, beyond white noise, in some tiles."""
    tile_of, shape = _fine_tiles(photograph)
    size = 32 // factor * factor
    hidden = visible = 0.0
    for y, x in product(*(np.linspace(0, n - size, _SAMPLED).astype(int).tolist() for n in shape)):
        tile = tile_of(y, x, size)
        means = block_means(tile, factor)
        noise = noise_variance(tile, tile != 0) * (1 - 1 / factor**2)
        hidden += max(float(np.var(tile) - np.var(means)) - noise, 0.0)
        visible += float(np.var(means))
    return hidden > 0.5 * visible
