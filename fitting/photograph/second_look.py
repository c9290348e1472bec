"""Rings that a first look has missed: no circles, beneath dust, a cross hair or print, or in the middle only."""

from dataclasses import replace

import numpy as np
from numpy.polynomial.chebyshev import chebvander
from scipy import ndimage

from fitting.photo import (
    Bend,
    Photograph,
    Rings,
    View,
    bent,
    box_of,
    evidence_of,
    find_rings,
    median,
    resolving_view,
    thin,
    view_of,
)
from fitting.reasons import Reason

# Radius of the middle, over the root of the lit box's area.
_REACH = 0.25
# What rings in the middle need, where the whole photograph shows none: match, share, coherence and fringes. Ten rings
# of another law pass for Newton's: a hologram of a bead has 0.37, 0.68, 0.90 and 9.5 there; rings under dust and a
# cross hair have 0.38, 0.56, 0.96 and 17.
_MATCH, _SHARE, _COHERENCE, _ORDERS = 0.3, 0.5, 0.93, 12.0

# Match of rings that are no circles, at least, and over that of the best circles: made ones have 0.8 and more, where
# circles have less than 0.5, and spirals of arms up to 0.4.
_BENT, _BETTER = 0.5, 1.5
# Light beyond so many robust standard deviations is no cosine's, whose crests are at 0.95 of them, noise and all;
# blocks around it that its edge may dim; shares of the field that such spots may take.
_BEYOND, _EDGE, _SPOTS = 4.0, 2, (0.002, 0.4)
# Degree of the background, and rounds of it without spots.
_DEGREE, _ROUNDS = 4, 4


def bent_rings(photograph: Photograph, view: View, circles: float) -> tuple[Photograph, Rings] | None:
    """The photograph and rings that are ellipses, or that the camera distorts; None without clear ones.

    `circles`: the match of the best of these, than which it has to be much better.
    """
    middle_y, middle_x = ((n - 1) / 2 for n in photograph.mask.shape)
    middle = (middle_x, middle_y)
    frame = Rings(1.0, middle, 0.0, 0.0, Bend(0.0, 0.0, 0.0, middle, float(np.hypot(*middle))))
    shown = view.shown(frame).bend
    rings = None if shown is None else bent(view.fringes, shown.middle, shown.unit)
    if (
        rings is None
        or rings.match < max(_BENT, _BETTER * circles)
        or evidence_of(photograph, rings := view.placed(rings), resolving_view(photograph, rings, view)).reason
    ):
        return None
    return photograph, rings


def rings_without_spots(photograph: Photograph) -> tuple[Photograph, Rings] | None:
    """The photograph without what is darker or brighter than all fringes, and the rings then; None without clear ones.

    Dust and lines that are deeper than the fringes hold most of the power in which a search looks for rings.
    """
    view = view_of(photograph)
    spots = _spots(view.means, view.mask)
    share = float(spots[view.mask].mean())
    if not _SPOTS[0] < share < _SPOTS[1]:
        return None
    (column, row), spotless = view.corner, photograph.mask.copy()
    wide = spots.repeat(view.factor, axis=0).repeat(view.factor, axis=1)
    part = spotless[row : row + len(wide), column : column + wide.shape[1]]
    part &= ~wide[: part.shape[0], : part.shape[1]]
    remaining = replace(photograph, mask=spotless, lit=photograph.lit & (spotless | ~photograph.mask))
    rings = find_rings(remaining)
    # The evidence takes longer than the search.
    if rings.match < _MATCH or evidence_of(remaining, rings).reason:
        return None
    remaining.warnings.append(Reason.SPOTS_LEFT_OUT(share=share))
    return remaining, rings


def _spots(light: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Where light is too far from a smooth background for fringes, and close to there."""
    rows, columns = thin(mask, 40_000)
    design_y, design_x = (chebvander(np.linspace(-1, 1, n), _DEGREE) for n in light.shape)
    pairs = [(j, i) for j in range(_DEGREE + 1) for i in range(_DEGREE + 1 - j)]
    design = np.stack([np.outer(design_y[:: rows.step, j], design_x[:: columns.step, i]) for j, i in pairs], axis=-1)
    at, deviation = mask.copy(), np.zeros_like(light)
    weights = np.zeros((_DEGREE + 1,) * 2)
    for _ in range(_ROUNDS):
        used = at[rows, columns]
        terms = design[used]
        weights[tuple(np.transpose(pairs))] = np.linalg.lstsq(
            terms.T @ terms, terms.T @ light[rows, columns][used], rcond=1e-12
        )[0]
        deviation = np.abs(light - design_y @ weights @ design_x.T)
        at = mask & (deviation < _BEYOND * 1.4826 * median(deviation[at]))
    return ndimage.binary_dilation(mask & ~at, iterations=_EDGE)


def rings_in_the_middle(photograph: Photograph) -> tuple[Photograph, Rings] | None:
    """The photograph cut to a disc in its middle, and the rings there; None where they are not clear.

    Their centre is in view. For a photograph in which no rings were found as a whole: outer ones that are lost to blur,
    coherence or dust leave most of the fringe power to something else.
    """
    rows, columns = box_of(photograph)
    if min(rows.stop - rows.start, columns.stop - columns.start) < 64:
        return None
    y, x = np.ogrid[: photograph.mask.shape[0], : photograph.mask.shape[1]]
    reach2 = _REACH**2 * (rows.stop - rows.start) * (columns.stop - columns.start)
    inside = (x - (columns.start + columns.stop - 1) / 2) ** 2 + (y - (rows.start + rows.stop - 1) / 2) ** 2 < reach2
    mask = photograph.mask & inside
    if np.count_nonzero(mask) < 0.5 * np.count_nonzero(inside):
        return None
    central = replace(photograph, mask=mask, lit=photograph.lit & inside)
    rings = find_rings(central)
    evidence = evidence_of(central, rings)
    fringes_agree = evidence.share > _SHARE and evidence.coherence > _COHERENCE and evidence.orders > _ORDERS
    column, row = (round(at) for at in rings.centre)
    centre_is_inside = 0 <= row < inside.shape[0] and 0 <= column < inside.shape[1] and bool(inside[row, column])
    if evidence.reason or evidence.match < _MATCH or not fringes_agree or not centre_is_inside:
        return None
    central.warnings.append(Reason.MIDDLE_ONLY())
    return central, rings
