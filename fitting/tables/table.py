"""Readings of a table: which columns are used, in which unit, and what is left out of them."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from fitting.reasons import Reason
from fitting.tables import headers
from fitting.tables.columns import columns_of, numbers
from fitting.tables.division import division, rounding_sd
from fitting.tables.spellings import in_usual_names
from newtonjax.numerics import shown

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
    were calculated; `division`: that digit, as "0.01 mm".
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


def readings(table: str | Path | Mapping[str, Any], columns: Mapping[str, str] | None = None) -> Readings:
    """Readings from a CSV file with a header, or from columns by name.

    Columns: `order`; then the first of `left_mm` with `right_mm`, `diameter_mm`, `radius_mm` that is there, in mm, um,
    cm, m or px; `sd_mm` (of that column's reading; in px beside px), `sigma`, `error` or `uncertainty`; and `series`.
    "diameter (mm)", "diameter [mm]", "Diameter, mm" and "Durchmesser [mm]" are the same. "D (mm)", n for orders,
    squares ("D² (mm²)") and several readings of a ring ("D1 (mm)", "D2 (mm)") are taken for what they seem to be, with
    a warning. `columns` maps these names to a table's own.

    Raises FileNotFoundError, and ValueError for a table without these columns, or a cell that is no number.
    """
    read_cells, read_lines = columns_of(table)
    mapped = (
        [header for header in dict(columns or {}).values() if isinstance(header, str)]
        if isinstance(columns, Mapping)
        else []
    )
    usual = in_usual_names(read_cells, read_lines, mapped)
    table_cells, lines = usual.cells, usual.lines
    cells, named, series_notes = _named(table_cells, columns)
    if "order" not in cells:
        like = headers.order_like(table_cells)
        raise ValueError(
            f"the table has no column 'order'; it has {', '.join(table_cells)}; name one with order={like}"
        )
    name, *secondaries = _size_columns(cells, named, table_cells)
    kind, unit = name.split("_")
    sizes = {key: numbers(cells[key], key, lines) for key in ("order", *_columns_of(name))}
    unnamed = [header for header in table_cells if header not in list((columns or {}).values())]
    sd_name, warnings = _deviation_column(cells, unnamed, kind, unit)
    warnings += [*series_notes, *usual.notes]
    if sd_name:
        sizes[sd_name] = numbers(cells[sd_name], sd_name, lines)
    order, radius = sizes["order"], _radius(sizes, name) * _in_metres(unit)
    complete = np.all([np.isfinite(column) for column in sizes.values()], axis=0)
    if not complete.any():
        raise ValueError("no row of the table is complete; give an order and a size in each row")
    if not complete.all():
        warnings.append(Reason.ROWS_LEFT_OUT(rows=_counted(int(np.sum(~complete)), "row")))
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
    column = " and ".join(_columns_of(name))
    column_unit = "px" if unit == "px" else "m"
    step = division([cells[part] for part in _columns_of(name)], used)
    rounding = rounding_sd(step, kind, headers.RADIUS_OVER[kind]) * _in_metres(unit)
    return Readings(
        order[used], radius[used], sd, column_unit, column, unit, series, series_names, rounding, f"{step:g} {unit}",
        warnings, is_wedge,
    )  # fmt: skip


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}{'s' if count > 1 else ''}"


def _in_metres(unit: str) -> float:
    return headers.METRES.get(unit, 1.0)


def _named(
    table_cells: Mapping[str, Sequence], columns: Mapping[str, str] | None
) -> tuple[dict[str, Sequence], set, list[str]]:
    """Columns by the names of `headers.NAMES`, which of them the user named, and what is to be said of further series.

    Raises ValueError for other names.
    """
    if columns is not None and not isinstance(columns, Mapping):
        raise ValueError(f"columns is {shown(columns)}; give a mapping such as {{'diameter_mm': 'D'}}")
    cells, named = {}, set()
    series = [header for header in table_cells if headers.canonical(header) == "series"]
    series.sort(key=lambda header: header.lower() != "series")
    for header, column in table_cells.items():
        name = "" if header in list((columns or {}).values()) else headers.canonical(header)
        if name == "series" and header != series[0]:
            continue
        if name and name in cells:
            raise ValueError(f"two columns of the table are {name}; leave one out, or name one with {name}={header}")
        if name:
            cells[name] = column
    for name, header in dict(columns or {}).items():
        if not isinstance(header, str) or header not in table_cells:
            raise ValueError(f"the table has no column {header!r}; it has {', '.join(table_cells)}")
        stated = headers.unit_of(header)
        with_unit = f"{name}_{stated}" if f"{name}_{stated}" in headers.NAMES else name
        if with_unit not in headers.NAMES:
            raise ValueError(f"a column cannot be named {name!r}; allowed: {', '.join(headers.NAMES)}")
        kind, _, unit = with_unit.partition("_")
        if stated and unit and stated != unit:
            raise ValueError(f"{name}={header}: the header says {stated}; name it {kind}_{stated}={header}")
        cells[with_unit] = table_cells[header]
        named.add(with_unit)
    notes: list[str] = []
    if len(series) > 1 and "series" not in named:
        further = ", ".join(series[1:])
        notes = [Reason.SERIES_NOT_USED(series=series[0], further=further)]
    return cells, named, notes


def _size_columns(cells: Mapping[str, Sequence], named: set, table_headers: Iterable[str]) -> list[str]:
    """Columns of ring sizes, the one to use first. Raises ValueError where there is none."""
    names = [f"{kind}_{unit}" for kind in headers.RADIUS_OVER for unit in headers.UNITS]
    names = [name for name in names if all(part in cells for part in _columns_of(name))]
    # Beside sizes of rings, positions are of something else.
    names = [name for name in names if not name.startswith("position")] or names
    # What the user names is what is meant.
    names.sort(key=lambda name: not any(part in named for part in _columns_of(name)))
    named_sizes = {name for name in named if name.split("_")[0] in headers.SIZES}
    if named_sizes and not (names and named_sizes & set(_columns_of(names[0]))):
        raise ValueError(f"{min(named_sizes)} needs its partner; name both columns")
    if names:
        return names
    listed = ", ".join(table_headers)
    if unitless := [kind for kind in headers.SIZES if kind in cells]:
        raise ValueError(
            f"column {unitless[0]!r} has no unit; call it {unitless[0]}_mm (or um, cm, m, px) in the header"
        )
    raise ValueError(
        f"the table has no ring sizes; it has {listed}; allowed: left_mm with right_mm, diameter_mm or radius_mm "
        f"(or um, cm, m, px); {headers.size_advice(table_headers)}"
    )


def _columns_of(name: str) -> tuple[str, ...]:
    kind, unit = name.split("_")
    return (name, f"right_{unit}") if kind == "left" else (name,)


def _radius(sizes: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    parts = [sizes[part] for part in _columns_of(name)]
    size = np.abs(parts[0] - parts[1]) if len(parts) == 2 else parts[0]
    return size * headers.RADIUS_OVER[name.split("_")[0]]


def _check_sizes(order: np.ndarray, radius: np.ndarray, name: str) -> None:
    if np.any(radius < 0):
        raise ValueError(f"{name} holds a negative size; allowed: zero or more")
    is_beyond = (radius > _LARGEST_RADIUS) | ((radius > 0) & (radius < _SMALLEST_RADIUS))
    if np.any(is_beyond) or np.any(np.abs(order) > _LARGEST_ORDER):
        raise ValueError(f"order or {name} holds a number beyond all rings; check the columns and units")


def _deviation_column(cells: Mapping, unnamed: Iterable[str], kind: str, unit: str) -> tuple[str, list[str]]:
    """The column with the sizes' standard deviations, "" without one, and what is to be said of such columns."""
    is_length = unit != "px"
    units = (unit, *(candidate for candidate in headers.UNITS if (candidate != "px") == is_length), "")
    candidates = ["_".join(filter(None, ["sd", of_kind, of_unit])) for of_unit in units for of_kind in ("", kind)]
    name = next((candidate for candidate in candidates if candidate in cells), "")
    read_from = " and ".join(_columns_of(f"{kind}_{unit}"))
    notes = []
    for header in unnamed:
        of_header = headers.canonical(header)
        if headers.is_deviation(header) and (of_header != name or not name):
            notes.append(Reason.COLUMN_NOT_USED(column=header, sizes=read_from))
        elif of_header == name and name in ("sd", f"sd_{kind}"):
            notes.append(Reason.COLUMN_WITHOUT_UNIT(column=header, unit=unit, sizes=read_from))
    return name, notes


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
        _radius({part: numbers(cells[part], part, lines) for part in _columns_of(column)}, column)[used]
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
