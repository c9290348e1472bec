"""Readings of a main scale and of its vernier, or drum, brought together."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fitting.tables.cells import numbers
from fitting.tables.columns import RawTable
from fitting.tables.headers import FILLERS, METRES, UNIT_WORDS, canonical
from fitting.tables.vocabulary import words_of

_ROLES = ("main", "vernier")
_SIDES = {"l": "left", "r": "right", "lhs": "left", "rhs": "right"}
_BESIDE = FILLERS | {"scale", "coincidence", "constant", "position", "division", "divisions", "of"}


@dataclass(frozen=True)
class _Part:
    """A column of one scale: which one, of what reading, in which unit ("" for divisions)."""

    header: str
    role: str
    reading: tuple[str, ...]
    unit: str


@dataclass(frozen=True)
class WithReadings:
    """A table with such readings as columns, their names by what they were made of; pairs that need a constant."""

    raw: RawTable
    made_of: Mapping[str, str]
    needs_constant: Sequence[str]


def with_readings(raw: RawTable, constant: float | None) -> WithReadings:
    """The table with main + constant x vernier for every such pair of columns that no column of totals stands beside.

    `constant` [m]: of a division of the vernier; not needed where its column has a unit of length.
    """
    parts = [part for header in raw.cells if (part := _part(header))]
    totals = {canonical(header) for header in raw.cells}
    cells, made_of, needs = dict(raw.cells), {}, []
    for main in (part for part in parts if part.role == "main"):
        vernier = next((part for part in parts if part.role == "vernier" and part.reading == main.reading), None)
        name = f"{' '.join(main.reading) or 'position'} ({main.unit})"
        if vernier is None or not main.unit or (canonical(name) or name) in totals:
            continue
        of_division = _of_division(vernier, main, raw.cells[vernier.header], constant)
        if of_division is None:
            needs.append(vernier.header)
            continue
        is_row = np.zeros(len(raw.lines), bool)
        main_scale, divisions = (
            numbers(raw.cells[part.header], part.header, raw.lines, is_row) for part in (main, vernier)
        )
        sums = main_scale + divisions * of_division / METRES[main.unit]
        cells[name] = ["" if np.isnan(total) else f"{total:.12g}" for total in sums]
        made_of[name] = f"{main.header} and {vernier.header}"
        for part in (main, vernier):
            del cells[part.header]
    return WithReadings(replace(raw, cells=cells), made_of, needs)


def _of_division(vernier: _Part, main: _Part, cells: Sequence, constant: float | None) -> float | None:
    """What the vernier's numbers are in [m]: its unit, or divisions; a unit above both scales is the main one's."""
    if vernier.unit == main.unit and all(str(cell).strip().isdigit() for cell in cells if str(cell).strip()):
        return constant
    return METRES.get(vernier.unit, constant)


def _part(header: str) -> _Part | None:
    words = words_of(header)
    roles = [role for role in _ROLES if role in words]
    if len(roles) != 1:
        return None
    units = [UNIT_WORDS[word] for word in words if word in UNIT_WORDS]
    unit = units[-1] if units and units[-1] in METRES else ""
    reading = [word for word in words if word not in (*_ROLES, *_BESIDE) and word not in UNIT_WORDS]
    return _Part(header, roles[0], tuple(_SIDES.get(word, word) for word in reading), unit)
