"""The second step: what is known of the light, and how long a pixel is on the object."""

from collections.abc import Mapping
from typing import Any

from nicegui import ui  # pyright: ignore[reportMissingImports]  # an extra

from fitting.shell import lamps
from fitting.shell.page import parts
from fitting.shell.page.sessions import Session
from fitting.shell.page.settings import Settings
from fitting.shell.page.worker import Worker

_TYPED, _CLICKED, _LENS, _EARLIER, _NONE = "typed", "clicked", "lens", "earlier", "none"
_WAYS = {
    _TYPED: "the pixel size, typed",
    _CLICKED: "two clicks on a known length",
    _LENS: "a lens of known radius: measure the pixel size",
    _EARLIER: "the pixel size measured before on this page",
    _NONE: "not known: fringe scale only",
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
    _LENS: {"radius": ("Known radius", "as in 1m"), "radius_sd": ("Its uncertainty", "as in 1mm or 0.5%")},
    _EARLIER: {},
    _NONE: {},
}


class ScaleStep:
    """Light and scale, as they were typed."""

    def __init__(self, session: Session):
        self._session = session
        self._fields: dict[str, Any] = {}
        # Of a fit of a known lens, or of two points: what `fit` takes as its scale.
        self.earlier: Mapping[str, Any] | None = None

    def build(self) -> None:
        """Show the fields."""
        words = lamps.NAMES[lamps.wavelength]
        with parts.section("2. Scale and light"):
            with parts.row():
                hint = "a lamp (sodium, mercury-green, hene) or 632.8nm"
                self._fields["wavelength"] = parts.field("Lamp or wavelength", hint, words=words)
                self._fields["wavelength_sd"] = parts.field("Its uncertainty", "as in 0.1nm; lamps have their own")
                self._fields["view"] = parts.Choice("Rings seen in", _VIEWS, "")
            self._way = parts.Choice("The scale is", _WAYS, _TYPED, self._choose)
            self._rows = {way: parts.row() for way in _FIELDS}
            for way, fields in _FIELDS.items():
                with self._rows[way]:
                    self._fields |= {name: parts.field(*texts) for name, texts in fields.items()}
            self._picture = ui.element("div").classes("nj-pick")
            parts.picked(self._picture, self._shape, self._take_point)
            self._line = parts.message()
        self._choose(_TYPED)

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
        if self._session.data and self._way.value == _CLICKED:
            address = f"/files/{self._session.token}/photograph.jpg?of={id(self._session.about)}"
            caption = "Click on both ends of the known length; their pixels can be typed too."
            with self._picture:
                ui.html(parts.figure(address, "the photograph", caption), sanitize=False)

    async def settings(self, worker: Worker) -> Settings:
        """What the fields say. Raises ValueError for what is missing, WorkError for two points that are none."""
        way = self._way.value
        names = ("wavelength", "wavelength_sd", "view", *(_FIELDS[way] if way != _CLICKED else ()))
        texts = {name: str(self._fields[name].value or "").strip() for name in names}
        if way == _EARLIER and self.earlier is None:
            raise ValueError("no pixel size was measured on this page before; fit the photograph of a known lens first")
        if way != _CLICKED:
            return Settings(texts, scale=self.earlier if way == _EARLIER else None)
        places = [str(self._fields[name].value or "").strip() for name in ("from", "to")]
        distance = str(self._fields["distance"].value or "").strip()
        distance_sd = str(self._fields["distance_sd"].value or "").strip()
        scale = await worker.call("scale", places, distance, distance_sd)
        self._line.set_text(f"pixel size {scale['pixel_size_m'] * 1e6:.5g} µm")
        points = ["newtonjax", "scale", "--point", places[0], "--point", places[1], "--distance", distance]
        points += ["--distance-sd", distance_sd] if distance_sd else []
        self.earlier = scale
        return Settings(texts, scale=scale, points=(*points, "--json", "scale.json"))

    def _choose(self, way: str) -> None:
        for name, row in self._rows.items():
            row.set_visibility(name == way)
        self.refresh()

    def _shape(self) -> tuple[int, int]:
        return self._session.about["rows"], self._session.about["columns"]

    def _take_point(self, x: float, y: float) -> None:
        """A click fills the first of the two places that is empty, or begins anew."""
        first, second = self._fields["from"], self._fields["to"]
        if first.value and not second.value:
            second.value = f"{x},{y}"
        else:
            first.value, second.value = f"{x},{y}", ""
