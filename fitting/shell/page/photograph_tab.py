"""The first tab: from a photograph to a radius, in five steps."""

import asyncio
import time
from typing import Any

from nicegui import ui  # pyright: ignore[reportMissingImports]  # an extra

from fitting.parameters import PART_OPTIONS
from fitting.shell.page import parts
from fitting.shell.page.photograph_tasks import ANSWER, PROGRESS
from fitting.shell.page.region_step import RegionStep
from fitting.shell.page.result_step import ResultStep
from fitting.shell.page.scale_step import ScaleStep
from fitting.shell.page.sessions import Session
from fitting.shell.page.worker import Worker, WorkError

_PARTS = {"": "if the image has it", "yes": "on", "no": "off"}
# How long the worker takes to be ready, as far as one can say beforehand.
_LOADING = "loading the fit: about 5 s, and 15 s when this computer does it for the first time"


class PhotographTab:
    """The five steps of one tab of a browser."""

    def __init__(self, session: Session, worker: Worker):
        self._session, self._worker = session, worker
        self._scale, self._region = ScaleStep(session), RegionStep(session)
        self._result = ResultStep(session, self._scale)
        self._began, self._is_running = 0.0, False

    def build(self) -> None:
        """Show the steps, and follow what happens to them."""
        self._photograph_step()
        self._scale.build()
        self._region.build()
        self._fit_step()
        self._result.build()
        ui.timer(0.5, self._tick)

    def _photograph_step(self) -> None:
        with parts.section("1. Photograph"):
            ui.html(
                '<label class="nj-drop">Choose a photograph of the rings, or drop it into this frame '
                '<input type="file" id="photograph" accept="image/*,.tif,.tiff,.npy,.dng,.cr2,.nef,.arw"></label>',
                sanitize=False,
            )
            with parts.row():
                ui.button("Use the sample", on_click=self._take_sample).props("no-caps outline")
            self._photograph_line = parts.message("No photograph yet.")
        ui.on("sending", lambda event: self._photograph_line.set_text(f"Sending {event.args['name']} ..."))
        ui.on("photograph", lambda event: self._arrived(event.args))
        parts.run_script("njDrop", self._session.token)

    def _fit_step(self) -> None:
        with parts.section("4. Fit"):
            with ui.expansion("Parts of the model").classes("w-full"), parts.row():
                self._parts = {name: parts.Choice(_named(name), _PARTS, "") for name in PART_OPTIONS}
            with parts.row():
                self._fit_button = ui.button("Fit the rings", on_click=self._fit).props("no-caps")
                self._cancel_button = ui.button("Cancel", on_click=self._session.cancel).props("no-caps outline")
            self._cancel_button.set_enabled(False)
            self._bar = ui.linear_progress(0.0, show_value=False).props('aria-label="Progress of the fit"')
            self._fit_line = parts.message()
            self._worker_line = parts.message()

    async def _take_sample(self) -> None:
        self._photograph_line.set_text("Reading the sample ...")
        try:
            settings = await self._session.take_sample()
        except WorkError as error:
            self._arrived({"ok": False, "message": str(error)})
            return
        self._scale.fill(settings.texts)
        self._arrived({"ok": True})

    def _arrived(self, answer: dict[str, Any]) -> None:
        """Say what became of a photograph; the steps after it begin anew."""
        if not answer["ok"]:
            self._photograph_line.set_text(f"Not a photograph that can be used: {answer['message']}")
            return
        about = self._session.about
        warnings = "".join(f" {text}." for text in about["warnings"])
        self._photograph_line.set_text(f"{self._session.name}: {about['columns']} x {about['rows']} pixels.{warnings}")
        self._scale.refresh()
        self._region.refresh()
        self._result.clear()
        self._fit_line.set_text("")
        self._bar.set_value(0.0)

    async def _fit(self) -> None:
        if not self._session.data:
            self._fit_line.set_text("Choose a photograph first (step 1).")
            return
        self._result.clear()
        self._set_running(True)
        try:
            settings = await self._scale.settings(self._worker)
            switches = {name: box.value for name, box in self._parts.items() if box.value}
            settings = settings._replace(texts={**settings.texts, **switches})
            await self._session.measure(settings, self._follow)
            self._result.show_files()
            self._end(f"Done after {time.monotonic() - self._began:.1f} s.")
        except asyncio.CancelledError:
            self._end("Cancelled. The numbers above are as they were.")
        except WorkError as error:
            self._end(f"No fit: {error}")
        except ValueError as error:
            self._end(f"Look at step 2: {error}")

    def _follow(self, kind: str, content: Any) -> None:
        """Show how far the fit is, and its answer as soon as that is there."""
        with self._bar:
            if kind == PROGRESS:
                step, steps = content
                self._bar.set_value(step / (steps + 1))
            elif kind == ANSWER:
                self._result.show()

    def _set_running(self, is_running: bool) -> None:
        self._is_running, self._began = is_running, time.monotonic()
        self._fit_button.set_enabled(not is_running)
        self._cancel_button.set_enabled(is_running)

    def _end(self, text: str) -> None:
        self._fit_line.set_text(text)
        self._bar.set_value(0.0)
        self._set_running(False)

    def _tick(self) -> None:
        """Say twice a second what is waited for, and for how long."""
        if not self._worker.is_ready:
            seconds = time.monotonic() - self._worker.started
            self._worker_line.set_text(f"{_LOADING} ({seconds:.0f} s so far)")
        else:
            self._worker_line.set_text("")
        if self._is_running:
            queue = f"; {self._worker.waiting - 1} more wait" if self._worker.waiting > 1 else ""
            self._fit_line.set_text(f"Fitting, {time.monotonic() - self._began:.0f} s so far{queue}")


def _named(part: str) -> str:
    return part.replace("_", " ").capitalize()
