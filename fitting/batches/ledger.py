"""The file of results: one JSON line a photograph, appended and synced before the next one counts as measured."""

import os
import threading
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Any

import msgspec

from fitting.batches.job import FAILED

try:
    import fcntl
except ImportError:  # Windows: two batches on one file are not noticed there
    fcntl = None

# Windows would end lines by two characters.
_BINARY = getattr(os, "O_BINARY", 0)
# Only Linux has a sync that leaves the times of the file alone.
_sync = getattr(os, "fdatasync", os.fsync)


class _Head(msgspec.Struct):
    """What a line needs to hold; the decoder skips the rest."""

    key: str
    status: str
    pages: int = 1


class Ledger:
    """Rows of a batch in a file, which survive the end of any process at any time.

    A row is one line that is written at once and synced. What a kill left after the last end of a line is cut off when
    the file is opened again.
    """

    def __init__(self, path: str | Path, retry: bool = False):
        """Open or make the file; `retry`: rows of failures do not count as measured.

        Raises ValueError where another batch writes the file or a line is no row, and OSError where it cannot be
        written.
        """
        self.path = Path(path)
        # Whoever ends the process at a signal holds it, so that no line is broken off.
        self.writing = threading.Lock()
        is_new = not self.path.exists()
        self._file = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_APPEND | _BINARY, 0o644)
        try:
            self._take()
            # The number of pages of the file, by the keys of the photographs that have a row.
            self.pages = {row.key: row.pages for row in self._heads() if not (retry and row.status == FAILED)}
        except BaseException:
            os.close(self._file)
            raise
        if is_new:
            self._sync_folder()

    def __enter__(self) -> "Ledger":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        os.close(self._file)

    def __contains__(self, key: str) -> bool:
        return key in self.pages

    def append(self, row: dict[str, Any]) -> None:
        """Write a row, unless there is one of its key: a cluster may run a job twice."""
        if row["key"] in self.pages:
            return
        line = msgspec.json.encode(row, enc_hook=lambda array: array.tolist()) + b"\n"
        with self.writing:
            while line:
                line = line[os.write(self._file, line) :]
            _sync(self._file)
        self.pages[row["key"]] = row.get("pages", 1)

    def _take(self) -> None:
        """Make sure that nobody else writes, and cut off a line that was not completed."""
        if fcntl is not None:
            try:
                fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise ValueError(f"another batch is writing {self.path}; wait for its end, or name another") from None
        size = os.fstat(self._file).st_size
        if size and self._read(size - 1, 1) != b"\n":
            os.ftruncate(self._file, self._end_of_lines(size))
            os.fsync(self._file)

    def _end_of_lines(self, size: int, chunk: int = 1 << 16) -> int:
        """The place after the last end of a line."""
        while size:
            start = max(0, size - chunk)
            if (place := self._read(start, size - start).rfind(b"\n")) >= 0:
                return start + place + 1
            size = start
        return 0

    def _read(self, start: int, count: int) -> bytes:
        with self.path.open("rb") as file:
            file.seek(start)
            return file.read(count)

    def _heads(self) -> Iterator[_Head]:
        decoder = msgspec.json.Decoder(_Head)
        with self.path.open("rb") as file:
            for number, line in enumerate(file, 1):
                try:
                    yield decoder.decode(line)
                except msgspec.MsgspecError as error:
                    raise ValueError(
                        f"{self.path}, line {number}, is no row of a batch ({error}); name another file"
                    ) from None

    def _sync_folder(self) -> None:
        """Keep the file's name, too, over a loss of power."""
        if os.name != "posix":
            return
        folder = os.open(self.path.absolute().parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)
