"""Every verb of the command at work, for `experiments.truth.stopping`: what each reads, and its process."""

import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
# By the words of a command line; words in capitals stand for paths.
SCALED = "--wavelength sodium --pixel-size 8um"
VERBS = {
    "help": "--help",
    "fit": f"fit SAMPLE {SCALED} --output-dir OUT/fit --json OUT/fit.json",
    "fit --mcmc": f"fit SAMPLE {SCALED} --mcmc --output-dir OUT/fit",
    "fit --scene": "fit SAMPLE --pixel-size 8um --scene SCENE --output-dir OUT/fit",
    "batch": f"batch SAMPLE BRIGHT {SCALED} --workers 1 --output-dir OUT/batch",
    "together": f"together SAMPLE BRIGHT {SCALED} --output-dir OUT/together",
    "form": "form FRINGES --wavelength sodium --output-dir OUT/form",
    "wedge": "wedge FRINGES --wavelength sodium --pixel-size 8um --output-dir OUT/wedge",
    "wedge table": "wedge POSITIONS --wavelength sodium --output-dir OUT/wedge",
    "compare": "compare SAVED SAVED_TOO --of radius --output-dir OUT/compare",
    "demo": "demo --output-dir OUT/demo",
    "scale": "scale GRID --division 0.2mm --output-dir OUT/scale",
    "rings": "rings TABLE --wavelength sodium --output-dir OUT/rings",
    "render": "render reflected --screen 1mm --shape 4096x4096 --output OUT/rings.tif",
    "render splat": "render reflected --screen 1mm --method splat --shape 256x256 --output OUT/rings.png",
    "sensitivity": "sensitivity SCENE --output-dir OUT/sensitivity",
    "design": "design SCENE --vary field=1mm:8mm --output-dir OUT/design",
    "tradeoff": "tradeoff SCENE --output-dir OUT/tradeoff",
    "selftest": "selftest --output-dir OUT/selftest",
    "doctor": "doctor --json",
    "app": "app --port 0",
}
# A server does not end by itself: so many seconds of it are enough.
ENDLESS = {"app": 8.0}
TABLE = "order,diameter_mm\n1,1.54\n2,2.17\n3,2.66\n4,3.07\n"
POSITIONS = "order,position_mm\n1,0.0\n2,0.14\n3,0.27\n4,0.41\n5,0.54\n"
PROGRAM = "import sys; from fitting.shell.entry import main; sys.exit(main())"


def make_inputs(folder: Path) -> dict[str, str]:
    """Write what the verbs read; the paths by their words."""
    sample = ROOT / "fitting/data/sample.png"
    rows, columns = np.indices((400, 500))
    grid = np.where((rows % 40 < 4) | (columns % 40 < 4), 60, 200).astype(np.uint8)
    fringes = (128 + 90 * np.cos(columns / 5 + (rows / 400) ** 2)).astype(np.uint8)
    bright = np.minimum(np.asarray(Image.open(sample)) * 1.1, 255).astype(np.uint8)
    names = {"SAMPLE": str(sample), "SCENE": str(ROOT / "docs/scene.toml")}
    for name, picture in {"GRID": grid, "FRINGES": fringes, "BRIGHT": bright}.items():
        names[name] = str(folder / f"{name.lower()}.png")
        Image.fromarray(picture).save(names[name])
    for name, text in {"TABLE": TABLE, "POSITIONS": POSITIONS}.items():
        names[name] = str(folder / f"{name.lower()}.csv")
        Path(names[name]).write_text(text, encoding="utf-8")
    for name in ("SAVED", "SAVED_TOO"):
        names[name] = str(folder / f"{name.lower()}.json")
        command = [sys.executable, "-c", PROGRAM, "rings", names["TABLE"], "--wavelength", "sodium"]
        subprocess.run([*command, "--json", names[name]], check=True, cwd=ROOT, stdout=subprocess.DEVNULL)
    return names


def started(verb: str, inputs: dict[str, str], out: Path, cache: Path) -> subprocess.Popen:
    """A verb at work as the leader of a group of processes, its results in the folder `out`.

    It returns when the program begins: before that, Python's own start answers Ctrl-C with a traceback.
    """
    out.mkdir()
    begun, begin = os.pipe()
    arguments = [inputs.get(word, word.replace("OUT", str(out))) for word in VERBS[verb].split()]
    process = subprocess.Popen(
        [sys.executable, "-c", f"import os; os.close({begin}); {PROGRAM}", *arguments],
        pass_fds=(begin,),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=ROOT,
        env={**os.environ, "JAX_COMPILATION_CACHE_DIR": str(cache)},
        start_new_session=True,
        # A job in the background has Ctrl-C ignored, and so would what it starts.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    os.close(begin)
    os.read(begun, 1)
    os.close(begun)
    return process


def duration(verb: str, inputs: dict[str, str], cache: Path) -> float:
    """Seconds that a verb takes undisturbed. Raises RuntimeError where it fails."""
    if verb in ENDLESS:
        return ENDLESS[verb]
    with tempfile.TemporaryDirectory() as name:
        began = perf_counter()
        process = started(verb, inputs, Path(name) / "out", cache)
        _, message = process.communicate()
    if process.returncode:
        raise RuntimeError(f"{verb} fails undisturbed: {message}")
    return perf_counter() - began
