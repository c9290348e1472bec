"""Names of columns: what a header says of kind and unit, in the spellings that people use."""

import re
from collections.abc import Iterable

METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6}
UNITS = (*METRES, "px")
# In the order of preference of sizes.
SIZES = ("left", "diameter", "radius", "right")
NAMES = ("order", "series", *(f"{kind}_{unit}" for kind in (*SIZES, "sd") for unit in UNITS))
_UNIT_WORDS = {unit: unit for unit in UNITS} | {
    "metre": "m", "meter": "m", "metres": "m", "meters": "m",
    "micron": "um", "microns": "um", "micrometre": "um", "micrometer": "um", "micrometres": "um", "micrometers": "um",
    "millimetre": "mm", "millimeter": "mm", "millimetres": "mm", "millimeters": "mm",
    "centimetre": "cm", "centimeter": "cm", "centimetres": "cm", "centimeters": "cm",
    "pixel": "px", "pixels": "px",
}  # fmt: skip
_DEVIATIONS = {"sd", "sigma", "error", "err", "uncertainty", "std", "stdev", "stddev", "deviation"}
_SERIES = {"series", "run", "set", "trial", "observer", "repeat", "measurement"}
_FILLERS = {"ring", "rings", "of", "the", "reading", "readings", "standard", "side"}
_LETTERS = {"d": "diameter", "r": "radius"}
_ORDER_LETTERS = {"m", "n", "k", "p"}
# What a column of orders is called by those who do not call it that.
_ORDER_LIKE = {"m", "n", "k", "p", "ring", "number", "no", "nr", "index", "i", "fringe", "#"}
_SIGNS = str.maketrans({"µ": "u", "μ": "u", "σ": " sigma ", "±": " sd "})


def canonical(header: str) -> str:
    """The name of `NAMES` that a header means, the same without its unit where it has none, or "" for another column.

    A column of deviations is "sd", with the kind of size between where the header names one: "sd_radius_mm".
    """
    words = [word for word in _words(header) if word not in _FILLERS]
    if "order" in words and all(word in _ORDER_LETTERS or word == "order" for word in words):
        return "order"
    if len(words) == 1 and words[0] in _SERIES:
        return "series"
    is_deviation = any(word in _DEVIATIONS for word in words)
    words = [word for word in words if word not in _DEVIATIONS]
    unit = _UNIT_WORDS.get(words[-1], "") if words else ""
    kinds = words[:-1] if unit else words
    if is_deviation:
        kinds = [_LETTERS.get(kind, kind) for kind in kinds]
        return "_".join(filter(None, ["sd", *kinds, unit])) if all(kind in SIZES for kind in kinds) else ""
    return "_".join(filter(None, [*kinds, unit])) if len(kinds) == 1 and kinds[0] in SIZES else ""


def unit_of(header: str) -> str:
    """The unit that a header states after its name: "D (cm)", "D, cm", "D / cm", "D [cm]", "D_cm"; "" without one."""
    words = _words(header)
    return _UNIT_WORDS.get(words[-1], "") if len(words) > 1 else ""


def is_deviation(header: str) -> bool:
    """Whether a header speaks of deviations."""
    return any(word in _DEVIATIONS for word in _words(header))


def order_like(headers: Iterable[str]) -> str:
    """The first header that may be that of the orders; "ITS-NAME" without one."""
    return next((header for header in headers if header.strip().lower() in _ORDER_LIKE), "ITS-NAME")


def size_advice(headers: Iterable[str]) -> str:
    """How to name a column of sizes: with the unit that its header states."""
    stated = [(header, unit_of(header)) for header in headers if unit_of(header) and not is_deviation(header)]
    if not stated:
        return "name one with its unit, such as diameter_mm=ITS-NAME for diameters in mm"
    header, unit = stated[0]
    return f"name one, such as diameter_{unit}={header} or radius_{unit}={header}"


def _words(header: str) -> list[str]:
    return [word for word in re.split(r"[\s_,;:/()\[\]{}.|-]+", header.translate(_SIGNS).lower()) if word]
