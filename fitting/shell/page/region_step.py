"""The third step: which part of the photograph is used."""

import asyncio
from typing import Any

from nicegui import ui  # pyright: ignore[reportMissingImports]  # an extra

from fitting.shell.page import parts
from fitting.shell.page.pictures import Region
from fitting.shell.page.sessions import Session
from fitting.shell.page.worker import WorkError

_ALL, _CIRCLE, _RECTANGLE, _WITHOUT = "all", "circle", "rectangle", "without-"
_SHAPES = {
    _ALL: "all that is lit and not saturated",
    _CIRCLE: "what is in a circle: click its middle, then its rim",
    _RECTANGLE: "what is in a rectangle: click two corners",
    _WITHOUT + _CIRCLE: "not what is in a circle: click its middle, then its rim",
    _WITHOUT + _RECTANGLE: "not what is in a rectangle: click two corners",
}
_FIELDS = {
    _ALL: (),
    _CIRCLE: (("x", "Middle x"), ("y", "Middle y"), ("radius", "Radius")),
    _RECTANGLE: (("x", "Corner x"), ("y", "Corner y"), ("to_x", "Opposite x"), ("to_y", "Opposite y")),
}


class RegionStep:
    """What the fit leaves out in red, and a region that narrows it."""

    def __init__(self, session: Session):
        self._session = session
        self._first: tuple[float, float] | None = None

    def build(self) -> None:
        """Show the fields."""
        with parts.section("3. Region"):
            self._shape = parts.Choice(self._session.form, "shape", "The fit uses", _SHAPES, self._choose)
            self._rows = {shape: parts.row() for shape in _FIELDS}
            self._fields: dict[str, dict[str, Any]] = {}
            for shape, names in _FIELDS.items():
                with self._rows[shape]:
                    self._fields[shape] = {name: _field(text) for name, text in names}
                    if names:
                        ui.button("Add this shape", on_click=self._use).props("no-caps outline")
                        ui.button("Take the last one back", on_click=self._undo).props("no-caps outline")
            self._picture = ui.element("div").classes("nj-pick")
            parts.picked(self._picture, self._size, self._take_point)
            self._line = parts.message()
            ui.label("Shapes add up: a circle that is used and one that is left out make a ring.").classes("nj-aside")
        self._choose(self._shape.value)

    def refresh(self) -> None:
        """Show the photograph that is there now; a new one begins without a region."""
        self._picture.clear()
        self._first = None
        about = self._session.about
        if not about:
            return
        address = f"/files/{self._session.token}/region.jpg?of={id(about)}"
        caption = f"{about['usable']:.0%} of the pixels are used; what is left out is red."
        with self._picture:
            ui.html(parts.figure(address, "the photograph; what the fit leaves out is red", caption), sanitize=False)

    def reset(self) -> None:
        """Begin anew with another photograph: all of it is used."""
        for fields in self._fields.values():
            for entry in fields.values():
                entry.value = None
        self._shape.choose(_ALL)
        self._choose(_ALL)
        self.refresh()

    async def _use(self) -> None:
        await self._narrow((*self._session.region, self._typed()))

    async def _undo(self) -> None:
        await self._narrow(self._session.region[:-1])

    async def _narrow(self, region: Region) -> None:
        if not self._session.data:
            self._line.set_text("Choose a photograph first (step 1).")
            return
        try:
            await self._session.narrow(region)
            parts.say(self._line, "")
        except (WorkError, ValueError) as error:
            parts.say(self._line, str(error), is_wrong=True)
        self.refresh()

    @property
    def _kind(self) -> str:
        """What is drawn: the form of the shape alone."""
        return self._shape.value.removeprefix(_WITHOUT)

    def _typed(self) -> dict[str, float]:
        """The shape of the fields."""
        values = {name: float(entry.value or 0.0) for name, entry in self._fields[self._kind].items()}
        return values | ({"leaves_out": 1.0} if self._shape.value.startswith(_WITHOUT) else {})

    def _choose(self, shape: str) -> Any:
        for name, row in self._rows.items():
            row.set_visibility(name == self._kind)
        self._first = None
        return asyncio.create_task(self._narrow(())) if shape == _ALL and self._session.region else None

    def _size(self) -> tuple[int, int]:
        return self._session.about["rows"], self._session.about["columns"]

    async def _take_point(self, x: float, y: float) -> None:
        """The first click is the middle or a corner, the second makes the region."""
        shape = self._kind
        if shape == _ALL:
            return
        fields = self._fields[shape]
        if self._first is None:
            self._first = x, y
            fields["x"].value, fields["y"].value = x, y
            self._line.set_text("And the second click.")
            return
        if shape == _CIRCLE:
            from_x, from_y = self._first
            fields["radius"].value = round(((x - from_x) ** 2 + (y - from_y) ** 2) ** 0.5, 1)
        else:
            fields["to_x"].value, fields["to_y"].value = x, y
        self._first = None
        await self._use()


def _field(text: str) -> Any:
    return ui.number(f"{text} [px]").props("dense outlined")
