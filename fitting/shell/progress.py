"""A line on the terminal for what takes longer than a second; it says when JAX is compiling."""

import os
import sys
import threading
from collections.abc import Callable, Generator
from contextlib import contextmanager

PATIENCE = 1.0
_COMPILING = "/jax/compilation_cache/compile_requests_use_cache"
_COMPILED = "/jax/core/compile/backend_compile_duration"


@contextmanager
def progress(task: str) -> Generator[None, None, None]:
    """Show `task` on stderr from the first second on until the block ends; nothing where stderr is no terminal."""
    with waiting(task) as say:
        if not _is_shown():
            yield
            return
        with _compilation(lambda: say(f"{task}: compiling (the next run will be quicker)"), lambda: say(task)):
            yield


@contextmanager
def waiting(task: str) -> Generator[Callable[[str], None], None, None]:
    """The same without JAX, which is not imported; what to call with other words."""
    # Without the import of rich where nothing is to be shown.
    if not _is_shown():
        yield lambda _: None
        return
    from rich.console import Console

    status = Console(stderr=True).status(task)
    timer = threading.Timer(PATIENCE, status.start)
    timer.start()
    try:
        yield status.update
    finally:
        timer.cancel()
        timer.join()
        status.stop()


def _is_shown() -> bool:
    """As rich decides it."""
    return sys.stderr.isatty() or bool(os.environ.get("FORCE_COLOR"))


@contextmanager
def _compilation(begun, ended) -> Generator[None, None, None]:
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
