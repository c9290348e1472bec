"""Image files as arrays of their codes, with all bits."""

import os
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fitting.photo import numpy_files, pillow_files, raw_files, tiff_pages, video_files
from newtonjax.numerics import require_memory, shown
from newtonjax.scene import PICTURE_PIXELS

# What is advised where a photograph is larger than the memory.
SMALLER = "crop the photograph to its rings, or reduce its pixels (`magick photo.png -resize 50% small.png`)"
# Endings of files that hold readings.
_TABLES = (".csv", ".tsv", ".xlsx", ".ods")
_LARGEST = "NEWTONJAX_LARGEST_PICTURE"
# The kinds of picture files, in the order in which they are asked: modules with the names of their formats, first bytes
# and endings by which these are known, `layout` and `load`. What none of them knows, Pillow tries.
_READERS = (raw_files, video_files, tiff_pages, numpy_files, pillow_files)
ALLOWED = ", ".join(name for reader in reversed(_READERS) for name in reader.NAMES)


class Picture(NamedTuple):
    """Codes [rows, columns] or [rows, columns, channels] of one picture of a file, which one, and of how many."""

    codes: np.ndarray
    page: int
    pages: int


def not_a_file(path: Path, wanted: str, is_photograph: bool = True) -> FileNotFoundError:
    """What is wrong with a path, and what is `wanted` in its place; a folder of photographs is for `batch`."""
    kind = "a folder, whose photographs newtonjax batch measures" if is_photograph and path.is_dir() else "not a file"
    return FileNotFoundError(f"{path} is {kind}; give {wanted}")


def load(path: str | Path, page: int | None = None) -> Picture:
    """A picture in a file, the first unless `page` says which (from 1 on), turned as its EXIF data say.

    Raises FileNotFoundError, and ValueError for what is no image, has no such page, or needs more memory than there is.
    """
    path = Path(path)
    if not path.is_file():
        raise not_a_file(path, f"the path of a photograph ({ALLOWED})")
    if path.stat().st_size == 0:
        raise ValueError(f"{path} is empty; give the path of a photograph")
    try:
        reader = reader_of(path) or pillow_files
        (rows, columns), size, pages = reader.layout(path)
    except Exception as error:
        raise _unreadable(path, error) from error
    number = 1 if page is None else page
    if isinstance(number, bool) or not isinstance(number, int | np.integer) or not 1 <= number <= pages:
        raise ValueError(f"page is {shown(page)}; allowed: 1 to {pages}, the pages of {path}")
    if rows * columns > PICTURE_PIXELS or _LARGEST in os.environ:
        require_few_pixels(path, rows, columns)
    # The decoder's buffer and the array made of it.
    require_memory(f"reading {path}, {rows} x {columns} pixels,", 2.0 * rows * columns * size, SMALLER)
    try:
        codes = reader.load(path, int(number) - 1)
        if codes.ndim < 2 or codes.size == 0:
            raise ValueError("it holds no pixels")
        return Picture(codes, int(number), pages)
    except Exception as error:
        raise _unreadable(path, error) from error


def require_few_pixels(path: Path, rows: int, columns: int) -> None:
    """Raise ValueError, before a picture is decoded, where its head says that it is larger than those of cameras.

    A file of a megabyte may unpack to gigabytes. `NEWTONJAX_LARGEST_PICTURE` [px] allows more.
    """
    stated = os.environ.get(_LARGEST, "")
    try:
        most = float(stated) if stated else PICTURE_PIXELS
    except ValueError:
        raise ValueError(f"{_LARGEST} is {stated!r}; allowed: a number of pixels, such as 1e9") from None
    if not rows * columns <= most:
        raise ValueError(
            f"{path} says that it holds {rows} x {columns} pixels; allowed: {most:.3g} pixels; "
            f"{SMALLER}, or set {_LARGEST}={1.1 * rows * columns:.1e} if it is meant"
        )


def _unreadable(path: Path, error: Exception) -> ValueError:
    """What is said of a file that a decoder refuses: these raise whatever they like."""
    reason = str(error).splitlines()[0] if str(error) else type(error).__name__
    table = "; a table of readings is for newtonjax rings" if path.suffix.lower() in _TABLES else ""
    return ValueError(f"{path} cannot be read as an image ({reason}); allowed: {ALLOWED}{table}")


def reader_of(path: Path) -> Any:
    """The module that reads a file: what `layout` and `load` are called of; None for one of no kind that is known."""
    with path.open("rb") as file:
        head = file.read(8)
    suffix = path.suffix.lower()
    return next((reader for reader in _READERS if head.startswith(reader.HEADS) or suffix in reader.SUFFIXES), None)
