"""The second step: what is known of the light, and how long a pixel is on the object."""

from collections.abc import Mapping
from typing import Any

from nicegui import ui  # pyright: ignore[reportMissingImports]  # an extra

from fitting.shell import lamps, quantities
from fitting.shell.page import parts
from fitting.shell.page.sessions import Session
from fitting.shell.page.settings import SCALE, Settings, check_lamp
from fitting.shell.page.worker import Worker, WorkError

_TYPED, _CLICKED, _RETICLE, _LENS, _EARLIER, _NONE = "typed", "clicked", "reticle", "lens", "earlier", "none"
_WAYS = {
    _TYPED: "the pixel size, typed",
    _CLICKED: "two clicks on a known length",
    _RETICLE: "a photograph of a grid, a ruler or a disc",
    _LENS: "a lens of known radius: measure the pixel size",
    _EARLIER: "the pixel size measured before on this page",
    _NONE: "not known: fringe scale only",
}
_KINDS = {
    "division": "a square grid: distance of two lines",
    "ruler": "a ruler: distance of neighbouring lines",
    "disc_diameter": "a disc: its diameter",
}
_VIEWS = {"": "reflected (if not known)", "reflected": "reflected", "transmitted": "transmitted"}
# Fields of each way, by the names of the shell's options.
_FIELDS = {
    _TYPED: {"pixel_size": ("Pixel size", "as in 12.75um"), "pixel_size_sd": ("Its uncertainty", "as in 0.1um or 1%")},
    _CLICKED: {
        "from": ("First point", "x,y in pixels"),
        "to": ("Second point", "x,y in pixels"),
        "distance": ("Distance", "as in 10mm"),
        "distance_sd": ("Its uncertainty", "as in 0.1mm or 1%"),
    },
    _RETICLE: {"size": ("Known size", "as in 0.2mm"), "size_sd": ("Its uncertainty", "as in 1um or 0.5%")},
    _LENS: {"radius": ("Known radius", "as in 1m"), "radius_sd": ("Its uncertainty", "as in 1mm or 0.5%")},
    _EARLIER: {},
    _NONE: {},
}


class ScaleStep:
    """Light and scale, as they were typed."""

    def __init__(self, session: Session, worker: Worker):
        self._session, self._worker = session, worker
        self._fields: dict[str, Any] = {}

    def build(self) -> None:
        """Show the fields."""
        words, form = lamps.NAMES[lamps.wavelength], self._session.form
        with parts.section("2. Scale and light"):
            with parts.row():
                hint = "a lamp (sodium, mercury-green, hene) or 632.8nm"
                self._fields["wavelength"] = parts.field(form, "wavelength", "Lamp or wavelength", hint, words)
                hint = "as in 0.1nm; lamps have their own"
                self._fields["wavelength_sd"] = parts.field(form, "wavelength_sd", "Its uncertainty", hint)
                self._fields["view"] = parts.Choice(form, "view", "Rings seen in", _VIEWS)
            self._way = parts.Choice(form, "way", "The scale is", _WAYS, self._choose)
            self._rows = {way: parts.row() for way in _FIELDS}
            for way, fields in _FIELDS.items():
                with self._rows[way]:
                    if way == _RETICLE:
                        self._kind = parts.Choice(form, "kind", "It shows", _KINDS)
                    self._fields |= {name: parts.field(form, name, *texts) for name, texts in fields.items()}
            self._reticle = ui.element("div").classes("nj-step-part")
            with self._reticle:
                parts.file_input(
                    "reticle", "Choose a photograph of it, by the same camera at the same place, or drop it here "
                )
                ui.button("Measure its pixel size", on_click=self._measure_reticle).props("no-caps outline")
            self._picture = ui.element("div").classes("nj-pick")
            parts.picked(self._picture, self._shape, self._take_point)
            self._line = parts.message()
        ui.on("reticle", lambda event: self._reticle_arrived(event.args))
        self._choose(self._way.value)

    def fill(self, texts: Mapping[str, str]) -> None:
        """Put texts into the fields, and empty the others."""
        for name, entry in self._fields.items():
            if name != "view":
                entry.value = texts.get(name, "")
        self._fields["view"].choose(texts.get("view", ""))
        self._way.choose(_TYPED)
        self._choose(_TYPED)

    def refresh(self) -> None:
        """Show the photograph that is there now."""
        self._picture.clear()
        session, way = self._session, self._way.value
        if session.data and way == _CLICKED:
            address = f"/files/{session.token}/photograph.jpg?of={id(session.about)}"
            caption = "Click on both ends of the known length; their pixels can be typed too."
            picture = parts.figure(address, "the photograph", caption)
        elif session.reticle.data and way == _RETICLE:
            address = f"/files/{session.token}/reticle.jpg?of={id(session.reticle)}"
            caption = f"{session.reticle.name}; what is measured in it is drawn."
            picture = parts.figure(address, "the photograph of something of known size", caption)
        else:
            return
        with self._picture:
            ui.html(picture, sanitize=False)

    async def settings(self) -> Settings:
        """What the fields say. Raises ValueError for what is missing, WorkError for a scale that cannot be measured."""
        way = self._way.value
        of_way = _FIELDS[way] if way in (_TYPED, _LENS) else ()
        texts = {name: self._text(name) for name in ("wavelength", "wavelength_sd", "view", *of_way)}
        if way == _CLICKED:
            return Settings(texts, scale=await self._clicked(), before=self._command_of_clicks())
        if way == _RETICLE:
            await self._measure_reticle(raises=True)
            return Settings(texts, scale=self._session.scale, before=self._command_of_reticle())
        if way == _EARLIER and not self._session.scale:
            raise ValueError("no pixel size was measured on this page before; fit the photograph of a known lens first")
        return Settings(texts, scale=self._session.scale if way == _EARLIER else None)

    def pixel_size(self) -> float | None:
        """The pixel size as far as it is known [m]. Raises ValueError for a text that is none."""
        way = self._way.value
        if way == _TYPED:
            text = self._text("pixel_size")
            return quantities.positive_length(text) if text else None
        return self._session.scale.get("pixel_size_m") if way in (_CLICKED, _RETICLE, _EARLIER) else None

    def wavelength(self) -> float | None:
        """The wavelength as far as it is known [m]. Raises ValueError for a text that is none."""
        text = self._text("wavelength")
        check_lamp(text)
        return lamps.wavelength(text).within(1.0) if text else None

    @property
    def view(self) -> str:
        """The side that the rings are seen on: reflected where nothing is said."""
        return self._fields["view"].value or "reflected"

    async def _clicked(self) -> Mapping[str, Any]:
        scale = await self._worker.call(
            "scale", [self._text("from"), self._text("to")], self._text("distance"), self._text("distance_sd")
        )
        self._line.set_text(f"pixel size {scale['pixel_size_m'] * 1e6:.5g} µm")
        self._session.scale = scale
        return scale

    def _command_of_clicks(self) -> tuple[str, ...]:
        words = ["newtonjax", "scale", "--point", self._text("from"), "--point", self._text("to")]
        words += ["--distance", self._text("distance")]
        words += ["--distance-sd", self._text("distance_sd")] if self._text("distance_sd") else []
        return (*words, "--json", SCALE)

    def _command_of_reticle(self) -> tuple[str, ...]:
        option = f"--{self._kind.value.replace('_', '-')}"
        words = ["newtonjax", "scale", self._session.reticle.name, option, self._text("size")]
        words += [f"{option}-sd", self._text("size_sd")] if self._text("size_sd") else []
        return (*words, "--json", SCALE)

    async def _measure_reticle(self, raises: bool = False) -> None:
        self._line.set_text("Measuring the pixel size ...")
        try:
            words = await self._session.measure_reticle(self._kind.value, self._text("size"), self._text("size_sd"))
        except WorkError as error:
            self._line.set_text(str(error))
            if raises:
                raise
            return
        self._line.set_text(words)
        self.refresh()

    def _reticle_arrived(self, answer: Mapping[str, Any]) -> None:
        self._line.set_text("" if answer["ok"] else f"Not a photograph that can be used: {answer['message']}")
        self.refresh()

    def _text(self, name: str) -> str:
        return str(self._fields[name].value or "").strip()

    def _choose(self, way: str) -> None:
        for name, row in self._rows.items():
            row.set_visibility(name == way)
        self._reticle.set_visibility(way == _RETICLE)
        self._line.set_text("")
        self.refresh()

    def _shape(self) -> tuple[int, int]:
        """Of the photograph that is clicked on; one of something of known size is only looked at."""
        return self._session.about["rows"], self._session.about["columns"]

    def _take_point(self, x: float, y: float) -> None:
        """A click fills the first of the two places that is empty, or begins anew."""
        if self._way.value != _CLICKED:
            return
        first, second = self._fields["from"], self._fields["to"]
        if first.value and not second.value:
            second.value = f"{x},{y}"
        else:
            first.value, second.value = f"{x},{y}", ""
