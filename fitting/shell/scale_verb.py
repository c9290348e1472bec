"""The verb `scale`: from a photograph of a ruled grid to the pixel size."""

import json
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


def from_file(path: Path) -> dict[str, float]:
    """Pixel size and its standard deviation [m] from the JSON that the verb wrote.

    Raises FileNotFoundError, and ValueError for a file without a pixel size.
    """
    if not path.is_file():
        raise FileNotFoundError(f"{path} is not a file; give the JSON that `newtonjax scale` wrote")
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        size, sd = float(content["pixel_size_m"]), float(content["pixel_size_sd_m"])
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(f"{path} holds no pixel_size_m with pixel_size_sd_m; make it by `newtonjax scale`") from error
    return {"pixel_size": size, "pixel_size_sd": sd}
