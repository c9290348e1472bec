"""The verb `form`: from a picture of fringes to the form of a surface."""

from pathlib import Path

import fitting
from fitting.shell.answer import Extras, Outputs
from fitting.shell.fit_verb import check_files
from fitting.shell.progress import progress
from fitting.shell.report_page import Measured


def run(photos: list[Path], options: dict, outputs: Outputs) -> int:
    """Measure, report, write; the exit status."""
    check_files(dict.fromkeys(photos, "picture of fringes"))
    outputs = outputs._replace(more=("map.csv",))
    outputs.check(tuple(photos))
    image, names = (photos[0], photos[0].name) if len(photos) == 1 else (photos, f"{len(photos)} frames")
    with progress(f"fitting {names}"):
        result = fitting.form(image, **options)
    measured = [Measured(path, options) for path in photos]
    return outputs.write(result, measured, Extras(files=lambda: {"map.csv": result.map_csv()}))
