"""The workers of a Dask cluster that runs already (the extra `cluster`)."""

import os
import time
from collections.abc import Callable
from importlib.metadata import version
from typing import Any

from fitting.batches.job import FAILED, Job

# Answers of the scheduler before it counts as absent, and the age of the number of workers before it is asked anew [s].
_PATIENCE, _FRESH = 5.0, 2.0


class ClusterPool:
    """As many jobs at a time as the cluster has threads; a job whose worker dies is moved by the scheduler."""

    def __init__(self, address: str, work: Callable[[Job], dict[str, Any]]):
        """Connect to the scheduler at `address`, such as tcp://127.0.0.1:8786.

        Raises ValueError where distributed is not installed or a worker lacks this version of newtonjax, and
        ConnectionError where no scheduler answers.
        """
        try:
            import distributed  # pyright: ignore[reportMissingImports]  # an extra
        except ImportError as error:
            raise ValueError("a cluster needs distributed; install it: pip install 'newtonjax[cluster]'") from error
        self._distributed, self._work = distributed, work
        try:
            self._client = distributed.Client(address, timeout=_PATIENCE, set_as_default=False)
        except (OSError, ValueError) as error:
            raise ConnectionError(
                f"no Dask scheduler answers at {address}; start one (`dask scheduler`), or correct the address"
            ) from error
        self._running: dict[Any, Job] = {}
        self._threads, self._counted = 0, -_FRESH
        self._check_version()

    def _check_version(self) -> None:
        """Raises ValueError where a worker has another version, or none: what it would answer is not comparable."""
        for address, installed in self._client.run(version, "newtonjax", on_error="return").items():
            if installed != version("newtonjax"):
                raise ValueError(
                    f"the worker {address} has {installed!r} for newtonjax, this machine {version('newtonjax')}; "
                    "install the same version on every worker"
                )

    def check_file(self, path: str) -> None:
        """Raises ValueError where a worker does not see a file: paths are sent, not pictures."""
        for address, sees_it in self._client.run(os.path.isfile, path).items():
            if not sees_it:
                raise ValueError(f"the worker {address} does not see {path}; put the photographs on a shared disk")

    def free(self) -> int:
        """How many jobs may be started."""
        if time.monotonic() - self._counted > _FRESH:
            self._threads = sum(self._client.nthreads().values())
            self._counted = time.monotonic()
        return max(0, self._threads - len(self._running))

    def start(self, job: Job) -> None:
        """Give a job to the scheduler, which chooses the worker."""
        self._running[self._client.submit(self._work, job, key=job.key, pure=False)] = job

    def finished(self, timeout: float | None) -> list[tuple[Job, dict[str, Any] | None]]:
        """Jobs that have ended within `timeout` [s] with what came out.

        Raises ConnectionError where the scheduler is gone.
        """
        if not self._running:
            time.sleep(timeout or _FRESH)
            return []
        try:
            with self._client.as_current():
                self._distributed.wait(list(self._running), timeout, "FIRST_COMPLETED")
        except TimeoutError:
            return []
        ended = [future for future in self._running if future.done()]
        return [(self._running.pop(future), self._outcome(future)) for future in ended]

    def _outcome(self, future: Any) -> dict[str, Any]:
        if future.status in ("lost", "cancelled"):
            raise ConnectionError("the Dask scheduler is gone; start it, and give the same command again")
        error = future.exception()
        outcome = (
            future.result()
            if error is None
            else {"status": FAILED, "reason": type(error).__name__, "message": " ".join(str(error).split())}
        )
        future.release()
        return outcome

    def close(self) -> None:
        """Leave the cluster; it runs on."""
        self._client.close()
