"""Cells of a table as people write numbers: decimal commas, units, deviations, signs of other alphabets."""

import functools
import math
import re
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fitting.tables.headers import FILLERS, METRES, ORDER_LIKE, UNIT_WORDS, words_of

# What stands where there is no reading.
_MISSING = {"", "-", "--", "---", "–", "—", "−", "/", "\\", "?", "*", "x", "...", "…", "n/a", "na", "nan", "none",
            "null", "k.a.", "n.a.", "nd", "n.d.", "н/д", "无"}  # fmt: skip
_ERROR = re.compile(r"#[\w/]+[!?]?|#{2,}|err:\d+", re.IGNORECASE)
_MINUS = str.maketrans({"−": "-", "–": "-", "—": "-", "‐": "-", "‑": "-", "﹣": "-", "－": "-", "٫": ".", "٬": ""})
_GROUPS = re.compile("(?<=\\d)[\u00a0\u202f\u2009'’](?=\\d{3}(?!\\d))")
# Signs of footnotes behind a number, and of roughness before it.
_NOTE = re.compile(r"(?<=\d)\s*(?:[*†‡§]+|(?<!10)[¹²³⁴⁵⁶⁷⁸⁹]\)?|\^?[a-d]\))$")
_ROUGHLY = re.compile(r"(?:[~≈≃]|ca?\.|about\s|approx\.?\s)\s*(?=[\d.,+-])", re.IGNORECASE)
_POWER = re.compile(r"\s*[x×*·⋅]\s*10\s*(?:\^|\*\*)?\s*[{(]?([+-−]?\d{1,2}|[⁺⁻]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+)[})]?")
_BRACKETS = re.compile(r"\(([^()]*(?:±|\+/-)[^()]*)\)")
_DIGITS = r"[+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][+-]?\d+)?"
_NUMBER = re.compile(rf"({_DIGITS})\s*(?:(?:±|\+/-|\+-)\s*({_DIGITS})|\((\d+)\))?\s*([^\W\d_]+|°)?\.?")
# Most cells, told without the pattern of all.
_SIMPLE = re.compile(r"-?\d+(?:\.\d+)?")
_PLAIN = re.compile(r"-?\d+[.,]?\d*", re.ASCII)
_THOUSANDS = re.compile(r"-?\d{1,3}(?:,\d{3})+\.\d+|-?\d{1,3}(?:,\d{3}){2,}")
# In German and others: 1.234,5.
_POINTED_THOUSANDS = re.compile(r"-?\d{1,3}(?:\.\d{3})+,\d+")
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,(\d+)(?:[eE][+-]?\d+)?")
_ORDINAL = re.compile(
    r"(\D*?)\s*(\d+)\s*(?:st|nd|rd|th|er|re|e|eme|ème|a|o|º|ª|°|-?[еяйо]|环|環|\.|\)|:)?(?:\s+(\D+))?"
)
# From here on a whole number beside "1,330" may be one beside thousands.
_HUNDREDS = 100


def is_missing(text: str) -> bool:
    """Whether a cell says that there is no reading."""
    return text.lower() in _MISSING or _ERROR.fullmatch(text) is not None


def plain(cell: str) -> str:
    """A cell without quotes and blanks, minus signs and digits as programs write them."""
    if _PLAIN.fullmatch(cell):
        return cell
    text = _GROUPS.sub("", cell.strip().strip("\"'`$").strip())
    text = _ROUGHLY.sub("", _NOTE.sub("", _POWER.sub(r"e\1", text)), count=1)
    if not text.isascii():
        text = unicodedata.normalize("NFKC", text).translate(_MINUS)
    return _BRACKETS.sub(r"\1", text)


def number_in(cell: str) -> re.Match[str] | None:
    """The number of a cell that is one, with its deviation and unit; None for text."""
    text = plain(cell)
    if _POINTED_THOUSANDS.fullmatch(text):
        text = text.replace(".", "")
    match = _NUMBER.fullmatch(text)
    if match and match[4] and unit_in(match[4]) is None:
        return None
    return match or _THOUSANDS.fullmatch(text)


def is_number(cell: str) -> bool:
    """Whether a cell holds a number, with a unit or without."""
    return _SIMPLE.fullmatch(cell) is not None or number_in(cell) is not None


@functools.lru_cache(1000)
def unit_in(text: str) -> str | None:
    """The unit of `headers.UNITS` that a word is; None for another word."""
    words = words_of(text)
    return UNIT_WORDS.get(words[0]) if len(words) == 1 else None


@dataclass(frozen=True)
class Column:
    """Cells in one way of writing: numbers with points, and text; unit and deviations that stood in the cells."""

    cells: list[str]
    unit: str = ""
    deviations: list[str] | None = None
    has_commas: bool = False

    def times(self, factor: float) -> "Column":
        """The column with its numbers and their deviations in another unit; text as it is."""
        if factor == 1:
            return self
        deviations = None if self.deviations is None else [_times(cell, factor) for cell in self.deviations]
        return replace(self, cells=[_times(cell, factor) for cell in self.cells], deviations=deviations)


def column_of(texts: Sequence[str], *, comma_separates: bool) -> Column:
    """A column's cells with what is in them brought apart. Cells that are no numbers stay as they are."""
    if all(_SIMPLE.fullmatch(text) for text in texts):
        return Column(list(texts))
    matches = [number_in(text) for text in texts]
    numbers = [_NUMBER.fullmatch(match.string) for match in matches if match]
    units = {unit_in(match[4]) for match in numbers if match and match[4]}
    has_deviations = any(match and (match[2] or match[3]) for match in numbers)
    written = [match.string if match else plain(text) for text, match in zip(texts, matches, strict=True)]
    decimals: list[str] = []
    for match in numbers:
        decimals += [] if match is None else [comma[1] for comma in [_DECIMAL_COMMA.fullmatch(match[1])] if comma]
    if _may_be_thousands(written, decimals, comma_separates):
        return Column(written)
    unit = next(iter(sorted(filter(None, units))), "")
    cells, deviations = [], []
    for text, match in zip(written, matches, strict=True):
        cell, deviation = _parts(text, match, unit)
        cells.append(cell)
        deviations.append(deviation)
    return Column(_orders(cells), unit, deviations if has_deviations else None, bool(decimals))


def _may_be_thousands(written: Sequence[str], decimals: list[str], comma_separates: bool) -> bool:
    """Whether "1,330" may be thousands: three decimals in each, beside whole numbers."""
    if not decimals or {len(digits) for digits in decimals} != {3}:
        return False
    beside = [text for text in written if text.lstrip("+-").isdigit()]
    return bool(beside) if comma_separates else any(abs(int(text)) >= _HUNDREDS for text in beside)


def _parts(text: str, match: re.Match[str] | None, unit: str) -> tuple[str, str]:
    """A cell's number in the column's unit, and its deviation; the text itself where it is no number."""
    if match is None:
        return ("" if is_missing(text) else text), ""
    number = _NUMBER.fullmatch(match.string)
    if number is None:
        return match.string.replace(",", ""), ""
    digits, deviation, last_digits, cell_unit = number.groups()
    digits = digits.replace(",", ".")
    deviation = (deviation or "").replace(",", ".")
    if last_digits:
        places = len(digits.partition(".")[2])
        deviation = f"{int(last_digits) * 10.0**-places:.12g}"
    factor = _factor(cell_unit, unit)
    if factor != 1:
        digits = f"{float(digits) * factor:.12g}"
        deviation = f"{float(deviation) * factor:.12g}" if deviation else ""
    return digits, deviation


def _times(cell: str, factor: float) -> str:
    return f"{float(cell) * factor:.12g}" if _SIMPLE.fullmatch(cell) else cell


def _factor(cell_unit: str | None, unit: str) -> float:
    metres = METRES.get(unit_in(cell_unit) or "") if cell_unit else None
    return metres / METRES[unit] if metres and unit in METRES else 1.0


def _orders(cells: list[str]) -> list[str]:
    """Cells such as "Ring 5", "5th", "n = 5" as the number in them, where most cells of a column are of that kind."""
    ordinals = [None if is_number(cell) else _ORDINAL.fullmatch(cell) for cell in cells]
    if not any(ordinals):
        return cells
    words = [words_of(f"{match[1]} {match[3] or ''}") if match else [] for match in ordinals]
    is_order = [
        match is not None and set(beside) <= ORDER_LIKE | FILLERS for match, beside in zip(ordinals, words, strict=True)
    ]
    if sum(is_order) < 2 or sum(is_order) < 0.5 * sum(bool(cell) for cell in cells):
        return cells
    return [match[2] if is_it and match else cell for cell, match, is_it in zip(cells, ordinals, is_order, strict=True)]


def numbers(cells: Sequence, name: str, lines: Sequence[int], is_row: np.ndarray | None = None) -> np.ndarray:
    """Cells as numbers, NaN for an empty one. Raises ValueError for text and infinities, with the line.

    `is_row` [rows]: where a number is needed; else text is NaN too.
    """
    values = np.empty(len(cells))
    for row, (cell, line) in enumerate(zip(cells, lines, strict=True)):
        text = str(cell).strip()
        try:
            values[row] = float(text.replace("_", "?")) if text else math.nan
        except ValueError:
            values[row] = math.nan
            if is_row is None or is_row[row]:
                raise ValueError(
                    f"line {line}, column {name}: {text[:40]!r} is not a number; give a plain number, or - to leave "
                    "the row out"
                ) from None
    if np.isinf(values).any():
        row = int(np.flatnonzero(np.isinf(values))[0])
        raise ValueError(f"line {lines[row]}, column {name}: {cells[row]!r} is not finite; give a plain number")
    return values
