"""A line on the terminal for what takes longer than a second; it says when JAX is compiling."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from fitting.parameters import on_a_terminal

PATIENCE = 1.0
_COMPILING = "/jax/compilation_cache/compile_requests_use_cache"
_COMPILED = "/jax/core/compile/backend_compile_duration"


@contextmanager
def progress(task: str) -> Iterator[None]:
    """Show `task` on stderr from the first second on until the block ends; nothing where stderr is no terminal."""
    if not on_a_terminal():
        yield
        return
    from rich.console import Console

    status = Console(stderr=True).status(task)
    timer = threading.Timer(PATIENCE, status.start)
    timer.start()
    try:
        with _compilation(
            lambda: status.update(f"{task}: compiling (the next run will be quicker)"),
            lambda: status.update(task),
        ):
            yield
    finally:
        timer.cancel()
        timer.join()
        status.stop()


@contextmanager
def steps(task: str) -> Iterator[Callable[[int, int], None]]:
    """A bar on stderr for a task of known length: call what it yields with the steps done and their number."""
    if not on_a_terminal():
        yield lambda *_: None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        line = bar.add_task(task, total=None)
        yield lambda done, total: bar.update(line, completed=done, total=total)


@contextmanager
def _compilation(begun, ended) -> Iterator[None]:
    """Call `begun` and `ended` around every compilation that JAX makes in the block."""
    from jax import monitoring

    # JAX's own names: its listeners are protocols, which the type checker compares by parameter names too.
    def on_event(event: str, **kwargs: str | int) -> None:  # noqa: ARG001 (JAX passes them)
        if event == _COMPILING:
            begun()

    def on_duration(event: str, duration_secs: float, **kwargs: str | int) -> None:  # noqa: ARG001 (JAX passes them)
        if event == _COMPILED:
            ended()

    monitoring.register_event_listener(on_event)
    monitoring.register_event_duration_secs_listener(on_duration)
    try:
        yield
    finally:
        monitoring.unregister_event_listener(on_event)
        monitoring.unregister_event_duration_listener(on_duration)
