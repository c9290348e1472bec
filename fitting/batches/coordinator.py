"""From photographs to rows: every one once, whatever dies on the way."""

import time
from collections import Counter, deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

from fitting.batches.job import FAILED, Job
from fitting.batches.ledger import Ledger

# A photograph whose worker died so often is not tried again.
_DEATHS = 3
# How long to wait for a result before new photographs are looked for, and the progress is shown [s].
_LOOK = 1.0


@runtime_checkable
class Pool(Protocol):
    """Workers: `LocalPool` or `ClusterPool`."""

    def free(self) -> int:
        """How many jobs may be started."""
        ...

    def start(self, job: Job) -> None:
        """Start one."""
        ...

    def finished(self, timeout: float | None) -> list[tuple[Job, dict[str, Any] | None]]:
        """Those that have ended; None where the worker died."""
        ...


@dataclass
class Tally:
    """Progress: how many photographs there are, how many had a row before, the statuses of new rows, the begin.

    `keys`: of all photographs so far, measured before or now, in their order.
    """

    total: int = 0
    resumed: int = 0
    statuses: Counter = field(default_factory=Counter)
    keys: dict[str, None] = field(default_factory=dict)
    began: float = field(default_factory=time.monotonic)

    @property
    def measured(self) -> int:
        """New rows."""
        return self.statuses.total()

    @property
    def done(self) -> int:
        """Photographs that have a row."""
        return self.resumed + self.measured

    @property
    def rate(self) -> float:
        """New rows a second."""
        return self.measured / max(time.monotonic() - self.began, 1e-9)

    @property
    def time_remaining(self) -> float | None:
        """Seconds to the end at this rate, None before the first row."""
        return (self.total - self.done) / self.rate if self.measured else None


@dataclass
class _Run:
    jobs: Iterator[Job | None]
    pool: Pool
    ledger: Ledger
    tally: Tally
    show: Callable[[bool], None]
    # Jobs that come before the next of `jobs`: those whose worker died, and further pages.
    waiting: deque = field(default_factory=deque)
    active: set = field(default_factory=set)
    deaths: Counter = field(default_factory=Counter)
    is_exhausted: bool = False
    has_measured: bool = False

    def next_job(self) -> Job | None:
        """The next photograph without a row, None where there is none at present."""
        while True:
            job = self.waiting.popleft() if self.waiting else self._from_source()
            if job is None:
                return None
            self.tally.keys[job.key] = None
            if job.key in self.active:  # it was named twice
                self.tally.total -= 1
                continue
            if job.key not in self.ledger:
                return job
            self.tally.resumed += 1
            self.add_pages(job)
            self.show(False)

    def _from_source(self) -> Job | None:
        if self.is_exhausted:
            return None
        try:
            return next(self.jobs)
        except StopIteration:
            self.is_exhausted = True
            return None

    def add_pages(self, job: Job) -> None:
        """The further pages of a file whose first one has a row."""
        pages = self.ledger.pages[job.key] if job.page is None else 1
        self.waiting.extend(job.on_page(page) for page in range(2, pages + 1))
        self.tally.total += pages - 1

    def start_jobs(self) -> None:
        """Start as many as may be: one until one is measured, whose compiled programs the other workers then load."""
        while self.pool.free() > 0 and (self.has_measured or not self.active):
            job = self.next_job()
            if job is None:
                return
            self.active.add(job.key)
            self.pool.start(job)

    def take(self, job: Job, outcome: dict[str, Any] | None) -> None:
        """Write the row of a job that has ended, or give the job again where its worker died."""
        self.active.discard(job.key)
        if outcome is None:
            self.deaths[job.key] += 1
            if self.deaths[job.key] < _DEATHS:
                self.waiting.append(job)
                return
            message = f"{_DEATHS} worker processes died of this photograph; is the memory too small for it?"
            outcome = {"status": FAILED, "reason": "WORKER_DIED", "message": message}
        self.ledger.append(job.row(outcome))
        self.tally.statuses[outcome["status"]] += 1
        self.has_measured |= outcome["status"] != FAILED
        self.add_pages(job)


def run(jobs: Iterator[Job | None], pool: Pool, ledger: Ledger, tally: Tally, show: Callable[[bool], None]) -> None:
    """Measure photographs until `jobs` ends.

    `jobs` gives None where there is no photograph at present. `show` is called after each change of `tally`, and
    every second; its argument says whether nothing remains to be done at present.
    """
    state = _Run(jobs, pool, ledger, tally, show)
    while True:
        state.start_jobs()
        if not state.active and state.is_exhausted and not state.waiting:
            break
        show(not state.active and not state.waiting)
        for job, outcome in pool.finished(_LOOK):
            state.take(job, outcome)
