"""Ctrl-C and SIGTERM end the command within two seconds, whatever it is doing, and leave no half-written file.

A handler in Python runs only between two steps of the interpreter: not before a compilation has ended, and an exception
that it raises inside a callback of JAX is dropped. So the handlers do nothing. The signal's number comes to a thread
through a socket (`signal.set_wakeup_fd`), and this thread ends the process.
"""

import os
import signal
import socket
import sys
import threading
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path

from fitting.files import output

_NAMES = {"SIGINT": "Ctrl-C", "SIGTERM": "SIGTERM", "SIGHUP": "SIGHUP"}
_SIGNALS = {int(getattr(signal, name)): text for name, text in _NAMES.items() if hasattr(signal, name)}
# How long a step that must not be broken off may take [s].
_PATIENCE = 1.0
_SHOW_CURSOR = "\x1b[?25h"

# Steps that must not be broken off, and what is said of files that stay.
_locks: list[threading.Lock] = []
_kept: dict[Path, str] = {}


@contextmanager
def watched() -> Generator[None, None, None]:
    """In this block, which the main thread runs, a signal ends the process; elsewhere nothing changes."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    listening, speaking = socket.socketpair()
    speaking.setblocking(False)
    before = {number: signal.signal(number, _do_nothing) for number in _SIGNALS}
    wakeup = signal.set_wakeup_fd(speaking.fileno(), warn_on_full_buffer=False)
    threading.Thread(target=_listen, args=(listening,), daemon=True, name="signals").start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(wakeup)
        for number, handler in before.items():
            signal.signal(number, handler)
        speaking.close()  # the thread reads the end, and ends


def keep(path: Path, words: str, lock: threading.Lock) -> None:
    """Say of a file, where a signal ends the process, that it stays; no step that holds the lock is broken off."""
    _kept[path] = words
    _locks.append(lock)


def _do_nothing(number: int, frame: object) -> None:
    del number, frame


def _listen(listening: socket.socket, end: Callable[[int], None] = os._exit) -> None:
    with listening:
        while received := listening.recv(1):
            if received[0] in _SIGNALS:
                _finish(received[0])
                end(128 + received[0])


def _finish(number: int) -> None:
    for lock in _locks:
        lock.acquire(timeout=_PATIENCE)
    output.remove_unfinished(_PATIENCE)
    complete = [str(path) for path in output.written] + [
        f"{path} ({words})" for path, words in _kept.items() if path.exists()
    ]
    cursor = _SHOW_CURSOR if sys.stderr.isatty() else ""
    message = f"{cursor}newtonjax: stopped by {_SIGNALS[number]}; complete: {', '.join(complete) or 'nothing'}"
    print(message, file=sys.stderr, flush=True)
