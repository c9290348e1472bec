"""Arrays in files of NumPy, `.npy` and `.npz`, as photographs; nothing in them is ever executed."""

import zipfile
from pathlib import Path
from typing import Any

import numpy as np

NAMES, SUFFIXES = ("NumPy's .npy and .npz",), ()
HEADS = (b"\x93NUMPY", b"PK\x03\x04")


def is_stack(shape: tuple[int, ...]) -> bool:
    """Whether an array of a shape is one of pictures, one or more: a last axis of 1 to 4 is one of channels."""
    return len(shape) == 4 or (len(shape) == 3 and shape[-1] > 4)


def layout(path: Path) -> tuple[tuple[int, int], int, int]:
    """Shape [px], bytes a pixel and the number of pictures of a file; its header alone is read."""
    shape, kind = _header(path)
    pictures = shape[0] if is_stack(shape) else 1
    rows, columns, *channels = (shape[1:] if is_stack(shape) else shape) + (1, 1)[len(shape) :]
    return (rows, columns), kind.itemsize * int(np.prod(channels or [1])), pictures


def load_array(path: Path) -> np.ndarray:
    """The array of a file, all its pictures; of a `.npy` file its values stay in the file until they are used.

    Raises ValueError for an archive of which no array is the image, and for arrays of Python's objects.
    """
    if not _is_archive(path):
        return np.load(path, mmap_mode="r", allow_pickle=False)
    with np.load(path, allow_pickle=False) as archive:
        return archive[_image_name(list(archive))]


def load(path: Path, number: int) -> np.ndarray:
    """One picture of a file, the first one number 0."""
    array = load_array(path)
    return array[number] if is_stack(array.shape) else array


def _is_archive(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(4) == HEADS[1]


def _image_name(names: list[str]) -> str:
    if "image" in names or len(names) == 1:
        return "image" if "image" in names else names[0]
    raise ValueError(f"it holds {', '.join(names) or 'nothing'}; allowed: one array, or one that is named image")


def _header(path: Path) -> tuple[tuple[int, ...], np.dtype]:
    if not _is_archive(path):
        with path.open("rb") as file:
            return _shape_and_kind(file)
    with zipfile.ZipFile(path) as archive:
        names = [name.removesuffix(".npy") for name in archive.namelist() if name.endswith(".npy")]
        with archive.open(f"{_image_name(names)}.npy") as file:
            return _shape_and_kind(file)


def _shape_and_kind(file: Any) -> tuple[tuple[int, ...], np.dtype]:
    read = {1: np.lib.format.read_array_header_1_0, 2: np.lib.format.read_array_header_2_0}
    version, _ = np.lib.format.read_magic(file)
    if version not in read:
        raise ValueError(f"version {version} of NumPy's format; allowed: 1 and 2")
    shape, _, kind = read[version](file)
    return shape, kind
