"""The public verb `batch`: many photographs, each with its settings, measured by worker processes."""

import inspect
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import closing
from pathlib import Path
from typing import Any, NamedTuple

import fitting
from fitting.batches import (
    Batch,
    ClusterPool,
    Job,
    Ledger,
    LocalPool,
    Tally,
    described,
    digest_of,
    photographs,
    rows_of,
    run,
)
from fitting.parameters import progress_of
from fitting.shell.photograph_work import measure, prepare

# Settings that may be a path; what the file holds is then part of a photograph's key.
_FILES = ("mask", "scale")


class Entry(NamedTuple):
    """A photograph, what is given of it, and the same for JSON."""

    path: Path
    arguments: Mapping[str, Any]
    settings: Mapping[str, Any]
    page: int | None = None


class Workers(NamedTuple):
    """Who measures: so many processes of this machine (None: one a core), or those of a Dask scheduler."""

    processes: int | None = None
    scheduler: str | None = None


def batch(
    paths: str | Path | Mapping[str, Any] | Iterable[str | Path | Mapping[str, Any]],
    results: str | Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    retry: bool = False,
    progress: bool | Callable[[int, int], None] | None = None,
    **settings: Any,
) -> Batch:
    """The rows of many photographs, measured by worker processes, with a control chart.

    Each row is appended to the file `results` and synced as soon as it is there: after the end of any process the same
    call goes on where it was. A photograph counts as measured by its content, its settings, its path and its page.
    What cannot be read, and what is refused, are rows with the reason. All pages of a TIFF, a GIF, a WebP or an array
    are measured. Worker processes are spawned: in a script this call stands under `if __name__ == "__main__":`.

    Args:
      paths: a photograph, a folder with its subfolders, a pattern such as `day*/*.tif`, or an iterable of these; in
        place of a path also a mapping with "photo" and settings of its own, "page" among them.
      results: the file of rows, one JSON object a line; it is made, or continued.
      workers: processes; one for each core unless given. Each takes about 0.8 GB of memory.
      scheduler: address of a Dask scheduler whose workers measure instead (the extra `cluster`); they must see the
        same paths.
      retry: True to measure again what has failed, such as unreadable files.
      progress: True for a bar on the terminal, or a function of (photographs done, their number).
      settings: arguments of `fit` for all photographs, such as wavelength and pixel_size [m].

    Raises ValueError for settings that `fit` does not take, FileNotFoundError for a path without a photograph,
    ConnectionError without a scheduler, RuntimeError where worker processes cannot start.

    """
    entries = [entry for item in _items(paths) for entry in _entries(item, settings)]
    tally = Tally(total=len(entries))
    with progress_of(progress, "measuring") as show:
        measure_all(
            iter(entries), Path(results), Workers(workers, scheduler), tally, lambda _: show(tally.done, tally.total),
            retry,
        )  # fmt: skip
    return Batch(Path(results), rows_of(Path(results), tally.keys))


def measure_all(
    entries: Iterator[Entry | None],
    results: Path,
    workers: Workers,
    tally: Tally,
    show: Callable[[bool], None],
    retry: bool = False,
    watch: Callable[[Ledger], None] = lambda _: None,
) -> None:
    """Measure photographs into a file of rows; `watch` gets it before the first; errors and `show` as of `batch`."""
    with closing(_pool(workers)) as pool, Ledger(results, retry) as ledger:
        watch(ledger)
        run(_jobs(entries, pool), pool, ledger, tally, show)


def entries_of(paths: Iterable[Path], arguments: Mapping[str, Any], page: int | None = None) -> list[Entry]:
    """Photographs that have their settings in common."""
    settings = {name: _described(name, value) for name, value in arguments.items() if value is not None}
    return [Entry(path, arguments, settings, page) for path in paths]


def _described(name: str, value: Any) -> Any:
    if name in _FILES and isinstance(value, str):
        return described(Path(value))
    if name == "scene":
        from newtonjax.benches import scene_text

        return scene_text(value)
    return described(value)


def _items(paths: Any) -> Iterable[Any]:
    if isinstance(paths, str | Path | Mapping):
        return [paths]
    if not isinstance(paths, Iterable):
        raise ValueError(f"paths is {paths!r}; allowed: a path, a folder, a pattern, a mapping, or several of these")
    return paths


def _entries(item: Any, settings: Mapping[str, Any]) -> list[Entry]:
    if isinstance(item, str | Path):
        check_arguments(settings)
        return entries_of(photographs([item]), settings)
    if not isinstance(item, Mapping) or not isinstance(item.get("photo"), str | Path):
        raise ValueError(f"a photograph is {item!r}; allowed: a path, or a mapping with one as 'photo'")
    arguments = {**settings, **item}
    path, page = Path(arguments.pop("photo")), arguments.pop("page", None)
    check_arguments(arguments)
    return entries_of([path.absolute()], arguments, page)


def check_arguments(arguments: Mapping[str, Any]) -> None:
    """Raises ValueError for what every photograph would fail by: names that `fit` does not take, and values."""
    allowed = [name for name in inspect.signature(fitting.fit).parameters if name not in ("image", "progress", "page")]
    if unknown := sorted(set(arguments) - set(allowed)):
        raise ValueError(f"{unknown[0]} is no setting of a photograph; allowed: {', '.join(allowed)}")
    if arguments.get("scene") is not None or arguments.get("scale") is not None:
        return
    # It checks at once, before the first frame; here there are none.
    checked = inspect.signature(fitting.fit_stack).parameters
    fitting.fit_stack((), **{name: value for name, value in arguments.items() if name in checked})


def _jobs(entries: Iterator[Entry | None], pool: LocalPool | ClusterPool) -> Iterator[Job | None]:
    is_first = True
    for entry in entries:
        if entry is None:
            yield None
            continue
        if is_first and isinstance(pool, ClusterPool):
            pool.check_file(str(entry.path))
        is_first = False
        yield Job(str(entry.path), entry.page, digest_of(entry.path), entry.arguments, entry.settings)


def _pool(workers: Workers) -> LocalPool | ClusterPool:
    if workers.scheduler is not None:
        return ClusterPool(workers.scheduler, measure)
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    count = cores if workers.processes is None else workers.processes
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= 1024:
        raise ValueError(f"workers is {count!r}; allowed: 1 to 1024 processes")
    return LocalPool(count, measure, prepare)
