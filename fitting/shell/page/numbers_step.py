"""Numbers of the model before a fit: the rings that they make over the photograph, and which of them a fit holds."""

import html
from collections.abc import Mapping
from typing import Any

from nicegui import ui  # pyright: ignore[reportMissingImports]  # an extra

from fitting.parameters import TABLE
from fitting.shell.page import parts
from fitting.shell.page.scale_step import ScaleStep
from fitting.shell.page.sessions import Session
from fitting.shell.page.worker import Worker

# Of a prior that holds a number, as a share of the span that it may have.
_HELD = 1e-6
_PLACES = ("centre_x", "centre_y")
# Numbers of parts of the model that may be held, by the names of `fitting.fit`.
_OF_PARTS = tuple(name for name, spec in TABLE.items() if spec.in_fit and name != "contact")
_TITLES = {
    "radius": "Radius of the lens [m]",
    "fringe_scale": "Fringe scale [per px²]",
    "gap": "Gap at the centre [nm]",
    "centre_x": "Centre, x [px]",
    "centre_y": "Centre, y [px]",
}
# What a fit may hold: its numbers.
_LOCKS = {"centre": _PLACES, "gap": ("gap",), **{name: (name,) for name in _OF_PARTS}}
# Before a fit: so many rings to half a diagonal.
_RINGS = 15
_METRES_A_NM = 1e-9


class NumbersStep:
    """Fields of numbers, with a lock each, and the rings that are expected of them."""

    def __init__(self, session: Session, scale: ScaleStep, worker: Worker):
        self._session, self._scale, self._worker = session, scale, worker
        self._fields: dict[str, Any] = {}
        self._locks: dict[str, Any] = {}
        self._is_drawing, self._is_stale = False, False

    def build(self) -> None:
        """Show the fields; their rings come with a photograph."""
        self._panel = ui.expansion("Numbers: see their rings, hold them", on_value_change=self.draw).classes("w-full")
        with self._panel:
            ui.label(
                "Dark rings of these numbers are drawn over the photograph; a click on it moves their centre. A number "
                "that is held keeps its value in the fit."
            )
            with parts.row():
                self._field("radius")
                self._field("fringe_scale")
                for name, numbers in _LOCKS.items():
                    if name in _OF_PARTS:
                        continue
                    for number in numbers:
                        self._field(number)
                    self._lock(name, f"hold the {name}")
            with ui.expansion("Numbers of parts of the model").classes("w-full"), parts.row():
                for name in _OF_PARTS:
                    self._field(name)
                    self._lock(name, f"hold {_named(name)}")
            self._start = self._box("start", "start the fit from this radius and centre, in place of a search")
            self._line = parts.message()
            self._picture = ui.element("div").classes("nj-pick")
            parts.picked(self._picture, self._shape, self._take_point)

    def refresh(self) -> None:
        """Numbers for the photograph that is there now."""
        if not self._session.about:
            return
        rows, columns = self._shape()
        half = ((rows**2 + columns**2) ** 0.5) / 2
        first = {"radius": 1.0, "fringe_scale": _RINGS / half**2, "gap": 0.0}
        first |= {"centre_x": (columns - 1) / 2, "centre_y": (rows - 1) / 2}
        self._fill({**dict.fromkeys(_OF_PARTS, 0.0), **first})
        self._show_picture()

    def restore(self) -> None:
        """The picture of the photograph that a page shows which was loaded again."""
        if self._session.about:
            self._show_picture()

    def take(self, answer: Mapping[str, Any]) -> None:
        """The numbers that a fit found, where the person has not held others."""
        values = {name: one["value"] for name, one in answer["parameters"].items()}
        numbers = {name: values[name] for name in ("radius", *_OF_PARTS) if name in values}
        numbers |= {name: values[f"{name}_px"] for name in _PLACES if f"{name}_px" in values}
        if answer["fringe_scale_per_px2"]:
            numbers["fringe_scale"] = answer["fringe_scale_per_px2"]
        if answer["gap_m"] is not None:
            numbers["gap"] = answer["gap_m"] / _METRES_A_NM
        locked = {number for name, of_lock in _LOCKS.items() if self._locks[name].value for number in of_lock}
        self._fill({name: value for name, value in numbers.items() if name not in locked})

    def texts(self) -> dict[str, str]:
        """What is held, and where a fit starts, as the shell's options have it.

        Raises ValueError for an empty number.
        """
        locked = [name for name, box in self._locks.items() if box.value]
        texts = {}
        fixed = [f"gap={self._number('gap'):g}nm"] if "gap" in locked else []
        fixed += [f"centre={self._place()}"] if "centre" in locked else []
        priors = [
            f"{name}={self._number(name):.8g}:{_HELD * (TABLE[name].bounds[1] - TABLE[name].bounds[0]):.2g}"
            for name in locked
            if name in _OF_PARTS
        ]
        if self._start.value:
            size = f"radius={self._number('radius'):.8g}m"
            if not self._is_scaled():
                size = f"fringe-scale={self._number('fringe_scale'):.8g}"
            texts["start"] = f"centre={self._place()} {size}"
        texts |= {"fix": " ".join(fixed)} if fixed else {}
        return texts | ({"prior": " ".join(priors)} if priors else {})

    def _place(self) -> str:
        return ",".join(f"{self._number(name):.8g}" for name in _PLACES)

    def _number(self, name: str) -> float:
        value = self._fields[name].value
        if value is None:
            raise ValueError(f"{_TITLES.get(name, name)} is empty; give a number, or do not hold it")
        return float(value)

    def _field(self, name: str) -> None:
        form = self._session.form
        title = _TITLES.get(name, _named(name).capitalize())
        entry = ui.number(
            title, value=form.get(f"number-{name}"), on_change=lambda event: self._changed(name, event.value)
        )
        self._fields[name] = entry.classes("nj-number").props("dense outlined step=any debounce=200")

    def _lock(self, name: str, title: str) -> None:
        self._locks[name] = self._box(f"hold-{name}", title)

    def _box(self, name: str, title: str) -> Any:
        form = self._session.form
        return ui.checkbox(
            title, value=form.setdefault(name, False), on_change=lambda event: form.update({name: event.value})
        )

    async def _changed(self, name: str, value: float | None) -> None:
        self._session.form[f"number-{name}"] = value
        await self.draw()

    def _fill(self, numbers: Mapping[str, float]) -> None:
        for name, value in numbers.items():
            self._fields[name].value = float(f"{value:.7g}")

    def _is_scaled(self) -> bool:
        return self._scale.pixel_size() is not None and self._scale.wavelength() is not None

    def _show_picture(self) -> None:
        rows, columns = self._shape()
        address = f"/files/{self._session.token}/photograph.jpg?of={id(self._session.about)}"
        self._picture.clear()
        with self._picture:
            ui.html(f'<img src="{html.escape(address)}" alt="the photograph under the expected rings">', sanitize=False)
            self._rings = ui.html("", sanitize=False, tag="svg").classes("nj-rings")
            self._rings.props(f'viewBox="0 0 {columns} {rows}" role=img aria-label="expected dark rings"')

    async def draw(self) -> None:
        """The rings of the newest numbers; while some are on their way, later ones replace each other."""
        self._is_stale = True
        if self._is_drawing or not self._panel.value or not self._session.about or self._session.running is not None:
            return
        self._is_drawing = True
        try:
            while self._is_stale:
                self._is_stale = False
                await self._draw_once()
        finally:
            self._is_drawing = False

    async def _draw_once(self) -> None:
        try:
            numbers = self._expected()
            path = await self._worker.call("expected", self._shape(), numbers)
            self._line.set_text("")
        except ValueError as error:  # a text that is none, or what the worker says
            self._line.set_text(str(error))
            path = ""
        self._rings.set_content(f'<path d="{path}"></path>')

    def _expected(self) -> dict[str, Any]:
        """Arguments of the expected rings. Raises ValueError for an empty number."""
        wavelength, pixel_size = self._scale.wavelength(), self._scale.pixel_size()
        is_scaled = wavelength is not None and pixel_size is not None
        for name in ("radius", "fringe_scale"):
            self._fields[name].set_visibility((name == "radius") == is_scaled)
        scale = self._number("fringe_scale")
        if wavelength is not None and pixel_size is not None:
            radius = self._number("radius")
            if not radius > 0:
                raise ValueError(f"the radius is {radius:g} m; give one above zero")
            scale = pixel_size**2 / (radius * wavelength)
        turns = 2 * self._number("gap") * _METRES_A_NM / wavelength if wavelength is not None else 0.0
        of_parts = {name: self._fields[name].value or 0.0 for name in _OF_PARTS}
        centre = self._number("centre_x"), self._number("centre_y")
        return {
            "centre_px": centre,
            "fringe_scale_per_px2": scale,
            "gap_turns": turns,
            "view": self._scale.view,
            "numbers": of_parts,
        }

    def _shape(self) -> tuple[int, int]:
        return self._session.about["rows"], self._session.about["columns"]

    async def _take_point(self, x: float, y: float) -> None:
        self._fields["centre_x"].value, self._fields["centre_y"].value = x, y
        await self.draw()


def _named(name: str) -> str:
    return name.replace("_", " ")
