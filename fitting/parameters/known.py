"""How well a number is known that a fit holds: a standard deviation in its unit, or a share of its value."""

from collections.abc import Mapping

import numpy as np

from fitting.parameters.bench import Knob

Known = Mapping[str, float | int | str]


def deviation(knob: Knob, sd: float | int | str) -> tuple[bool, float]:
    """Whether it is a share of the value ("0.1%"), and the standard deviation.

    Raises ValueError for what is none, and for a share of a number that is 0.
    """
    text = str(sd).strip()
    share = text.endswith("%")
    try:
        value = float(text.removesuffix("%")) * (0.01 if share else 1.0)
    except ValueError:
        value = np.nan
    if not 0 <= value < np.inf:
        raise ValueError(f"known: {knob.name} is {sd!r}; allowed: a standard deviation in its unit, or a percentage")
    if share and not knob.value:
        raise ValueError(f"known: {knob.name} is 0 here, of which {sd} is nothing; give it in {knob.unit or 'units'}")
    return share, value


def require_held(known: Known, free: tuple[str, ...]) -> None:
    """Raise ValueError for numbers that the fit finds."""
    if both_ways := sorted(set(known) & set(free)):
        raise ValueError(f"{', '.join(both_ways)} is found by the fit; known: numbers that it holds")
