"""A line on the terminal for what takes longer than a second; it says when JAX is compiling."""

import os
import sys
import threading
from collections.abc import Generator
from contextlib import contextmanager

PATIENCE = 1.0
_COMPILING = "/jax/compilation_cache/compile_requests_use_cache"
_COMPILED = "/jax/core/compile/backend_compile_duration"


@contextmanager
def progress(task: str) -> Generator[None, None, None]:
    """Show `task` on stderr from the first second on until the block ends; nothing where stderr is no terminal."""
    # As rich decides it, without its import where nothing is to be shown.
    if not (sys.stderr.isatty() or os.environ.get("FORCE_COLOR")):
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
