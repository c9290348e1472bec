"""Numbers in text: rounded to the second digit of their standard deviation."""

import math


def rounded(value: float, sd: float | None = None) -> str:
    """A value to the second digit of its standard deviation; to six digits where there is none."""
    if not sd or not math.isfinite(sd) or not math.isfinite(value) or value == 0:
        return f"{value:.6g}"
    # Of the deviation as it is printed: 0.0996 is 0.10.
    last = _order(float(_digits(sd, 2))) - 1
    return _digits(value, _order(round(value, -last) or value) - last + 1)


def with_sd(value: float, sd: float | None, unit: str = "") -> str:
    """Value, standard deviation and unit: "0.879 ± 0.016 m"."""
    deviation = "" if sd is None else f" ± {_digits(sd, 2) if sd else '0'}"
    return f"{rounded(value, sd)}{deviation} {unit}".rstrip()


def with_unit(name: str, unit: str) -> str:
    """A quantity's name with its unit: "radius [m]"."""
    return f"{name} [{unit}]" if unit else name


def _order(value: float) -> int:
    return math.floor(math.log10(abs(value)))


def _digits(value: float, count: int) -> str:
    """To so many digits, zeros at the end included."""
    return f"{value:#.{max(count, 1)}g}".replace(".e", "e").removesuffix(".")
