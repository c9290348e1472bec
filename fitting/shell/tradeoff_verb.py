"""The verb `tradeoff`: a table and a picture of speed against accuracy for the user's own scene."""

import csv
import io
from dataclasses import asdict
from pathlib import Path

import numpy as np

from fitting.report import output
from fitting.shell import session
from fitting.shell.answer import as_png
from fitting.shell.progress import steps
from fitting.studies import Way, tradeoff

_FILES = ("tradeoff.csv", "tradeoff.json", "tradeoff.png")


def run(
    path: Path, shape: tuple[int, int] | None, pixel_size: float | None, folder: Path | None, force: bool, splat: bool
) -> int:
    """Measure, print the table, write the files; the exit status."""
    session.prepare()
    session.keep_rays()
    scene, camera, camera_line = session.scene_and_camera(path, shape, pixel_size)
    files = output.files_of(folder, _FILES, force, (path,))
    with steps("timing every method") as report:
        ways = tradeoff(scene, camera, report, splat)
    print(f"{camera_line}\n{table(ways)}")
    if files:
        ways = sorted(ways, key=_order)
        answer = {"scene": str(path), "shape": camera.shape, "pixel_size_m": float(camera.pixel_size)}
        answer["ways"] = [asdict(way) for way in ways]
        answers = _csv(ways), output.json_text(answer), as_png(figure(ways))
        for file, content in zip(files, answers, strict=True):
            output.write(file, content, force)
    return 0


def table(ways: list[Way]) -> str:
    """The ways as text, fastest first; "chosen for" is the loosest tolerance at which `plan` takes it."""
    names = "method", "chosen for", "time", "memory", "phase", "intensity", "radius bias"
    units = "", "up to", "ms", "MB", "turns", "of peak", "ppm"
    lines = ["{:<14} {:>10} {:>9} {:>8} {:>9} {:>9} {:>12}".format(*head) for head in (names, units)]
    for way in sorted(ways, key=_order):
        bias = None if way.radius_bias is None else way.radius_bias * 1e6
        lines.append(
            f"{way.name:<14} {_short(way.tolerance):>10} {_short(way.seconds, 1e3):>9} {_short(way.bytes, 1e-6):>8} "
            f"{_short(way.phase_error):>9} {_short(way.intensity_error):>9} {_short(bias):>12}  {way.note}".rstrip()
        )
    return "\n".join(lines)


def _order(way: Way):
    return way.seconds is None, way.seconds or 0.0


def _short(value: float | int | None, factor: float = 1.0) -> str:
    return "" if value is None else f"{value * factor:.2g}"


def _csv(ways: list[Way]) -> str:
    units = {"seconds": "seconds_s", "phase_error": "phase_error_turns", "radius_bias": "radius_bias_relative"}
    text = io.StringIO(newline="")
    rows = [{units.get(name, name): value for name, value in asdict(way).items()} for way in ways]
    writer = csv.DictWriter(text, list(rows[0]))
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def figure(ways: list[Way]):
    """Time against error of intensity and against the bias of the radius: lower left is better."""
    from matplotlib.figure import Figure

    measures = {"intensity_error": "largest error of intensity, over the peak (red: ignores a part of the scene)"}
    if any(way.radius_bias is not None for way in ways if way.name != "Traced"):
        measures["radius_bias"] = "bias of the radius, relative (below 1e-12 at 1e-12)"
    canvas = Figure(figsize=(5.4 * len(measures), 4.4), layout="constrained")
    panels = canvas.subplots(1, len(measures), sharey=True, squeeze=False)[0]
    for axes, (name, label) in zip(panels, measures.items(), strict=True):
        places = [abs(v) for way in ways if way.name != "Traced" and (v := getattr(way, name)) is not None]
        middle = np.sqrt(max(min(places, default=1.0), 1e-12) * max(max(places, default=1.0), 1e-12))
        for way in ways:
            value = getattr(way, name)
            if way.seconds is None or value is None or way.name == "Traced":
                continue
            place = max(abs(value), 1e-12), 1e3 * way.seconds
            axes.loglog(*place, "o", color="tab:red" if way.note.startswith("ignores") else "tab:blue")
            side = {"xytext": (4, 4)} if place[0] <= middle else {"xytext": (-5, 5), "ha": "right"}
            axes.annotate(way.name, place, textcoords="offset points", fontsize=8, **side)
        for way in ways:
            if way.name == "Traced" and way.seconds is not None:
                axes.axhline(1e3 * way.seconds, color="0.6", lw=1, ls="--")
                axes.annotate("Traced: the reference", (0.02, 1e3 * way.seconds), xycoords=("axes fraction", "data"),
                              xytext=(0, 3), textcoords="offset points", fontsize=8, color="0.4")  # fmt: skip
        axes.set_xlabel(label, fontsize=9)
        axes.margins(x=0.2)
        axes.grid(alpha=0.3)
    panels[0].set_ylabel("time of an image [ms]")
    return canvas
