"""Frames of a stack one after the other: of an array, an iterable, the pages of a TIFF, a GIF or a video file."""

from collections.abc import Iterable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from fitting.photo.image_file import load

_ALLOWED = (
    "an array [frames, rows, columns] or with channels, an iterable of images, or a file (multi-page TIFF, GIF, video)"
)
_TIFF = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
# Formats that Pillow reads frame by frame; what is none of them is taken for a video, for which imageio has readers by
# these modules.
_STILL = (".gif", ".png", ".apng", ".webp", ".jpg", ".jpeg", ".bmp")
_VIDEO = {"av": "pyav", "imageio_ffmpeg": "FFMPEG"}


def frames_of(source: Any) -> Iterator[np.ndarray | ValueError]:
    """The frames of a source, in its order; for one that cannot be read, a ValueError that says why.

    `source`: an array [frames, rows, columns] or [frames, rows, columns, channels]; an iterable of images, each an
    array or a path; or the path of a file with several pages or frames. Nothing is read ahead.

    Raises at once FileNotFoundError for a path that is no file, and ValueError for what holds no frames or needs a
    reader that is not installed.
    """
    if isinstance(source, str | Path):
        return _of_file(Path(source))
    if hasattr(source, "ndim"):
        if source.ndim not in (3, 4) or (source.ndim == 3 and source.shape[-1] <= 4 < source.shape[0]):
            raise ValueError(f"frames of shape {source.shape} were given; allowed: {_ALLOWED}; of one image use fit")
        return map(_image, source)
    if not isinstance(source, Iterable):
        raise ValueError(f"frames is {type(source).__name__}; allowed: {_ALLOWED}")
    return map(_image, iter(source))


def _image(item: Any) -> np.ndarray | ValueError:
    try:
        if isinstance(item, str | Path):
            return load(item)
        return item if isinstance(item, np.ndarray) else np.asarray(item)
    except (ValueError, OSError) as error:
        return ValueError(str(error))


def _of_file(path: Path) -> Iterator[np.ndarray | ValueError]:
    if not path.is_file():
        raise FileNotFoundError(f"{path} is no file; give {_ALLOWED}")
    with path.open("rb") as file:
        head = file.read(4)
    if head in _TIFF:
        return _pages(path)
    if path.suffix.lower() in _STILL:
        return _moving(path, "pillow", {"mode": "RGB"})
    plugin = next((plugin for module, plugin in _VIDEO.items() if find_spec(module)), None)
    if plugin is None:
        raise ValueError(
            f"{path} is no TIFF, GIF, PNG or WebP; a reader of videos is not installed: pip install 'imageio[ffmpeg]' "
            "or 'imageio[pyav]'"
        )
    return _moving(path, plugin, {})


def _pages(path: Path) -> Iterator[np.ndarray | ValueError]:
    import tifffile

    with tifffile.TiffFile(path) as file:
        series = file.series[0]
        if len(file.pages) == 1 and series.ndim > 2 and series.shape[-1] > 4:
            # ImageJ keeps the pages of large files without a header each.
            yield from series.asarray(out="memmap")
            return
        for page in file.pages:
            try:
                codes = page.asarray()
                planes = getattr(page, "samplesperpixel", 1) > 1 and getattr(page, "planarconfig", 1) == 2
                yield np.moveaxis(codes, 0, -1) if planes else codes
            except Exception as error:  # the decoders raise whatever they like
                yield ValueError(f"the page cannot be read ({_first_line(error)})")


def _moving(path: Path, plugin: str, how: dict) -> Iterator[np.ndarray | ValueError]:
    """Frames by one of imageio's readers. The file is opened at once, so that what is none is told at once."""
    import imageio.v3 as iio

    reader: Any = plugin  # a name, which the stubs do not know
    try:
        file = iio.imopen(path, "r", plugin=reader)
    except Exception as error:  # as above
        raise ValueError(f"{path} cannot be read as frames ({_first_line(error)}); allowed: {_ALLOWED}") from error
    return _decoded(file, how)


def _decoded(file: Any, how: dict) -> Iterator[np.ndarray | ValueError]:
    with file:
        frames = file.iter(**how)
        while True:
            try:
                yield next(frames)
            except StopIteration:
                return
            except Exception as error:  # as above; a decoder that stumbled does not find its way back
                yield ValueError(f"the file cannot be read on from here ({_first_line(error)})")
                return


def _first_line(error: Exception) -> str:
    return str(error).splitlines()[0][:120] if str(error) else type(error).__name__
