"""Columns of a table: from a file, pasted text, or what a program holds, to lists of cells by header."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fitting.tables.cells import column_of
from fitting.tables.headers import METRES, NAMES, UNIT_WORDS, canonical, unit_of
from fitting.tables.layout import Layout, layout_of, quality_of
from fitting.tables.sides import sides_apart
from fitting.tables.sources import grids_of
from fitting.tables.units import in_usual_unit
from fitting.tables.vocabulary import words_of

_WHAT = "give the path of a CSV file with a header, or columns by name such as {'order': [1, 2], 'diameter_mm': [3, 4]}"
# "all lengths in mm" above a table, and the constant of a vernier.
_UNIT_ABOVE = re.compile(r"(?:\b(?:in|en|units?:?|einheit:?|unité:?)\s+|\[|\()(mm|cm|µm|μm|um|мм|см)\b", re.IGNORECASE)
_CONSTANT = re.compile(
    r"(?:\bl\.?\s*c\b\.?|least\s+count|vernier\s+constant|\bv\.?\s*c\b\.?|noniuswert|nonius\w*)[^\d]{0,25}"
    r"(\d*[.,]?\d+)\s*(mm|cm|um|µm|μm|m)\b",
    re.IGNORECASE,
)


@dataclass(frozen=True)
class RawTable:
    """Cells by header, and the line of the file (or the row) that each row stands on.

    `form`: how a file was read; `ignored`: rows that are none of the table; `constant` of a vernier that is stated
    above it, "" without one.
    """

    cells: dict[str, Sequence]
    lines: list[int]
    form: str = ""
    ignored: tuple[str, ...] = ()
    constant: str = ""


def columns_of(table: Any, separator: str | None = None, encoding: str | None = None) -> RawTable:
    """The columns of a table.

    Raises FileNotFoundError, and ValueError for what is no table.
    """
    if isinstance(table, Mapping):
        return _of_mapping(table)
    if isinstance(table, str | Path):
        return _of_grid(table, separator, encoding)
    raise ValueError(f"the table is of type {type(table).__name__}; {_WHAT}")


def constant_of(raw: RawTable) -> float | None:
    """What a division of the vernier is worth [m], as stated above the table; None without."""
    digits, _, unit = raw.constant.partition(" ")
    return float(digits) * METRES[UNIT_WORDS[words_of(unit)[0]]] if digits else None


def _of_mapping(table: Mapping) -> RawTable:
    cells: dict[str, Sequence] = {}
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
    return RawTable(cells, list(range(1, next(iter(lengths.values())) + 1)))


def _of_grid(table: str | Path, separator: str | None, encoding: str | None) -> RawTable:
    grids = grids_of(table, separator, encoding)
    # Of a workbook's sheets the first that names most of what a table needs.
    grid = max(grids, key=quality_of) if len(grids) > 1 else grids[0]
    try:
        layout = sides_apart(layout_of(grid))
    except ValueError as error:
        name = "the text" if isinstance(table, str) and "\n" in table else str(table)
        raise ValueError(f"{name}: {error}") from None
    names = [name.lower() if name.lower() in NAMES and name.lower() not in layout.names else name
             for name in layout.names]  # fmt: skip
    cells, has_commas = _cells(names, layout, grid.separator == ",", _unit_above(layout))
    if len(layout.block_names) > 1 and not any(canonical(name) == "series" for name in names):
        cells["series"] = [layout.block_names[k] for k in layout.block]
    form = ", ".join(filter(None, [grid.form, "decimal commas" if has_commas else ""]))
    return RawTable(cells, layout.lines, form, tuple(layout.ignored), _constant_above(layout.titles))


def _constant_above(titles: Sequence[str]) -> str:
    """The constant of a vernier that the lines above a table state, as "0.01 mm"; "" without one."""
    constant = _CONSTANT.search(" ".join(titles))
    return f"{constant[1].replace(',', '.')} {constant[2]}" if constant else ""


def _cells(
    names: list[str], layout: Layout, comma_separates: bool, unit_above: str
) -> tuple[dict[str, Sequence], bool]:
    """Cells by name, with units in the names that stand in the cells, and deviations as columns of their own."""
    cells: dict[str, Sequence] = {}
    has_commas = False
    for k, written in enumerate(names):
        column = column_of([row[k] for row in layout.rows], comma_separates=comma_separates)
        has_commas |= column.has_commas
        name, factor = in_usual_unit(written)
        column = column.times(factor)
        unit = column.unit or (unit_above if canonical(name) in ("diameter", "radius", "left", "right") else "")
        stated = unit_of(name)
        if stated and column.unit and stated != column.unit:
            raise ValueError(f"column {name!r} is in {stated}, its cells in {column.unit}; put the right unit in one")
        with_unit = f"{name} ({unit})" if unit and not stated else name
        cells[with_unit] = column.cells
        if column.deviations is not None:
            cells[f"error {with_unit}"] = column.deviations
    return cells, has_commas


def _unit_above(layout: Layout) -> str:
    """The unit of lengths that the lines above a table state, where they state one."""
    units = {unit_of(f"x {match[1]}") for match in _UNIT_ABOVE.finditer(" ".join(layout.titles))}
    return next(iter(units)) if len(units) == 1 else ""
