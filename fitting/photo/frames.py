"""Frames of a stack one after the other: of an array, an iterable, the pages of a TIFF, a GIF or a video file."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from fitting.photo import numpy_files, pillow_files, tiff_pages, video_files
from fitting.photo.image_file import load, reader_of, require_few_pixels

_ALLOWED = (
    "an array [frames, rows, columns] or with channels, an iterable of images, or a file (multi-page TIFF, GIF, .npy, "
    "video)"
)
_OF_SEVERAL_PAGES = (tiff_pages, pillow_files, video_files)


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
    reader = reader_of(path) or video_files  # what is no picture is taken for a video
    if reader is numpy_files:
        return _of_array(_array(path), f"frames in {path}")
    return _pages(path, reader) if reader in _OF_SEVERAL_PAGES else map(_image, iter([path]))


def _pages(path: Path, reader: Any) -> Iterator[np.ndarray | ValueError]:
    """The pages of a file, whose head is read at once: what is no picture, or a huge one, is refused undecoded."""
    try:
        (rows, columns), *_ = reader.layout(path)
    except Exception as error:  # decoders raise whatever they like
        raise ValueError(f"{path} cannot be read as frames ({_first_line(error)}); allowed: {_ALLOWED}") from error
    require_few_pixels(path, rows, columns)
    return map(_page, reader.each_frame(path))


def _page(codes: np.ndarray | Exception) -> np.ndarray | ValueError:
    if isinstance(codes, Exception):
        return ValueError(f"the page cannot be read ({_first_line(codes)})")
    return codes


def _array(path: Path) -> np.ndarray:
    try:
        return numpy_files.load_array(path)
    except Exception as error:  # of a damaged file NumPy raises whatever it likes
        raise ValueError(f"{path} cannot be read as frames ({_first_line(error)}); allowed: {_ALLOWED}") from error


def _first_line(error: Exception) -> str:
    return str(error).splitlines()[0][:120] if str(error) else type(error).__name__
