"""The verb `tradeoff`: a table and a picture of speed against accuracy for the user's own scene."""

import csv
import io
from dataclasses import asdict
from pathlib import Path

from fitting.parameters import output
from fitting.shell import session, stopping
from fitting.shell.answer import with_file
from fitting.shell.progress import progress
from fitting.shell.study_files import StudyFiles
from fitting.studies import Tradeoff, tradeoff

_FILES = ("tradeoff.csv", "tradeoff.json", "tradeoff.png")


def run(
    path: Path, shape: tuple[int, int] | None, pixel_size: float | None, folder: Path | None, force: bool, splat: bool
) -> int:
    """Measure, print the table, write the files; the exit status."""
    with progress("loading"):
        session.prepare()
        session.keep_rays()
        scene, camera, camera_line = session.scene_and_camera(path, shape, pixel_size)
    files = StudyFiles(
        output.files_of(folder, _FILES, force, (path,)), lambda result: _texts(result, path), camera_line, force
    )

    def so_far(result: Tradeoff) -> None:
        words = f"{len(result.timings)} {'method' if len(result.timings) == 1 else 'methods'}"
        keep(lambda: files.unfinished(result, words))

    with stopping.keeping() as keep:
        result = tradeoff(scene, camera, splat=splat, progress=True, so_far=so_far)
    print(files.report(result))
    files.write(result)
    return 0


def _texts(result: Tradeoff, path: Path) -> tuple[str, str]:
    return _csv(result), output.json_text(with_file(result, path).to_dict())


def _csv(result: Tradeoff) -> str:
    units = {"seconds": "seconds_s", "phase_error": "phase_error_turns", "radius_bias": "radius_bias_relative"}
    text = io.StringIO(newline="")
    rows = [{units.get(name, name): value for name, value in asdict(timing).items()} for timing in result.timings]
    writer = csv.DictWriter(text, list(rows[0]))
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()
