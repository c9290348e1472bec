"""The verb `sensitivity`: how well each number of a bench must be known, as text, table and picture."""

import csv
import io
from pathlib import Path
from typing import Any

import numpy as np

from fitting.parameters import knobs, output
from fitting.shell import assignments, session, stopping
from fitting.shell.answer import as_png, with_file
from fitting.shell.progress import progress
from fitting.studies import Sensitivity, Spread, check_spread, sensitivity, spread

_FILES = ("sensitivity.csv", "sensitivity.json", "sensitivity.png")
_OF_DRAWS = ("spread.csv", "spread.json", "spread.png", "spread.nc")
_DRAWS = 128


def run(
    path: Path,
    pixels: tuple,
    target: str | None,
    relative_accuracy: float,
    free: list[str] | None,
    sd: list[str],
    draws: int | None,
    folder: Path | None,
    force: bool,
) -> int:
    """Compute, print the tables, write the files; the exit status."""
    with progress("loading"):
        session.prepare()
        session.keep_rays()
        scene, camera, camera_line = session.scene_and_camera(path, *pixels)
    files = output.files_of(folder, (*_FILES, *(_OF_DRAWS if sd else ())), force, (path,))
    bench_numbers = knobs(scene, camera)
    names = None if free is None else _names_of(free)
    deviations = assignments.deviations(sd, {name: knob.unit for name, knob in bench_numbers.items()})
    request: dict[str, Any] = {"target": target, "free": names, "path": files[-1] if files else None}
    request["draws"] = _DRAWS if draws is None else draws
    if deviations:
        check_spread(scene, camera, deviations, **request)
    elif draws is not None:
        raise ValueError("--draws needs --sd NAME=SD, which says what is drawn")
    with progress("differentiating"):
        result = sensitivity(scene, camera, target=target, relative_accuracy=relative_accuracy, free=names)
    print(f"{camera_line}\n{result}")
    if files:
        _write(files, _contents(with_file(result, path), _csv(result)), force)
    if deviations:
        if files:
            stopping.keep(files[-1], "the same command with --force goes on with it")
        scatter = spread(scene, camera, deviations, **request, progress=True)
        print(scatter)
        if files:
            _write(files[len(_FILES) :], _contents(with_file(scatter, path), _shares_csv(scatter)), force)
    return 0


def _contents(result: Sensitivity | Spread, table: str) -> tuple[str | bytes, ...]:
    return table, output.json_text(result.to_dict()), as_png(result.figure())


def _write(files: list[Path], contents: tuple[str | bytes, ...], force: bool) -> None:
    for file, content in zip(files, contents, strict=False):
        output.write(file, content, force)


def _names_of(texts: list[str]) -> list[str]:
    """Names out of an option's texts, which may hold several with commas."""
    return [name for text in texts for name in text.split(",")]


def _csv(result: Sensitivity) -> str:
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow(["name", "unit", "value", f"slope_{result.unit or '1'}_per_unit", "tolerance"])
    for row in result.neglected:
        writer.writerow([row.name, row.unit, row.value, row.slope, "" if np.isinf(row.tolerance) else row.tolerance])
    return text.getvalue()


def _shares_csv(result: Spread) -> str:
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    indices = ("first", "first_low", "first_high", "total", "total_low", "total_high")
    writer.writerow(["name", "unit", "sd", f"slope_sd_{result.unit or '1'}", *indices])
    for share in result.shares:
        cells = (
            share.name,
            share.unit,
            share.sd,
            share.slope_sd,
            share.first,
            *share.first_range,
            share.total,
            *share.total_range,
        )
        writer.writerow(cells)
    return text.getvalue()
