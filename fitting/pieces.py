"""Pieces of the sentences in `reasons.py`: templates whose sentences are values of others."""

from enum import unique

from newtonjax.numerics import Wording


@unique
class Piece(Wording):
    """Parts of sentences, where one has them and another of the same name has not."""

    SERIES_AT_SIZE = "series {names} {verb} {ratio} times the {remaining} in r²: {look}"
    READINGS_AT_SIZE = (
        "the readings from order {first:g} on lie on the line at {factor} their size: they look like {look}"
    )
    BEND = (
        "r² against order is not a straight line: curvature of {deviations:+.1f} standard deviations, the slope "
        "changes by {change:+.0%} over the table{law}"
    )
    BEND_BY_LAW = "; {law}, not Newton's rings of a sphere"
    ANOTHER_LAW = "{power} against order is a line through contact as well: {law}"
    COUNTED_TOO_LOW = "the orders may be counted {rings} too low, or "
    COUNTED_TOO_HIGH = "the orders may be counted {rings} too high, or "
    RINGS_BETWEEN = "if {rings} between them, {then}"
    NO_RINGS_BETWEEN = "no whole number of rings explains it"
    SLIP = ": {look}; if so, the {measured} is {value:.4g}{unit}"
    SIZES_LOOK_LIKE = "what the table calls {called} look like {look}"
    UNIT_LOOKS_LIKE = "what the table calls {unit} looks like {look}"
