"""Claim: a batch that is killed at random loses no photograph, repeats none, and measures as one that is not killed.

Photographs are made, one in two hundred of which is no image. `newtonjax batch` measures them with one worker and with
two, undisturbed; then with two that are killed by SIGKILL: at random a worker or the coordinator, each after a random
number of new rows, the coordinator started again each time; and, where `distributed` is installed, on a Dask cluster of
two workers. Equal rows are equal to the last digit. Also: how long workers outlive their coordinator, CPU seconds a
photograph, and the addresses at which any of these processes listens. On a busy machine processes take longer to notice
anything; how long an import of JAX takes is printed beside. Linux alone, whose list of processes is read.

    python -m experiments.truth.batch [--photographs 2000] [--kills 20] [--seed 0] [--quick]
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
from collections import Counter
from collections.abc import Generator
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from pathlib import Path
from time import perf_counter, sleep

import numpy as np
from PIL import Image

from experiments import records

ROOT = Path(__file__).resolve().parents[2]
PIXEL_SIZE, WAVELENGTH = 3e-5, 589.3e-9
SHAPE = (64, 80)
# One photograph in so many is no image.
CORRUPT = 200
PROGRAM = "import sys; from fitting.shell.cli import main; sys.exit(main())"
OPTIONS = ("--wavelength", "589.3nm", "--pixel-size", "30um", "--view", "reflected")


def make(folder: Path, count: int, rng: np.random.Generator) -> None:
    """Photographs of lenses of about a metre, with noise."""
    y, x = np.indices(SHAPE)
    for number in range(count):
        path = folder / f"{number:05}.png"
        if number % CORRUPT == 7:
            path.write_bytes(b"\x89PNG\r\n\x1a\n" + rng.bytes(200))
            continue
        radius, (column, row) = rng.normal(1.0, 0.01), rng.normal((40.0, 32.0), 3.0)
        squared = ((x - column) ** 2 + (y - row) ** 2) * PIXEL_SIZE**2
        light = 0.5 - 0.4 * np.cos(2 * np.pi * squared / (radius * WAVELENGTH)) + rng.normal(0, 0.02, SHAPE)
        Image.fromarray(np.clip(np.round(65535 * light), 0, 65535).astype(np.uint16)).save(path)


def started(photographs: Path, folder: Path, workers: int) -> subprocess.Popen:
    """The command at work."""
    command = ["batch", str(photographs), *OPTIONS, "--workers", str(workers), "--output-dir", str(folder)]
    return subprocess.Popen(
        [sys.executable, "-c", PROGRAM, *command], cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )


def undisturbed(photographs: Path, folder: Path, workers: int) -> dict:
    """CPU seconds of the command and its workers, wall seconds, exit status."""
    began = perf_counter()
    process = started(photographs, folder, workers)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    cpu, wall = usage.ru_utime + usage.ru_stime, perf_counter() - began
    return {"workers": workers, "cpu_s": cpu, "wall_s": wall, "status": process.returncode}


def rows_of(folder: Path) -> list[dict]:
    """The complete rows."""
    path = folder / "results.jsonl"
    text = path.read_bytes() if path.exists() else b""
    return [json.loads(line) for line in text[: text.rfind(b"\n") + 1].splitlines()]


def lines_of(folder: Path) -> int:
    """How many rows there are."""
    path = folder / "results.jsonl"
    return path.read_bytes().count(b"\n") if path.exists() else 0


def workers_of(coordinator: int) -> list[int]:
    """The worker processes of a coordinator."""
    try:
        children = Path(f"/proc/{coordinator}/task/{coordinator}/children").read_text().split()
    except OSError:
        return []
    return [int(child) for child in children if b"spawn_main" in _command(int(child))]


def _command(process: int) -> bytes:
    try:
        return Path(f"/proc/{process}/cmdline").read_bytes()  # empty of one that has ended
    except OSError:
        return b""


def killed(photographs: Path, folder: Path, kills: int, count: int, rng: np.random.Generator) -> list[dict]:
    """Kill workers and coordinators until there are no more kills to make, then let the batch end."""
    events, process = [], started(photographs, folder, 2)
    for _ in range(kills):
        target = lines_of(folder) + int(rng.integers(0, 2 * count // (kills + 1)))
        while lines_of(folder) < target and process.poll() is None:
            sleep(0.01)
        if process.poll() is not None:
            break
        workers = workers_of(process.pid)
        if workers and rng.integers(2):
            os.kill(int(rng.choice(workers)), signal.SIGKILL)
            events.append({"killed": "worker", "rows": lines_of(folder)})
            continue
        process.kill()
        process.wait()
        began, torn = perf_counter(), _is_torn(folder)
        while any(_command(worker) for worker in workers):
            sleep(0.01)
        outlived = perf_counter() - began
        events.append({"killed": "coordinator", "rows": lines_of(folder), "outlived_s": outlived, "torn": torn})
        process = started(photographs, folder, 2)
    process.wait()
    return events


def _is_torn(folder: Path) -> bool:
    path = folder / "results.jsonl"
    return path.exists() and bool(data := path.read_bytes()) and not data.endswith(b"\n")


def _listening(processes: list[int]) -> set[str]:
    """The addresses at which processes wait for others, as Linux writes them: bytes of the host from the last on."""
    sockets = set()
    for process in processes:
        with suppress(OSError):  # it has ended
            sockets |= {os.readlink(link) for link in Path(f"/proc/{process}/fd").iterdir()}
    tables = [Path(f"/proc/net/{table}").read_text().splitlines()[1:] for table in ("tcp", "tcp6")]
    fields = [line.split() for table in tables for line in table]
    return {entry[1] for entry in fields if entry[3] == "0A" and f"socket:[{entry[9]}]" in sockets}


def _family(process: int) -> list[int]:
    """A process and all that come from it."""
    children = []
    with suppress(OSError):
        for task in Path(f"/proc/{process}/task").iterdir():
            children += (task / "children").read_text().split()
    return [process, *(member for child in children for member in _family(int(child)))]


@contextmanager
def watched_addresses() -> Generator[set[str], None, None]:
    """The addresses at which this process, or one that comes from it, listens at any time in the block."""
    addresses, ended = set(), threading.Event()

    def watch() -> None:
        while not ended.wait(0.25):
            addresses.update(_listening(_family(os.getpid())))

    watcher = threading.Thread(target=watch)
    watcher.start()
    try:
        yield addresses
    finally:
        ended.set()
        watcher.join()


def is_loopback(address: str) -> bool:
    """Whether an address, as Linux writes it, is one that this machine alone can reach."""
    host = address.split(":")[0]
    return host.endswith("7F") if len(host) == 8 else host == "0" * 24 + "01000000"


def on_a_cluster(photographs: Path, folder: Path) -> None:
    """The same by two workers of Dask, every socket of which is of this machine alone."""
    import distributed

    import fitting
    from fitting.shell import quantities

    here = {"host": "127.0.0.1", "dashboard_address": "127.0.0.1:0"}
    settings = {"wavelength": quantities.length("589.3nm"), "pixel_size": quantities.length("30um")}
    folder.mkdir()
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, **here) as cluster:
        address = cluster.scheduler_address
        fitting.batch(photographs, folder / "results.jsonl", scheduler=address, view="reflected", **settings)


def answers(folder: Path) -> dict[str, tuple]:
    """What was measured of each file."""
    return {row["path"]: (row["status"], row.get("value"), row.get("sd")) for row in rows_of(folder)}


def main(photographs: int, kills: int, seed: int, quick: bool) -> None:
    """Measure, kill, compare; fail where a row is missing, double or another one."""
    rng = np.random.default_rng(seed)
    began = perf_counter()
    subprocess.run([sys.executable, "-c", "import jax"], check=True)
    importing = perf_counter() - began
    with tempfile.TemporaryDirectory() as name:
        home, pictures = Path(name), Path(name) / "photographs"
        pictures.mkdir()
        make(pictures, photographs, rng)
        if not quick:
            undisturbed(pictures / "0000?.png", home / "compiled", 2)
        with watched_addresses() as addresses:
            runs = [undisturbed(pictures, home / f"workers{workers}", workers) for workers in (1, 2)]
            events = killed(pictures, home / "killed", kills, photographs, rng)
            folders = ["workers2", "killed"]
            if find_spec("distributed") and not quick:
                on_a_cluster(pictures, home / "cluster")
                folders.append("cluster")
        reference = answers(home / "workers1")
        counts = {folder: Counter(row["path"] for row in rows_of(home / folder)) for folder in folders}
        differing = {
            folder: sum(reference.get(path) != answer for path, answer in answers(home / folder).items())
            for folder in folders
        }
        statuses = Counter(row["status"] for row in rows_of(home / "killed"))
    expected = dict.fromkeys(reference, 1)
    kinds = Counter(event["killed"] for event in events)
    outlived = max((event["outlived_s"] for event in events if "outlived_s" in event), default=0.0)
    per_photograph = [run["cpu_s"] / photographs for run in runs]
    print(f"importing JAX takes {importing:.1f} s here; {photographs} photographs: {dict(statuses)}")
    one, two = per_photograph
    print(f"CPU s a photograph: {one:.3f} with one worker, {two:.3f} with two, {two / one:.2f} times as many")
    print(f"wall s: {runs[0]['wall_s']:.1f} and {runs[1]['wall_s']:.1f}")
    print(f"killed: {dict(kinds)}; workers outlived their coordinator by at most {outlived:.2f} s")
    elsewhere = sorted(address for address in addresses if not is_loopback(address))
    print(f"{len(addresses)} addresses were listened at, {len(elsewhere)} of them reached by other machines")
    for folder in folders:
        missing = len(expected) - len(counts[folder])
        doubles = sum(count > 1 for count in counts[folder].values())
        print(f"{folder}: {missing} missing, {doubles} double, {differing[folder]} other than with one worker")
    if not quick:
        table = {"import_jax_s": importing, "photographs": photographs, "runs": runs, "kills": events}
        sockets = {"addresses": len(addresses), "elsewhere": elsewhere}
        records.save("batch", {**table, "statuses": statuses, "differing": differing, "sockets": sockets})
    if len(expected) != photographs or any(dict(counts[folder]) != expected for folder in folders):
        raise SystemExit("a photograph was lost, or has more than one row")
    if any(differing.values()):
        raise SystemExit("a batch that was killed, or shared between workers, measures otherwise")
    if statuses["failed"] != sum(number % CORRUPT == 7 for number in range(photographs)):
        raise SystemExit("a file that is no image has no row that says so")
    if elsewhere:
        raise SystemExit(f"other machines can reach {', '.join(elsewhere)}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--photographs", type=int, default=2000)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    main(
        16 if options.quick else options.photographs, 2 if options.quick else options.kills, options.seed, options.quick
    )
