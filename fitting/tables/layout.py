"""Where a table lies among rows of cells: its header, its units, its blocks, and the rows that are none of it."""

import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from fitting.tables.cells import is_missing, is_number, unit_in
from fitting.tables.headers import METRES, SIZES, UNITS, canonical, order_rank
from fitting.tables.sources import Grid
from fitting.tables.spellings import spelling

# Rows in which a header is looked for, and the most words that one of its cells has.
_LOOKED_AT, _MOST_WORDS = 60, 9
# A number without an exponent.
_PLAIN = re.compile(r"-?\d+(?:[.,]\d+)?")
# A header's quality with orders and sizes, from which on no other one is looked for.
_COMPLETE = 3


@dataclass(frozen=True)
class Layout:
    """A table's columns by name, cells as they are written; the file's line of each row; rows that are none of it.

    `block` [rows]: of which table each row is, where several stand below or beside each other, by `block_names`.
    `titles`: what stands above, or in comments.
    """

    names: list[str]
    rows: list[list[str]]
    lines: list[int]
    block: list[int]
    block_names: list[str]
    titles: list[str]
    ignored: list[str]


@dataclass(frozen=True)
class _Header:
    names: list[str]
    first: int
    after: int
    quality: int


def layout_of(grid: Grid) -> Layout:
    """The table of a grid. Raises ValueError where there are no numbers, or rows of more cells than columns."""
    rows, lines = grid.rows, grid.lines
    width = max(map(len, rows))
    header = _best_header(rows)
    if header is None or header.quality < _COMPLETE:
        # Quantities may stand in rows, readings beside each other.
        turned = _turned(rows)
        sideways = _best_header(turned)
        if sideways is not None and sideways.quality >= _COMPLETE and sideways.first == 0:
            rows, header, lines = turned, sideways, list(range(1, width + 1))
    if header is not None and header.quality < _COMPLETE and _is_title(header, rows):
        header = None
    if header is None:
        names = _of_comment(grid)
        header = _Header(names or [f"column {k + 1}" for k in range(width)], 0, 0, 0)
        titles, has_header = grid.comments, bool(names)
    else:
        titles = [*grid.comments, *(" ".join(filter(None, row)) for row in rows[: header.first])]
        has_header = True
    body = list(zip(rows[header.after :], lines[header.after :], strict=True))
    return _blocks_apart(_body(header.names, body, titles, has_header))


def quality_of(grid: Grid) -> int:
    """How much of what a table needs the best header of a grid names, 0 for none."""
    upright, sideways = _best_header(grid.rows), _best_header(_turned(grid.rows))
    return max(upright.quality if upright else 0, sideways.quality if sideways and sideways.first == 0 else 0)


def _turned(rows: Sequence[Sequence[str]]) -> list[list[str]]:
    width = max(map(len, rows))
    return [list(row) for row in zip(*[_to(row, [""] * width) for row in rows], strict=True)]


def _is_title(header: _Header, rows: Sequence[Sequence[str]]) -> bool:
    """Whether a header of a single cell stands above rows of numbers that are wider."""
    return len(header.names) == 1 and any(len(row) > 1 and any(map(is_number, row)) for row in rows[header.after :])


def _of_comment(grid: Grid) -> list[str]:
    """Names in the last comment, as programs write them; none where it has not as many."""
    width = max(map(len, grid.rows))
    for text in reversed(grid.comments):
        for names in (re.split(re.escape(grid.separator), text) if grid.separator.strip() else [], text.split()):
            if len(names) == width and not any(map(is_number, names)):
                return [name.strip() for name in names]
    return []


def _best_header(rows: Sequence[Sequence[str]]) -> _Header | None:
    """The header that names most of what a table needs, the first of these; None where no row is one."""
    best = None
    for header in _headers(rows):
        if best is None or header.quality > best.quality:
            best = header
        if best.quality >= _COMPLETE + 1:
            break
    return best


def _headers(rows: Sequence[Sequence[str]]) -> Iterator[_Header]:
    """Rows of text above rows of numbers, alone, with a row of units, and with the row below."""
    for k, row in enumerate(rows[:_LOOKED_AT]):
        if not _is_text(row):
            continue
        below = rows[k + 1 : k + 3]
        if len(below) > 1 and (units := _units(below[0])):
            named = [f"{name} ({unit})" if unit else name for name, unit in zip(_to(row, units), units, strict=False)]
            yield _header(named, k, k + 2)
        elif below and sum(map(is_number, below[0])) > 0:
            yield _header(row, k, k + 1)
        elif len(below) > 1 and _is_text(below[0]) and sum(map(is_number, below[1])) > 0:
            yield _header(_joined(row, below[0]), k, k + 2)


def _is_text(row: Sequence[str]) -> bool:
    """Whether a row may be a header: words in some of its cells, no numbers beside, and not a sentence."""
    words = [cell for cell in row if cell and not is_missing(cell)]
    has_letters = any(any(letter.isalpha() or letter in "#№∅⌀" for letter in cell) for cell in words)
    return has_letters and not any(map(is_number, words)) and all(len(cell.split()) <= _MOST_WORDS for cell in words)


def _to(row: Sequence[str], like: Sequence) -> list[str]:
    return [*row, *[""] * (len(like) - len(row))]


def _units(row: Sequence[str]) -> list[str]:
    """The units in a row below the header that holds nothing else; empty where it is no such row."""
    units = [unit_in(cell.strip("()[]")) or "" for cell in row]
    is_unit = [bool(unit) or is_missing(cell) or cell == "1" for cell, unit in zip(row, units, strict=True)]
    return units if any(units) and all(is_unit) else []


def _joined(upper: Sequence[str], lower: Sequence[str]) -> list[str]:
    """Names of two rows, where a name above holds for the columns to its right that have none."""
    names, above = [], ""
    for k, name in enumerate(lower):
        above = upper[k] if k < len(upper) and upper[k] else above
        names.append(f"{above} {name}".strip())
    return names


def _header(names: Sequence[str], first: int, after: int) -> _Header:
    """A header with its quality: 2 for sizes with a unit, 1 for ones without, 1 for an order, and a point for both."""
    sizes = [canonical(name) for name in names]
    has_order = "order" in sizes or any(order_rank(name) is not None for name in names)
    has_size = any("_" in name and not name.startswith("sd") for name in sizes) or any(map(spelling, names))
    has_kind = any(name in ("left", "diameter", "radius", "position") for name in sizes)
    quality = (2 if has_size else 1 if has_kind else 0) + has_order + (has_order and has_size)
    return _Header(list(names), first, after, quality)


def _body(names: list[str], body: list[tuple[list[str], int]], titles: list[str], has_header: bool) -> Layout:
    """The rows below a header; a row of words between them begins another block."""
    width, rows, lines, ignored = len(names), [], [], []
    block, block_names, label, is_new = [], [], "", True
    read_as: Callable[[list[str]], list[str]] = list
    for row, line in body:
        if not any(map(is_number, row)):
            if _is_text(row) and _header(row, 0, 0).quality > _COMPLETE:
                read_as = _like_the_first(names, row, line)
            elif _to(row, names) != names and not _units(row):
                label = " ".join(filter(None, row))
                ignored.append(f"line {line} ({label[:30]!r})")
            is_new = True
            continue
        row = read_as(row)
        if any(row[width:]):
            raise ValueError(
                f"line {line}: its number of cells is not the header's {width}; where commas stand in numbers, put "
                "semicolons between cells, or quotes around them"
            )
        if is_new:
            block_names.append(label or str(len(block_names) + 1))
            label, is_new = "", False
        rows.append(_to(row, names)[:width])
        lines.append(line)
        block.append(len(block_names) - 1)
    if not rows:
        header = f"the header {', '.join(map(repr, names))}" if has_header else "any header"
        raise ValueError(f"there are no readings below {header}; give a header and one row a ring")
    # What the names say of a block that begins it is no row that was left out.
    ignored = [text for text in ignored if not any(repr(name[:30]) in text for name in block_names)]
    return Layout(names, rows, lines, block, block_names, titles, ignored)


def _like_the_first(names: list[str], header: list[str], line: int) -> Callable[[list[str]], list[str]]:
    """How a further header's rows are read below the first one: in its order, sizes in its units.

    Raises ValueError where the header names other columns, such as radii below diameters.
    """
    further = [_meaning(name) for name in header]
    sources: list[tuple[int, int]] = []
    for kind, unit in map(_meaning, names):
        at = next((k for k, (further_kind, _) in enumerate(further) if further_kind == kind), None)
        further_unit = unit if at is None else further[at][1]
        is_alike = unit == further_unit or {unit, further_unit} <= METRES.keys()
        if (at is None and (kind == "order" or kind in SIZES)) or not is_alike:
            raise ValueError(
                f"line {line} is a second header, {_listed(header)}, of other columns than the first, "
                f"{_listed(names)}; give each table by itself (newtonjax compare takes their results), or the same "
                "columns in both"
            )
        power = 0 if unit == further_unit else round(math.log10(METRES[further_unit] / METRES[unit]))
        sources.append((len(header) if at is None else at, power))

    def read(row: list[str]) -> list[str]:
        row = [*_to(row, header)[: len(header)], "", *row[len(header) :]]
        return [_times_ten(row[at], power) for at, power in sources]

    return read


def _times_ten(cell: str, power: int) -> str:
    """A plain number in a unit of which a power of ten makes the column's; what is none stays as it is."""
    return f"{cell}e{power}" if power and _PLAIN.fullmatch(cell) else cell


def _meaning(name: str) -> tuple[str, str]:
    """What a column holds, by name or letter, and its unit where it states one."""
    if order_rank(name) is not None:
        return "order", ""
    spelled = spelling(name)
    usual = canonical(name) or (spelled.name if spelled and not spelled.is_square else "")
    kind, _, unit = usual.rpartition("_") if usual.rpartition("_")[2] in UNITS else (usual, "", "")
    return kind or name, unit


def _listed(names: Sequence[str]) -> str:
    return repr(", ".join(filter(None, names)))


def _blocks_apart(layout: Layout) -> Layout:
    """The table without empty columns, blocks beside each other put below each other, and each name once."""
    names, rows = layout.names, layout.rows
    used = [k for k, name in enumerate(names) if name or any(row[k] for row in rows)]
    names, rows = [names[k] or f"column {k + 1}" for k in used], [[row[k] for k in used] for row in rows]
    period = _period(names)
    if period == len(names):
        names = _each_once(names)
        return replace(layout, names=names, rows=rows)
    count = len(names) // period
    beside = [(k, row[k * period : (k + 1) * period], line) for k in range(count)
              for row, line in zip(rows, layout.lines, strict=True)]  # fmt: skip
    beside = [(k, row, line) for k, row, line in beside if any(map(is_number, row))]
    return replace(
        layout,
        names=names[:period],
        rows=[row for _, row, _ in beside],
        lines=[line for _, _, line in beside],
        block=[k for k, _, _ in beside],
        block_names=[str(k + 1) for k in range(count)],
    )


def _period(names: Sequence[str]) -> int:
    """After how many columns the names begin anew, at least two; their number where they do not."""
    for period in range(2, len(names) // 2 + 1):
        if len(names) % period == 0 and all(name == names[k % period] for k, name in enumerate(names)):
            return period
    return len(names)


def _each_once(names: Sequence[str]) -> list[str]:
    """Names of which each stands once: a second "D (mm)" is "D (mm) 2"."""
    return [name if names.count(name) == 1 else f"{name} {1 + names[:k].count(name)}" for k, name in enumerate(names)]
