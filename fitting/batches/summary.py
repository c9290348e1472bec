"""What a batch has come to: a row a photograph, a table, a control chart, a report."""

import csv
import io
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import msgspec

from fitting.batches import chart
from fitting.batches.chart import Control
from fitting.batches.job import FAILED

# Statuses from the worst on, as the report lists them.
_STATUSES = (FAILED, "not-converged", "refused", "no-scale", "ok")
# Photographs that the report names one by one, at most.
_NAMED = 10


class Row(msgspec.Struct, frozen=True):
    """A photograph of a batch.

    - `status`: that of its `FitResult`, or "failed" for an unreadable file; `reason`: a name of `fitting.Reason`, or of
      what failed; `message`: the same in words.
    - `value`, `sd`: of `quantity`, in `unit`; `sd_noise`: by the noise of the image alone.
    - `taken`: local time, of the camera or of the file, ISO 8601; `seconds`: that the measurement took.
    """

    key: str
    path: str
    page: int
    status: str
    reason: str | None = None
    message: str = ""
    quantity: str | None = None
    unit: str = ""
    value: float | None = None
    sd: float | None = None
    sd_noise: float | None = None
    taken: str = ""
    seconds: float = 0.0
    warning_codes: list[str] = msgspec.field(default_factory=list)

    @property
    def name(self) -> str:
        """The file's name, with the page where it is not the first."""
        return Path(self.path).name + (f" page {self.page}" if self.page > 1 else "")

    @property
    def words(self) -> str:
        """The quantity as text shows it."""
        return (self.quantity or "").replace("_", " ")

    @property
    def unit_words(self) -> str:
        """The unit as text shows it."""
        return self.unit.replace("per_px2", "per px²")


@dataclass(frozen=True, repr=False)
class Batch:
    """The outcome of `fitting.batch`: `rows`, a photograph each, in the order of the photographs.

    `results`: the file with all that is known of each, a JSON object a line, whose `result` is that of
    `FitResult.to_dict`.
    """

    results: Path
    rows: tuple[Row, ...]

    @property
    def counts(self) -> dict[str, int]:
        """Photographs by status."""
        counts = Counter(row.status for row in self.rows)
        return {status: counts[status] for status in _STATUSES if counts[status]}

    @cached_property
    def measured(self) -> tuple[Row, ...]:
        """The rows of the control chart, in the order of time: those of the quantity that most photographs gave."""
        with_values = [row for row in self.rows if row.value is not None]
        if not with_values:
            return ()
        (quantity, _), *_ = Counter(row.quantity for row in with_values).most_common(1)
        return tuple(sorted((row for row in with_values if row.quantity == quantity), key=lambda row: row.taken))

    @cached_property
    def control(self) -> Control | None:
        """Centre line, limits and outliers of `measured`; None for fewer than five values."""
        return chart.control([row.value or 0.0 for row in self.measured], _noise(self.measured))

    @cached_property
    def outliers(self) -> tuple[Row, ...]:
        """Rows of `measured` outside of their limits."""
        if self.control is None:
            return ()
        return tuple(row for row, is_outlier in zip(self.measured, self.control.outliers, strict=True) if is_outlier)

    def figure(self, ax: Any = None) -> Any:
        """The control chart as a matplotlib figure; drawn into the axes `ax` where they are given.

        Raises ValueError where no photograph gave a value.
        """
        if not self.measured:
            raise ValueError("no photograph of this batch gave a value; print its report()")
        if ax is None:
            from matplotlib.figure import Figure

            ax = Figure(figsize=(9, 4.5), layout="constrained").add_subplot()
        times, values = [row.taken for row in self.measured], [row.value or 0.0 for row in self.measured]
        first = self.measured[0]
        label = f"{first.words} [{first.unit_words}]".replace(" []", "")
        chart.draw(ax, times, values, _noise(self.measured), self.control, label)
        return ax.figure

    def table(self) -> str:
        """The rows as CSV: a column for each measured quantity, with its unit in the name."""
        quantities = sorted({(row.quantity, row.unit) for row in self.rows if row.quantity})
        columns = [f"{name}_{part}{unit}".rstrip("_") for name, unit in quantities for part in ("", "sd_")]
        text, outside = io.StringIO(newline=""), {row.key for row in self.outliers}
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(["path", "page", "taken", "status", "reason", *columns, "outlier", "seconds", "message"])
        for row in self.rows:
            cells = [
                value if (row.quantity, row.unit) == quantity else None
                for quantity in quantities
                for value in (row.value, row.sd)
            ]
            is_outlier = "yes" if row.key in outside else ""
            about = (row.path, row.page, row.taken, row.status, row.reason)
            writer.writerow([*about, *cells, is_outlier, row.seconds, row.message])
        return text.getvalue()

    def report(self) -> str:
        """How many photographs of each status, the centre of the control chart, and what needs a look."""
        counts = ", ".join(f"{count} {status}" for status, count in self.counts.items())
        lines = [f"[[Batch]]  {len(self.rows)} photographs: {counts or 'none'}"]
        if self.control is not None:
            first, (centre, low, high, _) = self.measured[0], self.control
            lines += [
                f"    {first.words}: median {centre:.6g} {first.unit_words}, limits {low:.6g} to {high:.6g} "
                f"({len(self.outliers)} of {len(self.measured)} outside)"
            ]
        outliers = [f"{row.name}: {row.value:.6g} {row.unit_words}" for row in self.outliers]
        lines += _listed("Outliers", outliers)
        for status in (FAILED, "not-converged", "refused"):
            rows = [f"{row.name}: {row.message}" for row in self.rows if row.status == status]
            lines += _listed(status.capitalize(), rows)
        return "\n".join(lines)

    def __str__(self) -> str:
        return self.report()

    def __repr__(self) -> str:
        return "\n".join(["<Batch>", *self.report().splitlines()[:4]])


def _listed(title: str, texts: list[str]) -> list[str]:
    if not texts:
        return []
    omitted = [f"    and {len(texts) - _NAMED} more, in the table"] if len(texts) > _NAMED else []
    return [f"[[{title}]]", *(f"    {text}" for text in texts[:_NAMED]), *omitted]


def _noise(rows: Iterable[Row]) -> list[float]:
    """Standard deviations by which photographs differ: the noise of each image, not what all have in common."""
    return [row.sd_noise or row.sd or 0.0 for row in rows]


def rows_of(path: Path, keys: Iterable[str]) -> tuple[Row, ...]:
    """The rows of photographs by key, in this order; the last one where a photograph was measured again."""
    rows: dict[str, Row] = dict.fromkeys(keys)  # pyright: ignore[reportAssignmentType]  # filled below
    decoder = msgspec.json.Decoder(Row)
    with path.open("rb") as file:
        for line in file:
            row = decoder.decode(line)
            if row.key in rows:
                rows[row.key] = row
    return tuple(row for row in rows.values() if row is not None)
