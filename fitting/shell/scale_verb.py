"""The verb `scale`: from a photograph of a ruled grid to the pixel size."""

from pathlib import Path

import fitting
from fitting.shell.answer import Outputs
from fitting.shell.progress import progress


def run(photo: Path, options: dict, outputs: Outputs) -> int:
    """Measure, report, write; the exit status."""
    if not photo.is_file():
        raise FileNotFoundError(f"{photo} is not a file; give the path of a photograph of a grid")
    outputs.check((photo,))
    with progress(f"measuring {photo.name}"):
        result = fitting.scale(photo, **options)
    return outputs.write(result)
