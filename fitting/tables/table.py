"""Tables of ring readings: from a CSV file or columns to orders and radii."""

import csv
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

_METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "px": math.nan}
# What is read, in this order of preference; each gives the ring's radius as a factor times the (difference of) columns.
_KINDS = {"left": 0.5, "diameter": 0.5, "radius": 1.0}
_NAMES = ("order", *(f"{kind}_{unit}" for kind in ("left", "right", "diameter", "radius", "sd") for unit in _METRES))
# Two columns that tell the same ring's size may differ by this share before it is worth a word.
_AGREE = 0.02


@dataclass(frozen=True)
class Readings:
    """Ring radii [m], or [px] where `unit` is "px", by order; `sd` of the radii where the table states one."""

    order: np.ndarray
    radius: np.ndarray
    sd: np.ndarray | None
    unit: str
    column: str
    warnings: list[str] = field(default_factory=list)


def readings(table: str | Path | Mapping[str, Any], columns: Mapping[str, str] | None = None) -> Readings:
    """Readings from a CSV file with a header, or from columns by name.

    Columns: `order`; then the first of `left_mm` with `right_mm`, `diameter_mm`, `radius_mm` that is there, in mm, um,
    cm, m or px; and `sd_mm` (of that column's reading; in px beside px). `columns` maps these names to a table's own.

    Raises FileNotFoundError, and ValueError for a table without these columns, or a cell that is no number.
    """
    cells, lines = _columns(table)
    table_cells, named = dict(cells), dict(columns or {})
    for name, header in named.items():
        if header not in table_cells:
            raise ValueError(f"the table has no column {header!r}; it has {', '.join(table_cells)}")
        if name not in _NAMES:
            raise ValueError(f"a column cannot be named {name!r}; allowed: {', '.join(_NAMES)}")
        cells[name] = table_cells[header]
    if "order" not in cells:
        raise ValueError(f"the table has no column 'order'; it has {', '.join(cells)}; name one with order=ITS-NAME")
    size_names = _size_columns(cells)
    # What the user names is what is meant.
    size_names.sort(key=lambda name: not any(part in named for part in _columns_of(name)))
    if (
        any(part in named for part in _NAMES[1:])
        and size_names
        and not any(part in named for part in _columns_of(size_names[0]))
    ):
        lone = next(part for part in named if part != "order")
        raise ValueError(f"{lone} alone tells no ring's size; name its partner as well")
    if not size_names:
        raise ValueError(
            f"the table has no ring sizes; it has {', '.join(cells)}; allowed: left_mm with right_mm, diameter_mm or "
            "radius_mm (or um, cm, m, px), or name one with diameter_mm=ITS-NAME"
        )
    name, *secondaries = size_names
    kind, unit = name.split("_")
    numbers = {key: _numbers(cells[key], key, lines) for key in ("order", *_columns_of(name))}
    stated = [f"sd_{unit}", *(f"sd_{its_unit}" for its_unit in _METRES if (its_unit == "px") == (unit == "px"))]
    sd_name = next((sd for sd in stated if sd in cells), stated[0])
    if sd_name in cells:
        numbers[sd_name] = _numbers(cells[sd_name], sd_name, lines)
    complete = np.all([np.isfinite(column) for column in numbers.values()], axis=0)
    warnings = [f"{np.sum(~complete)} rows with an empty cell were left out"] if not complete.all() else []
    if not complete.any():
        raise ValueError("no row of the table is complete")
    scale = 1.0 if unit == "px" else _METRES[unit]
    radius = _radius(numbers, name)[complete] * scale
    if np.any(radius < 0):
        raise ValueError(f"{name} holds a negative size; allowed: zero or more")
    sd = None
    if sd_name in numbers:
        sd_scale = 1.0 if unit == "px" else _METRES[sd_name[3:]]
        sd = numbers[sd_name][complete] * sd_scale * _KINDS[kind] * (math.sqrt(2) if kind == "left" else 1)
        if np.any(sd <= 0) or sd.min() < 1e-9 * sd.max():
            raise ValueError(f"{sd_name} holds {numbers[sd_name].min():g}; allowed: above zero, and of one size")
    unread = [column for column in cells if column.startswith("sd_") and column in _NAMES and column != sd_name]
    warnings += [f"{column} was not used: the sizes are those of {name}" for column in unread]
    if np.any(radius > 1e6) or np.any(np.abs(numbers["order"][complete]) > 1e9):
        raise ValueError(f"order or {name} holds a number beyond all rings; check the columns and units")
    for secondary in secondaries:
        warnings += _disagreement(cells, lines, name, secondary, complete)
    return Readings(numbers["order"][complete], radius, sd, "px" if unit == "px" else "m", name, warnings)


def _columns(table) -> tuple[dict[str, list], list[int]]:
    """Cells by column, and the line of the file that each row stands on."""
    if isinstance(table, Mapping):
        cells = {str(name): list(np.atleast_1d(np.asarray(values))) for name, values in table.items()}
        if len({len(column) for column in cells.values()}) != 1:
            raise ValueError("the columns have different lengths, or there are none")
        return cells, list(range(1, len(next(iter(cells.values()))) + 1))
    path = Path(table)
    if not path.is_file():
        raise FileNotFoundError(f"{path} is no file; give the path of a table of ring readings (CSV with a header)")
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError(f"{path} is no text; give a table of ring readings (CSV with a header)") from None
    # Excel says its delimiter in a first line of its own.
    lines = [(n, line) for n, line in enumerate(text.splitlines(), 1) if not re.fullmatch(r"sep=.?", line.strip())]
    rows = [(n, line) for n, line in lines if line.strip() and not line.lstrip().startswith("#")]
    if len(rows) < 2:
        raise ValueError(f"{path} holds no readings; give a header and one row a ring")
    delimiter = max(",;\t", key=rows[0][1].count)
    header, *body = csv.reader([line for _, line in rows], delimiter=delimiter)
    names = [name.strip() for name in header]
    names = [name.lower() if name.lower() in _NAMES and name.lower() not in names else name for name in names]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ValueError(f"{path}: the header names {', '.join(map(repr, twice))} twice; give each column one name")
    if any(len(row) != len(names) for row in body):
        bad = next(n for (n, _), row in zip(rows[1:], body, strict=True) if len(row) != len(names))
        raise ValueError(f"{path}, line {bad}: its number of cells is not the header's {len(names)}")
    if delimiter != ",":
        body = [[cell.replace(",", ".") for cell in row] for row in body]
    return {name: [row[k] for row in body] for k, name in enumerate(names)}, [n for n, _ in rows[1:]]


def _size_columns(cells: Mapping[str, list]) -> list[str]:
    names = [f"{kind}_{unit}" for kind in _KINDS for unit in _METRES]
    return [name for name in names if all(part in cells for part in _columns_of(name))]


def _columns_of(name: str) -> tuple[str, ...]:
    kind, unit = name.split("_")
    return (name, f"right_{unit}") if kind == "left" else (name,)


def _numbers(column: list, name: str, lines: list[int]) -> np.ndarray:
    values = []
    for cell, line in zip(column, lines, strict=True):
        text = str(cell).strip()
        try:
            values.append(float(text.replace("_", "?")) if text else math.nan)
        except ValueError:
            raise ValueError(f"line {line}, column {name}: {text!r} is no number") from None
        if math.isinf(values[-1]):
            raise ValueError(f"line {line}, column {name}: {text!r} is not finite")
    return np.array(values)


def _radius(numbers: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    parts = [numbers[part] for part in _columns_of(name)]
    size = np.abs(parts[0] - parts[1]) if len(parts) == 2 else parts[0]
    return size * _KINDS[name.split("_")[0]]


def _disagreement(cells, lines, name: str, secondary: str, complete: np.ndarray) -> list[str]:
    """That two columns tell different sizes, in the same unit or by a factor that is not the same for all rows."""
    mine, theirs = (
        _radius({part: _numbers(cells[part], part, lines) for part in _columns_of(column)}, column)[complete]
        for column in (name, secondary)
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = theirs / mine
    ratio = ratio[np.isfinite(ratio) & (ratio > 0)]
    if len(ratio) == 0:
        return []
    mine_unit, their_unit = (_METRES[column.split("_")[1]] for column in (name, secondary))
    # Against pixels only the common factor, the scale, is unknown.
    factor = mine_unit / their_unit
    if name.endswith("px") != secondary.endswith("px"):
        factor = float(np.median(ratio))
    elif name.endswith("px"):
        factor = 1.0
    deviation = np.abs(ratio / factor - 1)
    if deviation.max() < _AGREE:
        return []
    return [f"{secondary} and {name} disagree by up to {deviation.max():.1%}: {name} was used"]
