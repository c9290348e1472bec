"""The verb `design`: from ranges with units to a better bench, as text, scene file, table and picture."""

import csv
import io
from pathlib import Path

import numpy as np

from fitting.parameters import knobs, output, target_first
from fitting.shell import assignments, session, stopping
from fitting.shell.answer import with_file
from fitting.shell.progress import progress
from fitting.shell.study_files import StudyFiles
from fitting.studies import Design, design, with_field
from newtonjax.benches import scene_text

_FILES = ("design.csv", "design.json", "design.toml", "design.png")
_OVER = 5


def run(path: Path, pixels: tuple, ranges: dict, limits: dict, search: dict, folder: Path | None, force: bool) -> int:
    """Search, print the design, write the files; the exit status."""
    with progress("loading"):
        session.prepare()
        session.keep_rays()
        scene, camera, camera_line = session.scene_and_camera(path, *pixels)
    files = StudyFiles(
        output.files_of(folder, _FILES, force, (path,)),
        lambda result: _texts(result, path),
        f"sensor, {camera_line}",
        force,
    )
    present = knobs(scene, camera)
    units = {name: knob.unit for name, knob in with_field(camera, present).items()}
    target = search["target"]
    vary = {name: assignments.span(name, text, units) for name, text in assignments.pairs("--vary", ranges["vary"])}
    over = None
    if ranges["over"]:
        measured, *_ = target_first(present, target, None)
        low, high = assignments.span(measured, ranges["over"], units)
        over = np.geomspace(low, high, _OVER) if low > 0 else np.linspace(low, high, _OVER)

    def so_far(result: Design) -> None:
        words = f"the best of {len(result.starts)} {'search' if len(result.starts) == 1 else 'searches'}"
        keep(lambda: files.unfinished(result, words))

    with stopping.keeping() as keep:
        result = design(
            scene,
            camera,
            vary,
            target=target,
            sd=assignments.deviations(ranges["sd"], units),
            over=over,
            robust=search["robust"],
            choose={
                name: [assignments.number(name, value_text, units) for value_text in text.split(",")]
                for name, text in assignments.pairs("--choose", ranges["choose"])
            },
            pixels_per_fringe=limits["pixels_per_fringe"],
            fill_fraction=limits["fill_fraction"],
            rings=_rings(limits["rings"]),
            starts=search["starts"],
            progress=True,
            so_far=so_far,
        )
    print(files.report(result))
    files.write(result)
    return 0


def _texts(result: Design, path: Path) -> tuple[str, str, str]:
    answer = with_file(result, path).to_dict()
    return _csv(result), output.json_text(answer), scene_text(result.scene, result.camera)


def _rings(text: str) -> tuple[float, float]:
    least, _, most = text.partition(":")
    try:
        return float(least or "1e-9"), float(most or "inf")
    except ValueError:
        raise ValueError(f"--rings {text!r}: give LEAST:MOST, such as 3:60, or 3:") from None


def _csv(result: Design) -> str:
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow(["name", "unit", "designed", "before"])
    for name, value in result.values.items():
        writer.writerow([name, result.units[name], value, result.before[name]])
    writer.writerow([f"{result.target}_relative_sd", "", result.relative_sd, result.before_sd])
    return text.getvalue()
