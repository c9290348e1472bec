"""Frames of one surface, stepped in phase: read at the size that a form needs, and cut to their pupil."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from PIL import Image

from fitting.irregularity.disc import EDGE, Pupil, around, disc_of, reduced
from fitting.irregularity.pupil import pupil_of, usable_pixels
from fitting.photo import Photograph, check_no_picture_twice, frames_of, read
from newtonjax.numerics import shown

# Three unknowns a pixel, light, contrast and phase, take three frames.
LEAST_FRAMES = 3
# A JPEG with more pixels is decoded at a fraction of its size: a form has few details.
_LARGE = 4_000_000
# Diameter of the pupil in the means over blocks that are fitted [px].
_DIAMETER = 120


class Frames(NamedTuple):
    """Frames on the disc of their pupil.

    - `light` [frames, pixels], float32; `u`, `v` [pixels]; `cells` [rows, columns]: place of each pixel, -1 for none.
    - `pupil`, `pupil_sd`: in pixels of the first photograph, which stands for all in a figure; `scale`: its pixels in
      those of the file; `is_speckled`: their light is a laser's.
    """

    light: np.ndarray
    u: np.ndarray
    v: np.ndarray
    cells: np.ndarray
    pupil: Pupil
    pupil_sd: float | None
    photograph: Photograph
    scale: int
    is_speckled: bool = True


def frames_of_surface(
    images: Any, pupil: tuple[float, float, float] | None, transfer: Any, mask: Any, edge: float = EDGE
) -> Frames:
    """The frames of a list of photographs, or of a file with several pages, within `edge` radii of their pupil.

    Raises ValueError for fewer than three, for frames of different shapes, and FileNotFoundError.
    """
    sources, scale = _sources(images, mask)
    first, *others = sources

    def photographed(source: Any) -> Photograph:
        return read(_smaller(source, scale), transfer, mask, None)

    photograph = photographed(first)
    views = [_view(photograph, mask is not None)]
    views += [_view(photographed(source), mask is not None) for source in others]
    shapes = sorted({view.usable.shape for view in views})
    if len(shapes) > 1:
        raise ValueError(f"frames have {shapes[0]} and {shapes[1]} pixels; give frames of one shape, of one camera")
    if pupil is None:
        circle, sd = _common_pupil(views)
    else:
        circle, sd = Pupil(*(float(at) / scale for at in pupil)), None
    factor = max(int(2 * circle.radius / _DIAMETER), 1)
    usable = np.all([view.usable for view in views], axis=0)
    lights, square, used = [], circle, usable
    for view in views:
        image, used, square = around(view.light(), usable, circle)
        image, used = reduced(image, used, factor)
        square = square.reduced(factor)
        lights.append(image)
    disc = disc_of(lights[0], used, square, edge)
    inside = disc.weights > 0
    v, u = (grid[inside] for grid in np.meshgrid(disc.v, disc.u, indexing="ij"))
    cells = np.full(inside.shape, -1)
    cells[inside] = np.arange(len(u))
    light = np.stack([_on_disc(image, disc, square)[inside] for image in lights])
    return Frames(
        light.astype(np.float32),
        u,
        v,
        cells,
        circle,
        sd,
        photograph,
        scale,
    )


def _on_disc(image: np.ndarray, disc: Any, circle: Pupil) -> np.ndarray:
    """The picture's light itself on the rows and columns of a disc."""
    rows = np.round(disc.v * circle.radius + circle.y).astype(int)
    columns = np.round(disc.u * circle.radius + circle.x).astype(int)
    return image[np.ix_(rows, columns)]


class _View(NamedTuple):
    """What is kept of a frame: its light, made of codes when asked for, usable pixels, pupil and its scatter."""

    light: Callable[[], np.ndarray]
    usable: np.ndarray
    pupil: Pupil
    pupil_sd: float | None


def _view(photograph: Photograph, has_mask: bool) -> _View:
    return _View(photograph.codes.whole, usable_pixels(photograph, has_mask), *pupil_of(photograph))


def _sources(images: Any, mask: Any) -> tuple[list, int]:
    """The frames, and by how much smaller than their files they are read."""
    sources = list(images)
    if len(sources) == 1 and isinstance(sources[0], str | Path):
        sources = list(frames_of(sources[0]))
    if len(sources) < LEAST_FRAMES:
        raise ValueError(f"{len(sources)} frames are given; a phase takes {LEAST_FRAMES} and more")
    names = [Path(source).name if isinstance(source, str | Path) else "frames" for source in sources]
    check_no_picture_twice(sources, names, [None] * len(sources))
    if refused := [error for error in sources if isinstance(error, ValueError)]:
        raise ValueError(f"a frame cannot be read: {refused[0]}")
    return sources, 1 if mask is not None else min(map(_scale_of, sources))


def _scale_of(source: Any) -> int:
    """By how much a large JPEG is read smaller; 1 for other files and arrays."""
    if not isinstance(source, str | Path):
        if not isinstance(source, np.ndarray):
            raise ValueError(f"a frame is {shown(source)}; allowed: an array, or the path of a picture")
        return 1
    if Path(source).suffix.lower() not in (".jpg", ".jpeg") or not Path(source).is_file():
        return 1
    with Image.open(source) as picture:
        return 4 if picture.width * picture.height > _LARGE else 1


def _smaller(source: Any, scale: int) -> Any:
    """A JPEG as its decoder makes it at a fraction of its size, in codes."""
    if scale == 1:
        return source
    with Image.open(source) as picture:
        picture.draft("L", (picture.width // scale, picture.height // scale))
        return np.asarray(picture.convert("L"))


def _common_pupil(views: list[_View]) -> tuple[Pupil, float | None]:
    """The median of the frames' circles, and the scatter of their edges."""
    circle = Pupil(*map(float, np.median([view.pupil for view in views], axis=0)))
    sds = [view.pupil_sd for view in views if view.pupil_sd is not None]
    return circle, float(np.median(sds)) if len(sds) == len(views) else None
