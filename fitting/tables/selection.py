"""Which columns of a table are used: the user's names, sizes in their order of preference, deviations, series."""

import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fitting.reasons import Reason
from fitting.tables import headers
from fitting.tables.cells import numbers
from fitting.tables.columns import RawTable
from fitting.tables.units import in_usual_unit
from newtonjax.numerics import Statement, shown

# Name of no column: the rows' own numbers, from 1.
ROW = "row"
SIZE_NAMES = tuple(f"{kind}_{unit}" for kind in headers.RADIUS_OVER for unit in headers.UNITS)


class UnreadTableError(ValueError):
    """A table that is not understood: what it lacks, and columns to name that would do, None where none are seen."""

    def __init__(self, lack: str, suggestion: Mapping[str, str] | None = None) -> None:
        """`suggestion`: names of `headers.NAMES` to the table's own."""
        self.lack, self.suggestion = lack, suggestion
        super().__init__(f"{lack}; columns={dict(suggestion)} would do" if suggestion else lack)


@dataclass(frozen=True)
class Selection:
    """Columns by the names of `headers.NAMES`, which of them the user named, and what is to be said of others."""

    cells: dict[str, Sequence]
    named: set[str]
    notes: list[Statement]


def mapped_columns(raw: RawTable, columns: Mapping[str, str] | None) -> dict[str, str]:
    """The user's names of columns, with the table's headers as they are written there.

    Letters of any size and blanks count for nothing; "column 3" is the third one. Raises ValueError for other names.
    """
    if columns is not None and not isinstance(columns, Mapping):
        raise ValueError(f"columns is {shown(columns)}; give a mapping such as {{'diameter_mm': 'D'}}")
    by_look = {_look(header): header for header in reversed(raw.cells)}
    by_place = {f"column{k}": header for k, header in enumerate(raw.cells, 1)}
    mapping = {}
    for name, header in dict(columns or {}).items():
        # A header of another unit stands among the columns in one of ours.
        look = _look(in_usual_unit(header)[0]) if isinstance(header, str) else ""
        match = header if look and header in raw.cells else by_look.get(look, by_place.get(look))
        if match is None and not (look and header == ROW and name == "order"):
            raise UnreadTableError(f"the table has no column {shown(header)}; it has {', '.join(raw.cells)}")
        mapping[name] = match or ROW
    return mapping


def _look(header: str) -> str:
    return "".join(unicodedata.normalize("NFKC", header).lower().split())


def selection(cells: Mapping[str, Sequence], mapping: Mapping[str, str]) -> Selection:
    """Columns by the names of `headers.NAMES`. Raises ValueError for other names, and for two columns of one."""
    selected, named = {}, set()
    series = [header for header in cells if headers.canonical(header) == "series"]
    series.sort(key=lambda header: header.lower() != "series")
    for header, column in cells.items():
        name = "" if header in mapping.values() else headers.canonical(header)
        if name == "series" and header != series[0]:
            continue
        if name and name in selected:
            raise UnreadTableError(
                f"two columns of the table are {name}; leave one out, or name one with {name}={header}", {name: header}
            )
        if name:
            selected[name] = column
    for name, header in mapping.items():
        with_unit = _with_unit(name, header)
        count = len(next(iter(cells.values())))
        selected[with_unit] = cells[header] if header in cells else [str(row) for row in range(1, count + 1)]
        named.add(with_unit)
    notes = []
    if len(series) > 1 and "series" not in named:
        notes = [Reason.SERIES_NOT_USED(series=series[0], further=", ".join(series[1:]))]
    return Selection(selected, named, notes)


def _with_unit(name: str, header: str) -> str:
    """The name of `headers.NAMES` that the user means. Raises ValueError where the header has another unit."""
    stated = headers.unit_of(header)
    with_unit = f"{name}_{stated}" if f"{name}_{stated}" in headers.NAMES else name
    if with_unit not in headers.NAMES:
        raise ValueError(f"a column cannot be named {name!r}; allowed: {', '.join(headers.NAMES)}")
    kind, _, unit = with_unit.partition("_")
    if stated and unit and stated != unit:
        raise UnreadTableError(
            f"{name}={header}: the header says {stated}; name it {kind}_{stated}={header}", {f"{kind}_{stated}": header}
        )
    return with_unit


def parts_of(name: str) -> tuple[str, ...]:
    """The columns that a size is made of: "left_mm" of itself and "right_mm"."""
    kind, unit = name.split("_")
    return (name, f"right_{unit}") if kind == "left" else (name,)


def size_columns(columns_read: Selection, table_headers: Iterable[str]) -> list[str]:
    """Columns of ring sizes, the one to use first. Raises ValueError where there is none."""
    cells, named = columns_read.cells, columns_read.named
    names = [name for name in SIZE_NAMES if all(part in cells for part in parts_of(name))]
    # Beside sizes of rings, positions are of something else.
    names = [name for name in names if not name.startswith("position")] or names
    # What the user names is what is meant.
    names.sort(key=lambda name: not any(part in named for part in parts_of(name)))
    named_sizes = {name for name in named if name.split("_")[0] in headers.SIZES}
    if named_sizes and not (names and named_sizes & set(parts_of(names[0]))):
        raise ValueError(f"{min(named_sizes)} needs its partner; name both columns")
    if names:
        return names
    listed = ", ".join(table_headers)
    if unitless := [kind for kind in headers.SIZES if kind in cells]:
        raise UnreadTableError(
            f"column {unitless[0]!r} has no unit; call it {unitless[0]}_mm (or um, cm, m, px) in the header"
        )
    raise UnreadTableError(
        f"the table has no ring sizes; it has {listed}; allowed: left_mm with right_mm, diameter_mm or radius_mm "
        f"(or um, cm, m, px); {headers.size_advice(table_headers)}"
    )


def deviation_column(
    columns_read: Selection, mapping: Mapping[str, str], table_headers: Iterable[str], size: str
) -> tuple[str, list[Statement]]:
    """The column with the sizes' standard deviations, "" without one, and what is to be said of such columns."""
    kind, unit = size.split("_")
    is_length = unit != "px"
    units = (unit, *(candidate for candidate in headers.UNITS if (candidate != "px") == is_length), "")
    candidates = ["_".join(filter(None, ["sd", of_kind, of_unit])) for of_unit in units for of_kind in ("", kind)]
    name = next((candidate for candidate in candidates if candidate in columns_read.cells), "")
    read_from = " and ".join(parts_of(size))
    notes = []
    for header in table_headers:
        of_header = headers.canonical(header)
        if header in mapping.values() or not headers.is_deviation(header):
            continue
        if of_header != name or not name:
            notes.append(Reason.COLUMN_NOT_USED(column=header, sizes=read_from))
        elif name in ("sd", f"sd_{kind}"):
            notes.append(Reason.COLUMN_WITHOUT_UNIT(column=header, unit=unit, sizes=read_from))
    return name, notes


def suggestion(raw: RawTable, mapping: Mapping[str, str]) -> dict[str, str]:
    """Columns that may be the orders and the sizes of a table that is not understood; empty where none are seen."""
    nothing = np.zeros(len(raw.lines), bool)
    columns = {
        header: numbers(cells, header, raw.lines, nothing)
        for header, cells in raw.cells.items()
        if header not in mapping.values() and not headers.is_deviation(header)
    }
    columns = {header: values for header, values in columns.items() if np.isfinite(values).sum() > 1}
    guess = dict(mapping)
    if "order" not in guess:
        guess["order"] = _order_among(columns)
    sizes = [
        header
        for header, values in columns.items()
        if header != guess["order"] and np.nanmin(values) >= 0 and not headers.is_no_size(header)
    ]
    is_named = any(name.split("_")[0] in headers.SIZES for name in guess)
    if not sizes and not is_named:
        return {}
    if not is_named:
        likeliest = max(sizes, key=lambda header: (_kind(header) != "", bool(headers.unit_of(header))))
        guess[f"{_kind(likeliest) or 'diameter'}_{headers.unit_of(likeliest) or 'mm'}"] = likeliest
    return guess


def _order_among(columns: Mapping[str, np.ndarray]) -> str:
    """The column that is likeliest the orders: called so, else whole numbers in their order; else the rows' numbers."""
    counts = [header for header, values in columns.items() if _is_count(values[np.isfinite(values)])]
    ranked = [header for header in counts if headers.order_rank(header) is not None]
    return (ranked or counts or [ROW])[0]


def _is_count(values: np.ndarray) -> bool:
    before, after = values[:-1], values[1:]
    is_sorted = np.all(before <= after) or np.all(before >= after)
    return bool(np.all(values == np.round(values)) and is_sorted and np.any(before != after))


def _kind(header: str) -> str:
    """The kind of size in the words of a header, without its unit; "" for another one."""
    words = headers.words_of(header)
    letters = [headers.LETTERS.get(word, word) for word in words]
    return next((word for word in letters if word in ("diameter", "radius")), "")
