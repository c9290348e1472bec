"""Readings of both sides of a ring below each other: a column says which side, another one where it was."""

from dataclasses import replace

from fitting.tables.cells import is_number
from fitting.tables.headers import order_rank, unit_of
from fitting.tables.layout import Layout
from fitting.tables.vocabulary import words_of

_SIDES = ("left", "right")


def sides_apart(layout: Layout) -> Layout:
    """The table with a row a ring and columns left and right, where its rows are one side each; else as it is.

    Orders may stand beside the first side alone, as merged cells leave them.
    """
    sides = next((k for k in range(len(layout.names)) if _says_sides(layout, k)), None)
    orders = next((k for k, name in enumerate(layout.names) if order_rank(name) is not None), None)
    places = next((k for k in range(len(layout.names)) if k not in (sides, orders) and _is_reading(layout, k)), None)
    if sides is None or orders is None or places is None:
        return layout
    rings: dict[tuple[int, str], dict[str, str]] = {}
    lines, order = [], ""
    for row, line, block in zip(layout.rows, layout.lines, layout.block, strict=True):
        order = row[orders] or order
        readings = rings.setdefault((block, order), {})
        side = _side(row[sides])
        # A second reading of one side is another table than this.
        if side in readings:
            return layout
        lines += [] if readings else [line]
        readings[side] = row[places]
    unit = unit_of(layout.names[places])
    names = [layout.names[orders], *(f"{side} ({unit})" if unit else side for side in _SIDES)]
    rows = [[order, *(readings.get(side, "") for side in _SIDES)] for (_, order), readings in rings.items()]
    return replace(layout, names=names, rows=rows, lines=lines, block=[block for block, _ in rings])


def _side(cell: str) -> str:
    words = words_of(cell)
    letters = {"l": "left", "r": "right"}
    return letters.get(words[0], words[0]) if len(words) == 1 else ""


def _says_sides(layout: Layout, column: int) -> bool:
    cells = [row[column] for row in layout.rows]
    sides = {cell: _side(cell) for cell in set(cells)} if len(set(cells)) == 2 else {}
    return set(sides.values()) == set(_SIDES)


def _is_reading(layout: Layout, column: int) -> bool:
    return all(is_number(row[column]) for row in layout.rows)
