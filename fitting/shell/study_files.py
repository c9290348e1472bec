"""The files of a study: tables, which are there at once and after a signal too, and a picture, which takes longer."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from fitting.parameters import output
from fitting.shell import stopping
from fitting.shell.answer import as_png
from fitting.shell.progress import progress


class StudyFiles(NamedTuple):
    """Files of a folder, none without one: `texts` makes the tables' contents of a result, the last file is a picture.

    `camera`: what is printed before each result.
    """

    files: Sequence[Path]
    texts: Callable[[Any], Sequence[str]]
    camera: str
    force: bool

    def report(self, result: Any) -> str:
        """What is printed."""
        return f"{self.camera}\n{result}"

    def unfinished(self, result: Any, words: str) -> stopping.Unfinished:
        """What a signal prints and writes of a result that is not the last one."""
        return stopping.Unfinished(words, self.report(result), self._tables(result))

    def write(self, result: Any) -> None:
        """Write the tables, and then the picture."""
        for file, text in self._tables(result).items():
            output.write(file, text, self.force)
        for file in self.files[-1:]:
            with progress("drawing"):
                output.write(file, as_png(result.figure()), self.force)

    def _tables(self, result: Any) -> dict[Path, str]:
        return dict(zip(self.files[:-1], self.texts(result), strict=True)) if self.files else {}
