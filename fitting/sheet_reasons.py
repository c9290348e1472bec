"""Sentences of the sheet's further measurements: wedges in photographs, rulers, discs. As in `fitting.reasons`."""

from enum import unique

from newtonjax.numerics import Wording


@unique
class SheetReason(Wording):
    """Sentences of `message` and `warnings` by name, grouped by what they are about."""

    # A ruler, or a disc, in a photograph.
    NO_LINES = "no ruler: no direction of evenly spaced lines was found; mask what lies beside it"
    FEW_LINES = "no ruler: {lines} lines in a row are seen; at least {least} are required"
    LINES_UNEVEN = (
        "no ruler: its lines scatter by {scatter:.2g} of their distance; at most {most:.2g} is allowed: mask what lies "
        "beside it, such as numerals"
    )
    ONE_WAY_ONLY = "{what} measures the scale one way only: pixels are taken as square, and the camera as looking down"
    LINES_OF_FRINGES = (
        "no ruler: these lines fade into one another as fringes do, and fill the picture ({overtones:.0%} of "
        "overtones, where a ruler has 25 % and more); straight fringes are measured by wedge; a ruler "
        "out of focus by two points"
    )
    SMOOTH_LINES = (
        "the lines fade into one another as fringes do ({overtones:.0%} of overtones): is this a ruler, and in focus?"
    )
    CONTACT_OF_A_LENS = (
        "no disc: rings surround the spot, so that it is the contact of a lens, whose size nobody knows; rings are "
        "measured by fit; for a scale photograph a disc or a ruler at the same place"
    )
    LIT_FIELD = (
        "no disc: fringes cross the round spot, so that it is the lit field of view; where its diameter on the object "
        "is known, give two points of its edge (--point twice, with --distance); otherwise photograph a disc or ruler "
        "at the same place"
    )
    NO_DISC = "no disc: no round spot with an edge all around was found in the picture; mask what lies beside it"
    DISC_CLIPPED = (
        "the edge of the disc does not tell its radius: its light is clipped, so that level, blur and radius stand for "
        "one another; expose less, or photograph a dark disc on bright ground"
    )
    DISC_CURVE = (
        "the codes are taken for sRGB; were they linear light, the pixel size would be {change:.2%} {size}: a quarter "
        "of that is in the standard deviation; give transfer (--transfer) where the camera's curve is known"
    )
    DISC_NOT_ROUND = (
        "the disc is {uneven:.2g} longer one way than across it: seen at a slant, or no square pixels; half of that is "
        "in the standard deviation"
    )

    # Straight fringes in a photograph.
    NO_STRAIGHT_FRINGES = (
        "no straight fringes: their phase is confirmed in too few parts of the picture; rings and arcs are measured by "
        "fit, a surface's form by form; mask what is no fringe"
    )
    FRINGES_CURVED = (
        "the fringes are curved or unevenly spaced: from the middle to the rim they change by {change:.0%}, where a "
        "wedge's may by {most:.0%}; rings and arcs are measured by fit, a surface's form by form"
    )
    OTHER_STRUCTURE = (
        "straight fringes explain {explained:.0%} of the image variance, and the residual is structure and no noise; "
        "at least {least:.0%} is required: mask what is no fringe; a ruled grid or a ruler is measured by scale"
    )
    FEW_STRAIGHT_FRINGES = "{fringes:.1f} fringes are seen; at least {least:g} are required: use a larger field"
    WEDGE_NOT_CONVERGED = (
        "the fit of straight fringes did not converge; mask what is no fringe; a ruled grid or a ruler is measured by "
        "scale"
    )
    WEDGE_BENT = (
        "the fringes change by {change:.1%} from the middle to the rim, beyond noise and the camera's distortion: the "
        "plates are bent, or seen at a slant; the angle is that in the middle, and its change is in the budget"
    )
    NO_ANGLE = (
        "{missing} not given: there is no angle without, and the spacing in pixels is the answer; give wavelength and "
        "pixel_size (newtonjax scale measures it, --scale-from takes its file)"
    )
