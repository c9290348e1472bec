"""The verb `testplate`: from pictures of fringes under a test plate to power, irregularity and radius."""

from pathlib import Path

import fitting
from fitting.shell.answer import Extras, Outputs
from fitting.shell.fit_verb import check_files
from fitting.shell.progress import progress
from fitting.shell.report_page import Measured


def run(photos: list[Path], options: dict, outputs: Outputs) -> int:
    """Measure, report, write; the exit status."""
    lamp = options["light_picture"]
    check_files(dict.fromkeys(photos, "picture of fringes") | ({} if lamp is None else {lamp: "picture of the light"}))
    outputs = outputs._replace(more=("map.csv",))
    outputs.check((*photos, *filter(None, (lamp, options["mask"]))))
    image, names = (photos[0], photos[0].name) if len(photos) == 1 else (photos, f"{len(photos)} pictures")
    with progress(f"measuring {names}"):
        result = fitting.plate_test(image, **options)
    measured = [Measured(path, options) for path in photos]
    return outputs.write(result, measured, Extras(files=lambda: {"map.csv": result.form.map_csv()}))
