"""The second tab: a bench of sliders, whose picture follows them."""

import asyncio
import html
from typing import Any

from nicegui import ui  # pyright: ignore[reportMissingImports]  # an extra

from fitting.shell.page import parts
from fitting.shell.page.bench_tasks import LIGHTS, SIDE, SLIDERS, VIEWS
from fitting.shell.page.sessions import Session
from fitting.shell.page.worker import Worker, WorkError


class BenchTab:
    """The virtual bench of one tab of a browser."""

    def __init__(self, session: Session, worker: Worker):
        self._session, self._worker = session, worker
        self._is_begun, self._is_busy = False, False
        self._latest: dict[str, Any] | None = None
        self._values: dict[str, Any] = {}

    def build(self) -> None:
        """Show sliders and picture; nothing is drawn before `begin`."""
        lists = parts.listed("view", "Rings seen in", {view: view for view in VIEWS})
        lists += parts.listed("light", "Light", LIGHTS)
        sliders = "".join(parts.slider(name, slider) for name, slider in SLIDERS.items())
        canvas = (
            f'<canvas id="bench" class="nj-canvas" width="{SIDE}" height="{SIDE}" role="img" '
            'aria-label="Picture of the rings on the bench"></canvas><p id="bench-line">The bench is being set up.</p>'
        )
        with parts.section("Virtual bench"):
            with parts.row():
                ui.html(canvas, sanitize=False).classes("nj-figure nj-seen")
                ui.html(f'<div class="nj-row">{lists}{sliders}</div>', sanitize=False).classes("nj-figure")
            self._numbers = ui.html("", sanitize=False)
            parts.heading("Speed against accuracy", 3)
            ui.label("Times every way to this picture, with its errors; the picture stands still meanwhile.")
            with parts.row():
                self._button = ui.button("Compare the ways", on_click=self._compare).props("no-caps outline")
            self._line = parts.message()
            self._trade = ui.html("", sanitize=False)
        ui.on("bench", lambda event: self._describe(event.args))

    async def begin(self) -> None:
        """Start the pictures, the first time that the tab is shown."""
        if not self._is_begun:
            self._is_begun = True
            parts.run_script("njBench", self._session.token)
            await self._describe({})

    async def _compare(self) -> None:
        self._button.set_enabled(False)
        self._line.set_text("Timing every way: about half a minute the first time, some seconds later.")
        try:
            text = await self._worker.call("compare", self._values)
            self._trade.set_content(parts.block("Speed against accuracy", text))
            self._line.set_text("")
        except (WorkError, asyncio.CancelledError) as error:
            self._line.set_text(str(error))
        finally:
            self._button.set_enabled(True)

    async def _describe(self, values: dict[str, Any]) -> None:
        """Show the numbers of the newest bench; while some are on their way, later ones replace each other."""
        self._latest = self._values = values
        if self._is_busy:
            return
        self._is_busy = True
        try:
            while self._latest is not None:
                newest, self._latest = self._latest, None
                self._show(await self._worker.call("describe", newest))
        except (WorkError, asyncio.CancelledError) as error:
            self._numbers.set_content(parts.block("Numbers of the bench", str(error)))
        finally:
            self._is_busy = False

    def _show(self, about: dict[str, Any]) -> None:
        rings = [(str(ring["order"]), f"{1e3 * ring['radius_m']:.4f}") for ring in about["rings"]]
        title = "What a photograph of this bench would tell at best"
        forecast = f"<h3>{title}</h3>{parts.block(title, about['bounds'])}" if about["bounds"] else ""
        warning = f'<p class="nj-warning">{html.escape(about["warning"])}</p>' if about["warning"] else ""
        self._numbers.set_content(
            warning
            + parts.table("Dark rings (of the wavelength of the slider)", ("order", "radius [mm]"), rings)
            + f"<p>Drawn by {html.escape(about['way'])}.</p>"
            + forecast
        )
