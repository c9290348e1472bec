"""What a worker process does besides its work: it ends with its coordinator, and leaves Ctrl-C to it."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable
from multiprocessing.connection import wait


def begin() -> None:
    """Of a new worker process: end when the coordinator has ended, however that came about."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # of the terminal's whole group; the coordinator decides
    coordinator = multiprocessing.parent_process()
    if coordinator is not None:
        threading.Thread(target=_end_after, args=(coordinator.sentinel,), daemon=True, name="coordinator").start()


def _end_after(sentinel: int) -> None:
    wait([sentinel])
    os._exit(1)


def warm_up(prepare: Callable[[], None]) -> int:
    """Load what the work needs, while the coordinator waits for the first result; the number of the process."""
    prepare()
    return os.getpid()
