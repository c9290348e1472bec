"""The verb `form`: from a picture of fringes to the form of a surface."""

from pathlib import Path

import fitting
from fitting.shell.answer import Extras, Outputs
from fitting.shell.progress import progress


def run(photo: Path, options: dict, outputs: Outputs) -> int:
    """Measure, report, write; the exit status."""
    if not photo.is_file():
        raise FileNotFoundError(f"{photo} is not a file; give the path of a picture of fringes")
    outputs = outputs._replace(more=("map.csv",))
    outputs.check((photo,))
    with progress(f"fitting {photo.name}"):
        result = fitting.form(photo, **options)
    return outputs.write(result, Extras(files=lambda _: {"map.csv": result.map_csv()}))
