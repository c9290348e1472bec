"""The first tab: from a photograph to a radius, in five steps."""

import asyncio
import time
from typing import Any

from nicegui import ui  # pyright: ignore[reportMissingImports]  # an extra

from fitting.parameters import PART_OPTIONS
from fitting.shell.page import parts
from fitting.shell.page.numbers_step import NumbersStep
from fitting.shell.page.photograph_tasks import ANSWER, PICTURE
from fitting.shell.page.region_step import RegionStep
from fitting.shell.page.result_step import ResultStep
from fitting.shell.page.scale_step import ScaleStep
from fitting.shell.page.sessions import Session
from fitting.shell.page.worker import Worker, WorkError

_PARTS = {"": "if the image has it", "yes": "on", "no": "off"}
# The steps of a fit as it tells them, each when it begins.
_STEPS = ("looking for the rings", "fitting the model", "reporting", "drawing")
# How long the worker takes to be ready, as far as one can say beforehand.
_LOADING = "loading the fit: about 5 s, and 15 s when this computer does it for the first time"


class PhotographTab:
    """The five steps of one tab of a browser."""

    def __init__(self, session: Session, worker: Worker):
        self._session, self._worker = session, worker
        self._scale, self._region = ScaleStep(session, worker), RegionStep(session)
        self._numbers = NumbersStep(session, self._scale, worker)
        self._result = ResultStep(session)
        self._shown: dict[str, Any] = {}
        self._was_running = False

    def build(self) -> None:
        """Show the steps, and follow what happens to them."""
        self._photograph_step()
        self._scale.build()
        self._region.build()
        self._fit_step()
        self._result.build()
        self._restore()
        ui.timer(0.5, self._tick)

    def _photograph_step(self) -> None:
        with parts.section("1. Photograph"):
            parts.file_input("photograph", "Choose a photograph of the rings, or drop it into this frame ")
            with parts.row():
                ui.button("Use the sample", on_click=self._take_sample).props("no-caps outline")
            self._photograph_line = parts.message("No photograph yet.")
        ui.on("sending", lambda event: self._sending(event.args))
        ui.on("photograph", lambda event: self._arrived(event.args))
        parts.run_script("njDrop", self._session.token)

    def _fit_step(self) -> None:
        with parts.section("4. Fit"):
            with ui.expansion("Parts of the model: switch them on and off").classes("w-full"), parts.row():
                form = self._session.form
                self._parts = {
                    name: parts.Choice(form, name, f"{_named(name)}: {what[0].lower()}{what[1:-1]}", _PARTS)
                    for name, what in PART_OPTIONS.items()
                }
            self._numbers.build()
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

    def _sending(self, about: dict[str, Any]) -> None:
        if about["kind"] == "photograph":
            self._photograph_line.set_text(f"Sending {about['name']} ...")

    def _arrived(self, answer: dict[str, Any]) -> None:
        """Say what became of a photograph; the steps after it begin anew."""
        if not answer["ok"]:
            still_there = f". {self._session.name} is still here" if self._session.data else ""
            parts.say(
                self._photograph_line,
                f"Not a photograph that can be used: {answer['message']}{still_there}.",
                is_wrong=True,
            )
            return
        self._say_photograph()
        self._scale.refresh()
        self._region.reset()
        self._numbers.refresh()
        self._result.clear()
        self._show_evidence({})
        self._fit_line.set_text("")
        self._bar.set_value(0.0)

    def _say_photograph(self) -> None:
        about = self._session.about
        warnings = "".join(f" {text}." for text in about["warnings"])
        parts.say(
            self._photograph_line, f"{self._session.name}: {about['columns']} x {about['rows']} pixels.{warnings}"
        )

    def _restore(self) -> None:
        """Show what the session holds already: the page was loaded again."""
        if not self._session.about:
            return
        self._say_photograph()
        self._region.refresh()
        self._numbers.restore()
        if self._session.answer:
            self._show_answer()

    def _show_answer(self) -> None:
        self._shown = self._session.answer
        self._result.show()
        self._show_evidence(self._shown["model"])
        self._numbers.take(self._shown)

    def _show_evidence(self, model: dict[str, str]) -> None:
        """Below each switch, why its part is there or not in the last fit."""
        for name, switch in self._parts.items():
            switch.say(f"last fit: {model[name]}" if name in model else "")

    async def _fit(self) -> None:
        session = self._session
        if not session.data:
            parts.say(self._fit_line, "Choose a photograph first (step 1).", is_wrong=True)
            return
        if session.running is not None:
            return
        try:
            settings = await self._scale.settings()
            switches = {name: box.value for name, box in self._parts.items() if box.value}
            settings = settings._replace(texts={**settings.texts, **switches, **self._numbers.texts()})
            work = session.measure(settings, self._follow)
            self._result.clear()
            self._show_running(True)
            parts.run_script("njFocus", f"c{self._cancel_button.id}")
            await work
            self._result.show_files()
            await self._numbers.draw()
            self._end(f"Done after {time.monotonic() - session.began:.1f} s.")
        except asyncio.CancelledError:
            self._end("Cancelled. There is no new answer.", is_wrong=True)
        except WorkError as error:
            self._end(f"No fit: {error}", is_wrong=True)
        except ValueError as error:
            self._end(f"Look at steps 2 and 4: {error}", is_wrong=True)

    def _follow(self, kind: str, content: Any) -> None:
        """Show the numbers as soon as they are there, and each picture; all else is asked for twice a second."""
        del content
        with self._bar:
            if kind == ANSWER:
                self._show_answer()
            elif kind == PICTURE:
                self._result.show_pictures()

    def _show_running(self, is_running: bool) -> None:
        self._fit_button.set_enabled(not is_running)
        self._cancel_button.set_enabled(is_running)

    def _end(self, text: str, is_wrong: bool = False) -> None:
        """Say how a fit ended; what gave no answer leaves the one before it."""
        if is_wrong and self._session.answer:
            self._show_answer()
            self._result.show_files()
        parts.say(self._fit_line, text, is_wrong)
        self._bar.set_value(0.0)
        self._show_running(False)
        parts.run_script("njFocus", f"c{self._fit_button.id}")

    async def _tick(self) -> None:
        """Say twice a second what is waited for, and for how long; a page that was loaded again follows so too."""
        session = self._session
        seconds = time.monotonic() - self._worker.started
        self._worker_line.set_text("" if self._worker.is_ready else f"{_LOADING} ({seconds:.0f} s so far)")
        if session.answer and session.answer is not self._shown:
            self._show_answer()
        self._result.show_pictures()
        is_running, was_running = session.running is not None, self._was_running
        self._was_running = is_running
        self._show_running(is_running)
        if not is_running:
            self._result.show_files()
        if was_running and not is_running:
            self._bar.set_value(0.0)
            await self._numbers.draw()
        if is_running:
            queue = f"; {self._worker.waiting - 1} more wait" if self._worker.waiting > 1 else ""
            step, steps = session.progress
            self._bar.set_value(step / (steps + 1))
            words = f"step {step} of {steps}: {_STEPS[step - 1]}" if step else "waiting for its turn"
            self._fit_line.set_text(f"Fitting, {time.monotonic() - session.began:.0f} s so far, {words}{queue}")


def _named(part: str) -> str:
    return part.replace("_", " ").capitalize()
