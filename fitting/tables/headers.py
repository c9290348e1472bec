"""Names of columns: what a header says of kind and unit, in the spellings that people use."""

import re
from collections.abc import Iterable

from fitting.tables.vocabulary import words_of

METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6}
UNITS = (*METRES, "px")
# Kinds of sizes in their order of preference: the ring's radius over what such a column holds. "left" holds the
# distance to "right", its partner.
RADIUS_OVER = {"left": 0.5, "diameter": 0.5, "radius": 1.0, "position": 1.0}
SIZES = (*RADIUS_OVER, "right")
NAMES = ("order", "series", *(f"{kind}_{unit}" for kind in (*SIZES, "sd") for unit in UNITS))
UNIT_WORDS = {unit: unit for unit in UNITS} | {
    "metre": "m", "meter": "m", "metres": "m", "meters": "m",
    "micron": "um", "microns": "um", "micrometre": "um", "micrometer": "um", "micrometres": "um", "micrometers": "um",
    "millimetre": "mm", "millimeter": "mm", "millimetres": "mm", "millimeters": "mm",
    "centimetre": "cm", "centimeter": "cm", "centimetres": "cm", "centimeters": "cm",
    "pixel": "px", "pixels": "px", "divisions": "px",
}  # fmt: skip
DEVIATIONS = {"sd", "sigma", "error", "err", "uncertainty", "std", "stdev", "stddev", "deviation", "u"}
_SERIES = {"series", "run", "set", "trial", "observer", "repeat", "measurement"}
FILLERS = {
    "ring", "rings", "of", "the", "reading", "readings", "standard", "side", "x", "dark", "bright", "edge", "total",
    "tr",     "value", "values", "measured", "microscope", "oldal",
}  # fmt: skip
ORDER_LETTERS = {"m", "n", "k", "p"}
_LETTERS = {"d": "diameter", "r": "radius"}
# "dm" is the diameter of ring m.
LETTERS = _LETTERS | {f"{letter}{ring}": kind for letter, kind in _LETTERS.items() for ring in (*ORDER_LETTERS, "i")}
# What a column of orders is called by those who do not call it that.
_RANKS = (
    {"order"}, {"m", "n", "k", "p", "j", "i"}, {"ring", "rings", "fringe"}, {"number", "no", "nr", "index", "#"},
)  # fmt: skip
ORDER_LIKE = set().union(*_RANKS)
_BESIDE_ORDERS = {"of", "the", "dark", "bright"}
# What is not proposed for a size: it would be read as another one.
_NO_SIZES = {"squared", "left", "right", "position", "main", "vernier", "x", "y"}
# "0.1 um": units of so much, or what the instrument reads.
_SHARE_OF_UNIT = re.compile(r"\d[.,]\d+\s*[^\W\d_]")
# Of the ring, of the order: in French and Italian.
_ARTICLES = {"l", "d", "dell"}


def canonical(header: str) -> str:
    """The name of `NAMES` that a header means, the same without its unit where it has none, or "" for another column.

    A column of deviations is "sd", with the kind of size between where the header names one: "sd_radius_mm".
    """
    words = [word for word in words_of(header) if word not in FILLERS]
    # "in" is an inch where no other unit follows.
    words = [word for k, word in enumerate(words) if word != "in" or not set(words[k + 1 :]) & UNIT_WORDS.keys()]
    if "order" in words and all(word in ORDER_LETTERS or word == "order" for word in words):
        return "order"
    if len(words) == 1 and words[0] in _SERIES:
        return "series"
    is_deviation = any(word in DEVIATIONS for word in words)
    words = [word for word in words if word not in DEVIATIONS]
    unit = UNIT_WORDS.get(words[-1], "") if words else ""
    kinds = words[:-1] if unit else words
    if is_deviation:
        kinds = [LETTERS.get(kind, kind) for kind in kinds]
        return "_".join(filter(None, ["sd", *kinds, unit])) if all(kind in SIZES for kind in kinds) else ""
    return "_".join(filter(None, [*kinds, unit])) if len(kinds) == 1 and kinds[0] in SIZES else ""


def unit_of(header: str) -> str:
    """The unit that a header states after its name: "D (cm)", "D, cm", "D / cm", "D [cm]", "D_cm"; "" without one."""
    words = words_of(header)
    return UNIT_WORDS.get(words[-1], "") if len(words) > 1 else ""


def is_deviation(header: str) -> bool:
    """Whether a header speaks of deviations."""
    return any(word in DEVIATIONS for word in words_of(header))


def order_rank(header: str) -> int | None:
    """How surely a header is that of the orders, 0 the surest; None for another one."""
    words = set(words_of(header)) - _BESIDE_ORDERS
    if words & {"ring", "fringe", "order"}:
        words -= _ARTICLES
    if not words or not words <= ORDER_LIKE:
        return None
    return next(rank for rank, likely in enumerate(_RANKS) if words & likely)


def order_like(headers: Iterable[str]) -> str:
    """The first header that may be that of the orders; "ITS-NAME" without one."""
    return next((header for header in headers if header.strip().lower() in ORDER_LIKE), "ITS-NAME")


def is_no_size(header: str) -> bool:
    """Whether a header says that its column is no diameter or radius as it stands: an order, a square, one side."""
    words = set(words_of(header))
    squares = {f"{unit}2" for unit in METRES}
    is_share = _SHARE_OF_UNIT.search(header) is not None
    return is_share or bool(words & (_NO_SIZES | squares)) or order_rank(header) is not None


def size_advice(headers: Iterable[str]) -> str:
    """How to name a column of sizes: with the unit that its header states."""
    stated = [
        (header, unit_of(header))
        for header in headers
        if unit_of(header) and not is_deviation(header) and not is_no_size(header)
    ]
    if not stated:
        return "name one with its unit, such as diameter_mm=ITS-NAME for diameters in mm"
    header, unit = stated[0]
    return f"name one, such as diameter_{unit}={header} or radius_{unit}={header}"
