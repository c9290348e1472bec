"""The verb `tradeoff`: a table and a picture of speed against accuracy for the user's own scene."""

import csv
import io
from dataclasses import asdict, replace
from pathlib import Path

import newtonjax as nj
from fitting import output, session
from fitting.answer import as_png
from fitting.progress import steps
from fitting.tradeoff import Way, tradeoff

_RIGHT = 1e-3  # Names of larger errors stand on the left of their point.
_FILES = ("tradeoff.csv", "tradeoff.json", "tradeoff.png")


def run(
    path: Path, shape: tuple[int, int] | None, pixel_size: float | None, folder: Path | None, force: bool, splat: bool
) -> int:
    """Measure, print the table, write the files; the exit status."""
    files = output.files_of(folder, _FILES, force, (path,))
    session.prepare()
    scene, camera = nj.load_scene(path)
    camera = nj.Camera((1024, 1024), 5e-6) if camera is None else camera
    camera = replace(camera, shape=shape or camera.shape, pixel_size=pixel_size or camera.pixel_size)
    with steps("timing every method") as report:
        ways = tradeoff(scene, camera, report, splat)
    print(table(ways))
    if files:
        answers = _csv(ways), output.json_text({"ways": [asdict(way) for way in ways]}), as_png(figure(ways))
        for file, content in zip(files, answers, strict=True):
            output.write(file, content, force)
    return 0


def table(ways: list[Way]) -> str:
    """The ways as text, fastest first."""
    names = "method", "for", "time", "memory", "phase", "intensity", "bias of r_L"
    units = "", "", "ms", "MB", "turns", "of peak", "ppm"
    lines = ["{:<14} {:>6} {:>9} {:>8} {:>9} {:>9} {:>12}".format(*head) for head in (names, units)]
    for way in sorted(ways, key=lambda w: (w.seconds is None, w.seconds or 0.0)):
        bias = None if way.radius_bias is None else way.radius_bias * 1e6
        lines.append(
            f"{way.name:<14} {_short(way.tolerance):>6} {_short(way.seconds, 1e3):>9} {_short(way.bytes, 1e-6):>8} "
            f"{_short(way.phase_error):>9} {_short(way.intensity_error):>9} {_short(bias):>12}  {way.note}".rstrip()
        )
    return "\n".join(lines)


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

    made = Figure(figsize=(10, 4.4), layout="constrained")
    panels = made.subplots(1, 2, sharey=True)
    for axes, name, label in zip(
        panels,
        ("intensity_error", "radius_bias"),
        ("largest error of intensity, over the peak", "bias of the radius, relative"),
        strict=True,
    ):
        for way in ways:
            value = getattr(way, name)
            if way.seconds is None or value is None or way.name == "Traced":
                continue
            place = max(abs(value), 1e-12), 1e3 * way.seconds
            axes.loglog(*place, "o", color="tab:red" if way.note.startswith("ignores") else "tab:blue")
            side = {"xytext": (4, 4)} if place[0] < _RIGHT else {"xytext": (-5, 5), "ha": "right"}
            axes.annotate(way.name, place, textcoords="offset points", fontsize=8, **side)
        for way in ways:
            if way.name == "Traced" and way.seconds is not None:
                axes.axhline(1e3 * way.seconds, color="0.6", lw=1, ls="--")
                axes.annotate("Traced: the reference", (0.02, 1e3 * way.seconds), xycoords=("axes fraction", "data"),
                              xytext=(0, 3), textcoords="offset points", fontsize=8, color="0.4")  # fmt: skip
        axes.set_xlabel(label)
        axes.margins(x=0.2)
        axes.grid(alpha=0.3)
    panels[0].set_ylabel("time of an image [ms]")
    return made
