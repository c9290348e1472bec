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
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path
from time import monotonic, time

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
# Processes that would go on alone.
_children: list[subprocess.Popen] = []


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


def keep(path: Path, words: str, lock: threading.Lock) -> None:
    """Say of a file, where a signal ends the process, that it stays; no step that holds the lock is broken off."""
    _kept[path] = words
    _locks.append(lock)


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
    output.remove_unfinished(_PATIENCE / 2)
    _remove_fresh_programs()
    complete = [str(path) for path in output.written] + [
        f"{path} ({words})" for path, words in _kept.items() if path.exists()
    ]
    cursor = _SHOW_CURSOR if sys.stderr.isatty() else ""
    message = f"{cursor}newtonjax: stopped by {_SIGNALS[number]}; complete: {', '.join(complete) or 'nothing'}"
    sys.stdout.flush()  # of a report what was printed
    print(message, file=sys.stderr, flush=True)


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
