"""Frames of a stack one after the other: of an array, an iterable, the pages of a TIFF, a GIF or a video file."""

from collections.abc import Iterable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from fitting.photo import numpy_files, pillow_files, tiff_pages
from fitting.photo.image_file import load, reader_of, require_few_pixels

_ALLOWED = (
    "an array [frames, rows, columns] or with channels, an iterable of images, or a file (multi-page TIFF, GIF, .npy, "
    "video)"
)
# What is no picture is taken for a video, for which imageio has readers by these modules.
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
        return _of_array(source, "frames")
    if not isinstance(source, Iterable):
        raise ValueError(f"frames is {type(source).__name__}; allowed: {_ALLOWED}")
    return map(_image, iter(source))


def _of_array(array: Any, name: str) -> Iterator[np.ndarray | ValueError]:
    if not numpy_files.is_stack(array.shape):
        raise ValueError(f"{name} of shape {array.shape} were given; allowed: {_ALLOWED}; of one image use fit")
    return map(_image, array)


def _image(item: Any) -> np.ndarray | ValueError:
    try:
        if isinstance(item, str | Path):
            return load(item).codes
        return item if isinstance(item, np.ndarray) else np.asarray(item)
    except (ValueError, OSError) as error:
        return ValueError(str(error))


def _of_file(path: Path) -> Iterator[np.ndarray | ValueError]:
    if not path.is_file():
        raise FileNotFoundError(f"{path} is not a file; give {_ALLOWED}")
    reader = reader_of(path)
    _refuse_huge(path, reader)
    if reader is tiff_pages:
        return map(_page, tiff_pages.each_page(path))
    if reader is numpy_files:
        return _of_array(_array(path), f"frames in {path}")
    if reader is pillow_files:
        return map(_page, _still(path))
    if reader is not None:
        return map(_image, iter([path]))
    plugin = next((plugin for module, plugin in _VIDEO.items() if find_spec(module)), None)
    if plugin is None:
        raise ValueError(
            f"{path} is no TIFF, GIF, PNG or WebP; a reader of videos is not installed: pip install 'imageio[ffmpeg]' "
            "or 'imageio[pyav]'"
        )
    return _moving(path, plugin)


def _refuse_huge(path: Path, reader: Any) -> None:
    """Raise ValueError for pictures larger than those of cameras, before one is decoded."""
    if reader not in (tiff_pages, pillow_files):
        return
    try:
        (rows, columns), *_ = reader.layout(path)
    except Exception:  # what is wrong with the file is said where its frames are read
        return
    require_few_pixels(path, rows, columns)


def _page(codes: np.ndarray | Exception) -> np.ndarray | ValueError:
    if isinstance(codes, Exception):
        return ValueError(f"the page cannot be read ({_first_line(codes)})")
    return codes


def _array(path: Path) -> np.ndarray:
    try:
        return numpy_files.load_array(path)
    except Exception as error:  # of a damaged file NumPy raises whatever it likes
        raise ValueError(f"{path} cannot be read as frames ({_first_line(error)}); allowed: {_ALLOWED}") from error


def _still(path: Path) -> Iterator[np.ndarray | Exception]:
    """Frames by Pillow. The file's head is read at once, so that what is no picture is refused at once."""
    try:
        pillow_files.layout(path)
    except Exception as error:  # as above
        raise ValueError(f"{path} cannot be read as frames ({_first_line(error)}); allowed: {_ALLOWED}") from error
    return pillow_files.each_frame(path)


def _moving(path: Path, plugin: str) -> Iterator[np.ndarray | ValueError]:
    """Frames of a video by one of imageio's readers. The file is opened at once, for the same reason."""
    import imageio.v3 as iio

    reader: Any = plugin  # a name, which the stubs do not know
    try:
        file = iio.imopen(path, "r", plugin=reader)
    except Exception as error:  # as above
        raise ValueError(f"{path} cannot be read as frames ({_first_line(error)}); allowed: {_ALLOWED}") from error
    return _decoded(file)


def _decoded(file: Any) -> Iterator[np.ndarray | ValueError]:
    with file:
        frames = file.iter()
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
