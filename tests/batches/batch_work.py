"""Work of worker processes in tests: what a file says is done, in place of a measurement.

python batch_work.py RESULTS FOLDER WORKERS    a coordinator that a test may kill
"""

import os
import signal
import sys
import time
from contextlib import closing
from pathlib import Path

from fitting.batches import Job, Ledger, LocalPool, Tally, digest_of, follow, photographs, run

# Long enough for a kill to meet it.
SECONDS = 0.02


def nothing() -> None:
    """Prepare a worker."""


def refuse_to_start() -> None:
    """Prepare a worker that ends of it."""
    os._exit(1)


def work(job: Job) -> dict:
    """Do what the file says: `value`, `pages`, `die` for each worker, `die once`, or `raise`."""
    verb, _, number = Path(job.path).read_text().partition(" ")
    trace(job)
    time.sleep(SECONDS)
    if verb == "die" and (not number or not (mark := Path(f"{job.path}.died")).exists()):
        if number:
            mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    if verb == "raise":
        raise ValueError("as asked")
    row = {"status": "ok", "quantity": "radius", "unit": "m", "value": 1.0, "worker": os.getpid()}
    return row | ({"pages": int(number)} if verb == "pages" and job.page is None else {})


def trace(job: Job) -> None:
    """Note the process that works."""
    folder = Path(job.path).parent / ".workers"
    folder.mkdir(exist_ok=True)
    (folder / str(os.getpid())).touch()


def jobs_of(paths):
    """A job for each path."""
    for path in paths:
        yield None if path is None else Job(str(path), None, digest_of(path), {}, {"wavelength": 5e-7})


def measured(results: Path, folder: Path, workers: int = 2, prepare=nothing, retry: bool = False) -> Tally:
    """A batch of all files of a folder."""
    paths = photographs([folder])
    tally = Tally(total=len(paths))
    with Ledger(results, retry) as ledger, closing(LocalPool(workers, work, prepare)) as pool:
        run(jobs_of(paths), pool, ledger, tally, lambda _: None)
    return tally


def followed(results: Path, folder: Path) -> None:
    """A batch without end."""
    with Ledger(results) as ledger, closing(LocalPool(1, work, nothing)) as pool:
        run(jobs_of(follow(folder, still=0.2)), pool, ledger, Tally(), lambda _: None)


if __name__ == "__main__":
    if sys.argv[3] == "follow":
        followed(Path(sys.argv[1]), Path(sys.argv[2]))
    measured(Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3]))
