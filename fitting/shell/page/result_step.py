"""The fifth step: the answer, what its uncertainty is made of, and files to keep."""

import html
from typing import Any

from nicegui import ui  # pyright: ignore[reportMissingImports]  # an extra

from fitting.parameters import TABLE, between, explained, length_unit, parameters_from, text_of, with_sd
from fitting.shell.page import parts
from fitting.shell.page.photograph_tasks import ADDED
from fitting.shell.page.sessions import Session

# Files to keep, in their order, with what they are.
_FILES = {
    "report.html": "Report (HTML)",
    "result.json": "All numbers (JSON)",
    "dark_rings.csv": "Dark rings (CSV)",
    "bright_rings.csv": "Bright rings (CSV)",
    "result.png": "Picture (PNG)",
    "report.txt": "Report (text)",
    "mask.png": "Mask (PNG)",
    "scale.json": "Scale (JSON)",
    "repeat.sh": "Shell command",
    "repeat.py": "Python lines",
}
# Pictures of an answer, with what they show and what is to be seen in them.
_PICTURES = {
    "rings.jpg": ("the photograph with the fitted dark rings", "The fitted dark rings in red."),
    "residual.jpg": ("photograph less model", "Photograph less model: rings here are left unexplained."),
    "unwrapped.jpg": (
        "unwrapped view: the order across, the angle down",
        "Unwrapped: bands of photograph and model in turn. A good fit is straight vertical lines.",
    ),
    "tried.jpg": ("the photograph with the dark rings that were tried", "The rings that were tried, in red."),
}


class ResultStep:
    """What is shown of the last fit."""

    def __init__(self, session: Session):
        self._session = session
        self._offered: tuple[str, ...] = ()

    def build(self) -> None:
        """Show that there is nothing yet."""
        with parts.section("5. Result"):
            self._area = ui.element("div").props("aria-live=polite")
            self._pictures = ui.html(sanitize=False)
            self._tables, self._links = ui.element("div"), ui.element("div")
        self.clear()

    def clear(self) -> None:
        """Forget the last answer."""
        for area in (self._area, self._tables, self._links):
            area.clear()
        self._pictures.set_content("")
        self._offered = ()
        with self._area:
            ui.label("No result yet.")

    def show(self) -> None:
        """Show the numbers of the answer; its pictures and files follow."""
        answer = self._session.answer
        self._area.clear()
        self._tables.clear()
        with self._area:
            ui.label(str(answer["headline"])).classes("nj-headline")
            for text in _sentences(answer):
                ui.label(text)
            for text in answer["warnings"]:
                ui.label(f"Note: {text}").classes("nj-warning")
        self.show_pictures()
        with self._tables:
            tables = _budget(answer) + _parameters(answer) + _model(answer)
            words = _words(" ".join([*_sentences(answer), *answer["warnings"], tables]))
            ui.html(tables + words, sanitize=False)
            if answer["status"] == "ok" and answer["measured"] == "pixel_size":
                ui.button("Use this pixel size for the next photograph", on_click=self._keep_scale).props("no-caps")
            parts.heading("To repeat it", 3)
            for name in ("repeat.sh", "repeat.py"):
                text = self._session.files[name].decode()
                ui.html(parts.block(_FILES[name], text, wraps=True), sanitize=False)

    def show_files(self) -> None:
        """Offer the files of the answer, as far as they are drawn."""
        names = tuple(name for name in _FILES if name in self._session.files)
        if names == self._offered:
            return
        self._offered = names
        self._links.clear()
        if not names:
            return
        address = f"/files/{self._session.token}"
        links = "".join(f'<li><a href="{address}/{name}" download>{_FILES[name]}</a></li>' for name in names)
        with self._links:
            parts.heading("To keep", 3)
            ui.html(f'<ul class="nj-links">{links}</ul>', sanitize=False)

    def _keep_scale(self) -> None:
        self._session.scale = {key: value for key, value in self._session.answer.items() if key not in ADDED}
        ui.notify("Step 2 now offers this pixel size for the next photograph.")

    def show_pictures(self) -> None:
        """Show the pictures of the answer, as far as they are drawn."""
        address, stamp = f"/files/{self._session.token}", f"?of={id(self._session.answer)}"
        shown = [(name, *words) for name, words in _PICTURES.items() if name in self._session.files]
        figures = "".join(parts.figure(f"{address}/{name}{stamp}", alt, caption) for name, alt, caption in shown)
        content = f'<div class="nj-row">{figures}</div>' if figures else ""
        if content != self._pictures.content:
            self._pictures.set_content(content)


# Share of the variance below which a row of the budget is not shown; the report has all of them.
_SMALLEST = 1e-6


def _sentences(answer: dict[str, Any]) -> list[str]:
    """The interval, and what would make it narrower."""
    sentences = []
    if answer["status"] == "ok" and answer["radius_interval_m"]:
        sd = answer["parameters"]["radius"]["sd"] if "radius" in answer["parameters"] else None
        sentences.append(f"With a probability of 95 % from {between(answer['radius_interval_m'], sd, 'm')}.")
    if answer["unstated"]:
        sentences.append(f"{answer['unstated'].replace('_', ' ')}.")
    if answer["dominant"]:
        sentences.append(
            f"Most of the uncertainty is of {answer['dominant'].removeprefix('largest: ').replace('_', ' ')}."
        )
    return sentences


def _budget(answer: dict[str, Any]) -> str:
    """The rows of the budget as bars, the longest first."""
    rows = [(row["source"], next(value for key, value in row.items() if key != "source")) for row in answer["budget"]]
    total = sum(sd**2 for _, sd in rows)
    rows = [(source, sd) for source, sd in rows if sd**2 > _SMALLEST * total]
    if not total:
        return ""
    factor, unit = length_unit(answer["parameters"][answer["measured"]]["value"], unit=TABLE[answer["measured"]].unit)
    lines = "".join(
        f'<tr><th scope="row">{html.escape(source.replace("_", " "))}</th>'
        f"<td>{sd * factor:.2g} {unit}</td><td>{sd**2 / total:.0%}</td>"
        f'<td><div class="nj-bar" style="width:{8 * sd**2 / total:.2f}rem"></div></td></tr>'
        for source, sd in sorted(rows, key=lambda row: -row[1])
    )
    title = f"What the uncertainty of the {answer['measured'].replace('_', ' ')} is made of"
    head = "<tr><th scope=col>source</th><th scope=col>standard deviation</th><th scope=col>share</th><td></td></tr>"
    return (
        f'<div class="nj-scroll" tabindex="0" role="region" aria-label="{title}">'
        f"<table><caption>{title}</caption>{head}{lines}</table></div>"
    )


def _parameters(answer: dict[str, Any]) -> str:
    rows = [
        (name.replace("_", " "), text_of(number), "given" if number.fixed else "measured")
        for name, number in parameters_from(answer).items()
    ]
    if answer["fringe_scale_per_px2"]:
        scale = with_sd(answer["fringe_scale_per_px2"], answer["fringe_scale_sd_per_px2"], "per px²")
        rows.insert(0, ("fringe scale", scale, "measured"))
    return parts.table("Numbers", ("name", "value", "from"), rows) if rows else ""


def _model(answer: dict[str, Any]) -> str:
    rows = [(part.replace("_", " "), why) for part, why in answer["model"].items()]
    return parts.table("Parts of the model, and the evidence", ("part", "why"), rows) if rows else ""


def _words(text: str) -> str:
    """What the words of an answer mean, in a sentence each."""
    rows = explained(text)
    return parts.table("Words", ("word", "what it means"), rows) if rows else ""
