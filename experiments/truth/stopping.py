"""Claim: Ctrl-C and SIGTERM are obeyed within two seconds whatever a verb is doing, and leave no half-written file.

Signals are sent to every verb of the command at random moments of its run: while it is imported, compiles, solves and
writes; every second time with an empty cache of compiled programs. For each: seconds until the process has ended, its
exit status, files whose names end in `.part`, whether every file that stays is complete (JSON parses, pictures open,
the chain can be read) and is named in the last line, whether that line is all that stderr shows, and whether every
program left in the cache is whole. A run that ends by itself before its signal counts apart. On a busy machine two
seconds may pass before the process gets its turn: how long the import of JAX takes is printed beside.

    python -m experiments.truth.stopping [--signals 200] [--seed 0] [--quick]
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path
from time import perf_counter, sleep

import numpy as np
from PIL import Image

from experiments import records

ROOT = Path(__file__).resolve().parents[2]
LIMIT = 2.0
# Moments are drawn up to this multiple of the time that the verb takes.
BEYOND = 1.05
# By the words of a command line; SAMPLE, SCENE, TABLE, GRID and OUT stand for paths.
VERBS = {
    "help": "--help",
    "fit": "fit SAMPLE --wavelength sodium --pixel-size 8um --output-dir OUT/fit --json OUT/fit.json",
    "fit --mcmc": "fit SAMPLE --wavelength sodium --pixel-size 8um --mcmc --output-dir OUT/fit",
    "demo": "demo --output-dir OUT/demo",
    "scale": "scale GRID --division 0.2mm --output-dir OUT/scale",
    "rings": "rings TABLE --wavelength sodium --output-dir OUT/rings",
    "render": "render reflected --screen 1mm --shape 4096x4096 --output OUT/rings.tif",
    "render splat": "render reflected --screen 1mm --method splat --shape 256x256 --output OUT/rings.png",
    "sensitivity": "sensitivity SCENE --output-dir OUT/sensitivity",
    "design": "design SCENE --vary field=1mm:8mm --output-dir OUT/design",
    "tradeoff": "tradeoff SCENE --output-dir OUT/tradeoff",
}
TABLE = "order,diameter_mm\n1,1.54\n2,2.17\n3,2.66\n4,3.07\n"
PROGRAM = "import sys; from fitting.shell.entry import main; sys.exit(main())"


def started(verb: str, folder: Path, cache: Path) -> subprocess.Popen:
    """A verb at work in a folder of its own, its results in `folder / "out"`."""
    (folder / "table.csv").write_text(TABLE, encoding="utf-8")
    rows, columns = np.indices((400, 500))
    grid = np.where((rows % 40 < 4) | (columns % 40 < 4), 60, 200).astype(np.uint8)
    Image.fromarray(grid).save(folder / "grid.png")
    (folder / "out").mkdir()
    names = {
        "SAMPLE": str(ROOT / "fitting/data/sample.png"),
        "SCENE": str(ROOT / "docs/scene.toml"),
        "TABLE": str(folder / "table.csv"),
        "GRID": str(folder / "grid.png"),
    }
    arguments = [names.get(word, word.replace("OUT", str(folder / "out"))) for word in VERBS[verb].split()]
    return subprocess.Popen(
        [sys.executable, "-c", PROGRAM, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=ROOT,
        env={**os.environ, "JAX_COMPILATION_CACHE_DIR": str(cache)},
        # A job in the background has Ctrl-C ignored, and so would what it starts.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )


def duration(verb: str, cache: Path) -> float:
    """Seconds that a verb takes undisturbed. Raises RuntimeError where it fails."""
    with tempfile.TemporaryDirectory() as name:
        began = perf_counter()
        process = started(verb, Path(name), cache)
        _, message = process.communicate()
    if process.returncode:
        raise RuntimeError(f"{verb} fails undisturbed: {message}")
    return perf_counter() - began


def stopped(verb: str, number: int, moment: float, folder: Path, cache: Path) -> dict:
    """Run a verb, send it a signal after `moment` seconds, and look at what it leaves."""
    process = started(verb, folder, cache)
    sleep(moment)
    seconds = None
    if process.poll() is None:
        began = perf_counter()
        process.send_signal(number)
        _, message = process.communicate(timeout=120)
        seconds = perf_counter() - began
    else:
        _, message = process.communicate()
    out = folder / "out"
    files = [path for path in out.rglob("*") if path.is_file()]
    complete = [path for path in files if not path.name.endswith(".part")]
    has_ended = process.returncode == 0
    return {
        "verb": verb,
        "signal": signal.Signals(number).name,
        "moment": moment,
        "seconds": seconds,
        "status": process.returncode,
        "message": message.replace(f"{folder}/", "").strip().splitlines()[-3:],
        "half_written": [path.name for path in files if path not in complete] + _half_programs(cache),
        "broken": [path.name for path in complete if not _is_complete(path)],
        "unnamed": [path.name for path in complete if not has_ended and str(path) not in message],
        "empty_folders": [path.name for path in out.iterdir() if path.is_dir() and not any(path.iterdir())],
        "surplus": message.count("\n") > 1 or "Traceback" in message,
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


FAULTS = ("half_written", "broken", "unnamed", "empty_folders", "surplus")


def main(signals: int, seed: int, quick: bool) -> None:
    """Send the signals, print the table, and fail where one was not obeyed or left something half written."""
    generator = np.random.default_rng(seed)
    began = perf_counter()
    subprocess.run([sys.executable, "-c", "import jax"], check=True)
    importing = perf_counter() - began
    verbs = ["help", "fit", "scale", "rings"] if quick else list(VERBS)
    rows = []
    with tempfile.TemporaryDirectory() as name:
        warm = Path(name)
        cold_times = {verb: duration(verb, warm) for verb in verbs}
        warm_times = {verb: duration(verb, warm) for verb in verbs}
        for k in range(signals):
            verb, is_cold = verbs[k % len(verbs)], k // len(verbs) % 2 == 1
            number = (signal.SIGINT, signal.SIGTERM)[generator.integers(2)]
            moment = BEYOND * generator.uniform(0.0, (cold_times if is_cold else warm_times)[verb])
            with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as cold:
                row = stopped(verb, number, moment, Path(folder), Path(cold) if is_cold else warm)
            rows.append({**row, "cold": is_cold})
            print(json.dumps(rows[-1]), file=sys.stderr, flush=True)
    obeyed = [row for row in rows if row["seconds"] is not None]
    print(f"importing JAX takes {importing:.1f} s here")
    for verb in verbs:
        times = [row["seconds"] for row in obeyed if row["verb"] == verb]
        if times:
            print(f"{verb:<13} {len(times):>3} signals, ended after {np.median(times):.2f} s, at most {max(times):.2f}")
    late = [row for row in obeyed if row["seconds"] > LIMIT]
    faulty = [row for row in rows if any(row[fault] for fault in FAULTS)]
    print(
        f"{len(obeyed)} of {len(rows)} signals met a running verb; {len(late)} took over {LIMIT:g} s; "
        f"{len(faulty)} left something half written, unnamed or empty, or printed more than one line"
    )
    for row in late + faulty:
        print(row)
    if not quick:
        records.save("stopping", {"import_jax_s": importing, "rows": rows})
    if faulty or len(late) > (len(obeyed) // 4 if quick else 0):
        raise SystemExit("a signal was not obeyed, or left something half written")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--signals", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    main(8 if options.quick else options.signals, options.seed, options.quick)
