"""Columns that say what they hold in letters, squares, repeats or means: brought to the names of `headers.NAMES`."""

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fitting.reasons import Reason
from fitting.tables import headers
from fitting.tables.columns import numbers

# What tells one of several readings of a ring from the others.
_LABELS = {"a", "b", "c", "x", "y", "h", "v", "horizontal", "vertical", "first", "second", "third", "i", "ii", "iii"}
_NUMBERED = re.compile(r"([a-z]+)([1-9]\d?)")


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
    words = [word for word in words if word not in ("squared", "mean") and word not in headers.FILLERS - {"x"}]
    unit = headers.UNIT_WORDS.get(words[-1], "") if len(words) > 1 else ""
    if not unit:
        return None
    head, *labels = _with_numbers_apart(words[:-1])
    kind = headers.LETTERS.get(head, head)
    is_letter = head in headers.LETTERS
    if is_letter and labels and labels[0] in headers.ORDER_LETTERS:
        labels = labels[1:]
    # "d_m" alone may be a diameter in metres, or that of ring m.
    is_subscript = unit == "m" and re.fullmatch(r"\s*[dDr]_?m\s*", header)
    is_label = len(labels) <= 1 and all(label in _LABELS or label.isdigit() for label in labels)
    if kind not in headers.SIZES or not is_label or is_subscript:
        return None
    return Spelling(f"{kind}_{unit}", "".join(labels), is_mean, is_square, is_letter)


def _with_numbers_apart(words: Sequence[str]) -> list[str]:
    """Words, a number at the end of one by itself: "d2" is d, 2."""
    apart = []
    for word in words:
        match = _NUMBERED.fullmatch(word)
        apart += [match[1], match[2]] if match else [word]
    return apart


@dataclass(frozen=True)
class Table:
    """Cells by header, the line that each row stands on, and what is to be said of the columns."""

    cells: dict[str, Sequence]
    lines: list[int]
    notes: list[str]


def in_usual_names(cells: Mapping[str, Sequence], lines: list[int], mapped: Collection[str]) -> Table:
    """A table whose columns have the names of `headers.NAMES` where its headers say so in another way.

    Of what is there in the usual way nothing changes. Several columns of one size, such as D1 and D2, are readings of
    the same rings, one below the other. `mapped`: headers that the user has named.
    """
    usual = {headers.canonical(header) for header in cells if header not in mapped}
    table = (
        _with_orders(Table(dict(cells), lines, []), mapped) if "order" not in usual else Table(dict(cells), lines, [])
    )
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
    return Table(cells, table.lines, [*table.notes, *notes])


def _with_orders(table: Table, mapped: Collection[str]) -> Table:
    """The table with the one column of whole numbers for its orders that is called as orders often are."""
    candidates = []
    for header, values in table.cells.items():
        words = set(headers.words_of(header))
        if header in mapped or not words or not words <= headers.ORDER_LIKE:
            continue
        try:
            orders = numbers(values, header, table.lines)
        except ValueError:
            continue
        orders = orders[np.isfinite(orders)]
        if len(np.unique(orders)) > 1 and np.all(2 * orders == np.round(2 * orders)):
            candidates.append(header)
    return _renamed(table, candidates[0], "order", is_doubtful=True) if len(candidates) == 1 else table


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
    note = Reason.COLUMNS_UNITED(columns=", ".join(sorted(merged)))
    return Table(cells, table.lines * len(first), [*table.notes, note])


def _rooted(table: Table, header: str, name: str) -> Table:
    """The table with the roots of a column of squares."""
    squares = numbers(table.cells[header], header, table.lines)
    if np.any(squares < 0):
        raise ValueError(f"{header} holds a negative square; allowed: zero or more")
    cells = dict(table.cells) | {name: np.sqrt(squares).tolist()}
    del cells[header]
    return Table(cells, table.lines, [*table.notes, Reason.SQUARES_TAKEN(column=header, sizes=name)])
