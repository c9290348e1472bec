"""Sentences of test plates. As in `fitting.reasons`."""

from enum import unique

from newtonjax.numerics import Wording


@unique
class PlateReason(Wording):
    """Sentences of `message` and `warnings` by name."""

    PLATE_UNDETERMINED = (
        "this picture has too few fringes: power is determined to ±{power:.2g} and irregularity to ±{irregularity:.2g} "
        "fringe, at most {most:g} is allowed; {remedy}"
    )
    PLATE_RIVALS = (
        "{count} further forms explain this picture equally well, with powers of {powers} fringes against {power:.3g}; "
        "{remedy}"
    )
    PLATE_NOT_EXPLAINED = (
        "no form was found: the best one leaves {unexplained:.0%} of the fringes unexplained, at most {most:.0%} is "
        "allowed; mask what is no fringe, give pupil, or {remedy}"
    )
    PLATE_REMEDY = (
        "give one of: three pictures, each pressed by about a third of a fringe more than the last one; a picture with "
        "3 fringes of tilt and more; a picture of the light without fringes (light_picture)"
    )
    PLATE_REMEDY_OF_FRINGES = (
        "give one of: three pictures, each pressed by about a third of a fringe more than the last one; a picture with "
        "3 fringes of tilt and more"
    )
    PLATE_FRAMES_UNDETERMINED = (
        "these {count} pictures determine power to ±{power:.2g} and irregularity to ±{irregularity:.2g} fringe, at "
        "most {most:g} is allowed; give pictures whose fringes move by about a third of a fringe from one to the next, "
        "or one with 3 fringes of tilt and more"
    )
    PLATE_FRAMES_CONTRADICT = (
        "no one form explains these {count} pictures; give pictures of one part in one place under one light, between "
        "which only the plate is pressed, by about a third of a fringe from one to the next"
    )
    PLATE_FRAMES_BLURRED = (
        "these pictures are blurred by {blur:.2g} px at an aperture of {radius:.0f} px radius, at most {most:.2g} px "
        "is allowed, as the dark rim reaches what is measured; focus, or take larger pictures"
    )
    PLATE_SIGN_OPEN = (
        "the sign of power is open, and shown positive: say which way the rings move when the plate is pressed "
        "(rings_move)"
    )
    PLATE_SIGN_CONTRADICTS = (
        "the order of the pictures, each pressed more than the last one, gives power the other sign than rings_move, "
        "which is followed: check both"
    )
    PLATE_NO_RADIUS = "the radius of the part needs {missing}"
    PLATE_LIGHT_DARK = "the picture of the light is dark in {share:.0%} of the aperture; these pixels are left out"
