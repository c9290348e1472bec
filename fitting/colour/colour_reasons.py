"""What the fit of all channels together may say: sentences of results by name, as in `fitting/reasons.py`."""

from enum import unique

from newtonjax.numerics import Wording


@unique
class ColourReason(Wording):
    """Sentences of `message` and `warnings` about the light of a photograph."""

    LINES_NOT_SEEN = (
        "the rings do not show the lines of this light: bands without lines explain them as well (odds of e^{odds:.1f} "
        "for the lines, at least e^{least:g} are required); a radius needs lines, or one wavelength "
        "with its standard deviation, of an LED or behind a filter"
    )
    ONE_LINE_SEEN = (
        "the rings show one line alone, not the several of this light: any single line explains them as well (odds of "
        "e^{odds:.1f} for the several, at least e^{least:g} are required), and which it is they do not tell; give the "
        "line, such as light='mercury:546nm', or its wavelength"
    )
    ANOTHER_LAMP = (
        "these are not the rings of {lines} nm: the lines of {best} explain them better (odds of e^{odds:.0f}); give "
        "light={best!r} (--light {best}) if this was the lamp"
    )
    OTHER_CURVES = (
        "these are not the rings of this lamp under this camera: with their curves changed by {change:.1f} times what "
        "is expected, {share:.1e} of the fringes' variance is left over beyond noise, and a radius would be off by 1 "
        "to 13 %; give the curves of this lamp and this camera, or one wavelength with its standard deviation"
    )
    CURVES_OFF = (
        "the curves of lamp and camera are not quite those of the rings: changed by {change:.1f} times what is "
        "expected, they leave {share:.1e} of the fringes' variance beyond noise; {sd:.1%} of the wavelengths is in the "
        "budget"
    )
    WAVELENGTHS_ASSUMED = (
        "rings do not tell by how much all wavelengths of lamp and camera are off together: {sd:.1%} is in the budget; "
        "state it (wavelength_sd, --wavelength-sd) if their curves are better known, or worse"
    )
    FURTHER_LINES = (
        "a lamp of {lamp} has further lines, which the channels of this photograph see: with all of them the fringe "
        "scale changes by {change:.1%}, which is in the budget; give light={lamp!r} (--light {lamp}) for the radius by "
        "all lines, or photograph behind a filter"
    )
    CHANNELS_CLIPPED = (
        "the brightest rings of {channels} are cut off, below the largest code: they were left out; expose less"
    )
    CHANNELS_DARK = (
        "{channels} has light in less than half of the field of the brightest channel, or one level: it was left out"
    )
    CHANNELS_DISAGREE = (
        "the channels by themselves differ by {spread:.2%} in the {measured}, {deviations:.1f} times what their noise "
        "explains: their scatter is in the budget"
    )
    GAP_ORDER_OPEN = (
        "the gap at the centre may be off by whole half waves: the order taken has a probability of {probability:.0%}"
    )
    RATIOS_ALONE = (
        "nothing is given of the light: rings give ratios of radii, and the fringe scale of their mean wave; a radius "
        "needs a lamp (light), or a wavelength"
    )
    NO_COMMON_CHANNEL = "the pictures have no channel in common that is lit in all of them; take them under one light"
    OTHER_LIGHT = (
        "{name} is of another light than the others: beside them {worse:.0f} times as much of its rings is left over "
        "as by itself, at most {most:.0f} are allowed; ratios need pictures of one lamp through one camera"
    )
