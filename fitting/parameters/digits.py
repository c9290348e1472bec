"""Numbers in text: rounded to the second digit of their standard deviation, lengths in a unit of their size."""

import math
from collections.abc import Sequence
from typing import Any

# Units of length from their least size on [m].
_LENGTHS = ((0.1, "m"), (1e-4, "mm"), (1e-6, "um"), (0.0, "nm"))
# Digits of what was given.
_GIVEN = 10
_PER_METRE = {"m": 1.0, "mm": 1e3, "um": 1e6, "nm": 1e9}


def rounded(value: float, sd: float | None = None, digits: int = 6) -> str:
    """A value to the second digit of its standard deviation; to so many digits where there is none."""
    if not sd or not math.isfinite(sd) or not math.isfinite(value) or value == 0:
        return f"{value:.{digits}g}"
    # Of the deviation as it is printed: 0.0996 is 0.10.
    last = _order(float(_digits(sd, 2))) - 1
    return _digits(value, _order(round(value, -last) or value) - last + 1)


def length_unit(*sizes: float | None, unit: str = "m") -> tuple[float, str]:
    """How many of m, mm, um or nm a metre has, by the largest size [m], and which; 1 and `unit` where it is not "m"."""
    size = max((abs(size) for size in sizes if size is not None), default=0.0)
    if unit != "m" or not 0 < size < math.inf:
        return 1.0, unit
    name = next(name for least, name in _LENGTHS if size >= least)
    return _PER_METRE[name], name


def with_sd(value: float, sd: float | None, unit: str = "", digits: int = 6) -> str:
    """Value, standard deviation and unit: "0.879 ± 0.016 m", "9.857 ± 0.014 mm"; `digits` without a deviation."""
    factor, unit = length_unit(value, sd, unit=unit)
    value, sd = value * factor, None if sd is None else sd * factor
    deviation = "" if sd is None else f" ± {_digits(sd, 2) if sd else '0'}"
    return f"{rounded(value, sd, digits)}{deviation} {unit}".rstrip()


def text_of(number: Any) -> str:
    """Value, standard deviation and unit of a `Parameter`."""
    # What was given is shown as it was; a fitted number without a deviation has no tenth digit.
    return with_sd(number.value, number.sd or None, number.unit, _GIVEN if number.fixed else 6)


def between(ends: Sequence[float], sd: float | None, unit: str = "") -> str:
    """An interval (low, high), to the digits of a standard deviation: "9.829 to 9.884 mm"."""
    factor, unit = length_unit(*ends, unit=unit)
    low, high = (rounded(end * factor, None if sd is None else sd * factor) for end in ends)
    return f"{low} to {high} {unit}".rstrip()


def exact(value: float, unit: str = "") -> str:
    """What was given, with all its digits: "589.3 nm"."""
    return with_sd(value, None, unit, _GIVEN)


def with_unit(name: str, unit: str) -> str:
    """A quantity's name with its unit: "radius [m]"."""
    return f"{name} [{unit}]" if unit else name


def _order(value: float) -> int:
    return math.floor(math.log10(abs(value)))


def _digits(value: float, count: int) -> str:
    """To so many digits, zeros at the end included."""
    return f"{value:#.{max(count, 1)}g}".replace(".e", "e").removesuffix(".")
