"""How far a long call has come: a bar on the terminal, or the caller's own function."""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

# True for a bar on stderr; or a function of the steps done and their number.
Progress = bool | Callable[[int, int], None] | None


@contextmanager
def progress_of(progress: Progress, task: str) -> Iterator[Callable[[int, int], None]]:
    """What a verb calls with the steps done and their number: a bar on a terminal, a function, or nothing."""
    if callable(progress):
        yield progress
    elif not (progress and on_a_terminal()):
        yield lambda *_: None
    else:
        from rich.console import Console
        from rich.progress import Progress as Bar

        with Bar(console=Console(stderr=True), transient=True) as bar:
            line = bar.add_task(task, total=None)
            yield lambda done, total: bar.update(line, completed=done, total=total)


def on_a_terminal() -> bool:
    """As rich decides it, without its import where nothing is to be shown."""
    return sys.stderr.isatty() or bool(os.environ.get("FORCE_COLOR"))
