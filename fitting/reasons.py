"""What a measurement may say of itself: why there is no answer, and what to look at in one.

The texts of results, but for those of rulers, discs and wedges in photographs (`sheet_reasons`), of test plates
(`plate_reasons`) and of lamps (`colour_reasons` of `fitting.colour`).

A name is the `code` of the sentence, `reason` and `warning_codes` of a result, and stays; the texts are templates in
the syntax of `str.format`, and may be put better. A translation is a table from these templates to others
(`Statement.translated`). Errors of input are ValueErrors with their text where they are raised.
"""

from enum import unique

from fitting.wordings import BeamWords, FormWords, GridWords, RivalWords, StudyWords, TogetherWords, WedgeWords
from newtonjax.numerics import Wording


@unique
class Reason(Wording):
    """Sentences of `message` and `warnings` by name, grouped by what they are about."""

    # What was read of a photograph.
    READ_AS_8_BIT = "{kind} values up to 255 were read as 8-bit codes; give transfer='linear' for counts of light"
    SATURATED = "{share:.0%} of the pixels are saturated and were left out; expose less"
    FIRST_PAGE = "page 1 of {pages} was measured; page=N (--page N) reads another one, fitting.fit_stack all"
    TWO_LEVELS = "the picture has two levels only: a photograph in grey or colours is measured more precisely"
    TOO_FEW_PIXELS = "{usable} pixels of {total} can be used: the image is saturated, dark or masked"
    UNIFORM = "the image is uniform: there are no fringes"
    VIEW_ASSUMED = (
        'view (--view) is not given: "reflected" is assumed; one image cannot distinguish reflected from transmitted '
        "rings unless the gap is known, nor Newton's rings from those of a Michelson interferometer"
    )

    # Whether it shows rings: by the search, then by the fit.
    STRAIGHT_BEND = (
        "the fringes are straight: across {orders:.0f} fringes they bend by {bend:.2g} fringe spacings; a radius needs "
        "at least {least:.2g}; newtonjax wedge measures straight fringes, newtonjax scale a ruler"
    )
    STRAIGHT_WAVE = (
        "the fringes are straight: evenly spaced ones explain {plane:.0%} of the fringe power, rings {match:.0%}; a "
        "radius needs rings or arcs; newtonjax wedge measures straight fringes"
    )
    NO_RINGS_MATCH = "no rings: the best ones explain {match:.0%} of the fringe power; at least {least:.0%} is required"
    NO_RINGS_AGREEMENT = (
        "no rings: the best ones explain {match:.0%} of the fringe power, {share:.0%} of the image's variance follows "
        "their phase from place to place, and neighbouring places agree to {coherence:.0%}; at least {least:.0%} of "
        "both is required where rings explain so little"
    )
    MANY_BEAMS = BeamWords.MANY_BEAMS
    MANY_BEAM_RINGS = BeamWords.MANY_BEAM_RINGS
    SHARP_RINGS_MISFIT = BeamWords.SHARP_RINGS_MISFIT
    SPOTS_LEFT_OUT = "{share:.0%} of the field is darker or brighter than fringes (dust, a crosshair): left out"
    MIDDLE_ONLY = "rings are seen in the middle of the picture only: what lies further out was left out"
    LENS_SMALLER_THAN_FIELD = (
        "wavelength and pixel size imply a lens radius of {radius:.3g} m, but the rings extend to {reach:.3g} m; check "
        "the units"
    )
    STRAIGHT_FIT_WAVE = "the fringes are straight, with {straight:.0%} of the power: newtonjax wedge measures them"
    STRAIGHT_FIT_BEND = (
        "the fringes are straight: across {orders:.2g} fringes they bend by {bend:.2g} fringe spacings; a radius needs "
        "curved ones; newtonjax wedge measures straight ones, newtonjax scale a ruler"
    )
    NO_RINGS_FIT = (
        "no rings found: the best ring pattern explains {explained:.1%} of the image variance; at least {least:.0%} is "
        "required"
    )
    NOT_FINITE = "the fit has no finite optimum: no rings were recognized"
    NOT_CURVED = "the rings' curvature is not determined"
    TOO_FEW_FRINGES = (
        "the image shows {orders:.3g} fringes, which do not determine a scale; at least {least:g} are required: "
        "include more rings, or a larger field, or give start or fixed values"
    )
    TOO_FEW_FRINGES_GUIDED = (
        "the image shows {orders:.3g} fringes, which do not determine a scale; at least {least:g} are required: "
        "include more rings, or a larger field"
    )
    NOT_ONE_SPHERE = (
        "a ring pattern explains {explained:.0%} of the image variance, but the residual is not random: the fringes "
        "are not the rings of one sphere"
    )
    UNEVEN_LIGHT = (
        "{orders:.1f} fringes lie in light so uneven that it may pass for some: at least {least:g} are needed; take "
        "more rings into the picture, light it more evenly, or give start or fixed values"
    )
    STRUCTURE_BESIDE_FEW_FRINGES = (
        "the image shows only {orders:.1f} fringes, and {share:.1%} of its variance is structure that the model does "
        "not explain; curvature cannot be separated from it: include more rings, or a larger field"
    )
    SCENE_MISFIT = (
        "the scene does not reproduce these fringes: it explains {explained:.0%} of the image variance, a free ring "
        "pattern {by_rings:.0%}; check the scene and the fixed parameters"
    )

    # What a fit determines.
    NOT_CONVERGED = "least squares did not converge; mask what is not rings, or give start"
    UNDETERMINED = "undetermined: {error}"
    CURVATURE_UNCERTAIN = "the curvature is not determined: its standard deviation exceeds a fifth of its value"
    UNLIKELY_SIZE = "the {measured} of {value} is not what lenses and lamps have, {low} to {high}: check the units"
    NO_SCALE = "{missing} are not given; only one unknown can be measured, so the result is the fringe scale"
    PLATE_LENS_NOT_CONVEX = "with a plate radius of {plate:g} m and rings of {effective:.4g} m the lens is not convex"
    PLATE_LENS_TOO_SMALL = "at a plate radius of {plate:g} m the lens, {lens:.3g} m, is below its rings, {reach:.3g} m"
    PLATE_LENS_FLAT = (
        "with a plate radius of {plate:g} m the curvature of the lens is zero within its standard deviation"
    )
    CORRELATED_RESIDUALS = (
        "residuals of neighbouring pixels are correlated ({inflation:.3g} times the variance of white noise): the "
        "model misses structure in the image; the noise row of the budget is enlarged, other model errors are not "
        "included"
    )
    TREATED_AS_EXACT = (
        "no standard deviation is given for {names}: treated as exact, and the reported uncertainty does not include it"
    )
    PART_NOT_FITTED = "{part}: {why}"
    BRIGHT_FOR_DARK = "fringes are bright where the given gap predicts dark ones; check gap and view"
    NEAR_SAMPLING_LIMIT = (
        "the finest fringes are {width:.2g} pixels wide, close to the sampling limit of 2 pixels; mask the rim or use "
        "more pixels"
    )
    NO_PURE_COSINE = (
        "the fringes are no pure cosine, and no exponent of the codes makes them one (the best lies at the edge of "
        "what was tried, {exponent:.2g}): more than two beams, clipping, or a curve that is no power law"
    )

    # What else may have made the rings.
    RIVAL_ASTRAY = RivalWords.ASTRAY
    HELD_CONTRADICTED = RivalWords.HELD_CONTRADICTED
    RIVAL_WEAK_LIGHT = RivalWords.WEAK_LIGHT
    RIVAL_WEAK_LIGHT_APART = RivalWords.WEAK_LIGHT_APART
    RIVAL_SHARP_FRINGES = "sharper fringes than two beams make (harmonics {second:.2g} and {third:.2g}): more beams"
    RIVAL_CUT_FRINGES = "crests or troughs are cut off (harmonics {second:.2g} and {third:.2g}); expose less"
    RIVAL_SECOND_SYSTEM = (
        "what the rings leave over holds a second system of rings, of {ratio:.2g} times their scale and {contrast:.0%} "
        "of their contrast: a ghost, another face or a second colour; mask it, or keep it out of the light"
    )
    RIVAL_FORM = "fringes up to {size:.2g} turns off a sphere's (coma, trefoil): {shift:+.2%} of the scale with these"
    RIVAL_LARGE_FORM = (
        "fringes seem up to {size:.2g} turns off a sphere's: too far for an estimate of what they do to the scale, and "
        "not in the budget; newtonjax form measures such a surface"
    )
    RIVAL_VIEW_OR_FORM = (
        "the rings are elliptic by {stretch:.2%}: a view at {angle:.1f} degrees, or a lens with two radii {apart:.2%} "
        "apart, whose mean curvature is of a radius {share:.2%} smaller; a stated view angle decides"
    )
    RIVAL_ANOTHER_LAW = "no camera distorts by {value:+.0%} at half a diagonal: rings of another law than a sphere's"
    RIVAL_RING_LAW = "rings in r to power {power:.2f}, not 2: that law is {missed:.3f} turns off, spheres {own:.3f}"
    RIVAL_PRIOR_TENSION = (
        "{name} is {value:.2g}, {ratio:.1f} prior sd from {centre:g} ± {sd:.2g}: {share:.2%} of the scale; cut "
        "(axis_px, --axis)? A picture of a grid (--scale-from), the lens turned, or a prior of your own would tell"
    )

    # Frames of a stack.
    FRAME_UNUSABLE = "{error}"
    FRAME_MASKED = "{share:.0%} of its pixels are no numbers, or masked"
    FRAME_SATURATED = "saturated: {share:.0%} of its pixels cannot be used"
    FRAME_UNIFORM = "uniform: there are no fringes"
    FRAME_DARK = "dark or blank: its light varies by less than a tenth of the last frame's"
    RINGS_LOST = "the rings are not where the last frame had them"
    SEARCHED_ANEW = "{reason}: searched anew"
    SEARCHED_IN_VAIN = "{reason}, and a search ended with: {message}"
    # Draws from a posterior, and studies of a bench.
    CHAIN_TOO_SHORT = StudyWords.CHAIN_TOO_SHORT
    CHAIN_BEYOND_LIKELIHOOD = StudyWords.CHAIN_BEYOND_LIKELIHOOD
    CHAIN_PRIOR_TENSION = StudyWords.CHAIN_PRIOR_TENSION
    UNDETERMINED_COMBINATIONS = StudyWords.UNDETERMINED_COMBINATIONS
    ONLY_PRODUCT_MEASURED = StudyWords.ONLY_PRODUCT_MEASURED
    UNSEEN_CHANGES = StudyWords.UNSEEN_CHANGES
    TARGET_UNDETERMINED = StudyWords.TARGET_UNDETERMINED
    NOISE_ABOVE_ACCURACY = StudyWords.NOISE_ABOVE_ACCURACY
    VARIANCE_NOT_RESOLVED = StudyWords.VARIANCE_NOT_RESOLVED
    DRAW_NOT_CONVERGED = StudyWords.DRAW_NOT_CONVERGED
    DESIGN_UNDETERMINED = StudyWords.DESIGN_UNDETERMINED
    NO_DESIGN_WITHIN_LIMITS = StudyWords.NO_DESIGN_WITHIN_LIMITS
    TOO_MANY_FRINGES = StudyWords.TOO_MANY_FRINGES

    # A ruled grid.
    TOO_FEW_PIXELS_OF_GRID = "{pixels} pixels can be used: the image is dark or masked"
    NO_GRID = "no grid: no two directions of evenly spaced lines were found"
    NO_GRID_COHERENCE = "no grid found: line coherence is {coherence:.2g}; at least {least:.2g} is required"
    GRID_TOO_SMALL = "no square grid: its lines cover too little of the picture"
    GRID_NOT_SQUARE = GridWords.GRID_NOT_SQUARE
    DIVISION_TREATED_AS_EXACT = (
        "no standard deviation is given for division: treated as exact, and the uncertainty does not include it"
    )
    PIXELS_NOT_SQUARE = GridWords.PIXELS_NOT_SQUARE
    DISTANCE_TREATED_AS_EXACT = "no standard deviation is given for distance: it is treated as exact"
    PIXELS_TAKEN_AS_SQUARE = "two points measure the scale one way only: pixels are taken as square, seen from above"
    POINTS_TOO_NEAR = "the points are {length:.3g} px apart, which do not determine a scale; take points farther apart"
    PICTURE_OF_OTHER_SIZE = "half diagonals of {picture:.4g} px, that of the grid {grid:.4g} px: taken as a cut"
    LARGER_THAN_GRID = "the picture is larger than the grid's: another camera, or resized; measure its own scale"
    STRETCHED_OTHERWISE = GridWords.STRETCHED_OTHERWISE

    # A table of ring readings: what was read.
    ROWS_LEFT_OUT = "{rows} with an empty cell left out"
    ROWS_WITHOUT_ORDER = "{listed}: the order is no number; left out"
    CENTRE_LEFT_OUT = "{readings} of radius 0 (order {orders}): the centre, no ring; left out"
    COLUMN_TAKEN = "{column} was taken for {meaning}; if it is not, name the column with columns or --column"
    COLUMNS_UNITED = "{columns} are readings of the same rings, each of which counts"
    MEAN_NOT_USED = "{column} was not used: it is the mean of {sizes}"
    SQUARES_TAKEN = "{column} was taken for squares: their roots are {sizes}, with equal errors of the squares"
    COLUMN_NOT_USED = "{column} was not used: the sizes are those of {sizes}"
    COLUMN_WITHOUT_UNIT = "{column} has no unit: taken in {unit}, as {sizes}"
    SERIES_NOT_USED = "the series are those of {series}; not of {further} (name the column with columns or --column)"
    COLUMNS_DISAGREE = "{column} and {sizes} disagree by up to {deviation:.1%}: {sizes} was used"

    # What contradicts its line.
    ONE_RING = "readings of {count} ring; a {measured} needs at least two orders"
    MIXED_SERIES = "{series}; set them right in the table"
    MIXED_SIZES = "{mixture}; set them right in the table"
    MIXED_SIZES_SET_RIGHT = "{mixture}; set them right in the table; the {measured} is then {value}"
    RINGS_BEYOND_LENS = "the ring radii exceed the lens radius that they imply; check the units"
    NOT_GROWING = "the radii do not grow with the order; count orders from the centre outwards"
    NO_LINE = "{bend}: such readings give no {measured}"
    NO_PIXEL_SIZE = "without a pixel size there is no radius: the fringe scale is the answer"
    BEYOND_BOUNDS = "the {measured} is {value:.4g}{unit}; check units and columns; allowed: {low:g} to {high:g}{unit}"
    DOUBTED_BEYOND_BOUNDS = "{doubt}; allowed: {low:g} to {high:g}{unit}"
    INTERVAL_REACHES_ZERO = (
        "the readings do not determine the {measured}: {value}, and the 95 % interval reaches zero; it is below "
        "{highest:.3g}{unit}{suspects}; read more rings, or state the readings' sd"
    )
    OWN_INTERCEPTS = "the series are counted from different rings: each has an intercept of its own"
    TWO_READINGS = "two readings give a line but no standard deviation; read more rings, or state sd_mm"
    SERIES_DIFFER = "the series differ by more than their readings' errors ({values}): the spread is in the budget"
    BENT_LINE = "{bend}: half of that change is in the budget; check orders and readings"
    READINGS_LEFT_OUT = "{count} readings ({listed}) lie off the line of the others and were left out"
    READING_LEFT_OUT = "1 reading ({listed}) lies off the line of the others and was left out"
    LEFT_OUT_AT_SIZE = "{count} of the readings left out {verb} on the line at {factor} the size: {look}?"
    ORDERS_SET_RIGHT = "{count} orders were miscounted by a whole ring and set right; see their flags"
    LIKELY_MISREAD = "the readings do not lie on a line; order {orders} is the likeliest to be misread"
    ORDERS_MISCOUNTED = (
        "the readings up to order {before:g} and from order {after:g} on lie on lines of one slope that are "
        "{rings:.2g} +/- {sd:.1g} orders {distance} apart than counted; {proposals}; the answer is the slope of the "
        "two sides alone"
    )
    COUNT_NOT_EXCLUDED = (
        "the readings do not exclude a miscount between orders {before:g} and {after:g}: then the {measured} would be "
        "{values}; read the rings between them"
    )
    NOT_THROUGH_CONTACT = (
        "the line does not pass through the contact order (offset {offset:+.2g} orders): {count}the surfaces do not "
        "touch; the {measured} comes from the slope and is not affected"
    )
    OTHER_LAW_THROUGH_CONTACT = (
        "the line does not pass through the contact order (offset {offset:+.2g} orders), and {law}: with a gap the "
        "{measured} is right, with that law there is none; read more rings"
    )
    ONLY_ROUNDING = (
        "the readings lie closer to their line than {column}, read to {division}, can tell: the standard deviation is "
        "that of the rounding, once for equal repeats of a ring"
    )
    SHARED_RING_ERROR = (
        "readings of one ring agree {common:.2g} times better than the rings lie on the line: they share its error, so "
        "the rings are counted and not the readings"
    )
    SCATTER_ABOVE_STATED = "the readings scatter {ratio:.2g} times as far as their stated sd: the scatter's was used"
    SCATTER_BELOW_STATED = (
        "the readings scatter {ratio:.2g} times as far as their stated sd, which was used: by their scatter the "
        "{measured}'s sd is {by_scatter} and not {stated}"
    )
    BEYOND_SENSIBLE = (
        "the {measured} of {value:.4g}{unit} is beyond {low:g} to {high:g}{unit}: check units, columns and "
        "what is given{slip} (name the column with columns or --column)"
    )
    NOT_AS_EXPECTED = (
        "the {measured} is {ratio:.2g} times the expected one{slip} (name the column with columns or --column)"
    )

    # Several results in one question.
    RESULTS_DIFFER = (
        "the results differ in the {measured} {ratio:.2g} times as far as their own errors: the spread is in the budget"
    )

    # Positions of straight fringes, as of a wedge.
    FEW_FRINGES_OF_WEDGE = WedgeWords.FEW_FRINGES_OF_WEDGE
    NO_SPACING = WedgeWords.NO_SPACING
    WEDGE_TOO_STEEP = WedgeWords.WEDGE_TOO_STEEP
    FRINGES_MISCOUNTED = WedgeWords.FRINGES_MISCOUNTED
    UNEVEN_FRINGES = WedgeWords.UNEVEN_FRINGES

    # Several pictures in one answer.
    PICTURE_LEFT_OUT = TogetherWords.PICTURE_LEFT_OUT
    TOO_FEW_PICTURES = TogetherWords.TOO_FEW_PICTURES
    PICTURE_CONTRADICTS = TogetherWords.PICTURE_CONTRADICTS
    PICTURES_CONTRADICT = TogetherWords.PICTURES_CONTRADICT
    NO_COMMON_VALUE = TogetherWords.NO_COMMON_VALUE
    GAP_ORDER_UNDECIDED = TogetherWords.GAP_ORDER_UNDECIDED
    PHASES_CONTRADICT = TogetherWords.PHASES_CONTRADICT

    # The form of a surface.
    PUPIL_NOT_SEEN = FormWords.PUPIL_NOT_SEEN
    PUPIL_TOO_SMALL = FormWords.PUPIL_TOO_SMALL
    FORM_NO_FRINGES = FormWords.FORM_NO_FRINGES
    FORM_NOT_CONFIRMED = FormWords.FORM_NOT_CONFIRMED
    FORM_FEW_FRINGES = FormWords.FORM_FEW_FRINGES
    FORM_NOT_CONVERGED = FormWords.FORM_NOT_CONVERGED
    FORM_SIGN_OPEN = FormWords.FORM_SIGN_OPEN
    FORM_SIGN_UNDECIDED = FormWords.FORM_SIGN_UNDECIDED
    FORM_RIVALS = FormWords.FORM_RIVALS
    FRAMES_NOT_STEPPED = FormWords.FRAMES_NOT_STEPPED
    FRAMES_ALIKE = FormWords.FRAMES_ALIKE
    FRAME_CONTRADICTS = FormWords.FRAME_CONTRADICTS
