"""The page `report.html` that every verb leaves which measures something, of a refusal with the photograph."""

import hashlib
import shlex
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

# A refusal shows so many photographs, and each with about so many pixels along its longer side.
_MOST, _SIDE = 4, 800
STANDARD_INPUT = Path("-")
# Options by which a photograph is read.
_READING = ("transfer", "mask", "page")


class Measured(NamedTuple):
    """A file that was measured; `reading`: options of a photograph, by some of which it is read, None for a table."""

    path: Path
    reading: Mapping[str, Any] | None = None


def page_of(result, measured: Sequence[Measured], pictures: Mapping[str, bytes], text: str) -> str:
    """The page of a result; `pictures` are PNG files by their titles, `text` its report."""
    from fitting.parameters import Source, page

    command = " ".join(["newtonjax", *map(shlex.quote, sys.argv[1:])])
    sources = [Source(*_name_and_digest(file.path, result)) for file in measured]
    return page(result, sources, command, pictures, text)


def _name_and_digest(path: Path, result) -> tuple[str, str]:
    if path == STANDARD_INPUT:
        return "standard input", result.origin.sha256
    return path.name, hashlib.sha256(path.read_bytes()).hexdigest()


def figures_of_refusal(result, measured: Sequence[Measured]) -> dict[str, Any]:
    """Figures by their titles: the photographs with what was tried on them, or the readings of a table."""
    photographs = [file for file in measured if file.reading is not None]
    if not photographs:
        return {"Readings": result.figure()}
    figure = result.tried_figure()
    if figure is not None:
        return {"Photograph, with what was tried": figure}
    return {f"Photograph {file.path.name}, as it was read": _drawn(file) for file in photographs[:_MOST]}


def _drawn(file: Measured) -> Any:
    """The photograph; what a mask takes out, or has no light, is tinted."""
    from matplotlib.figure import Figure

    import fitting

    options = file.reading or {}
    photograph_read = fitting.read(file.path, **{name: options.get(name) for name in _READING})
    step = max(1, max(photograph_read.mask.shape) // _SIDE)
    image, mask = photograph_read.image[::step, ::step], photograph_read.mask[::step, ::step]
    rows, columns = image.shape
    axes = Figure(figsize=(8, 8 * rows / columns + 0.2), layout="constrained").subplots()
    low, high = np.percentile(image[mask] if mask.any() else image, [1, 99])
    extent = (-0.5, photograph_read.mask.shape[1] - 0.5, photograph_read.mask.shape[0] - 0.5, -0.5)
    axes.imshow(image, cmap="gray", vmin=low, vmax=high if high > low else low + 1, extent=extent)
    axes.imshow(np.where(mask, np.nan, 1.0), cmap="autumn", vmin=0, vmax=2, alpha=0.35, extent=extent)
    return axes.figure
