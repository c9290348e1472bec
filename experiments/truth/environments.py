"""Claim: the wheel installs alone and with each extra alone, and without an extra one line names it.

The wheel is built and installed into an empty environment, where `newtonjax demo` measures its photograph. In a copy of
this environment for each extra (by links) the verb that needs it is asked for: before the extra is installed,
when one line must name it, and after, when it must not. Packages come from the registry of `pip`; seconds and sizes are
those of the extra beside the core.

    python -m experiments.truth.environments [--python python3.12] [--extras app cluster ...]
"""

import argparse
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path
from time import perf_counter

from experiments import records

ROOT = Path(__file__).resolve().parents[2]
SAMPLE = ROOT / "fitting/data/sample.png"
GIVEN = "wavelength=589.3e-9, pixel_size=12.75e-6, view='reflected'"
CHAIN = f"import fitting; r = fitting.fit({str(SAMPLE)!r}, {GIVEN}); print(fitting.sample(r, sampler='nuts', steps=20))"
# Of each extra what needs it: the command's arguments, or lines of Python.
NEEDING: dict[str, tuple[str, ...] | str] = {
    "app": ("app", "--host", "no address"),
    "cluster": ("batch", str(SAMPLE), "--wavelength", "sodium", "--scheduler", "tcp://127.0.0.1:1"),
    "raw": ("fit", "photo.dng", "--wavelength", "sodium"),
    "nuts": CHAIN,
    "video": ("fit", "film.mp4", "--wavelength", "sodium"),
    "sheets": ("rings", "table.xlsx", "--wavelength", "sodium"),
}


def run(*command: str | Path, folder: Path) -> subprocess.CompletedProcess:
    """A command's outcome."""
    return subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, cwd=folder)


def install(environment: Path, wanted: str, folder: Path) -> dict:
    """Install, and what that takes: seconds, megabytes and packages."""
    python = environment / "bin/python"
    before, packages = size_of(environment), installed(environment)
    began = perf_counter()
    done = run(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", wanted, folder=folder)
    if done.returncode:
        raise SystemExit(f"{wanted} cannot be installed: {done.stderr}")
    seconds = perf_counter() - began
    more = len(installed(environment)) - len(packages)
    return {"seconds": round(seconds, 1), "mb": round(size_of(environment) - before), "packages": more}


def size_of(environment: Path) -> float:
    """Megabytes of an environment, compiled code included."""
    return sum(path.stat().st_size for path in environment.rglob("*") if path.is_file()) / 1e6


def installed(environment: Path) -> list[Path]:
    """What is installed in it."""
    return list(environment.glob("lib/python*/site-packages/*.dist-info"))


def answer(environment: Path, needing: tuple[str, ...] | str, folder: Path) -> str:
    """What is said where an extra is needed."""
    python = environment / "bin/python"
    if isinstance(needing, str):
        return run(python, "-c", needing, folder=folder).stderr
    start = "from fitting.shell.entry import main; main()"
    return run(python, "-c", start, *needing, folder=folder).stderr


def main(python: str, extras: list[str]) -> None:
    """Install and ask; fail where an extra is not named, or not enough."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for empty in ("photo.dng", "film.mp4"):
            (folder / empty).write_bytes(b"nothing that is read")
        with zipfile.ZipFile(folder / "table.xlsx", "w") as workbook:
            workbook.writestr("nothing", "that is read")
        built = run(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder, folder=ROOT)
        wheel = next(folder.glob("*.whl"), None)
        if wheel is None:
            raise SystemExit(built.stderr)
        core = folder / "core"
        run(python, "-m", "venv", core, folder=folder)
        table = {"python": run(core / "bin/python", "--version", folder=folder).stdout.split()[1]}
        table["core"] = install(core, str(wheel), folder)
        demo = run(core / "bin/newtonjax", "demo", "--output-dir", folder / "demo", folder=folder)
        page = core / "share/man/man1/newtonjax.1"
        print(f"Python {table['python']}; core {table['core']}, demo ends with {demo.returncode}", flush=True)
        if demo.returncode or not page.is_file():
            raise SystemExit(f"the core alone does not work: {demo.stderr}")
        for extra in extras:
            environment = folder / extra
            shutil.copytree(core, environment, symlinks=True, copy_function=lambda a, b: Path(b).hardlink_to(a))
            without = answer(environment, NEEDING[extra], folder)
            table[extra] = install(environment, f"{wheel}[{extra}]", folder)
            beside = answer(environment, NEEDING[extra], folder)
            print(f"{extra}: {table[extra]}; without it: {without.splitlines()[-1]}", flush=True)
            if f"newtonjax[{extra}]" not in without or f"newtonjax[{extra}]" in beside:
                raise SystemExit(f"{extra} is not named where it is missing, or where it is not: {beside}")
            shutil.rmtree(environment)
    suffix = "" if python == sys.executable else "_" + table["python"].rsplit(".", 1)[0].replace(".", "")
    records.save(f"environments{suffix}", table)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--python", default=sys.executable)
    parser.add_argument("--extras", nargs="*", default=list(NEEDING), choices=list(NEEDING))
    options = parser.parse_args()
    main(options.python, options.extras)
