"""Claim: Ctrl-C and SIGTERM are obeyed within two seconds whatever a verb is doing, and leave no half-written file.

Signals are sent to the verbs `fit`, `fit --mcmc`, `render`, `rings`, `sensitivity`, `design` and `tradeoff` at random
moments of their run: while they import, compile, solve and write. For each: seconds until the process has ended, its
exit status, files whose names end in `.part`, and whether every file that stays is complete (JSON parses, pictures
open, the chain can be read). A run that ends by itself before its signal counts apart. On a busy machine two seconds
may pass before the process gets its turn: how long the import of JAX takes is printed beside.

    python -m experiments.truth.stopping [--signals 200] [--seed 0] [--quick]
"""

import argparse
import json
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter, sleep

import numpy as np

from experiments import records

ROOT = Path(__file__).resolve().parents[2]
LIMIT = 2.0
# Each with the seconds among which the moments are drawn.
VERBS = {
    "fit": (("fit", "SAMPLE", "--wavelength", "sodium", "--pixel-size", "8um", "--output-dir", "OUT"), 2.5),
    "fit --mcmc": (
        ("fit", "SAMPLE", "--wavelength", "sodium", "--pixel-size", "8um", "--mcmc", "--output-dir", "OUT"),
        12.0,
    ),
    "render": (("render", "reflected", "--screen", "1mm", "--shape", "4096x4096", "--output", "OUT/rings.tif"), 3.0),
    "render splat": (
        (
            "render",
            "reflected",
            "--screen",
            "1mm",
            "--method",
            "splat",
            "--shape",
            "256x256",
            "--output",
            "OUT/rings.png",
        ),
        8.0,
    ),
    "rings": (("rings", "TABLE", "--wavelength", "sodium", "--output-dir", "OUT"), 1.5),
    "sensitivity": (("sensitivity", "SCENE", "--output-dir", "OUT"), 4.0),
    "design": (("design", "SCENE", "--vary", "field=1mm:8mm", "--output-dir", "OUT"), 6.0),
    "tradeoff": (("tradeoff", "SCENE", "--output-dir", "OUT"), 10.0),
}
TABLE = "order,diameter_mm\n1,1.54\n2,2.17\n3,2.66\n4,3.07\n"
PROGRAM = "import sys; from fitting.shell.cli import main; sys.exit(main())"


def stopped(verb: str, number: int, moment: float, folder: Path) -> dict:
    """Run a verb, send it a signal after `moment` seconds, and look at what it leaves."""
    (folder / "table.csv").write_text(TABLE, encoding="utf-8")
    out = folder / "out"
    if verb.startswith("render"):
        out.mkdir()
    names = {
        "SAMPLE": str(ROOT / "fitting/data/sample.png"),
        "SCENE": str(ROOT / "docs/scene.toml"),
        "TABLE": str(folder / "table.csv"),
    }
    arguments = [names.get(word, word.replace("OUT", str(out))) for word in VERBS[verb][0]]
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=ROOT,
    )
    sleep(moment)
    if process.poll() is None:
        began = perf_counter()
        process.send_signal(number)
        _, said = process.communicate(timeout=120)
        seconds = perf_counter() - began
    else:
        _, said = process.communicate()
        seconds = None
    files = [path for path in out.rglob("*") if path.is_file()] if out.exists() else []
    return {
        "verb": verb,
        "signal": signal.Signals(number).name,
        "moment": moment,
        "seconds": seconds,
        "status": process.returncode,
        "said": said.replace(f"{folder}/", "").strip().splitlines()[-1:],
        "half_written": [path.name for path in files if path.name.endswith(".part")],
        "broken": [path.name for path in files if not path.name.endswith(".part") and not _is_complete(path)],
        "empty_folder": out.is_dir() and not files and not verb.startswith("render"),
    }


def _is_complete(path: Path) -> bool:
    """Whether a file holds what its name says, to its end."""
    try:
        if path.suffix == ".json":
            json.loads(path.read_text(encoding="utf-8"))
        elif path.suffix in (".png", ".tif"):
            from PIL import Image

            Image.MAX_IMAGE_PIXELS = None
            with Image.open(path) as image:
                image.load()
        elif path.suffix == ".h5":
            import h5py

            with h5py.File(path) as file:
                return "mcmc" in file
    except Exception:  # whatever a broken file raises
        return False
    return True


def main(signals: int, seed: int, quick: bool) -> None:
    """Send the signals, print the table, and fail where one was not obeyed or left something half written."""
    generator = np.random.default_rng(seed)
    began = perf_counter()
    subprocess.run([sys.executable, "-c", "import jax"], check=True)
    importing = perf_counter() - began
    rows = []
    for k in range(signals):
        verb = list(VERBS)[k % len(VERBS)]
        number = (signal.SIGINT, signal.SIGTERM)[generator.integers(2)]
        with tempfile.TemporaryDirectory() as folder:
            rows.append(stopped(verb, number, generator.uniform(0.0, VERBS[verb][1]), Path(folder)))
    obeyed = [row for row in rows if row["seconds"] is not None]
    print(f"importing JAX takes {importing:.1f} s here")
    for verb in VERBS:
        times = [row["seconds"] for row in obeyed if row["verb"] == verb]
        if times:
            print(
                f"{verb:<13} {len(times):>3} signals, ended after {np.median(times):.2f} s, at most {max(times):.2f} s"
            )
    late = [row for row in obeyed if row["seconds"] > LIMIT]
    wrong = [row for row in rows if row["half_written"] or row["broken"] or row["empty_folder"]]
    print(
        f"{len(obeyed)} of {len(rows)} signals met a running verb; {len(late)} took over {LIMIT:g} s; "
        f"{len(wrong)} left a half-written file or an empty folder"
    )
    for row in late + wrong:
        print(row)
    if not quick:
        records.save("stopping", {"import_jax_s": importing, "rows": rows})
    if wrong or len(late) > (len(obeyed) // 4 if quick else 0):
        raise SystemExit("a signal was not obeyed, or left something half written")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--signals", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--quick", action="store_true")
    given = parser.parse_args()
    main(8 if given.quick else given.signals, given.seed, given.quick)
