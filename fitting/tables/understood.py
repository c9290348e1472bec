"""What was understood of a table, in one line: how it was read, columns, units, and rows that were left out."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fitting.tables.columns import RawTable

# Rows that the line lists at most.
_LISTED = 6


@dataclass(frozen=True)
class Rejected:
    """Rows that were left out: how many with an empty cell; those without an order, between the readings or below."""

    incomplete: int
    between: list[str]
    below: list[str]

    @classmethod
    def of(cls, cells: Sequence, order: np.ndarray, complete: np.ndarray, lines: Sequence[int]) -> "Rejected":
        """`cells` of the orders, and as numbers; which rows are `complete`."""
        texts = [str(cell).strip() for cell in cells]
        is_text = np.array([bool(text) for text in texts]) & ~np.isfinite(order)
        last = int(np.flatnonzero(complete).max())
        rows = [(row, f"line {lines[row]} ({texts[row][:30]!r})") for row in np.flatnonzero(is_text).tolist()]
        return cls(
            int(np.sum(~complete & ~is_text)),
            [text for row, text in rows if row < last and _is_no_mark(texts[row])],
            [text for row, text in rows if row >= last or not _is_no_mark(texts[row])],
        )


def _is_no_mark(text: str) -> bool:
    return text.lower() not in ("nan", "none")


def sentence(
    raw: RawTable,
    names: Sequence[str],
    origins: Mapping[str, str],
    made_of: Mapping[str, str],
    rejected: Rejected,
) -> str:
    """One line: separators and encoding; each column with its header and unit; rows left out, and why."""
    parts = [raw.form] if raw.form else []
    columns = []
    for name in names:
        kind, _, unit = name.partition("_")
        header = origins.get(name, "")
        header = made_of.get(header, made_of.get(f"{kind} ({unit})", header))
        columns.append(f"{kind}{f' [{unit}]' if unit else ''}{f' from {header!r}' if header else ''}")
    parts.append(", ".join(columns))
    rows = [*raw.ignored, *rejected.between, *rejected.below]
    if rejected.incomplete:
        rows.append(f"{rejected.incomplete} with an empty cell")
    if rows:
        beyond = f" and {len(rows) - _LISTED} more" if len(rows) > _LISTED else ""
        parts.append(f"left out: {', '.join(rows[:_LISTED])}{beyond}")
    return "; ".join(parts)
