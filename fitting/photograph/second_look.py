"""Rings that fill the middle of a photograph only, beneath dust, a cross hair, or where the outer ones are lost."""

from dataclasses import replace

import numpy as np

from fitting.photo import Photograph, Rings, box_of, evidence_of, find_rings
from fitting.reasons import Reason

# Radius of the middle, over the root of the lit box's area.
_REACH = 0.25
# What rings in the middle need, where the whole photograph shows none: match, share, coherence and fringes. Ten rings
# of another law pass for Newton's: a hologram of a bead has 0.37, 0.68, 0.90 and 9.5 there; rings under dust and a
# cross hair have 0.38, 0.56, 0.96 and 17.
_MATCH, _SHARE, _COHERENCE, _ORDERS = 0.3, 0.5, 0.93, 12.0


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
