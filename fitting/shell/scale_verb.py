"""The verb `scale`: from a photograph of a ruled grid to the pixel size."""

import json
from pathlib import Path

import numpy as np

import fitting
from fitting.shell.answer import Outputs, as_png
from fitting.shell.progress import progress


def run(photo: Path, given: dict, outputs: Outputs) -> int:
    """Measure, report, write; the exit status."""
    if not photo.is_file():
        raise FileNotFoundError(f"{photo} is no file; give the path of a photograph of a grid")
    outputs.check((photo,))
    with progress(f"measuring {photo.name}"):
        result = fitting.scale(photo, **given)
    return outputs.write(result, _picture)


def from_file(path: Path) -> dict[str, float]:
    """Pixel size and its standard deviation [m] from the JSON that the verb wrote.

    Raises FileNotFoundError, and ValueError for a file without a pixel size.
    """
    if not path.is_file():
        raise FileNotFoundError(f"{path} is no file; give the JSON that `newtonjax scale` wrote")
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        size, sd = float(found["pixel_size_m"]), float(found["pixel_size_sd_m"])
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(f"{path} holds no pixel_size_m with pixel_size_sd_m; make it by `newtonjax scale`") from error
    return {"pixel_size": size, "pixel_size_sd": sd}


def _picture(result) -> bytes:
    from matplotlib.figure import Figure

    from fitting.reticle import lines_at

    image = result.photograph.image
    figure = Figure(figsize=(9, 9 * image.shape[0] / image.shape[1] + 0.6), layout="constrained")
    axes = figure.subplots()
    low, high = np.percentile(image[result.photograph.lit], [1, 99])
    axes.imshow(image, cmap="gray", vmin=low, vmax=high)
    for turns, colour in zip(lines_at(result), ("tab:red", "tab:cyan"), strict=True):
        levels = np.arange(np.ceil(turns.min()), np.floor(turns.max()) + 1)
        axes.contour(turns, levels=levels, colors=colour, linewidths=0.6)
    axes.set_title(f"pixel size {result.pixel_size:.6g} ± {result.pixel_size_sd:.2g} m, the lines as measured")
    return as_png(figure)
