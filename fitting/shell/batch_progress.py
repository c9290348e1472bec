"""What the verb `batch` tells while it runs: how far it is, how fast, and how long it will take."""

import os
import sys
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager

from fitting.batches import Tally

# Where stderr is no terminal, a line so often [s].
_INTERVAL = 30.0


@contextmanager
def progress_line(tally: Tally) -> Generator[Callable[[], None], None, None]:
    """What to call after each change of `tally`: a bar on a terminal, a line each half minute in a log."""
    if not (sys.stderr.isatty() or os.environ.get("FORCE_COLOR")):
        yield _log(tally)
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn

    columns = BarColumn(), TextColumn("{task.description}")
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(sentence(tally), total=None)
        yield lambda: bar.update(task, description=sentence(tally), completed=tally.done, total=tally.total or None)


def _log(tally: Tally) -> Callable[[], None]:
    printed = time.monotonic()

    def show() -> None:
        nonlocal printed
        if time.monotonic() - printed >= _INTERVAL:
            printed = time.monotonic()
            print(f"newtonjax: {sentence(tally)}", file=sys.stderr, flush=True)

    return show


def sentence(tally: Tally) -> str:
    """The progress in one line."""
    statuses = "".join(f", {n} {status}" for status, n in sorted(tally.statuses.items()) if status != "ok")
    before = f", {tally.resumed} measured before" if tally.resumed else ""
    remaining = tally.time_remaining
    speed = "" if remaining is None else f"; {tally.rate:.3g} a second, {_duration(remaining)} left"
    return f"{tally.done} of {tally.total} photographs{before}{statuses}{speed}"


def _duration(seconds: float) -> str:
    if seconds < 90:
        return f"{seconds:.0f} s"
    minutes = seconds / 60
    return f"{minutes:.0f} min" if minutes < 90 else f"{minutes / 60:.1f} h"
