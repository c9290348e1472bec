"""What a verb does with its answer: text or JSON on the screen, files in a folder, a reason, an exit status."""

import io
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from fitting.parameters import output, section
from fitting.shell import report_page
from fitting.shell.progress import progress
from fitting.shell.report_page import Measured

_EXIT = {"ok": 0, "no-scale": 0, "refused": 3, "not-converged": 4}
_NAMES = {"picture": "result.png", "report": "report.txt", "json": "result.json", "page": "report.html"}


class Extras(NamedTuple):
    """What a verb adds: keys of the answer, text after the report, files of the folder where there is an answer.

    `titles`: of those files that are pictures for the page.
    """

    answer: Mapping[str, Any] = MappingProxyType({})
    text: str = ""
    files: Callable[[], Mapping[str, bytes | str]] | None = None
    titles: Mapping[str, str] = MappingProxyType({})


class Outputs(NamedTuple):
    """Where the answer goes: a JSON file or "-", a folder, whether files there may be replaced, and more of them."""

    json: str | None = None
    folder: Path | None = None
    force: bool = False
    more: tuple[str, ...] = ()

    def in_folder(self) -> dict[str, Path]:
        """The files of the folder by what they hold; `more` of them by their own names."""
        names = _NAMES | {name: name for name in self.more}
        return {} if self.folder is None else {kind: self.folder / name for kind, name in names.items()}

    def check(self, keep: tuple[Path, ...]) -> None:
        """Make the folder, and refuse before the work starts what cannot be written; `keep` is what the command reads.

        Raises OSError and ValueError as `output.check_free` does.
        """
        if self.folder is not None:
            if self.folder.exists() and not self.folder.is_dir():
                raise NotADirectoryError(f"--output-dir {self.folder} is not a folder; name another one")
            output.make_folder(self.folder)
        path = self._json_path()
        # The JSON of a refusal is no answer that could be lost.
        paths = [] if path is None or output.holds_refusal(path) else [path]
        output.check_free([*self.in_folder().values(), *paths], self.force, keep=keep)

    def write(
        self, result, measured: Sequence[Measured], extras: Extras | None = None, picture_bytes: bytes = b""
    ) -> int:
        """Write the files that were asked for, and print the report, or why there is no answer; the exit status.

        `measured`: the files; `extras`: more for the answer, for the text, and for the folder; `picture_bytes`: the
        picture, if it is drawn already.
        """
        status, extras = _EXIT[result.status], extras or Extras()
        answer, text = _texts(result, extras)
        # Whoever reads the text may be gone by now, and a disk may be full: neither loses the other.
        try:
            if path := self._json_path():
                output.write(path, answer, self.force or output.holds_refusal(path))
            if self.folder is not None:
                with progress("drawing"):
                    picture_bytes = self._write_result(result, answer, text, picture_bytes)
                    self._write_further(result, measured, extras, text, picture_bytes)
        finally:
            if self.json == "-":
                sys.stdout.write(answer)
            elif status != 3:
                print(text)
        if status:
            print(f"newtonjax: {result.status}: {' '.join(result.message.split())}", file=sys.stderr)
        return status

    def _write_further(
        self, result, measured: Sequence[Measured], extras: Extras, text: str, picture_bytes: bytes
    ) -> None:
        """The verb's own files where there is a picture, and the page."""
        files = extras.files() if extras.files and picture_bytes else {}
        for name, content in files.items():
            output.write(self.in_folder()[name], content, self.force)
        pictures = {"Result": picture_bytes}
        pictures |= {title: png for name, title in extras.titles.items() if isinstance(png := files.get(name), bytes)}
        if not picture_bytes:
            figures = report_page.figures_of_refusal(result, measured)
            pictures = {title: as_png(figure) for title, figure in figures.items()}
        page = report_page.page_of(result, measured, pictures, text)
        output.write(self.in_folder()["page"], page, self.force)

    def keep(self, result) -> bytes:
        """Write to the folder what is complete before longer work starts; the picture, empty without one."""
        return b"" if self.folder is None else self._write_result(result, *_texts(result, Extras()))

    def _write_result(self, result, answer: str, text: str, picture_bytes: bytes = b"") -> bytes:
        paths = self.in_folder()
        output.write(paths["report"], text + section(text) + "\n", self.force)
        output.write(paths["json"], answer, self.force)
        if _EXIT[result.status] == 3:
            return b""
        picture_bytes = picture_bytes or as_png(result.figure())
        output.write(paths["picture"], picture_bytes, self.force)
        return picture_bytes

    def _json_path(self) -> Path | None:
        return None if self.json in (None, "-") else Path(str(self.json))


def _texts(result, extras: Extras) -> tuple[str, str]:
    """The answer as JSON, and the report."""
    text = result.report() + extras.text
    return output.json_text({**result.to_dict(), **extras.answer}), text


def with_file(result, path: Path):
    """A result of a study, with the name of the scene's file in its origin."""
    return replace(result, origin=result.origin._replace(file=path.name))


def as_png(figure) -> bytes:
    """A matplotlib figure as a PNG file."""
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=120)
    return file.getvalue()
