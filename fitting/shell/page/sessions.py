"""What the page remembers of each open tab of a browser, in memory and until that tab is closed."""

import asyncio
import re
import secrets
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import PurePosixPath, PureWindowsPath
from typing import Any, NamedTuple

from fitting.shell.page.photograph_tasks import ANSWER, PICTURE, PROGRESS, sample
from fitting.shell.page.pictures import Region
from fitting.shell.page.settings import Settings
from fitting.shell.page.worker import Worker, WorkError

# Letters that a name keeps, and how many of them.
_LETTERS, _LONGEST = re.compile(r"[^\w.()+ -]+"), 80
# Endings that the answer's files have, and the page's pictures.
MEDIA = {
    ".html": "text/html; charset=utf-8",
    ".json": "application/json",
    ".csv": "text/csv; charset=utf-8",
    ".png": "image/png",
    ".jpg": "image/jpeg",
    ".txt": "text/plain; charset=utf-8",
    ".py": "text/plain; charset=utf-8",
    ".sh": "text/plain; charset=utf-8",
}


class Reticle(NamedTuple):
    """A photograph of something of known size: its name, its bytes, and the picture of what was found in it."""

    name: str = ""
    data: bytes = b""
    picture: bytes = b""


@dataclass
class Session:
    """One tab: its photograph, what is known of it, and the files of its last answer.

    `token` stands in the addresses of all that; nobody else can guess it. `form`: what is typed and chosen, by name;
    `scale`: the pixel size that was measured last, as `fitting.fit` takes it; `holders`: pages that show it, two for a
    while where one is loaded again.
    """

    photographs: Worker
    token: str = field(default_factory=lambda: secrets.token_urlsafe(32))
    name: str = ""
    data: bytes = b""
    about: dict[str, Any] = field(default_factory=dict)
    region: Region = ()
    form: dict[str, Any] = field(default_factory=dict)
    scale: Mapping[str, Any] = field(default_factory=dict)
    reticle: Reticle = field(default_factory=Reticle)
    answer: dict[str, Any] = field(default_factory=dict)
    files: dict[str, bytes] = field(default_factory=dict)
    table_files: dict[str, bytes] = field(default_factory=dict)
    running: asyncio.Task | None = None
    began: float = 0.0
    progress: tuple[int, int] = (0, 4)
    holders: int = 0

    async def take(self, name: str, data: bytes) -> dict[str, Any]:
        """Look at a photograph, and measure this one from now on. Raises WorkError for what is none."""
        name = clean_name(name)
        if not data:
            raise WorkError(f"{name} is empty; choose a photograph")
        about = await self.photographs.call("look", data, name)
        self.name, self.data, self.region = name, data, ()
        self.answer, self.files = {}, {}
        self._show(about)
        return self.about

    async def take_sample(self) -> Settings:
        """The same with the sample photograph; what is known of it."""
        data, name, settings = sample()
        await self.take(name, data)
        return settings

    async def narrow(self, region: Region) -> None:
        """Use only a region of the photograph, or all that is usable. Raises WorkError for an empty one."""
        self._show(await self.photographs.call("look", self.data, self.name, region))
        self.region = region

    async def take_reticle(self, name: str, data: bytes) -> None:
        """Keep a photograph of something of known size. Raises WorkError for what is none."""
        name = clean_name(name)
        if not data:
            raise WorkError(f"{name} is empty; choose a photograph")
        about = await self.photographs.call("look", data, name)
        self.reticle = Reticle(name, data, about["pictures"]["photograph.jpg"])

    async def measure_reticle(self, kind: str, size: str, size_sd: str) -> str:
        """Take the scale from the photograph of something of known size; it in words. Raises WorkError without one."""
        if not self.reticle.data:
            raise WorkError("there is no photograph of it yet; choose one")
        answer = await self.photographs.call("reticle", self.reticle.data, self.reticle.name, kind, size, size_sd)
        self.scale, self.reticle = answer["scale"], self.reticle._replace(picture=answer["picture"])
        return answer["words"]

    async def measure(self, settings: Settings, listener: Callable[[str, Any], None]) -> None:
        """Fit the photograph; answer and files are then here, and where there is no new answer those before it.

        Raises WorkError, and CancelledError after `cancel`.
        """
        settings = settings._replace(has_mask=bool(self.region))
        settings.arguments()  # what cannot be read is said at once

        def tell(kind: str, content: Any) -> None:
            if kind == PROGRESS:
                self.progress = content
            if kind == ANSWER:
                self.files = {
                    "repeat.sh": "\n".join([*settings.shell_lines(self.name), ""]).encode(),
                    "repeat.py": "\n".join([*settings.python_lines(self.name), ""]).encode(),
                }
                self.answer = content
            if kind == PICTURE:
                name, picture = content
                self.files[name] = picture
            listener(kind, content)

        work = self.photographs.call("measure", self.data, self.name, settings, self.region, listener=tell)
        before = self.answer, self.files
        self.answer, self.files = {}, {}
        self.began, self.progress = time.monotonic(), (0, 4)
        self.running = asyncio.get_running_loop().create_task(work)
        try:
            drawn_files = await self.running
            self.files |= drawn_files
        except BaseException:
            if not self.answer:
                self.answer, self.files = before
            raise
        finally:
            self.running = None

    def cancel(self) -> None:
        """Give up the measurement that runs; one that waits for its turn leaves the queue."""
        if self.running is not None:
            self.running.cancel()

    def file(self, name: str) -> bytes | None:
        """A file of an answer or a picture of the photograph."""
        reticle = {"reticle.jpg": self.reticle.picture} if self.reticle.picture else {}
        holders = self.files, self.table_files, self.about.get("pictures", {}), reticle
        return next((files[name] for files in holders if name in files), None)

    def _show(self, about: dict[str, Any]) -> None:
        self.about = about


class Sessions:
    """All open tabs, by their tokens."""

    def __init__(self, photographs: Worker):
        self._photographs = photographs
        self._by_token: dict[str, Session] = {}

    def open(self, token: str = "") -> Session:
        """The one with this token where it is open still; else a new one, which knows nothing of the others."""
        session = self._by_token.get(token) or Session(self._photographs)
        self._by_token[session.token] = session
        session.holders += 1
        return session

    def get(self, token: str) -> Session | None:
        """The one with this token."""
        return self._by_token.get(token)

    def close(self, token: str) -> None:
        """Forget one and all that it holds when no page shows it any more."""
        session = self._by_token.get(token)
        if session is None:
            return
        session.holders -= 1
        if session.holders < 1:
            del self._by_token[token]
            session.cancel()

    def __len__(self) -> int:
        return len(self._by_token)


def clean_name(name: str) -> str:
    """The name of a file without folders and odd letters, short enough for every file system."""
    name = PurePosixPath(PureWindowsPath(name).as_posix()).name
    name = _LETTERS.sub("_", name).strip(" .")
    stem, dot, suffix = name.rpartition(".")
    if not dot:
        return name[:_LONGEST] or "photograph"
    return f"{stem[:_LONGEST]}.{suffix[:10]}"
