"""The quick form of every claim, one after the other in one process: what `make claims` runs.

    python -m experiments.claims [NAME ...]

A line a claim: its verdict, seconds and memory, and what it printed where it failed. What one claim compiled serves the
next, and is dropped where the process has grown beyond `LARGEST`.
"""

import gc
import io
import os
import runpy
import sys
import traceback
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from time import perf_counter, process_time

import jax

FOLDER = Path(__file__).parent
LARGEST = 1.2  # GiB
sys.path.append(str(FOLDER.parent / "tests"))

import memory  # noqa: E402 (of the tests)


def quick_forms() -> list[str]:
    """Names of the scripts that have a quick form."""
    scripts = {path.stem: path.read_text(encoding="utf-8") for path in sorted(FOLDER.glob("*/*.py"))}
    return [name for name, text in scripts.items() if "[--quick]" in text]


def run(name: str) -> str:
    """Run one quick form as its command would: what it printed if it failed, else nothing."""
    printed, arguments = io.StringIO(), sys.argv
    sys.argv = [str(next(FOLDER.glob(f"*/{name}.py"), name)), "--quick"]
    try:
        with redirect_stdout(printed), redirect_stderr(printed):
            runpy.run_path(sys.argv[0], run_name="__main__")
    except (Exception, SystemExit) as failure:
        if not isinstance(failure, SystemExit) or failure.code:
            return printed.getvalue() + traceback.format_exc()
    finally:
        sys.argv = arguments
        jax.config.update("jax_enable_x64", True)
    return "" if printed.getvalue() else "it printed nothing"


def main(names: list[str]) -> int:
    """Run the claims by name, all of them if none is named: how many failed."""
    os.environ["MPLBACKEND"] = "Agg"
    gc.set_threshold(50_000, 20, 100)  # as the tests do, and why
    names, failures = names or quick_forms(), 0
    for name in names:
        began, worked = perf_counter(), process_time()
        failure = run(name)
        failures += bool(failure)
        wall, processor = perf_counter() - began, process_time() - worked
        verdict, size = "FAILED" if failure else "passed", memory.resident()
        print(f"{name:<12} {verdict} {wall:6.1f} s ({processor:5.1f} s of processor), {size:.1f} GiB", flush=True)
        if failure:
            print(failure[-6000:].strip(), flush=True)
        memory.release(LARGEST, memory.MOST_MAPS)
    print(f"{len(names) - failures} passed, {failures} failed")
    return failures


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]) > 0)
