"""The third tab: tables of ring diameters, pasted from a spreadsheet."""

from nicegui import ui  # pyright: ignore[reportMissingImports]  # an extra

from fitting.shell import lamps
from fitting.shell.page import parts
from fitting.shell.page.sessions import Session
from fitting.shell.page.worker import Worker, WorkError

_EXAMPLE = "order\tdiameter_mm\n5\t3.43\n10\t4.86\n15\t5.95\n20\t6.87\n25\t7.68\n30\t8.41"
_HINT = "one line a ring; the first line names the columns: order, diameter_mm (or radius_mm, diameter_px)"
_FILES = {"rings.json": "All numbers (JSON)", "rings.txt": "Report (text)", "rings.png": "Picture (PNG)"}
# Fields by the names of `fitting.rings`: what they are, a hint, and words that are completed.
_FIELDS = {
    "wavelength": ("Lamp or wavelength of the table", "sodium or 632.8nm", lamps.NAMES[lamps.wavelength]),
    "wavelength_sd": ("Uncertainty of the wavelength", "as in 0.1nm"),
    "pixel_size": ("Pixel size of the table", "only for columns in pixels, as in 12.75um"),
}


class TableTab:
    """A table of rings of one tab of a browser."""

    def __init__(self, session: Session, worker: Worker):
        self._session, self._worker = session, worker

    def build(self) -> None:
        """Show the fields."""
        with parts.section("A table of rings"):
            self._table = ui.textarea("Table").props("outlined rows=10").classes("w-full")
            ui.label(_HINT).classes("nj-aside")
            with parts.row():
                self._fields = {
                    name: parts.field(self._session.form, f"table-{name}", *texts) for name, texts in _FIELDS.items()
                }
            with parts.row():
                ui.button("Compute the radius", on_click=self._measure).props("no-caps")
                ui.button("Fill in an example", on_click=self._fill).props("no-caps outline")
            self._line = parts.message()
            self._area = ui.element("div").props("aria-live=polite")

    def _fill(self) -> None:
        self._table.value, self._fields["wavelength"].value = _EXAMPLE, "sodium"

    async def _measure(self) -> None:
        parts.say(self._line, "Computing ...")
        self._area.clear()
        texts = {name: str(entry.value or "").strip() for name, entry in self._fields.items()}
        try:
            answer = await self._worker.call("table", str(self._table.value or ""), texts)
        except WorkError as error:
            parts.say(self._line, str(error), is_wrong=True)
            return
        self._line.set_text("" if answer["status"] == "ok" else f"The answer is: {answer['status']}.")
        self._session.table_files = answer["files"]
        with self._area:
            for words in answer["warnings"]:
                ui.label(f"Note: {words}").classes("nj-warning")
            ui.html(self._html(answer), sanitize=False)

    def _html(self, answer: dict) -> str:
        address = f"/files/{self._session.token}"
        links = "".join(
            f'<li><a href="{address}/{name}" download>{title}</a></li>'
            for name, title in _FILES.items()
            if name in answer["files"]
        )
        return parts.block("Report of the table", answer["report"]) + f'<ul class="nj-links">{links}</ul>'
