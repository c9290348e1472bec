"""What the worker process of the page does: load, warm up, and then one task after the other."""

import os
import signal
import threading
import time
from collections.abc import Callable
from importlib import import_module
from multiprocessing import parent_process
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

# Kinds of messages to the page; all others are what a task tells while it runs.
READY, ANSWERED, FAILED, ENDED = "ready", "answered", "failed", "ended"
# Tasks by name: the module and its function, called with the folder, what it may tell, and the page's arguments.
TASKS = {
    "look": ("photograph_tasks", "look"),
    "measure": ("photograph_tasks", "measure"),
    "scale": ("photograph_tasks", "scale"),
    "reticle": ("photograph_tasks", "reticle"),
    "expected": ("photograph_tasks", "expected"),
    "table": ("table_task", "measure"),
    "draw": ("bench_tasks", "draw"),
    "describe": ("bench_tasks", "describe"),
    "compare": ("bench_tasks", "compare"),
}


def serve(pipe: Connection, files: Path, warm_up: str) -> None:
    """Answer tasks until the page ends; the process that is warm says so first."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # of the terminal's whole group; the page decides
    parent = parent_process()
    if parent is not None:
        threading.Thread(target=_end_after, args=(parent.sentinel, files), daemon=True, name="page").start()
    began = time.perf_counter()
    if warm_up:
        _WARM_UPS[warm_up](files)
    pipe.send((READY, time.perf_counter() - began))
    while True:
        try:
            name, arguments = pipe.recv()
        except EOFError:
            return
        pipe.send(_answer(name, files, lambda kind, content: pipe.send((kind, content)), arguments))


def _end_after(sentinel: int, files: Path) -> None:
    """When the page has ended, however that came about, nothing of its photographs stays."""
    wait([sentinel])
    for path in files.glob("*"):
        path.unlink(missing_ok=True)
    os._exit(1)


def _for_photographs(files: Path) -> None:
    """Have the compiled programs of a first answer loaded while the person still reads."""
    from fitting.shell import session
    from fitting.shell.page import photograph_tasks

    session.prepare()
    photograph_tasks.measure(files, lambda *_: None, *photograph_tasks.sample())


def _for_benches(files: Path) -> None:
    """The same for pictures of a bench."""
    from fitting.shell import session
    from fitting.shell.page import bench_tasks

    session.prepare()
    session.keep_rays()
    bench_tasks.draw(files, lambda *_: None, {})


_WARM_UPS = {"photographs": _for_photographs, "bench": _for_benches}


def _answer(name: str, files: Path, tell: Callable[[str, Any], None], arguments: tuple) -> tuple[str, Any]:
    """The answer of a task, or why there is none."""
    module, function = TASKS[name]
    try:
        task = getattr(import_module(f"fitting.shell.page.{module}"), function)
        return ANSWERED, task(files, tell, *arguments)
    except Exception as error:  # whatever a decoder raises, the page must say it and go on
        text = " ".join(str(error).split()) or type(error).__name__
        return FAILED, text.replace(f"{files}{os.sep}", "")
