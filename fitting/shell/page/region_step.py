"""The third step: which part of the photograph is used."""

import asyncio
from collections.abc import Mapping
from typing import Any

from nicegui import ui  # pyright: ignore[reportMissingImports]  # an extra

from fitting.shell.page import parts
from fitting.shell.page.sessions import Session
from fitting.shell.page.worker import WorkError

_ALL, _CIRCLE, _RECTANGLE = "all", "circle", "rectangle"
_SHAPES = {
    _ALL: "all that is lit and not saturated",
    _CIRCLE: "a circle: click its middle, then its rim",
    _RECTANGLE: "a rectangle: click two corners",
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
            self._shape = parts.Choice("The fit uses", _SHAPES, _ALL, self._choose)
            self._rows = {shape: parts.row() for shape in _FIELDS}
            self._fields: dict[str, dict[str, Any]] = {}
            for shape, names in _FIELDS.items():
                with self._rows[shape]:
                    self._fields[shape] = {name: _field(text) for name, text in names}
                    if names:
                        ui.button("Use this region", on_click=self._use).props("no-caps outline")
            self._picture = ui.element("div").classes("nj-pick")
            parts.picked(self._picture, self._size, self._take_point)
            self._line = parts.message()
        self._choose(_ALL)

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

    async def _use(self) -> None:
        await self._narrow(self._typed())

    async def _narrow(self, region: Mapping[str, float] | None) -> None:
        if not self._session.data:
            self._line.set_text("Choose a photograph first (step 1).")
            return
        try:
            await self._session.narrow(region)
            self._line.set_text("")
        except (WorkError, ValueError) as error:
            self._line.set_text(str(error))
        self.refresh()

    def _typed(self) -> dict[str, float] | None:
        """The region of the fields, None without one."""
        shape = self._shape.value
        if shape == _ALL:
            return None
        values = {name: entry.value for name, entry in self._fields[shape].items()}
        return {name: float(value or 0.0) for name, value in values.items()}

    def _choose(self, shape: str) -> Any:
        for name, row in self._rows.items():
            row.set_visibility(name == shape)
        self._first = None
        return asyncio.create_task(self._narrow(None)) if shape == _ALL and self._session.region else None

    def _size(self) -> tuple[int, int]:
        return self._session.about["rows"], self._session.about["columns"]

    async def _take_point(self, x: float, y: float) -> None:
        """The first click is the middle or a corner, the second makes the region."""
        shape = self._shape.value
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
        await self._narrow(self._typed())


def _field(text: str) -> Any:
    return ui.number(f"{text} [px]").props("dense outlined")
