"""Claim: a second answer takes a third of a second, a fresh process a few times what it takes to import JAX.

One run, every group in a fresh process, `import jax` beside each: (1) after one render 20 other benches and shapes, a
known shape, one pixel; the first render, plan, information and design of a process without a compilation cache; (2) the
photographs and trials under NEWTONJAX_SHARED and made pictures of 12 and 29 megapixels; (3) the verbs of the shell with
an empty and with a filled cache; (4) frames of a stack, and each tenth of them against a fit of it alone. CPU seconds
are of all threads, import of JAX included where a process is fresh. `--source FOLDER` fits the photographs with another
checkout; `--before` puts the answers of such a run beside those of this one, and says how far they lie apart.

    python -m experiments.speed.answer_time [--quick] [--source FOLDER] [--before FILE.json] [--only GROUP ...]
"""

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from experiments.speed import answer_tasks
from experiments.speed.answer_tasks import middle

HERE = Path(__file__).resolve().parents[1]
RESULTS, SHARED = HERE / "results", Path(os.environ.get("NEWTONJAX_SHARED", HERE.parents[2] / "shared"))
SHELL = "from fitting.shell.cli import main; raise SystemExit(main())"
TASK = "from experiments.speed import answer_tasks; answer_tasks.main()"
COLD = {"render": 5, "plan": 5, "information": 11, "design": 27}


def child(*arguments: str, cache: str | None = None, source: Path = HERE.parent) -> dict:
    """Run Python once: CPU and wall seconds, peak memory [MB], and the JSON object that it printed last, if any."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("JAX_")}
    environment |= {
        "PYTHONPATH": os.pathsep.join(map(str, (source, HERE.parent))),
        "XDG_CACHE_HOME": cache or os.devnull,
    }
    if cache:
        environment["JAX_COMPILATION_CACHE_DIR"] = cache
    begin = time.perf_counter()
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as said:
        process = subprocess.Popen([sys.executable, *arguments], stdout=out, stderr=said, env=environment)
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        wall = time.perf_counter() - begin
        for stream in (out, said):
            stream.seek(0)
        lines, errors = out.read().splitlines(), said.read()
    if process.returncode not in (0, 3):
        raise RuntimeError(f"{' '.join(arguments)[:200]}: {errors[-2000:]}")
    seconds = used.ru_utime + used.ru_stime
    value = json.loads(lines[-1]) if lines and lines[-1].startswith("{") else {}
    return {"cpu_s": seconds, "wall_s": wall, "peak_mb": used.ru_maxrss / 1024, "value": value}


def task(*arguments: str, **given) -> dict:
    """A task of `answer_tasks` in a process of its own."""
    return child("-c", TASK, *arguments, **given)


def import_jax(turns: int = 3) -> dict:
    """The baseline: medians of a process that imports JAX and ends."""
    runs = [child("-c", "import jax") for _ in range(turns)]
    return {key: middle([run[key] for run in runs]) for key in ("cpu_s", "wall_s")}


def over_import(runs: list[dict], limit: float) -> dict:
    """Medians of fresh processes, and their ratio to `import jax`, measured beside them."""
    base = import_jax()
    found = {key: middle([run[key] for run in runs]) for key in ("cpu_s", "wall_s", "peak_mb")}
    ratio = found["cpu_s"] / base["cpu_s"]
    return found | {"import_jax_cpu_s": base["cpu_s"], "ratio": ratio, "limit": limit, "holds": ratio <= limit}


def simulator(quick: bool) -> dict:
    """Point 1: other answers of a process that has given one, and the first ones of fresh processes."""
    again = task("again", "3" if quick else "20")["value"]
    found = {"again": again}
    limits = {"new_cpu_s": 0.3, "known_cpu_s": 0.02, "plan_cpu_s": 0.3}
    for key, limit in limits.items():
        found[key] = {"median": middle(again[key]), "worst": max(again[key]), "limit": limit}
    found["one_pixel_cpu_s"] = {"median": again["one_pixel_cpu_s"], "worst": again["one_pixel_cpu_s"], "limit": 0.3}
    if not quick:
        found["cold"] = {verb: over_import([task(verb)], limit) for verb, limit in COLD.items()}
    return found


def photographs(cache: str, source: Path, before: Path | None) -> dict:
    """Point 2: every photograph in a process of its own, with a filled cache; made pictures too."""
    earlier = json.loads(before.read_text(encoding="utf-8"))["photographs"]["rows"] if before else []
    earlier, rows, ours = {row["file"]: row for row in earlier}, [], source == HERE.parent
    for path in answer_tasks.photographs(SHARED):
        if not ours and path.name.startswith("stepped_"):
            continue  # an earlier fit takes more memory than there is
        row = task("photograph", str(path), "3" if ours else "1", cache=cache, source=source)["value"]
        rows.append(row | {"megapixels": answer_tasks.megapixels(path), "before": earlier.get(path.name)})
        print(line_of(rows[-1]), flush=True)
    times = [row["cpu_s"] for row in rows]
    sizes = (("3000", "4000"), ("5700", "5120")) if ours else ()
    with tempfile.TemporaryDirectory() as folder:
        for size in sizes:
            task("large", *size, folder)
        made = [task("large", *size, folder, cache=cache)["value"] for size in sizes]
    return {
        "rows": rows,
        "made": made,
        "median_cpu_s": middle(times),
        "worst_cpu_s": max(times),
        "over_limit": [row["file"] for row in [*rows, *made] if row["cpu_s"] > answer_tasks.limit(row)],
    }


def line_of(row: dict) -> str:
    """A row of the table of photographs."""
    before = row.get("before")
    cells = [row["file"], f"{row['megapixels']:.1f}", f"{before['cpu_s']:.2f}" if before else "", f"{row['cpu_s']:.2f}"]
    cells.append(f"{answer_tasks.limit(row):.1f}")
    for one in (before, row):
        known = one and one["answer"] is not None and one["sd"]
        cells.append(f"{one['answer']:.7g} ± {one['sd']:.2g}" if known else (one or {}).get("status", ""))
    if before and before["sd"] and row["sd"]:
        cells += [f"{(row['answer'] - before['answer']) / before['sd']:+.2f}", f"{row['sd'] / before['sd']:.3f}"]
    return "| " + " | ".join([*cells, *[""] * (9 - len(cells))]) + f" | {row['peak_mb']:.0f} |"


def shell(quick: bool) -> dict:
    """Point 3: the verbs with an empty compilation cache, then with the one that this left."""
    sample = str(HERE.parent / "fitting" / "data" / "sample.png")
    given = ["--wavelength", "589.294nm", "--pixel-size", "8um", "--view", "reflected"]
    found = {"help": over_import([child("-c", SHELL, "--help") for _ in range(3)], 1.0)}
    if quick:
        return found
    with tempfile.TemporaryDirectory() as folder:
        verbs = {
            "fit": ("fit", sample, *given),
            "render": ("render", "reflected", "--screen", "1mm", "--output", f"{folder}/rings.png", "--force"),
        }
        for name, arguments in verbs.items():
            cache = f"{folder}/{name}"
            Path(cache).mkdir()
            first = child("-c", SHELL, *arguments, cache=cache)
            later = [child("-c", SHELL, *arguments, cache=cache) for _ in range(3)]
            found |= {f"{name}, cold": over_import([first], 8), f"{name}, warm": over_import(later, 3)}
    return found


def stack(quick: bool) -> dict:
    """Point 4: frames of 256 x 256 a second of CPU, against `fit`."""
    found = task("stack", *(("12", "96") if quick else ("200", "256")))["value"]
    limits = {"frames_per_cpu_s": 50, "radius_from_fit_sd": 0.1, "gap_from_fit_sd": 0.1}
    return found | {"limits": limits}


def table(found: dict) -> str:
    """All of it as markdown."""
    loads = ", ".join(f"{name} {one['load'][0]:.0f}" for name, one in found.items() if "load" in one)
    lines = ["# What an answer takes", "", f"{os.cpu_count()} processors; load when each group began: {loads}.", ""]
    lines += ["| what | CPU s | largest | limit | holds |", "|---|---|---|---|---|"]
    for key in ("new_cpu_s", "known_cpu_s", "plan_cpu_s", "one_pixel_cpu_s"):
        if row := found.get("simulator", {}).get(key):
            holds = "yes" if row["worst"] <= row["limit"] else "no"
            lines.append(f"| {key} | {row['median']:.3f} | {row['worst']:.3f} | {row['limit']:g} | {holds} |")
    lines += [
        "",
        "| fresh process | CPU s | over `import jax` | limit | holds | peak MB |",
        "|---|---|---|---|---|---|",
    ]
    fresh = {f"first {name}": row for name, row in found.get("simulator", {}).get("cold", {}).items()}
    for name, row in {
        **fresh,
        **{f"newtonjax {name}": row for name, row in found.get("shell", {}).items() if name != "load"},
    }.items():
        cells = f"{row['cpu_s']:.2f} | {row['ratio']:.1f} | {row['limit']:g} | {'yes' if row['holds'] else 'no'}"
        lines.append(f"| {name} | {cells} | {row['peak_mb']:.0f} |")
    if one := found.get("stack"):
        lines += [
            "",
            f"Stack of 256 x 256: {one['frames_per_cpu_s']:.0f} frames a second of CPU (limit 50), radius and gap",
        ]
        lines[-1] += (
            f" at most {one['radius_from_fit_sd']:.3f} and {one['gap_from_fit_sd']:.3f} sd from `fit` (limit 0.1)."
        )
    if pictures := found.get("photographs"):
        over = ", ".join(pictures["over_limit"]) or "none"
        lines += ["", f"Photographs: median {pictures['median_cpu_s']:.2f} s (limit 0.4), worst"]
        lines[-1] += f" {pictures['worst_cpu_s']:.2f} s; over the limit of their size and outcome: {over}."
        head = ["file", "Mpx", "before, CPU s", "CPU s", "limit", "before", "answer", "apart, sd", "ratio of sd", "MB"]
        lines += ["", "| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
        lines += map(line_of, [*pictures["rows"], *pictures["made"]])
    return "\n".join(lines) + "\n"


def main() -> None:
    """Measure, print the table, and save it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="three benches, a small stack and --help, saved nowhere")
    parser.add_argument("--source", type=Path, default=HERE.parent, help="another checkout to fit the photographs with")
    parser.add_argument("--before", type=Path, help="results of such a run, to compare with")
    names = ["simulator", "shell", "stack", "photographs"]
    parser.add_argument(
        "--only", nargs="*", default=names, help="groups to measure; the others stay as they were saved"
    )
    options = parser.parse_args()
    file = RESULTS / ("answer_time.json" if options.source == HERE.parent else "answer_time_before.json")
    found: dict = json.loads(file.read_text(encoding="utf-8")) if file.is_file() and not options.quick else {}
    groups = {"simulator": lambda: simulator(options.quick), "shell": lambda: shell(options.quick)}
    groups |= {"stack": lambda: stack(options.quick)}
    with tempfile.TemporaryDirectory() as cache:
        if not options.quick and SHARED.is_dir():
            groups["photographs"] = lambda: photographs(cache, options.source.resolve(), options.before)
        for name in [name for name in groups if name in options.only]:
            load = os.getloadavg()
            found[name] = groups[name]() | {"load": load}
    text = table(found)
    print(text)
    if options.quick:
        worst = max(found["simulator"]["again"]["new_programs"])
        assert worst <= 4, f"a new bench and shape compiles {worst} programs"
        assert found["stack"]["measured"] == 1.0
        assert math.isfinite(found["shell"]["help"]["ratio"])
        return
    file.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    file.with_suffix(".md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
