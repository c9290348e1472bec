"""Claim: the stated 95 % interval covers the truth, on the model and with defects that the fit is not told about.

Rendered photographs (`defects.py`): radius 5 mm to 50 m, 3 to 300 rings, noise 1 to 20 %, the centre up to one field
outside, where the Cramér–Rao bound allows 1 % of the radius. For each defect: share refused, coverage of the interval
from noise alone and of the total one, median of half-width over error (2.9 for a normal error), wrong acceptances
(more than ten half-widths off and more than 5 %), and the share in which each rival fires. "Before" is the fit with no
parts allowed and the interval of its noise row.

An interval that averages over sets of parts, and has rows for what is assumed of the bench, is meant to cover 95 % of
truths that are drawn from these priors (`drawn_parts.py`), and covers more where nothing of that is there: the middle
of every prior. Both are measured.

    python -m experiments.truth.intervals [--seeds 100] [--on-model 1000] [--drawn 300] [--processes 2] [--quick]
"""

import argparse
import csv
import json
import sys
import time
from pathlib import Path

import numpy as np

from experiments import records
from experiments.truth.defects import DEFECTS, DRAWN, WAVELENGTH, bound, draw_case, photograph

_KEPT = (
    "defect",
    "seed",
    "radius_m",
    "rings",
    "noise",
    "size",
    "bound",
    "status",
    "after_error",
    "after_half",
    "rivals",
    "seconds",
)
_PAGE = Path(__file__).parents[2] / "docs" / "uncertainty.md"
_COLUMNS = (
    "defect",
    "photographs",
    "refused",
    "covered before",
    "covered",
    "half-width before",
    "half-width",
    "median error",
    "half-width over error",
    "half-width over rms error",
)
_NO_PARTS = dict.fromkeys(("oblique_view", "distortion", "fifth_order", "lens_form", "contact", "film"), False)


def run(job):
    """Fit one photograph, with and without parts; a row of numbers."""
    import jax

    jax.config.update("jax_enable_x64", True)
    import fitting

    defect, seed, largest = job
    case = draw_case(defect, seed, largest)
    row = {"defect": defect, "seed": seed, "radius_m": case.radius, "rings": case.rings, "noise": case.noise}
    row |= {"size": case.size, "bound": bound(case)}
    if row["bound"] > 0.01:
        return row | {"status": "beyond the bound"}
    image, pixel_size, sd = photograph(case)
    given = {"wavelength": WAVELENGTH, "pixel_size": pixel_size, "pixel_size_sd": sd}
    began = time.perf_counter()
    after = fitting.fit(image, **given)
    row |= {"seconds": time.perf_counter() - began, "status": after.status, "message": after.message}
    row["rivals"] = " ".join(finding.rival.replace(" ", "_") for finding in after.rivals)
    if after.status == "ok":
        row |= _measured("after", after, after.radius_interval, case.radius)
        row |= {"parts": after.evidence.found.parts, "budget": after.budget}
    if defect not in ("none", DRAWN):
        before = fitting.fit(image, **given, parts=_NO_PARTS, transfer="linear" if image.dtype.kind == "f" else "srgb")
        if before.status == "ok":
            half = 1.96 * before.radius_sd_noise
            row |= _measured("before", before, (before.radius - half, before.radius + half), case.radius)
    return row


def _shares(names: list[list[str]]) -> dict[str, float]:
    """Of photographs, the share in which each rival fires; of one that never does there is no entry."""
    every = sorted({name for row in names for name in row})
    return {name: sum(name in row for row in names) / len(names) for name in every}


def _measured(name: str, result, interval, truth: float) -> dict:
    low, high = interval
    return {
        f"{name}_error": result.radius / truth - 1,
        f"{name}_half": (high - low) / 2 / truth,
        f"{name}_covered": bool(low <= truth <= high),
    }


def summary(defect: str, rows: list[dict]) -> dict:
    """One line of the table, over the photographs whose bound allows 1 %."""
    rows = [row for row in rows if row["defect"] == defect and row["status"] != "beyond the bound"]
    ok = [row for row in rows if "after_error" in row]
    plain = [row for row in rows if "before_error" in row]

    def median(name, table):
        return float(np.median([abs(row[name]) for row in table])) if table else None

    wrong = [row for row in ok if abs(row["after_error"]) > max(0.05, 10 * row["after_half"])]
    line = {
        "defect": defect,
        "photographs": len(rows),
        "refused": (len(rows) - len(ok)) / max(len(rows), 1),
        "covered": float(np.mean([row["after_covered"] for row in ok])) if ok else None,
        "median_error": median("after_error", ok),
        "median_half_width": median("after_half", ok),
        "half_width_over_error": float(np.median([row["after_half"] / abs(row["after_error"]) for row in ok]))
        if ok
        else None,
        "half_width_over_rms": float(np.mean([(row["after_error"] / row["after_half"]) ** 2 for row in ok]) ** -0.5)
        if ok
        else None,
        "accepted_wrongly": len(wrong),
        "rivals": _shares([row["rivals"].split() for row in rows]),
    }
    if plain:
        line |= {
            "before_covered": float(np.mean([row["before_covered"] for row in plain])),
            "before_median_error": median("before_error", plain),
            "before_median_half_width": median("before_half", plain),
        }
    return line


def main() -> None:
    """Run every defect and write the table and all rows."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=100, help="of every defect")
    parser.add_argument("--on-model", type=int, default=1000, help="seeds without a defect")
    parser.add_argument("--drawn", type=int, default=300, help="seeds with parts drawn from their priors")
    parser.add_argument("--defects", nargs="*", default=DEFECTS, choices=DEFECTS)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--largest", type=int, default=700, help="pixels to a side of the largest image")
    parser.add_argument("--quick", action="store_true", help="one seed of a few defects, small images, nothing written")
    options = parser.parse_args()
    largest, names, processes = (
        (420, ("none", "distortion 2 %"), 1) if options.quick else (options.largest, options.defects, options.processes)
    )
    counts = {"none": options.on_model, DRAWN: options.drawn}
    jobs = [(d, s, largest) for d in names for s in range(1 if options.quick else counts.get(d, options.seeds))]
    rows = []
    for row in records.each(run, jobs, processes):
        rows.append(row)
        if len(rows) % 200 == 0 and not options.quick:
            save(names, rows)
        if len(rows) % 50 == 0:
            print(f"{len(rows)} of {len(jobs)} photographs", file=sys.stderr, flush=True)
    for name in names:
        print(json.dumps(summary(name, rows)))
    if not options.quick:
        _into_documentation(save(names, rows))


def save(names, rows: list[dict]) -> list[dict]:
    """Write the table, and every photograph that was fitted in a few numbers; the table."""
    short = [{key: _digits(row.get(key)) for key in _KEPT} for row in rows if row["status"] != "beyond the bound"]
    table = [summary(name, rows) for name in names]
    every = records.RESULTS / "intervals.csv"
    if len(names) < len(DEFECTS) and every.exists():  # the other defects stay as they were
        before = json.loads((records.RESULTS / "intervals.json").read_text(encoding="utf-8"))
        table += [line for line in before["table"] if line["defect"] not in names]
        with every.open(encoding="utf-8", newline="") as file:
            short += [row for row in csv.DictReader(file) if row["defect"] not in names]
    table.sort(key=lambda line: DEFECTS.index(line["defect"]))
    short.sort(key=lambda row: (row["defect"], int(row["seed"])))
    records.save("intervals", {"table": table})
    with every.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, _KEPT)
        writer.writeheader()
        writer.writerows(short)
    return table


def _into_documentation(table: list[dict]) -> None:
    """Put the table between its two marks in docs/uncertainty.md."""
    text = _PAGE.read_text(encoding="utf-8")
    head, tail = text[: text.index("<!-- coverage -->")], text[text.index("<!-- end -->") :]
    lines = ["| " + " | ".join(_COLUMNS) + " |", "|---" * len(_COLUMNS) + "|"]
    for line in table:
        cells = [line["defect"], str(line["photographs"]), _share(line["refused"])]
        cells += [_share(line.get("before_covered"))]
        cells += [_share(line["covered"]), _small(line.get("before_median_half_width"))]
        cells += [_small(line["median_half_width"]), _small(line["median_error"])]
        cells += [f"{line['half_width_over_error']:.1f}", f"{line['half_width_over_rms']:.1f}"]
        lines.append("| " + " | ".join(cells) + " |")
    _PAGE.write_text(head + "<!-- coverage -->\n" + "\n".join(lines) + "\n" + tail, encoding="utf-8")


def _share(value: float | None) -> str:
    return "" if value is None else f"{100 * value:.1f} %"


def _small(value: float | None) -> str:
    return "" if value is None else f"{value:.1e}"


def _digits(value):
    return float(f"{value:.4g}") if isinstance(value, float) else value


if __name__ == "__main__":
    main()
