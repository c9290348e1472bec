"""Standard deviations of given numbers: in the number's unit, or as a percentage of its value."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from newtonjax.scene import RELATIVE_SD

if TYPE_CHECKING:
    from fitting.parameters.bench import Knob

# A standard deviation: a number in the unit of what it belongs to, or a text such as "0.1%".
Deviation = float | int | str
Deviations = Mapping[str, Deviation]
# What may be 0, and have a deviation all the same.
_ABOUT_ZERO = ("angle",)


def absolute_sd(name: str, sd: Deviation | None, value: Any) -> float | None:
    """The standard deviation of a given quantity, in its unit; None where there is none.

    Raises ValueError for what is not a standard deviation, for one of a quantity that is not given, and for more than a
    quarter of its value.
    """
    if sd is None:
        return None
    is_relative, size = _read(sd)
    if not 0 <= size < np.inf:
        raise ValueError(f'{name}_sd is {sd}; allowed: zero or a positive number in SI units, or a text such as "0.1%"')
    if size and value is None:
        raise ValueError(f"{name}_sd is given without {name}; give both, or neither")
    if value is None:
        return size
    if is_relative and size and not float(value):
        raise ValueError(f"{name}_sd is {sd} of {name}, which is 0; give {name}_sd in SI units")
    absolute = size * abs(float(value)) if is_relative else size
    if name not in _ABOUT_ZERO and absolute > RELATIVE_SD * abs(float(value)):
        raise ValueError(
            f"{name}_sd is {sd} of {name}, {float(value):g}; allowed: up to a quarter of it; check the units"
        )
    return absolute


def relative_or_absolute_sd(knob: "Knob", sd: Deviation) -> tuple[bool, float]:
    """Whether it is a fraction of a bench's number ("0.1%"), and the standard deviation.

    Raises ValueError for what is not a standard deviation, and for a percentage of a number that is 0.
    """
    is_relative, size = _read(sd)
    if not 0 <= size < np.inf:
        raise ValueError(f"sd: {knob.name} is {sd!r}; allowed: a standard deviation in its unit, or a percentage")
    if is_relative and not knob.value:
        raise ValueError(f"sd: {knob.name} is 0, and {sd} of 0 is 0; give it in {knob.unit or 'plain numbers'}")
    return is_relative, size


def _read(sd: Any) -> tuple[bool, float]:
    """Whether it is a percentage, and its size: a fraction then; NaN for what is not a number."""
    text = sd.strip() if isinstance(sd, str) else ""
    is_relative = text.endswith("%")
    try:
        return is_relative, 0.01 * float(text[:-1]) if is_relative else float(np.asarray(sd).item())
    except (TypeError, ValueError):
        return is_relative, np.nan


def check_not_free(sd: Deviations, free: tuple[str, ...]) -> None:
    """Raise ValueError for numbers that the fit determines."""
    if both_ways := sorted(set(sd) & set(free)):
        raise ValueError(f"{', '.join(both_ways)} is free: the fit determines it; sd: numbers that the fit is given")
