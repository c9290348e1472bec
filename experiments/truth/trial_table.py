"""Claim: every shared picture and table that went wrong has its right outcome, and a refusal takes 1.5 s at most.

Every file of the shared folders `trials`, `photos` and `tables` (NEWTONJAX_SHARED), measured as a user would: what
came of it before (its README says so), what comes of it now, what is right, and whether these two agree. A number is
right within 2.5 (tables: 0.5) of the larger of two deviations, its own and that of what is known. A scale that was read
by eye lies between axis and rim, where distortion changes it: 6 % is its deviation. Photographs of which nothing is
known are asked for an answer alone, and white light is held against the catalogue's radius. CPU seconds are the second
call's, or the first's if that is less: the first one compiles.

    python -m experiments.truth.trial_table [--output FILE] [--quick]
"""

import argparse
import json
import os
import resource
from collections.abc import Callable
from pathlib import Path
from time import process_time
from typing import NamedTuple

import numpy as np

import fitting
from experiments import records
from experiments.truth.trial_photos import PHOTOS
from experiments.truth.trial_pictures import PICTURES
from experiments.truth.trial_rows import Row
from experiments.truth.trial_sheets import TABLES

SHARED = Path(os.environ.get("NEWTONJAX_SHARED", "../shared"))
_LONGEST_REFUSAL = 1.5  # CPU seconds


class Outcome(NamedTuple):
    """What came of one file, in the units of SI."""

    status: str
    value: float | None
    sd: float | None
    words: str
    cpu_s: float


def _scale() -> fitting.Scale:
    """The camera of the sodium lenses, by its reticle."""
    return fitting.scale(SHARED / "photos/reticle_0.2mm.jpg", division=0.2e-3)


def _of_fit(result) -> tuple[float | None, float | None]:
    """The measured number, or the fringe scale [1/px²] where there is no pixel size."""
    parameter = result.parameters.get(result.measured)
    if result.status == "ok" and parameter:
        return parameter.value, parameter.sd
    scale = result.fringe_scale_per_px2
    return scale, None if scale is None else float(np.sqrt(result.covariance[0, 0]))


def _of_stack(rows) -> tuple[float | None, float | None]:
    """Mean radius of the frames, and the largest of their standard deviations."""
    return float(np.mean([row.radius for row in rows])), max(row.radius_sd for row in rows)


def _of_form(result) -> tuple[float | None, float | None]:
    """Number of fringes across the aperture."""
    return result.fringes, None


def _of_rings(result) -> tuple[float | None, float | None]:
    if result.measured == "wavelength":
        return result.wavelength, result.wavelength_sd
    return result.radius, result.radius_sd


_CALLS: dict[str, tuple[Callable, Callable]] = {
    "fit": (fitting.fit, _of_fit),
    "fit_stack": (lambda path, **options: list(fitting.fit_stack(path, **options)), _of_stack),
    "form": (fitting.form, _of_form),
    "scale": (fitting.scale, lambda result: (result.pixel_size, result.pixel_size_sd)),
    "rings": (fitting.rings, _of_rings),
    "wedge": (fitting.wedge, lambda result: (result.thickness, result.thickness_sd)),
}


def measured(row: Row) -> Outcome:
    """Measure one file twice: the outcome, and the second call's CPU seconds."""
    call, numbers = _CALLS[row.verb]
    options = dict(row.options)
    if options.get("scale"):
        options["scale"] = _scale()
    seconds, result = [], None
    for _ in range(2):
        began = process_time()
        result = call(SHARED / row.file, **options)
        seconds.append(process_time() - began)
    cpu_s = round(min(seconds), 2)
    last = result[-1] if isinstance(result, list) else result
    message = getattr(last, "message", "")
    words = "; ".join([message, *getattr(last, "warnings", ())]).strip("; ")
    return Outcome(last.status, *numbers(result), words, cpu_s)


def judged(row: Row, outcome: Outcome) -> str:
    """What is not right about an outcome, nothing where it is."""
    if outcome.status == "refused" and outcome.cpu_s > _LONGEST_REFUSAL:
        return f"refused after {outcome.cpu_s} s"
    if outcome.status not in row.statuses:
        return f"status {outcome.status}"
    if row.words and not any(word in outcome.words for word in row.words):
        return "the reason is not named"
    if row.value is None or outcome.value is None:
        return ""
    sd = max(row.value_sd, outcome.sd or 0.0)
    distance = abs(outcome.value - row.value) / sd
    return f"{distance:.1f} standard deviations off" if distance > row.reach else ""


def line(row: Row) -> dict:
    """One line of the table."""
    outcome = measured(row)
    fault = judged(row, outcome)
    options = " ".join(f"{name}={value}" for name, value in row.options.items())
    numbers = "" if outcome.value is None else f" {outcome.value:.6g}"
    deviation = "" if outcome.sd is None else f" +- {outcome.sd:.2g}"
    print(f"{row.file:48} {outcome.status}{numbers}{deviation} {outcome.cpu_s} s  {fault or 'right'}")
    return {
        "file": row.file,
        "command": f"{row.verb} {options}".strip(),
        "before": row.before,
        "now": outcome._asdict(),
        "right": row.right,
        "fault": fault,
    }


def main() -> None:
    """Measure every file that is at hand and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, help="file of the table instead of results/trials.json")
    parser.add_argument("--quick", action="store_true", help="the tables alone, nothing written")
    options = parser.parse_args()
    rows = TABLES if options.quick else PICTURES + PHOTOS + TABLES
    if not (SHARED / "trials").is_dir():
        print(f"no trials in {SHARED} (NEWTONJAX_SHARED): nothing to measure")
        return
    table = [line(row) for row in rows]
    right = sum(not entry["fault"] for entry in table)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    print(f"{right} of {len(table)} right; largest memory {peak:.2f} GiB")
    if options.quick:
        assert right == len(table), "an outcome has changed"
    elif options.output:
        options.output.write_text(json.dumps(table, indent=1) + "\n", encoding="utf-8")
    else:
        records.save("trials", {"right": right, "rows": len(table), "largest_memory_gib": peak, "table": table})


if __name__ == "__main__":
    main()
