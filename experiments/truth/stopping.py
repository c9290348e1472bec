"""Claim: Ctrl-C and SIGTERM are obeyed within two seconds whatever a verb is doing, and leave no half-written file.

Signals are sent to every verb of the command at random moments of its run: while it is imported, compiles, solves and
writes; every second time with an empty cache of compiled programs. Ctrl-C goes to the whole group of processes, as a
terminal sends it, in a third of the runs twice; SIGTERM to the command alone. For each: seconds until the process has
ended, its exit status, whether a process that it started still runs three seconds later, files whose names end in
`.part`, whether every file that stays is complete (JSON parses, pictures open, the chain can be read) and is named in
the last line (but after a second Ctrl-C, which has the command end without a word), whether that line is all that
stderr shows, and whether every program left in the cache is whole. A run that ends by itself before its signal counts
apart. On a busy machine two seconds may pass before the process gets its turn: how long the import of JAX takes is
printed beside.

    python -m experiments.truth.stopping [--signals 200] [--seed 0] [--verbs fit,batch] [--quick]
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import zlib
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from time import perf_counter, sleep

import numpy as np
from PIL import Image

from experiments import records
from experiments.truth.stopped_verbs import VERBS, duration, make_inputs, started

LIMIT = 2.0
KINDS = ("SIGINT", "SIGTERM", "SIGINT twice")
# Sooner after the first a second one is taken for its echo [s].
AGAIN = 0.4
# How long what a command has started may take to end after it [s].
GRACE = 3.0
# Moments are drawn up to this multiple of the time that the verb takes.
BEYOND = 1.05


def send(process: subprocess.Popen, kind: str) -> str:
    """Send a kind of signal; what the process prints until it ends."""
    if kind == "SIGTERM":
        process.send_signal(signal.SIGTERM)
    else:
        os.killpg(process.pid, signal.SIGINT)
    if kind == "SIGINT twice":
        sleep(AGAIN)
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGINT)
    return process.communicate(timeout=120)[1]


def survivors(group: int) -> bool:
    """Whether a moment after the end of a command something that it started still runs; that is ended then."""
    until = perf_counter() + GRACE
    while _runs(group):
        if perf_counter() > until:
            os.killpg(group, signal.SIGKILL)
            return True
        sleep(0.05)
    return False


def _runs(group: int) -> bool:
    """Whether a process of a group runs: one that has ended may still be in the table (Linux's proc(5))."""
    for path in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            state, _, its_group = path.read_text().rpartition(")")[2].split()[:3]
            if int(its_group) == group and state != "Z":
                return True
    return False


def stopped(verb: str, kind: str, moment: float, inputs: dict[str, str], out: Path, cache: Path) -> dict:
    """Run a verb, send it a signal after `moment` seconds, and look at what it leaves."""
    process = started(verb, inputs, out, cache)
    sleep(moment)
    seconds = None
    if process.poll() is None:
        began = perf_counter()
        message = send(process, kind)
        seconds = perf_counter() - began
    else:
        _, message = process.communicate()
    files = [path for path in out.rglob("*") if path.is_file()]
    complete = [path for path in files if not path.name.endswith(".part")]
    is_silent = process.returncode == 0 or (kind == "SIGINT twice" and not message)
    return {
        "verb": verb,
        "signal": kind,
        "moment": moment,
        "seconds": seconds,
        "status": process.returncode,
        "message": message.replace(f"{out.parent}/", "").strip().splitlines()[-3:],
        "half_written": [path.name for path in files if path not in complete] + _half_programs(cache),
        "broken": [path.name for path in complete if not _is_complete(path)],
        "unnamed": [path.name for path in complete if not is_silent and str(path) not in message],
        "empty_folders": [path.name for path in out.iterdir() if path.is_dir() and not any(path.iterdir())],
        "surplus": message.count("\n") > 1 or "Traceback" in message,
        "survivors": survivors(process.pid),
    }


def _half_programs(cache: Path) -> list[str]:
    """Programs of JAX's cache that cannot be unpacked, and what was to become one of ours."""
    parts = [path.name for path in cache.glob("programs/.*.part")]
    for path in cache.glob("*-cache"):
        try:
            zlib.decompress(path.read_bytes())
        except zlib.error:
            parts.append(path.name)
    return parts


def _is_complete(path: Path) -> bool:
    """Whether a file holds what its name says, to its end."""
    try:
        if path.suffix == ".json":
            json.loads(path.read_text(encoding="utf-8"))
        elif path.suffix == ".jsonl":
            return all(json.loads(line) for line in path.read_text(encoding="utf-8").splitlines())
        elif path.suffix in (".png", ".tif"):
            Image.MAX_IMAGE_PIXELS = None
            with Image.open(path) as image:
                image.load()
        elif path.suffix == ".html":
            return path.read_text(encoding="utf-8").rstrip().endswith(">")
        elif path.suffix == ".h5":
            import h5py

            with h5py.File(path) as file:
                return "mcmc" in file
    except Exception:  # whatever a broken file raises
        return False
    return path.stat().st_size > 0


FAULTS = ("half_written", "broken", "unnamed", "empty_folders", "surplus", "survivors")


def rows_of(signals: int, seed: int, verbs: list[str]) -> Iterator[dict]:
    """Each signal with what came of it."""
    generator = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as name:
        warm = Path(name) / "programs"
        inputs = make_inputs(Path(name))
        cold_times = {verb: duration(verb, inputs, warm) for verb in verbs}
        warm_times = {verb: duration(verb, inputs, warm) for verb in verbs}
        for k in range(signals):
            verb, is_cold = verbs[k % len(verbs)], k // len(verbs) % 2 == 1
            kind = KINDS[generator.integers(len(KINDS))]
            moment = BEYOND * generator.uniform(0.0, (cold_times if is_cold else warm_times)[verb])
            with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as cold:
                row = stopped(verb, kind, moment, inputs, Path(folder) / "out", Path(cold) if is_cold else warm)
            yield {**row, "cold": is_cold}


def main(signals: int, seed: int, verbs: list[str], is_quick: bool) -> None:
    """Send the signals, print the table, and fail where one was not obeyed or left something half written."""
    began = perf_counter()
    subprocess.run([sys.executable, "-c", "import jax"], check=True)
    importing = perf_counter() - began
    rows = []
    for row in rows_of(signals, seed, verbs):
        rows.append(row)
        print(json.dumps(row), file=sys.stderr, flush=True)
    obeyed = [row for row in rows if row["seconds"] is not None]
    print(f"importing JAX takes {importing:.1f} s here")
    for verb in verbs:
        times = [row["seconds"] for row in obeyed if row["verb"] == verb]
        if times:
            print(f"{verb:<13} {len(times):>3} signals, ended after {np.median(times):.2f} s, at most {max(times):.2f}")
    late = [row for row in obeyed if row["seconds"] > LIMIT]
    faulty = [row for row in rows if any(row[fault] for fault in FAULTS)]
    print(
        f"{len(obeyed)} of {len(rows)} signals met a running verb; {len(late)} took over {LIMIT:g} s; {len(faulty)} "
        "left a process, or something half written, unnamed or empty, or printed more than one line"
    )
    for row in late + faulty:
        print(row)
    if verbs == list(VERBS):
        records.save("stopping", {"import_jax_s": importing, "rows": rows})
    if faulty or len(late) > (len(obeyed) // 4 if is_quick else 0):
        raise SystemExit("a signal was not obeyed, or left something half written")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--signals", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--verbs", default=",".join(VERBS))
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    some = ["help", "fit", "scale", "rings"] if options.quick else options.verbs.split(",")
    main(8 if options.quick else options.signals, options.seed, some, options.quick)
