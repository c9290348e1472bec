"""Columns that say what they hold in letters, squares, repeats or means: brought to the names of `headers.NAMES`."""

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from fitting.reasons import Reason
from fitting.tables import headers
from fitting.tables.cells import numbers

# Letters beside "left" and "right" that say nothing more.
_SIDE_LETTERS = {"x", "y", "d", "l", "r"}
_BY_LETTERS = {"l": "left", "r": "right", "xl": "left", "xr": "right", "x1": "left", "x2": "right", "li": "left",
               "re": "right"}  # fmt: skip
# What tells one of several readings of a ring from the others.
_LABELS = {"a", "b", "c", "x", "y", "h", "v", "horizontal", "vertical", "first", "second", "third", "i", "ii", "iii"}
_READERS = {"observer", "trial", "attempt", "person", "student", "set"}
# No ring is counted so far.
_MOST = 1e9
_NUMBERED = re.compile(r"([a-z]+)([1-9]\d?)|([dr])([xyhv])")


class Spelling(NamedTuple):
    """What a header means: the name in `headers.NAMES`, which of several readings, and how it says so."""

    name: str
    label: str
    is_mean: bool
    is_square: bool
    is_letter: bool


def spelling(header: str) -> Spelling | None:
    """What a header means that is none of the usual names, such as "D (mm)", "d_2/cm", "D² (mm²)", "mean radius, um".

    A capital R is no ring's radius: tables of rings call the lens's so. None for a header of something else.
    """
    words = headers.words_of(header)
    if any(word in headers.DEVIATIONS for word in words) or re.match(r"\s*R\b", header.replace("_", " ")):
        return None
    # A unit's square is written mm2 as well.
    words = [
        part
        for word in words
        for part in ((word[:-1], "squared") if word[:-1] in headers.METRES and word[-1] == "2" else (word,))
    ]
    is_square, is_mean = "squared" in words, "mean" in words
    words = [word for word in words if word not in ("squared", "mean", "in", *_READERS, *headers.FILLERS - {"x"})]
    place = next((k for k in range(len(words) - 1, 0, -1) if words[k] in headers.UNIT_WORDS), 0)
    # "d_m" alone may be a diameter in metres, or that of ring m.
    if not place or (words[place] == "m" and re.fullmatch(r"\s*[dDr]_?m\s*", header)):
        return None
    unit = headers.UNIT_WORDS[words[place]]
    kind, labels = _kind_and_labels(_with_numbers_apart([*words[:place], *words[place + 1 :]]))
    is_label = len(labels) <= 1 and all(label in _LABELS or label.isdigit() for label in labels)
    if kind not in headers.SIZES or not is_label:
        return None
    is_letter = not any(word == kind for word in words)
    return Spelling(f"{kind}_{unit}", "".join(labels), is_mean, is_square, is_letter)


def _kind_and_labels(words: list[str]) -> tuple[str, list[str]]:
    """The kind of size that words speak of, and what is left: "diameter d n 2" is a diameter, 2."""
    side = next((word for word in words if word in ("left", "right")), "")
    if side:
        # Of "d left", "x_l left", "left position" all is the reading on the left.
        return side, [word for word in words if word not in (side, "diameter", "position", *_SIDE_LETTERS)]
    head, *labels = words or [""]
    if labels and (head in _LABELS or head.isdigit()):
        # "A d", "1 diameter": which reading comes first.
        head, *labels = *labels, head
    kind = headers.LETTERS.get(head, head)
    if labels and (labels[0] == kind[:1] or (kind == "position" and labels[0] == "x")):
        labels = labels[1:]
    if labels and labels[0] in headers.ORDER_LETTERS:
        labels = labels[1:]
    return kind, labels


def _with_numbers_apart(words: Sequence[str]) -> list[str]:
    """Words, a number at the end of one by itself: "d2" is d, 2; "dx" is d, x."""
    apart = []
    for word in words:
        match = _NUMBERED.fullmatch(word)
        apart += filter(None, match.groups()) if match else [word]
    return apart


@dataclass(frozen=True)
class Table:
    """Cells by header, the line that each row stands on, and what is to be said of the columns.

    `origins`: the table's own header of a column that got a usual name.
    """

    cells: dict[str, Sequence]
    lines: list[int]
    notes: list[str]
    origins: dict[str, str] = field(default_factory=dict)


def in_usual_names(cells: Mapping[str, Sequence], lines: list[int], mapped: Collection[str]) -> Table:
    """A table whose columns have the names of `headers.NAMES` where its headers say so in another way.

    Of what is there in the usual way nothing changes. Several columns of one size, such as D1 and D2, are readings of
    the same rings, one below the other. `mapped`: headers that the user has named.
    """
    usual = {headers.canonical(header) for header in cells if header not in mapped}
    table = Table(dict(cells), lines, [])
    if "order" not in usual:
        table = _with_orders(table, mapped)
    if not any(name in headers.NAMES and name != "order" for name in usual):
        table = _with_sides(table, mapped)
        usual |= {name for name in table.origins if name != "order"}
    unusual = {
        header: spelled
        for header in table.cells
        if header not in mapped and not headers.canonical(header) and (spelled := spelling(header)) is not None
    }
    plain = {header: spelled for header, spelled in unusual.items() if not spelled.is_square and not spelled.is_mean}
    groups: dict[str, dict[str, str]] = {}
    for header, spelled in plain.items():
        if spelled.name not in usual:
            groups.setdefault(spelled.name, {}).setdefault(spelled.label, header)
    for name, by_label in groups.items():
        if len(by_label) == 1:
            (header,) = by_label.values()
            table = _renamed(table, header, name, unusual[header].is_letter)
    repeated = {name: by_label for name, by_label in groups.items() if len(by_label) > 1}
    if repeated:
        table = _one_below_the_other(table, repeated)
    for header, spelled in unusual.items():
        if spelled.name in (*usual, *groups) or any(
            name in table.cells for name in headers.NAMES if name[:4] in _SIZES
        ):
            if spelled.is_mean and spelled.name in repeated:
                table.notes.append(
                    Reason.MEAN_NOT_USED(column=header, sizes=", ".join(repeated[spelled.name].values()))
                )
        elif spelled.is_mean and not spelled.is_square:
            table = _renamed(table, header, spelled.name, spelled.is_letter)
        elif spelled.is_square:
            table = _rooted(table, header, spelled.name)
    return table


# How the names of sizes begin.
_SIZES = tuple(kind[:4] for kind in headers.SIZES)


def _renamed(table: Table, header: str, name: str, is_doubtful: bool) -> Table:
    cells = {name if column == header else column: values for column, values in table.cells.items()}
    notes = [Reason.COLUMN_TAKEN(column=header, meaning=name)] if is_doubtful else []
    return replace(table, cells=cells, notes=[*table.notes, *notes], origins=table.origins | {name: header})


def _with_orders(table: Table, mapped: Collection[str]) -> Table:
    """The table with the one column of whole numbers for its orders that is called most as orders are."""
    candidates: dict[int, list[str]] = {}
    for header, values in table.cells.items():
        rank = headers.order_rank(header)
        if header in mapped or rank is None:
            continue
        orders = numbers(values, header, table.lines, np.zeros(len(values), bool))
        orders = orders[np.abs(orders) < _MOST]
        if len(np.unique(orders)) > 1 and np.all(2 * orders == np.round(2 * orders)):
            candidates.setdefault(rank, []).append(header)
    if not candidates or len(likeliest := candidates[min(candidates)]) > 1:
        return table
    return _renamed(table, likeliest[0], "order", is_doubtful=min(candidates) > 0)


def _with_sides(table: Table, mapped: Collection[str]) -> Table:
    """The table with its columns of both sides, where two are called "L" and "R", "x_l" and "x_r" or "x1" and "x2"."""
    by_side: dict[tuple[str, str], str] = {}
    for header in table.cells:
        words = [word for word in headers.words_of(header) if word not in headers.FILLERS - {"x"}]
        unit = headers.UNIT_WORDS.get(words[-1], "") if len(words) > 1 else ""
        side = _BY_LETTERS.get("".join(words[:-1]))
        if unit and side and header not in mapped:
            by_side.setdefault((side, unit), header)
    for (side, unit), header in by_side.items():
        if side == "left" and (partner := by_side.get(("right", unit))):
            table = _renamed(table, header, f"left_{unit}", is_doubtful=True)
            return _renamed(table, partner, f"right_{unit}", is_doubtful=True)
    return table


def _one_below_the_other(table: Table, repeated: Mapping[str, Mapping[str, str]]) -> Table:
    """The table with a row for each reading. Columns of another number of readings than the first stay as they are."""
    first = next(iter(repeated.values()))
    alike = {name: by_label for name, by_label in repeated.items() if by_label.keys() == first.keys()}
    merged = {header for by_label in alike.values() for header in by_label.values()}
    cells: dict[str, Sequence] = {
        header: list(values) * len(first) for header, values in table.cells.items() if header not in merged
    }
    for name, by_label in alike.items():
        cells[name] = [cell for label in first for cell in table.cells[by_label[label]]]
    listed = ", ".join(sorted(merged))
    origins = table.origins | {name: ", ".join(by_label.values()) for name, by_label in alike.items()}
    notes = [*table.notes, Reason.COLUMNS_UNITED(columns=listed)]
    return Table(cells, table.lines * len(first), notes, origins)


def _rooted(table: Table, header: str, name: str) -> Table:
    """The table with the roots of a column of squares."""
    squares = numbers(table.cells[header], header, table.lines, np.zeros(len(table.lines), bool))
    if np.any(squares < 0):
        raise ValueError(f"{header} holds a negative square; allowed: zero or more")
    cells = dict(table.cells) | {name: np.sqrt(squares).tolist()}
    del cells[header]
    notes = [*table.notes, Reason.SQUARES_TAKEN(column=header, sizes=name)]
    return replace(table, cells=cells, notes=notes, origins=table.origins | {name: header})
