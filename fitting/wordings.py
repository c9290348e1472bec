"""Templates of sentences in `reasons.py`, by subject, where that table would be too long with them."""


class BeamWords:
    """Of rings of many beams."""

    MANY_BEAMS = (
        "these fringes are not of two beams: their second and third harmonics are {second:.2f} and {third:.2f} of "
        "their amplitude, whatever the camera's exponent; at most {most_second} and {most_third} are allowed "
        "(Fabry-Perot rings are as sharp)"
    )
    MANY_BEAM_RINGS = (
        "rings of many beams: finesse {finesse}, fringe scale {scale}. They give no radius, since an etalon makes the "
        "same ones; if they are Newton's rings between coated faces, give that bench, such as "
        "scene=newton_rings(lens_coating='mirror:50%', plate_coating='mirror:50%')"
    )
    SHARP_RINGS_MISFIT = (
        "rings of many beams explain {explained:.0%} of the image's variance; at least {least:.0%} is required where a "
        "bench with coated faces, or all orders, is given"
    )


class RivalWords:
    """Of what else may have made the rings."""

    ASTRAY = (
        "in {share:.0%} of the field the fringes are not where a sphere's would be: a spiral, circles of another law, "
        "rings of which part was found, a surface that is no sphere (use form); mask what is not of one ring system"
    )
    WEAK_LIGHT = (
        "part of the field was left out since it is lit weakly, and in {share:.0%} of the field rings that are seen "
        "there are not where the fit puts them: their spacing differs by {spacing:.1%}, which is a row of the budget; "
        "light the field evenly, or turn the camera towards the rings"
    )
    WEAK_LIGHT_APART = (
        "the bright and the weakly lit part of the field contradict each other: in {share:.0%} of it rings are not "
        "where those of the bright part continue, by {spacing:.0%} of their spacing, and no one radius explains both; "
        "light the field evenly, look along the normal, or mask one part"
    )
    HELD_CONTRADICTED = (
        "the picture contradicts the held {name}: left free it comes out as {place}, {ratio:.1f} standard deviations "
        "away; where the held value is wrong, so is the answer: leave it free, unless it is known otherwise"
    )


class StudyWords:
    """Of draws from a posterior, and of studies of a bench."""

    CHAIN_TOO_SHORT = (
        "the chain of {steps} steps is shorter than {times} autocorrelation times of {slowest:.0f} steps: take at "
        "least {least} steps"
    )
    CHAIN_BEYOND_LIKELIHOOD = (
        "the posterior extends {excursion:.2g} turns from the fit; the likelihood is accurate to {near:g} turns, and "
        "draws beyond are missing; include more rings"
    )
    CHAIN_PRIOR_TENSION = (
        "{name} is {value:.8g} ± {sd:.2g} by the fit, {ratio:.1f} sd from its prior, {prior}: they contradict each "
        "other; widen the prior, or look for what is wrong in picture, scale or light"
    )
    UNDETERMINED_COMBINATIONS = "{combinations}"
    ONLY_PRODUCT_MEASURED = "{together}: only {product} is measured"
    UNSEEN_CHANGES = "{together}: the image does not change with {changes}"
    TARGET_UNDETERMINED = "the image does not determine {target} with {beside} free: {why}"
    NOISE_ABOVE_ACCURACY = "noise alone exceeds the requested accuracy: increase exposure, pixels or rings first"
    VARIANCE_NOT_RESOLVED = "some fractions of the variance are not resolved by this number of draws; increase draws"
    DRAW_NOT_CONVERGED = "the fit with {values} (SI units) does not converge: give smaller deviations"
    DESIGN_UNDETERMINED = (
        "no starting design determines {target}: a beam misses the field, or a parameter is undetermined"
    )
    NO_DESIGN_WITHIN_LIMITS = (
        "no design within the bounds meets the limits: {limit} stays exceeded; widen bounds or limits"
    )
    TOO_MANY_FRINGES = "the field has too many fringes for a smooth forecast: give a smaller field, or fewer rings"


class TogetherWords:
    """Of several pictures in one answer."""

    PICTURE_LEFT_OUT = "{name} was left out: {why}"
    TOO_FEW_PICTURES = "pictures that can be used: {count}; at least two are required; {why}"
    PICTURE_CONTRADICTS = (
        "{name} contradicts the other pictures by {size:.1f} standard deviations in what they share: look at it alone, "
        "and leave it out if its camera or lens was another"
    )
    NO_COMMON_VALUE = (
        "the pictures have no {measured} in common: {values}, {size:.3g} standard deviations apart, at most {most:g} "
        "are taken for one; measure each by itself, or leave out {picture}"
    )
    PICTURES_CONTRADICT = (
        "the two pictures contradict each other by {size:.1f} standard deviations in what they share; a third one "
        "tells which is wrong"
    )
    GAP_ORDER_UNDECIDED = (
        "the order of the gap is open: the most probable one, a gap of {gap:.4g} m, holds {probability:.1%}; a further "
        "wavelength, a shorter gap_range or wavelengths known better tell it"
    )
    PHASES_CONTRADICT = (
        "no gap has the phases of all pictures: the nearest is {size:.1f} standard deviations away; the lens moved "
        "between them, a wavelength or the view is wrong, or the gap is outside of gap_range"
    )


class FormWords:
    """Of the form of a surface."""

    PUPIL_NOT_SEEN = "no edge of an aperture is seen: the form is of the largest circle ({radius:.5g} px); give pupil"
    PUPIL_TOO_SMALL = "no aperture of at least {least:g} pixels radius is seen; give pupil, or use a larger image"
    FORM_NO_FRINGES = "no form was found: too few parts of the pupil show evenly spaced fringes; tilt, or mask others"
    FORM_NOT_CONFIRMED = (
        "no form was found: the phase of the best one is confirmed in {agreement:.0%} of the pupil; at least "
        "{least:.0%} is required: give pupil, mask what is no fringe, or tilt the surfaces until the fringes are open"
    )
    FORM_FEW_FRINGES = "{fringes:.1f} fringes, some of them perhaps uneven light: at least {least:g} are required; tilt"
    FORM_NOT_CONVERGED = "the form did not converge; give fewer terms, mask what is no fringe, or tilt the surfaces"
    FORM_SIGN_OPEN = "the sign of all terms is open, power is shown positive: one image does not tell it; give sign"
    FORM_SIGN_UNDECIDED = "term {term} is zero within its standard deviation: its sign does not decide that of the form"
    FORM_RIVALS = "{count} further forms explain the image equally well: tilt the surfaces by more fringes to decide"
    FRAMES_NOT_STEPPED = (
        "the frames do not follow one phase: it explains {explained:.0%} of their change, at least {least:.0%} is "
        "required; give frames of one surface and one camera, give pupil, or mask what is no fringe"
    )
    FRAMES_ALIKE = "the frames have one phase, so that light and fringes are not told apart: step by parts of a fringe"
    FRAME_CONTRADICTS = (
        "frame {frame} contradicts the others: chi-squared between their forms is {size:.1f} a term; its light or its "
        "surface was another, leave it out"
    )


class GridWords:
    """Of a ruled grid, and of rings that do not go with it."""

    GRID_NOT_SQUARE = (
        "no square grid: what looks like one is {skew:.2g}° off a right angle, {stretch:.1%} longer one way and "
        "distorted by {distortion:.2g}"
    )
    PIXELS_NOT_SQUARE = (
        "pixels are {uneven:.2g} longer one way than across it ({along}; {ratio:.2g} standard deviations): a tilted "
        "grid, or no square pixels; their mean counts, with half of the difference as sd ({uneven:.2%} of a radius)"
    )
    STRETCHED_OTHERWISE = (
        "the rings are stretched by {rings:.4f} ± {rings_sd:.2g} (x over y), the grid by {grid:.4f} ± {grid_sd:.2g}, "
        "{ratio:.2g} standard deviations apart: one was photographed at a slant. The radius may be {size:.2%} off"
    )


class WedgeWords:
    """Sentences about positions of straight fringes, as of a wedge."""

    FEW_FRINGES_OF_WEDGE = "positions of {count} fringes; a wedge needs at least three orders"
    NO_SPACING = "the positions do not determine a spacing: {spacing:.3g} +/- {sd:.2g} m; read more fringes"
    WEDGE_TOO_STEEP = "a spacing of {spacing:.3g} m is finer than the fringes of any wedge; check the units"
    FRINGES_MISCOUNTED = (
        "orders {before:g} and {after:g} lie {rings:.2g} +/- {sd:.1g} orders farther apart than counted"
    )
    UNEVEN_FRINGES = "the spacing changes by {change:+.1%} over the table ({deviations:.1f} sd); its mean was used"
