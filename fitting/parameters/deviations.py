"""Standard deviations of numbers that a bench's fit is given."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from fitting.parameters.fringe_scale import Deviation, read_sd
from newtonjax.numerics import shown

if TYPE_CHECKING:
    from fitting.parameters.bench import Knob

Deviations = Mapping[str, Deviation]


def relative_or_absolute_sd(knob: "Knob", sd: Deviation) -> tuple[bool, float]:
    """Whether it is a fraction of a bench's number ("0.1%"), and the standard deviation.

    Raises ValueError for what is not a standard deviation, and for a percentage of a number that is 0.
    """
    is_relative, size = read_sd(sd)
    if not 0 <= size < np.inf:
        raise ValueError(f"sd: {knob.name} is {shown(sd)}; allowed: a standard deviation in its unit, or a percentage")
    if is_relative and not knob.value:
        raise ValueError(f"sd: {knob.name} is 0, and {sd} of 0 is 0; give it in {knob.unit or 'plain numbers'}")
    return is_relative, size


def check_not_free(sd: Deviations, free: tuple[str, ...]) -> None:
    """Raise ValueError for numbers that the fit determines."""
    if both_ways := sorted(set(sd) & set(free)):
        raise ValueError(f"{', '.join(both_ways)} is free: the fit determines it; sd: numbers that the fit is given")
