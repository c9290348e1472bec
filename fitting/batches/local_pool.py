"""Worker processes of this machine, of which any may die at any time."""

import multiprocessing
import signal
import threading
import time
from collections.abc import Callable, Generator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import Any, NamedTuple

from fitting.batches import worker
from fitting.batches.job import FAILED, Job

# Workers that die before they are ready, one after the other, before the batch gives up.
_FAILED_STARTS = 3
Work = Callable[[Job], dict[str, Any]]


class _Worker(NamedTuple):
    """A pool of one process, and whether that is ready."""

    pool: ProcessPoolExecutor
    ready: Future


class LocalPool:
    """`count` processes, each in a pool of its own: one that dies takes no job but its own with it.

    A pool of several processes gives up all of its jobs where one process dies, and does not say which job it had. New
    processes are spawned, for a process that runs JAX has threads and must not fork.
    """

    def __init__(self, count: int, work: Work, prepare: Callable[[], None]):
        """Each process calls `prepare`, then `work` of its jobs: importable functions. All start with the first job."""
        self._count, self._work, self._prepare = count, work, prepare
        self._failed_starts = 0
        self._workers: list[_Worker] = []
        self._running: dict[Future, tuple[int, Job]] = {}

    def free(self) -> int:
        """How many jobs may be started: as many as there are idle workers, so that a kill delays no other job."""
        return self._count - len(self._running)

    def start(self, job: Job) -> None:
        """Give a job to an idle worker."""
        if not self._workers:
            self._workers = [self._new_worker() for _ in range(self._count)]
        busy = {place for place, _ in self._running.values()}
        place = next(place for place in range(len(self._workers)) if place not in busy)
        try:
            future = self._workers[place].pool.submit(self._work, job)
        except BrokenProcessPool:  # it died while it was idle
            self._replace(place)
            future = self._workers[place].pool.submit(self._work, job)
        self._running[future] = place, job

    def finished(self, timeout: float | None) -> list[tuple[Job, dict[str, Any] | None]]:
        """Jobs that have ended within `timeout` [s] with what came out; None where the worker died of it.

        Raises RuntimeError where workers die before they are ready.
        """
        if not self._running:
            time.sleep(timeout or 0.0)
        done, _ = wait(self._running, timeout, FIRST_COMPLETED)
        return [ended for future in done if (ended := self._ended(future, *self._running.pop(future)))]

    def _ended(self, future: Future, place: int, job: Job) -> tuple[Job, dict[str, Any] | None] | None:
        try:
            outcome = future.result()
        except BrokenProcessPool:
            was_ready = self._was_ready(place)
            self._replace(place)
            if was_ready:
                return job, None
            self.start(job)
            return None
        except Exception as error:  # what cannot be sent between processes, for one
            return job, {"status": FAILED, "reason": type(error).__name__, "message": str(error)}
        self._failed_starts = 0
        return job, outcome

    def _was_ready(self, place: int) -> bool:
        ready = self._workers[place].ready
        return ready.done() and ready.exception() is None

    def _replace(self, place: int) -> None:
        if not self._was_ready(place):
            self._failed_starts += 1
        if self._failed_starts >= _FAILED_STARTS:
            raise RuntimeError(
                "worker processes end before they are ready; look at their messages above. A script that calls this "
                'needs `if __name__ == "__main__":` before what it does'
            )
        self._workers[place].pool.shutdown(wait=False)
        self._workers[place] = self._new_worker()

    def close(self) -> None:
        """Let the processes end."""
        for item in self._workers:
            item.pool.shutdown(wait=False, cancel_futures=True)

    def _new_worker(self) -> _Worker:
        pool = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), initializer=worker.begin)
        with _deaf_to_ctrl_c():
            return _Worker(pool, pool.submit(worker.warm_up, self._prepare))


@contextmanager
def _deaf_to_ctrl_c() -> Generator[None, None, None]:
    """Ignore Ctrl-C for as long as a process is started, which then ignores it from its first step on."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
