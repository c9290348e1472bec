"""Ctrl-C and SIGTERM end the command within two seconds, whatever it is doing, and leave no half-written file.

A handler in Python runs only between two steps of the interpreter: not before a compilation has ended, and an exception
that it raises inside a callback of JAX is dropped. So the handlers do nothing. The signal's number comes to a thread
through a socket (`signal.set_wakeup_fd`), and this thread has the process end. A second signal ends it at once.
"""

import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress
from pathlib import Path
from time import monotonic, time
from typing import NamedTuple

from fitting.parameters import output

_NAMES = {"SIGINT": "Ctrl-C", "SIGTERM": "SIGTERM", "SIGHUP": "SIGHUP"}
_SIGNALS = {int(getattr(signal, name)): text for name, text in _NAMES.items() if hasattr(signal, name)}
# How long a step that must not be broken off may take [s].
_PATIENCE = 1.0
# A signal that comes sooner after the first is the same one: `timeout` sends it to the process and to its group [s].
_ECHO = 0.3
# How long the ending may take altogether, before the process ends as it is [s].
_LIMIT = 1.8
# An entry of JAX's cache as young as this may be half of one [s].
_FRESH = 1.0
_SHOW_CURSOR = "\x1b[?25h"

# Steps that must not be broken off, and what is said of files that stay.
_locks: list[threading.Lock] = []
_kept: dict[Path, str] = {}
# What to call for what there is so far of the answer, where there is something.
_so_far: "list[Callable[[], Unfinished]]" = []
# Processes that would go on alone.
_children: list[subprocess.Popen] = []


class Unfinished(NamedTuple):
    """What there is of an answer before its end: what to call it, its report, and its files with their contents."""

    words: str
    report: str
    files: dict[Path, str]


@contextmanager
def watched() -> Generator[None, None, None]:
    """In this block, which the main thread runs, a signal ends the process; elsewhere nothing changes.

    A signal that the parent has ignored, as `nohup` does with SIGHUP, stays ignored.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    listening, speaking = socket.socketpair()
    speaking.setblocking(False)
    heeded = [number for number in _SIGNALS if signal.getsignal(number) is not signal.SIG_IGN]
    before = {number: signal.signal(number, _do_nothing) for number in heeded}
    wakeup = signal.set_wakeup_fd(speaking.fileno(), warn_on_full_buffer=False)
    listener = threading.Thread(target=_listen, args=(listening,), daemon=True, name="signals")
    listener.start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(wakeup)
        for number, handler in before.items():
            signal.signal(number, handler)
        speaking.close()
        listener.join()  # it reads the end; where a signal came before that, the process ends here


@contextmanager
def left_to_a_server() -> Generator[None, None, None]:
    """In this block of `watched` the handlers that a server sets end it; what closes its terminal is a SIGTERM."""
    wakeup = signal.set_wakeup_fd(-1)
    hangup = int(getattr(signal, "SIGHUP", 0))
    is_heeded = bool(hangup) and signal.getsignal(hangup) is _do_nothing
    if is_heeded:
        signal.signal(hangup, lambda *_: signal.raise_signal(signal.SIGTERM))
    try:
        yield
    finally:
        if is_heeded:
            signal.signal(hangup, _do_nothing)
        signal.set_wakeup_fd(wakeup)


def keep(path: Path, words: str, lock: "threading.Lock | None" = None) -> None:
    """Say of a file, where a signal ends the process, that it stays; no step that holds the lock is broken off."""
    _kept[path] = words
    if lock is not None:
        _locks.append(lock)


@contextmanager
def keeping() -> Generator[Callable[[Callable[[], Unfinished]], None], None, None]:
    """In this block a signal prints and writes what the function makes that was last handed over, if one was.

    It is called in another thread, and has a second; existing files are replaced.
    """
    try:
        yield lambda make: _so_far.__setitem__(slice(None), [make])
    finally:
        _so_far.clear()


def ends_with_us(child: subprocess.Popen) -> None:
    """Have a process that this one started end where a signal ends this one."""
    _children.append(child)


def _do_nothing(number: int, frame: object) -> None:
    del number, frame


def _listen(listening: socket.socket) -> None:
    ending, status, begun = None, 0, 0.0
    with listening, suppress(TimeoutError):
        while received := listening.recv(1):
            number = received[0]
            if ending is not None and monotonic() > begun + _ECHO:
                break
            if ending is None and number in _SIGNALS:
                status, begun = 128 + number, monotonic()
                listening.settimeout(_LIMIT)
                ending = threading.Thread(target=_end, args=(number,), daemon=True, name="ending")
                ending.start()
        else:  # the main thread has left the block
            if ending is not None:
                ending.join(_LIMIT)
    if ending is not None:
        os._exit(status)


def _end(number: int) -> None:
    """Remove what is half written, name what is complete, and end the process whatever goes wrong with that."""
    try:
        _finish(number)
    finally:
        os._exit(128 + number)


def _finish(number: int) -> None:
    deadline = monotonic() + _PATIENCE
    for child in _children:
        child.kill()
    for lock in _locks:
        lock.acquire(timeout=max(0.0, deadline - monotonic()))
    complete = [str(path) for path in dict.fromkeys(output.written) if path not in _kept] + [
        f"{path} ({words})" for path, words in _kept.items() if path.exists()
    ]
    unfinished = _leave_what_there_is()
    output.remove_unfinished(_PATIENCE / 2)
    _remove_fresh_programs()
    cursor = _SHOW_CURSOR if sys.stderr.isatty() else ""
    end = f"complete: {', '.join(complete) or 'nothing'}"
    message = f"{cursor}newtonjax: stopped by {_SIGNALS[number]}; {unfinished}{end}"
    sys.stdout.flush()  # of a report what was printed
    print(message, file=sys.stderr, flush=True)


def _leave_what_there_is() -> str:
    """Print and write what there is of the answer; words for it."""
    if not _so_far:
        return ""
    words, report, files = _so_far[-1]()
    print(report)
    written = []
    for path, content in files.items():
        with suppress(OSError):
            output.write(path, content, force=True)
            written.append(str(path))
    return f"kept: {words}{' in ' * bool(written)}{', '.join(written)}; "


def _remove_fresh_programs() -> None:
    """Remove the youngest programs of JAX's cache.

    JAX writes a program under its final name, takes a half one for a program at every later run, and warns of it.
    """
    # No more than was asked for: JAX may be in the middle of its import.
    config = getattr(sys.modules.get("jax"), "config", None)
    name = getattr(config, "jax_compilation_cache_dir", None)
    if name is None:
        return
    folder = Path(name)
    for path in [*folder.glob("*-cache"), *folder.glob(f"programs/.{os.getpid()}.*.part")]:
        with suppress(OSError):
            if path.suffix == ".part" or path.stat().st_mtime > time() - _FRESH:
                path.unlink()
