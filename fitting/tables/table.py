"""Readings of a table: which columns are used, in which unit, and what is left out of them."""

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from fitting.parameters import number
from fitting.reasons import Reason
from fitting.tables import headers
from fitting.tables.cells import numbers
from fitting.tables.columns import RawTable, columns_of, constant_of
from fitting.tables.division import division, rounding_sd
from fitting.tables.selection import (
    SIZE_NAMES,
    UnreadTableError,
    deviation_column,
    mapped_columns,
    parts_of,
    selection,
    size_columns,
    suggestion,
)
from fitting.tables.spellings import in_usual_names
from fitting.tables.understood import Rejected, sentence
from fitting.tables.verniers import with_readings

# Two columns of the same ring's size may differ by this share before it is worth a word.
_AGREE = 0.02
# Radii [m, px] and orders beyond which nothing was meant.
_SMALLEST_RADIUS, _LARGEST_RADIUS, _LARGEST_ORDER = 1e-9, 1e6, 1e9
# A stated deviation below this, in the table's unit, is none.
_SMALLEST_SD = 1e-12


@dataclass(frozen=True)
class Readings:
    """Ring radii [m], or [px] where `unit` is "px", by order; `sd` of the radii where the table states it.

    Where `is_wedge`, positions of straight fringes stand in place of radii.

    `column`: what was read; `length_unit`: its unit in the table; `series` [readings]: numbers of series, None without;
    `series_names` of these numbers. `rounding`: standard deviation of the radii by the sizes' last digit, 0 where they
    were calculated; `division`: that digit, as "0.01 mm". `understood`: columns, units and rows left out, in a line.
    """

    order: np.ndarray
    radius: np.ndarray
    sd: np.ndarray | None
    unit: str
    column: str
    length_unit: str
    series: np.ndarray | None = None
    series_names: tuple[str, ...] = ()
    rounding: float = 0.0
    division: str = ""
    warnings: list[str] = field(default_factory=list)
    is_wedge: bool = False
    understood: str = ""


def readings(
    table: str | Path | Mapping[str, Any],
    columns: Mapping[str, str] | None = None,
    *,
    separator: str | None = None,
    encoding: str | None = None,
    vernier: float | None = None,
) -> Readings:
    """Readings from a file with a header, from pasted text with line breaks, or from columns by name.

    Columns: `order`; then the first of `left_mm` with `right_mm`, `diameter_mm`, `radius_mm` that is there, in mm, um,
    cm, m or px; `sd_mm` (of that column's reading; in px beside px), `sigma`, `error` or `uncertainty`; and `series`.
    "diameter (mm)", "diameter [mm]", "Diameter, mm" and "Durchmesser [mm]" are the same. "D (mm)", n for orders,
    squares ("D² (mm²)") and several readings of a ring ("D1 (mm)", "D2 (mm)") are taken for what they seem to be, with
    a warning. `columns` maps these names to a table's own; "row" for the orders are the rows' numbers. `separator`
    ("comma", "semicolon", "tab", "bar", "blank") and `encoding` overrule what is found; `vernier` [m] is what a
    division of the vernier is worth beside a main scale.

    Raises FileNotFoundError, and ValueError for a table without these columns, or a cell that is no number.
    """
    raw = columns_of(table, separator, encoding)
    if vernier is not None and not 1e-9 < number("vernier", vernier) < 0.1:
        raise ValueError(f"vernier is {vernier}; allowed: 1e-9 to 0.1 m")
    try:
        return _readings(raw, columns, vernier)
    except UnreadTableError as error:
        raise UnreadTableError(error.lack, _that_works(raw, columns, vernier, error)) from None


def _that_works(raw: RawTable, columns: Mapping[str, str] | None, vernier: float | None, error: UnreadTableError):
    """Names of columns with which the table is read; None where none are found."""
    texts = {name: header for name, header in dict(columns or {}).items() if isinstance(header, str)}
    header_of = {name: header for name, header in texts.items() if header in raw.cells}
    stated = dict(error.suggestion or {})
    beside = {name: header for name, header in header_of.items() if header not in stated.values()}
    for guess in (beside | stated, suggestion(raw, header_of), suggestion(raw, {})):
        with suppress(ValueError):
            if guess and _readings(raw, guess, vernier):
                return guess
    return None


def _readings(raw: RawTable, columns: Mapping[str, str] | None, vernier: float | None) -> Readings:
    united = with_readings(raw, constant_of(raw) if vernier is None else vernier)
    raw = united.raw
    mapping = mapped_columns(raw, columns)
    usual = in_usual_names(raw.cells, raw.lines, list(mapping.values()))
    lines, columns_read = usual.lines, selection(usual.cells, mapping)
    cells = columns_read.cells
    if "order" not in cells:
        like = headers.order_like(usual.cells)
        raise UnreadTableError(
            f"the table has no column 'order'; it has {', '.join(usual.cells)}; name one with order={like}"
        )
    if united.needs_constant and not any(name in cells for name in SIZE_NAMES):
        listed = ", ".join(united.needs_constant)
        raise ValueError(f"{listed}: the vernier's constant is not stated; give vernier (--vernier 0.01mm)")
    name, *secondaries = size_columns(columns_read, usual.cells)
    kind, unit = name.split("_")
    # A row whose order is no number is one of means, or of remarks.
    order = numbers(cells["order"], "order", lines, np.zeros(len(lines), bool))
    is_row = np.isfinite(order)
    sd_name, sd_notes = deviation_column(columns_read, mapping, usual.cells, name)
    sizes = {key: numbers(cells[key], key, lines, is_row) for key in filter(None, (*parts_of(name), sd_name))}
    warnings = [*columns_read.notes, *usual.notes, *sd_notes]
    radius = _radius(sizes, name) * _in_metres(unit)
    complete = np.all([is_row, *(np.isfinite(column) for column in sizes.values())], axis=0)
    if not complete.any():
        raise UnreadTableError("no row of the table is complete; give an order and a size in each row")
    rejected = Rejected.of(cells["order"], order, complete, lines)
    if rejected.incomplete:
        warnings.append(Reason.ROWS_LEFT_OUT(rows=_counted(rejected.incomplete, "row")))
    if rejected.between:
        warnings.append(Reason.ROWS_WITHOUT_ORDER(listed=", ".join(rejected.between[:5])))
    is_wedge = kind == "position"
    _check_sizes(order[complete], np.abs(radius[complete]) if is_wedge else radius[complete], name)
    centre = complete & (radius == 0) & (not is_wedge)
    if centre.any():
        orders = ", ".join(f"{m:g}" for m in np.unique(order[centre])[:5])
        warnings.append(Reason.CENTRE_LEFT_OUT(readings=_counted(int(centre.sum()), "reading"), orders=orders))
    used = complete & ~centre
    if not used.any():
        raise ValueError(f"{name} holds no ring: every size is zero; give the sizes of rings")
    sd = _deviation(sizes[sd_name][used], sd_name, kind, unit) if sd_name else None
    for secondary in secondaries:
        warnings += _disagreement(cells, lines, name, secondary, used)
    series, series_names = _series(cells, used)
    column = " and ".join(parts_of(name))
    step = division([cells[part] for part in parts_of(name)], used)
    rounding = rounding_sd(step, kind, headers.RADIUS_OVER[kind]) * _in_metres(unit)
    origins = dict(usual.origins) | mapping
    understood = sentence(raw, ["order", *parts_of(name), *filter(None, [sd_name])], origins, united.made_of, rejected)
    return Readings(
        order[used], radius[used], sd, "px" if unit == "px" else "m", column, unit, series, series_names, rounding,
        f"{step:g} {unit}", warnings, is_wedge, understood,
    )  # fmt: skip


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}{'s' if count > 1 else ''}"


def _in_metres(unit: str) -> float:
    return headers.METRES.get(unit, 1.0)


def _radius(sizes: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    parts = [sizes[part] for part in parts_of(name)]
    size = np.abs(parts[0] - parts[1]) if len(parts) == 2 else parts[0]
    return size * headers.RADIUS_OVER[name.split("_")[0]]


def _check_sizes(order: np.ndarray, radius: np.ndarray, name: str) -> None:
    if np.any(radius < 0):
        raise ValueError(f"{name} holds a negative size; allowed: zero or more")
    is_beyond = (radius > _LARGEST_RADIUS) | ((radius > 0) & (radius < _SMALLEST_RADIUS))
    if np.any(is_beyond) or np.any(np.abs(order) > _LARGEST_ORDER):
        raise ValueError(f"order or {name} holds a number beyond all rings; check the columns and units")


def _deviation(stated: np.ndarray, name: str, kind: str, unit: str) -> np.ndarray:
    """Standard deviations of the radii. Raises ValueError for what are none."""
    if np.any(stated <= 0) or stated.min() < 1e-9 * stated.max():
        raise ValueError(f"{name} holds {stated.min():g}; allowed: above zero, and of one size")
    if not _SMALLEST_SD <= stated.min() <= stated.max() <= _LARGEST_RADIUS:
        raise ValueError(f"{name} holds {stated.max():g}; allowed: {_SMALLEST_SD:g} to {_LARGEST_RADIUS:g}")
    stated_unit = name.split("_")[-1]
    metres = _in_metres(stated_unit if stated_unit in headers.UNITS else unit)
    return stated * metres * headers.RADIUS_OVER[kind] * (math.sqrt(2) if kind == "left" else 1)


def _series(cells: Mapping[str, Sequence], used: np.ndarray) -> tuple[np.ndarray | None, tuple[str, ...]]:
    """Number of the series of each reading, and the series' names, by their column; None without one."""
    if "series" not in cells:
        return None, ()
    labels = [str(label).strip() for label, is_used in zip(cells["series"], used, strict=True) if is_used]
    names = tuple(dict.fromkeys(labels))
    numbered = {label: number for number, label in enumerate(names)}
    return np.array([numbered[label] for label in labels], int), names


def _disagreement(cells, lines, name: str, secondary: str, used: np.ndarray) -> list[str]:
    """That two columns tell different sizes, in the same unit or by a factor that is not the same for all rows."""
    primary, second = (
        _radius({part: numbers(cells[part], part, lines) for part in parts_of(column)}, column)[used]
        for column in (name, secondary)
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = second / primary
    ratio = ratio[np.isfinite(ratio) & (ratio > 0)]
    if len(ratio) == 0:
        return []
    unit, second_unit = (column.split("_")[1] for column in (name, secondary))
    # Against pixels only the common factor, the scale, is unknown.
    factor = _in_metres(unit) / _in_metres(second_unit)
    if (unit == "px") != (second_unit == "px"):
        factor = float(np.median(ratio))
    deviation = np.abs(ratio / factor - 1)
    if deviation.max() < _AGREE:
        return []
    return [Reason.COLUMNS_DISAGREE(column=secondary, sizes=name, deviation=float(deviation.max()))]
