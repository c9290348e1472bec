"""Files that the shell writes: whole or not at all, and never over another one unless asked to."""

import json
import os
import threading
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path

import msgspec

# Of the JSON of a refusal [bytes].
_LONGEST_REFUSAL = 1_000_000
# Files that this process has written whole, in their order.
written: list[Path] = []
# What a process that is stopped removes: half-written files, and the folders that it made if they are still empty.
_half_written: set[Path] = set()
_folders: list[Path] = []
# Held while these change; a process that is stopped takes it and does not give it back.
_changing = threading.Lock()


def check_free(paths: list[Path], force: bool, keep: tuple[Path, ...] = ()) -> None:
    """Refuse outputs before the work starts.

    Raises FileExistsError for a file that is there already (unless `force`), ValueError for one of `keep` (what the
    command reads), and FileNotFoundError for a folder that is not there.
    """
    if len({path.absolute() for path in paths}) < len(paths):
        raise ValueError(f"two answers would go to one file; name another file than {paths[-1]}")
    for path in paths:
        if any(path.exists() and read.exists() and path.samefile(read) for read in keep):
            raise ValueError(f"{path} is what the command reads; name another file to write")
        if path.is_dir():
            raise IsADirectoryError(f"{path} is a folder; name a file to write")
        if path.exists() and not path.is_file():
            raise ValueError(f"{path} is not a regular file; name a file to write, or - for the screen")
        if os.path.lexists(path) and not force:
            raise FileExistsError(f"{path} is there already; name another file, or add --force to overwrite it")
        if not path.parent.is_dir():
            raise FileNotFoundError(f"{path.parent} is not a folder; make it first, or name another file than {path}")
        _try_to_write(path)


def holds_refusal(path: Path) -> bool:
    """Whether a file is the JSON of a measurement that was refused: no answer is lost with it."""
    try:
        if path.suffix != ".json" or path.stat().st_size > _LONGEST_REFUSAL:
            return False
        saved = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(saved, dict) and saved.get("status") == "refused"


def _try_to_write(path: Path) -> None:
    """Raises OSError where no file can be written beside `path`: better before the work than after it."""
    neighbour = _neighbour(path.resolve())
    with _changing:
        try:
            neighbour.touch()
        except OSError as error:
            raise type(error)(f"{path} cannot be written ({error.strerror}); name another file") from error
        neighbour.unlink()


def make_folder(folder: Path) -> None:
    """Make a folder for files, and those above it; a process that is stopped removes it if it is still empty."""
    with _changing:  # or a process that is stopped would not know of it
        if not folder.is_dir():
            folder.mkdir(parents=True)
            _folders.append(folder)


def remove_unfinished(patience: float = -1) -> None:
    """Remove what is half written, before the process ends: no file of this process is written from here on.

    `patience`: how long to wait for a file that just takes its name [s]; as long as needed unless given.
    """
    _changing.acquire(timeout=patience)
    for path in _half_written:
        path.unlink(missing_ok=True)
    remove_empty_folders()


def remove_empty_folders() -> None:
    """Remove the folders that this process has made for files and that hold none."""
    for folder in _folders:
        with suppress(OSError):
            folder.rmdir()


def write(path: Path, content: bytes | str, force: bool) -> None:
    """Write a whole file or none: into a neighbour first, which then takes the name in one step.

    Raises FileExistsError for a file that is there already, unless `force`.
    """
    check_free([path], force)
    data = content.encode("utf-8") if isinstance(content, str) else content
    with in_one_step(path) as neighbour:
        neighbour.write_bytes(data)


@contextmanager
def in_one_step(path: Path) -> Generator[Path, None, None]:
    """A neighbour to write into, which takes the name at the end, or is gone where that is not reached."""
    path = path.resolve()  # a link stays one, and its target gets the content
    neighbour = _neighbour(path)
    with _changing:
        _half_written.add(neighbour)
    try:
        yield neighbour
        with _changing:
            os.replace(neighbour, path)
            written.append(path)
    finally:
        with _changing:
            neighbour.unlink(missing_ok=True)
            _half_written.discard(neighbour)


def _neighbour(path: Path) -> Path:
    return path.with_name(f".{path.name}.{os.getpid()}.part")


def files_of(folder: Path | None, names: tuple[str, ...], force: bool, keep: tuple[Path, ...]) -> list[Path]:
    """The files of a folder, which is made, by name; none without a folder.

    Raises FileExistsError where one is there already (unless `force`), ValueError for one of `keep` (what the command
    reads), and NotADirectoryError for a file in the folder's place.
    """
    if folder is None:
        return []
    if folder.exists() and not folder.is_dir():
        raise NotADirectoryError(f"{folder} is a file; name a folder to write into")
    files = [folder / name for name in names]
    existing = [file for file in files if os.path.lexists(file)]
    if existing and not force:
        raise FileExistsError(f"{existing[0]} is there already; name another folder, or add --force to overwrite it")
    make_folder(folder)
    check_free(files, force, keep)
    return files


def json_text(answer: dict) -> str:
    """One JSON object, with null for what is not finite."""
    text = msgspec.json.encode(answer, enc_hook=lambda array: array.tolist())
    return msgspec.json.format(text, indent=2).decode() + "\n"
