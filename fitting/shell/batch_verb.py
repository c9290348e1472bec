"""The verb `batch`: many photographs to a table, a control chart and an exit status."""

import os
import sys
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from fitting.batches import FAILED, Batch, Tally, follow, photographs, rows_of
from fitting.parameters import output
from fitting.shell import stopping
from fitting.shell.answer import as_png
from fitting.shell.batch_progress import progress_line
from fitting.shell.fit_arguments import FitOptions, arguments_of
from fitting.shell.fit_verb import check_options
from fitting.shell.manifest import rows_of_manifest
from fitting.shell.photographs import Entry, Workers, check_arguments, entries_of, measure_all

_RESULTS, _TABLE, _CHART = "results.jsonl", "summary.csv", "chart.png"
_TRACKER = "ignore::UserWarning:multiprocessing.resource_tracker"
# The exit status of a batch, by the worst status of a photograph.
_EXIT = {FAILED: 5, "not-converged": 4, "refused": 3}


class Request(NamedTuple):
    """What is measured, where the answers go, and by whom; `arriving`: the folder that is followed."""

    paths: list[Path]
    options: FitOptions
    folder: Path
    workers: Workers
    arriving: Path | None = None
    retry: bool = False


def run(request: Request) -> int:
    """Measure, print the report, write the table and the chart; the exit status."""
    folder, tally = request.folder, Tally()
    if not request.paths and request.arriving is None:
        raise ValueError("no photographs are named; give files, folders, patterns, a manifest, or --follow FOLDER")
    if request.arriving is not None and not request.arriving.is_dir():
        raise NotADirectoryError(f"--follow {request.arriving} is not a folder; make it, or name another one")
    check_options(request.options)
    entries = _entries(request)
    _check_folder(folder)
    tally.total = len(entries)
    following = iter(()) if request.arriving is None else _arriving(request, request.arriving, tally)
    summary = _Summary(folder, tally)
    _keep_tracker_quiet()
    with progress_line(tally) as show:

        def after_a_change(is_idle: bool) -> None:
            show()
            if is_idle:
                summary.refresh()

        measure_all(
            _all(entries, following),
            folder / _RESULTS,
            request.workers,
            tally,
            after_a_change,
            request.retry,
            lambda ledger: stopping.keep(ledger.path, "the same command goes on with it", ledger.writing),
        )
    batch = summary.write()
    print(batch.report())
    print(f"files: {', '.join(str(path) for path in (folder / _RESULTS, *summary.files))}")
    return _status(batch)


class _Summary:
    """Table and chart, written when nothing remains to be done, and again when there is more."""

    def __init__(self, folder: Path, tally: Tally):
        self._folder, self._tally = folder, tally
        self._written, self._not_before = 0, 0.0
        self.files: list[Path] = []

    def refresh(self) -> None:
        """Write where there are new rows, for at most a tenth of the time: all rows are read for it."""
        if self._written == self._tally.done or time.monotonic() < self._not_before:
            return
        began = time.monotonic()
        self.write()
        self._not_before = time.monotonic() + 9 * (time.monotonic() - began)

    def write(self) -> Batch:
        """Write both, the chart where there is a value."""
        results = self._folder / _RESULTS
        batch = Batch(results, rows_of(results, self._tally.keys))
        self.files = [self._folder / _TABLE]
        output.write(self.files[0], batch.table(), force=True)
        if batch.measured:
            self.files.append(self._folder / _CHART)
            output.write(self.files[1], as_png(batch.figure()), force=True)
        self._written = self._tally.done
        return batch


def _entries(request: Request) -> list[Entry]:
    """The photographs that are named, manifests read."""
    entries, plain = [], [path for path in request.paths if path.suffix.lower() != ".csv"]
    if plain:
        entries += _checked(photographs(plain, request.folder), request.options)
    for manifest in (path for path in request.paths if path.suffix.lower() == ".csv"):
        for photo, options in rows_of_manifest(manifest, request.options):
            check_options(options)
            entries += _checked([photo], options)
    return entries


def _checked(paths: list[Path], options: FitOptions) -> list[Entry]:
    arguments = arguments_of(options)
    page = arguments.pop("page", None)
    check_arguments(arguments)
    return entries_of(paths, arguments, page)


def _arriving(request: Request, folder: Path, tally: Tally) -> Iterator[Entry | None]:
    for path in follow(folder, request.folder):
        if path is None:
            yield None
            continue
        tally.total += 1
        yield from _checked([path], request.options)


def _all(entries: Iterable[Entry], following: Iterator[Entry | None]) -> Iterator[Entry | None]:
    yield from entries
    yield from following


def _check_folder(folder: Path) -> None:
    """Make the folder; files of an earlier run in it are continued, or replaced."""
    if folder.exists() and not folder.is_dir():
        raise NotADirectoryError(f"--output-dir {folder} is a file; name a folder")
    output.make_folder(folder)
    output.check_free([folder / _RESULTS, folder / _TABLE, folder / _CHART], force=True)


def _keep_tracker_quiet() -> None:
    """Start the process that removes the semaphores of worker pools so that it does not complain after Ctrl-C."""
    if os.name != "posix":
        return
    from multiprocessing import resource_tracker

    before = os.environ.get("PYTHONWARNINGS")
    os.environ["PYTHONWARNINGS"] = ",".join(filter(None, [before, _TRACKER]))
    try:
        resource_tracker.ensure_running()
    finally:
        del os.environ["PYTHONWARNINGS"]
        if before is not None:
            os.environ["PYTHONWARNINGS"] = before


def _status(batch: Batch) -> int:
    counts = batch.counts
    worst = next((status for status in _EXIT if status in counts), None)
    if worst is None:
        return 0
    numbers = ", ".join(f"{counts[status]} {status}" for status in _EXIT if status in counts)
    print(f"newtonjax: of {len(batch.rows)} photographs {numbers}; {_TABLE} has the reasons", file=sys.stderr)
    return _EXIT[worst]
