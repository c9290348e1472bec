"""Quantities at the shell: a number with its unit, read by pint and turned into SI."""

import functools
import math
import re
from collections.abc import Callable
from decimal import Decimal

_NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*)", re.DOTALL)
_COMMA = re.compile(r"[+-]?\d+,\d")
_UNIT = re.compile(r"[^\W\d_]+|°")
_EXAMPLES = {"length": "nm, um, mm, cm or m, as in 589.3nm", "angle": "mrad, rad, deg or arcsec, as in 0.1mrad"}
# Read without pint, whose registry takes longer to build than the other units are worth.
_USUAL = {
    "length": {
        "nm": 1e-9,
        "um": 1e-6,
        "\N{MICRO SIGN}m": 1e-6,
        "\N{GREEK SMALL LETTER MU}m": 1e-6,
        "mm": 1e-3,
        "cm": 1e-2,
        "m": 1.0,
        "km": 1e3,
    },
    "angle": {"rad": 1.0, "mrad": 1e-3, "deg": math.pi / 180},
}
_KNOWN = {
    "length": ("meter", "micron", "angstrom", "inch", "foot", "thou", "mil"),
    "angle": ("radian", "degree", "arcminute", "arcsecond", "turn", "gradian"),
}


@functools.cache
def _registry():
    import pint

    return pint.UnitRegistry(cache_folder=None)


def length(text: str) -> float:
    """Metres of a length such as "589.3nm".

    Raises ValueError, in one line with what was given and what is allowed, for a number without a unit, for a unit of
    another kind and for what is no number or not finite.
    """
    return _si(text, "length")


def angle(text: str) -> float:
    """Radians of an angle such as "0.1mrad"; errors as in `length`."""
    return _si(text, "angle")


def positive_length(text: str) -> float:
    """Metres of a length above zero; errors as in `length`."""
    value = length(text)
    if value <= 0:
        raise ValueError(f"{text!r} is not above zero; give a positive length, in {_EXAMPLES['length']}")
    return value


def length_range(text: str) -> tuple[float, float]:
    """Metres of the lowest and the highest length, such as "0um,5um"; errors as in `length`."""
    ends = [length(end) for end in text.split(",")]
    if len(ends) != 2 or not ends[0] < ends[1]:
        raise ValueError(f"{text!r} is no range; give the lowest and the highest length, as in 0um,5um")
    return ends[0], ends[1]


def number(text: str) -> float:
    """A number without a unit. Raises ValueError for what is none."""
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"{text!r} is not a number; give one without a unit, such as 1.5") from None


def length_sd(text: str) -> float | str:
    """Metres of a standard deviation of a length, or the text of a percentage; errors as in `length`."""
    return _sd(text, length, f"in {_EXAMPLES['length']}")


def angle_sd(text: str) -> float | str:
    """Radians of a standard deviation of an angle, or the text of a percentage; errors as in `length`."""
    return _sd(text, angle, f"in {_EXAMPLES['angle']}")


def number_sd(text: str) -> float | str:
    """A standard deviation of a number without a unit, or the text of a percentage; errors as in `number`."""
    return _sd(text, number, "as in 0.001")


def _sd(text: str, read: Callable[[str], float], example: str) -> float | str:
    if text.strip().endswith("%"):
        match = _NUMBER.fullmatch(text.strip())
        if not match or match[2] != "%" or not 0 <= float(match[1]) < math.inf:
            raise ValueError(f"{text!r} is no percentage; give zero or more, as in 0.1%")
        return text.strip()
    value = read(text)
    if not 0 <= value < math.inf:
        raise ValueError(f"{text!r} is negative or no number; give zero or more, {example}, or as in 0.1%")
    return value


def _si(text: str, kind: str) -> float:
    offered = _EXAMPLES[kind]
    match = _NUMBER.fullmatch(text.strip())
    if _COMMA.match(text.strip()):
        raise ValueError(f"{text!r} has a decimal comma; write a point: {text.strip().replace(',', '.', 1)}")
    if not match:
        raise ValueError(f"{text!r} is no {kind}; give a number and a unit: {offered}")
    digits, unit = match.groups()
    if not unit:
        raise ValueError(f"{text!r} has no unit; give one of {offered}")
    factor = _factor(unit, kind)
    if factor is None:
        raise ValueError(f"{text!r}: {unit!r} is no unit of {kind}; give one of {offered}")
    # In decimal: 635 nm is 6.35e-07 m, where the product of two floats is 6.350000000000001e-07 m.
    value = float(Decimal(digits) * Decimal(repr(factor)))
    if not math.isfinite(value):
        raise ValueError(f"{text!r} is too large; give a finite {kind}")
    return value


def _factor(unit: str, kind: str) -> float | None:
    """The SI value of one unit; None where pint does not know it or it measures something else."""
    if unit in _USUAL[kind]:
        return _USUAL[kind][unit]
    import pint

    if not _UNIT.fullmatch(unit):  # one word: pint itself would go on to products and powers
        return None
    registry = _registry()
    base = registry.Unit("meter" if kind == "length" else "radian")
    try:
        root = registry.Quantity(1.0, registry.parse_units(unit)).to_root_units()
    except (pint.PintError, ValueError):
        return None
    # Root units, not dimensions: to pint an angle is dimensionless, and so is a percentage. And by name: to pint a
    # pixel is the 96th part of an inch.
    supported = str(registry.parse_units(unit)).endswith(_KNOWN[kind])
    return float(root.magnitude) if supported and root.units == base else None
