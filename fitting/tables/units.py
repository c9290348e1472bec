"""Units that a header states in a way of its own: powers of ten before a unit, inches and thousandths of them."""

import re

from fitting.tables.headers import METRES, UNIT_WORDS
from fitting.tables.vocabulary import folded

# Units with the one of ours that stands in their place, and how many of it they are.
_UNITS = {
    "in": ("mm", 25.4), "inch": ("mm", 25.4), "inches": ("mm", 25.4), "mil": ("mm", 0.0254), "mils": ("mm", 0.0254),
    "thou": ("mm", 0.0254), "nm": ("um", 1e-3), "dm": ("cm", 10.0),
}  # fmt: skip
# "(x10^-3 m)", "[10⁻⁶ m²]", "/ 10-6 m^2", "(m·10^-3)", "(in)": at the end of a header, in brackets or after a stroke.
_UNIT = re.compile(r"\s*(?:[(\[]([^()\[\]]*)[)\]]|/\s*([^/()\[\]]+))\s*$")
_POWER = r"(?:[x*.×·]\s*)?10\s*(?:\^|\*\*|e)?\s*\{?([+-]?\d{1,2})\}?"
_NAME = r"([a-z]+?)\s*(2|\^\s*\{?2\}?|squared)?"
_BEFORE = re.compile(rf"(?:{_POWER}\s*[*.·]?\s*)?{_NAME}")
_AFTER = re.compile(rf"{_NAME}\s*{_POWER}")
_MINUS = str.maketrans("−–—", "---")


def in_usual_unit(header: str) -> tuple[str, float]:
    """The header with a unit of `headers.UNITS` in place of its own, and what its numbers are to be multiplied by.

    "r² (10⁻⁶ m²)" is "r² (m²)", 1e-6; "D (in)" is "D (mm)", 25.4. Another header stays as it is, with 1.
    """
    match = _UNIT.search(header)
    stated = folded(match[1] or match[2]).translate(_MINUS).replace(" squared", "squared").strip() if match else ""
    before, after = _BEFORE.fullmatch(stated), _AFTER.fullmatch(stated)
    if before:
        power, unit, square = before.groups()
    elif after:
        unit, square, power = after.groups()
    else:
        return header, 1.0
    name, factor = _UNITS.get(unit, (UNIT_WORDS.get(unit, ""), 1.0))
    if name not in METRES or (power is None and unit not in _UNITS):
        return header, 1.0
    start = match.start() if match else len(header)
    return f"{header[:start]} ({name}{'²' if square else ''})", factor ** (2 if square else 1) * 10.0 ** int(power or 0)
