"""Which photographs a batch measures: files, folders, patterns, and those that still arrive."""

import glob
import os
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

# Names by which photographs in folders are recognized; a file that is named itself may have any.
_PICTURES = (".png", ".apng", ".jpg", ".jpeg", ".tif", ".tiff", ".gif", ".webp", ".bmp", ".npy", ".npz")
_RAW = (".arw", ".cr2", ".cr3", ".dng", ".nef", ".orf", ".pef", ".raf", ".raw", ".rw2")
_VIDEOS = (".mp4", ".m4v", ".mov", ".avi", ".mkv", ".webm", ".mpg", ".mpeg", ".mts", ".wmv", ".3gp")
# A file that arrives is complete when its size and time have not changed between two looks, so far apart [s].
_STILL = 1.0


def photographs(paths: Iterable[str | Path], without: Path | None = None) -> list[Path]:
    """The files of paths, folders with all their subfolders, and patterns such as `day*/*.tif`, each once.

    `without`: a folder whose files are no photographs, that of the results. Raises FileNotFoundError for what matches
    no file.
    """
    files: dict[Path, None] = {}
    for path in paths:
        matches = _matches(path, without)
        if not matches:
            raise FileNotFoundError(f"{path} matches no photograph; give files, folders, or patterns such as 'a/*.png'")
        files |= dict.fromkeys(matches)
    return list(files)


def _matches(path: str | Path, without: Path | None) -> list[Path]:
    if os.path.isdir(path):
        return sorted(_inside(path, without))
    if os.path.exists(path):
        return [Path(path).absolute()]
    matches = sorted(glob.glob(os.path.expanduser(path), recursive=True))
    return [Path(file).absolute() for file in matches if os.path.isfile(file)]


def _inside(folder: str | Path, without: Path | None) -> Iterator[Path]:
    """Photographs in a folder and below it, but for hidden ones."""
    omitted = None if without is None else str(without.absolute())
    for place, folders, names in os.walk(os.path.abspath(folder)):
        folders[:] = [name for name in folders if name[0] != "." and os.path.join(place, name) != omitted]
        for name in names:
            if name[0] != "." and os.path.splitext(name)[1].lower() in (*_PICTURES, *_RAW, *_VIDEOS):
                yield Path(place, name)


def follow(folder: str | Path, without: Path | None = None, still: float = _STILL) -> Iterator[Path | None]:
    """Photographs of a folder, those that are there and those that arrive, without end; None where there is none now.

    The folder is looked through each `still` seconds: also network shares, which send no word of new files. A file that
    changes later comes again.
    """
    earlier: dict[Path, tuple[int, int]] = {}
    reported: dict[Path, tuple[int, int]] = {}
    while True:
        began = time.monotonic()
        current = dict(_stamps(folder, without))
        for path, stamp in sorted(current.items()):
            if earlier.get(path) == stamp != reported.get(path):
                reported[path] = stamp
                yield path
        earlier = current
        yield None
        while time.monotonic() - began < still:
            yield None


def _stamps(folder: str | Path, without: Path | None) -> Iterator[tuple[Path, tuple[int, int]]]:
    for path in _inside(folder, without):
        try:
            status = path.stat()
        except OSError:  # it is gone again
            continue
        yield path, (status.st_size, status.st_mtime_ns)
