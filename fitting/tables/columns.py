"""Columns of a table: from a CSV file, or from what a program holds, to lists of cells by header."""

import codecs
import csv
import math
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from fitting.tables.headers import NAMES, UNIT_WORDS, is_chinese, words_of

_WHAT = "give the path of a CSV file with a header, or columns by name such as {'order': [1, 2], 'diameter_mm': [3, 4]}"

# Excel says its delimiter in a line of its own.
_SEPARATOR = re.compile(r'\s*"?sep=([,;\t|]?).?"?\s*', re.IGNORECASE)
_DECIMAL_COMMA = re.compile(r"-?\d+,(\d+)")
_COMMENTS = ("#", "%", "//")
# Workbooks, new (a ZIP archive) and old (a compound file).
_WORKBOOKS = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")
# Characters that no table has.
_NO_TEXT = re.compile(r"[\x00-\x08\x0e-\x1b\x7f\ufffe\uffff]")


def columns_of(table: Any) -> tuple[dict[str, Sequence], list[int]]:
    """Cells by header, and the line of the file (or the row) that each row stands on.

    Raises FileNotFoundError, and ValueError for what is no table.
    """
    if isinstance(table, Mapping):
        return _of_mapping(table)
    if isinstance(table, str | Path):
        return _of_file(Path(table))
    raise ValueError(f"the table is of type {type(table).__name__}; {_WHAT}")


def numbers(cells: Sequence, name: str, lines: Sequence[int]) -> np.ndarray:
    """Cells as numbers, NaN for an empty one. Raises ValueError for text and infinities, with the line."""
    values = np.empty(len(cells))
    for row, (cell, line) in enumerate(zip(cells, lines, strict=True)):
        text = str(cell).strip()
        try:
            values[row] = float(text.replace("_", "?")) if text else math.nan
        except ValueError:
            raise ValueError(
                f"line {line}, column {name}: {text[:40]!r} is not a number; give a plain number"
            ) from None
    if np.isinf(values).any():
        row = int(np.flatnonzero(np.isinf(values))[0])
        raise ValueError(f"line {lines[row]}, column {name}: {cells[row]!r} is not finite; give a plain number")
    return values


def _of_mapping(table: Mapping) -> tuple[dict[str, Sequence], list[int]]:
    cells = {}
    for name, values in table.items():
        try:
            column = np.atleast_1d(np.asarray(values))
        except ValueError:
            raise ValueError(f"column {name!r} is ragged: lists within a list; give one number for each row") from None
        if column.ndim > 1:
            raise ValueError(f"column {name!r} has the shape {column.shape}; give one number for each row")
        cells[str(name)] = column.tolist()
    lengths = {name: len(column) for name, column in cells.items()}
    if not lengths:
        raise ValueError(f"the table has no columns; {_WHAT}")
    if len(set(lengths.values())) != 1:
        stated = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise ValueError(f"the columns have different lengths ({stated}); give one number for each row")
    return cells, list(range(1, next(iter(lengths.values())) + 1))


def _of_file(path: Path) -> tuple[dict[str, Sequence], list[int]]:
    if not path.is_file():
        raise FileNotFoundError(f"{path} is no file; give the path of a table of ring readings (CSV with a header)")
    lines = _text_of(path).splitlines()
    separators = [_SEPARATOR.fullmatch(line) for line in lines]
    numbered = [(n, line) for n, line in enumerate(lines, 1) if separators[n - 1] is None]
    rows = [(n, line) for n, line in numbered if line.strip() and not line.lstrip().startswith(_COMMENTS)]
    if len(rows) < 2:
        raise ValueError(f"{path} holds no readings; give a header and one row a ring")
    delimiter = next((match[1] for match in separators if match and match[1]), _delimiter_of(rows[0][1]))
    try:
        header, *body = csv.reader([line for _, line in rows], delimiter=delimiter)
    except csv.Error as error:
        raise ValueError(f"{path} is no CSV file ({error}); give a header and one row a ring") from None
    if len(body) != len(rows) - 1:
        raise ValueError(f"{path}: a quoted cell spans several lines; give one line a row")
    names = [name.strip() for name in header]
    if len(body) > 1 and len(body[0]) == len(names) and (units := _units(body[0])):
        names = [f"{name} ({unit})" if unit else name for name, unit in zip(names, units, strict=True)]
        del body[0], rows[1]
    names = [name.lower() if name.lower() in NAMES and name.lower() not in names else name for name in names]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ValueError(f"{path}: the header names {', '.join(map(repr, twice))} twice; give each column one name")
    if any(len(row) != len(names) for row in body):
        bad = next(n for (n, _), row in zip(rows[1:], body, strict=True) if len(row) != len(names))
        raise ValueError(f"{path}, line {bad}: its number of cells is not the header's {len(names)}")
    columns = [[row[k] for row in body] for k in range(len(names))]
    if delimiter != ",":
        columns = [[cell.replace(",", ".") for cell in column] for column in columns]
    cells: dict[str, Sequence] = {name: _with_points(column) for name, column in zip(names, columns, strict=True)}
    return cells, [n for n, _ in rows[1:]]


def _text_of(path: Path) -> str:
    """A file's text: UTF-8, UTF-16 with a byte-order mark, or what Windows writes in China and in the West.

    Raises ValueError for what is no text.
    """
    content = path.read_bytes()
    if content.startswith(_WORKBOOKS):
        raise ValueError(f"{path} is a workbook of a spreadsheet program; save its sheet as CSV and give that")
    encodings = (
        ("utf-16",)
        if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
        else ("utf-8-sig", "gb18030", "cp1252")
    )
    for encoding in encodings:
        with suppress(UnicodeDecodeError):
            text = content.decode(encoding)
            # Western letters may pass for Chinese ones, but not for the words of a table's header.
            if encoding == "gb18030" and not is_chinese(text):
                continue
            if not _NO_TEXT.search(text):
                return text
    raise ValueError(f"{path} is no text; give a table of ring readings (CSV with a header)")


def _units(row: list[str]) -> list[str]:
    """The units in a row below the header that holds nothing else; empty where it is no such row."""
    words = [words_of(cell) for cell in row]
    is_unit = [len(cell) == 1 and cell[0] in UNIT_WORDS for cell in words]
    if not any(is_unit) or not all(unit or not cell for unit, cell in zip(is_unit, words, strict=True)):
        return []
    return [UNIT_WORDS[cell[0]] if unit else "" for unit, cell in zip(is_unit, words, strict=True)]


def _delimiter_of(header: str) -> str:
    """Tab or semicolon where the header has any, for then commas are within its names; else comma."""
    outside_quotes = re.sub(r'"[^"]*"', "", header)
    delimiter = max(";\t", key=outside_quotes.count)
    return delimiter if delimiter in outside_quotes else ","


def _with_points(column: list[str]) -> list[str]:
    """Cells with a point for a decimal comma, where each is a whole number with decimals.

    Three decimals each, beside whole numbers, may be thousands: these are left, and are no numbers.
    """
    with_comma = [_DECIMAL_COMMA.fullmatch(cell.strip()) for cell in column]
    decimals = {len(match[1]) for match in with_comma if match}
    has_whole_numbers = any(cell.strip().lstrip("-").isdigit() for cell in column)
    if not decimals or (decimals == {3} and has_whole_numbers):
        return column
    return [cell.replace(",", ".") if match else cell for cell, match in zip(column, with_comma, strict=True)]
