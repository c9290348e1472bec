"""Pieces of HTML that the page is made of."""

import html
import json
from collections.abc import Callable, Iterable
from importlib.resources import files
from inspect import isawaitable
from typing import Any

from nicegui import ui  # pyright: ignore[reportMissingImports]  # an extra

from fitting.shell.page.bench_tasks import Slider


def resource(name: str) -> str:
    """The text of a file beside this one."""
    return (files("fitting.shell") / "page" / name).read_text(encoding="utf-8")


def heading(text: str, level: int = 2) -> None:
    """A heading of the page's outline."""
    ui.html(html.escape(text), sanitize=False, tag=f"h{level}")


def section(title: str) -> Any:
    """A step with its heading, to be entered with `with`."""
    area = ui.element("section").classes("nj-step").props(f'aria-label="{html.escape(title)}"')
    with area:
        heading(title)
    return area


def row() -> Any:
    """Fields side by side, below each other where there is no room."""
    return ui.element("div").classes("nj-row")


def field(form: dict[str, Any], name: str, label: str, hint: str = "", words: Iterable[str] = ()) -> Any:
    """A field for a text, which `form` keeps under a name; `words` are completed."""
    entry = ui.input(
        label,
        value=form.setdefault(name, ""),
        autocomplete=list(words) or None,
        on_change=lambda event: form.update({name: event.value}),
    )
    entry.classes("nj-field").props("outlined dense")
    if hint:
        entry.props(f'hint="{html.escape(hint)}"')
    return entry


class Choice:
    """One of several words by a native list, which every keyboard and phone knows; `form` keeps it under a name.

    Below stands a line of what is known of it.
    """

    def __init__(
        self,
        form: dict[str, Any],
        name: str,
        label: str,
        options: dict[str, str],
        changed: Callable[[str], Any] | None = None,
    ):
        self._form, self._name, self._options, self._changed = form, name, options, changed
        form.setdefault(name, next(iter(options)))
        with ui.element("label").classes("nj-field"):
            ui.label(label)
            self._list = ui.html(self._rows(), sanitize=False, tag="select").classes("nj-select")
            self._line = ui.label().classes("nj-aside")
        self._list.on("change", self._take, js_handler="(event) => emit(event.target.value)")

    @property
    def value(self) -> str:
        """The word that is chosen."""
        return self._form[self._name]

    def choose(self, value: str) -> None:
        """Choose one of the words."""
        self._form[self._name] = value
        self._list.set_content(self._rows())

    def say(self, text: str) -> None:
        """Say what is known of it."""
        self._line.set_text(text)

    def _take(self, event: Any) -> None:
        self._form[self._name] = event.args if event.args in self._options else self.value
        if self._changed is not None:
            self._changed(self.value)

    def _rows(self) -> str:
        return "".join(
            f'<option value="{html.escape(key)}"{" selected" if key == self.value else ""}>{html.escape(text)}</option>'
            for key, text in self._options.items()
        )


def message(text: str = "") -> Any:
    """A line that is read out when it changes."""
    return ui.label(text).props("role=status aria-live=polite")


def say(line: Any, text: str, is_wrong: bool = False) -> None:
    """Change such a line; what is wrong stands out."""
    line.set_text(text)
    line.classes(**{"add" if is_wrong else "remove": "nj-warning"})


def figure(address: str, alt: str, caption: str) -> str:
    """A picture with its caption."""
    return (
        f'<figure class="nj-figure"><img src="{html.escape(address)}" alt="{html.escape(alt)}">'
        f"<figcaption>{html.escape(caption)}</figcaption></figure>"
    )


def table(caption: str, head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A table whose cells are texts; it scrolls where it is wider than the screen."""
    top = "".join(f'<th scope="col">{html.escape(cell)}</th>' for cell in head)
    lines = "".join(
        "<tr>" + "".join(f"<td>{html.escape(str(cell))}</td>" for cell in cells) + "</tr>" for cells in rows
    )
    return (
        f'<div class="nj-scroll" tabindex="0" role="region" aria-label="{html.escape(caption)}">'
        f"<table><caption>{html.escape(caption)}</caption><tr>{top}</tr>{lines}</table></div>"
    )


def block(title: str, text: str, wraps: bool = False) -> str:
    """Lines to copy; long ones are broken, or the block scrolls."""
    kind = ' class="nj-wraps"' if wraps else ""
    return f'<pre{kind} tabindex="0" role="region" aria-label="{html.escape(title)}">{html.escape(text)}</pre>'


def picked(area: Any, shape: Callable[[], tuple[int, int]], take: Callable[[float, float], Any]) -> None:
    """Call `take` with the place (x, y) [px of the photograph] of a click on the picture in this area."""

    async def scaled(event: Any) -> None:
        x, y = event.args
        rows, columns = shape()
        taking = take(round(x * columns, 1), round(y * rows, 1))
        if isawaitable(taking):
            await taking

    area.on("click", scaled, js_handler=_CLICK)


def file_input(name: str, text: str) -> None:
    """A frame for a photograph, chosen or dropped; `page.js` sends it to the route of this name."""
    kinds = "image/*,.tif,.tiff,.npy,.dng,.cr2,.nef,.arw"
    ui.html(
        f'<label class="nj-drop" data-drop="{name}">{html.escape(text)} '
        f'<input type="file" id="{name}" accept="{kinds}"></label>',
        sanitize=False,
    )


def slider(name: str, about: Slider) -> str:
    """A slider of the bench, with its value beside its title."""
    return (
        f'<div class="nj-field nj-slider"><label for="bench-{name}">{html.escape(about.title)}: '
        f'<output id="bench-{name}-value">{about.first:g}</output> {html.escape(about.unit)}</label>'
        f'<input type="range" id="bench-{name}" data-bench="{name}" min="{about.lowest:g}" max="{about.highest:g}" '
        f'step="{about.step:g}" value="{about.first:g}"></div>'
    )


def listed(name: str, title: str, options: dict[str, str]) -> str:
    """A list of the bench."""
    rows = "".join(f'<option value="{html.escape(key)}">{html.escape(text)}</option>' for key, text in options.items())
    return (
        f'<div class="nj-field"><label for="bench-{name}">{html.escape(title)}</label>'
        f'<select class="nj-select" id="bench-{name}" data-bench="{name}">{rows}</select></div>'
    )


_CLICK = (
    "(event) => { const image = event.currentTarget.querySelector('img'); if (!image) return; "
    "const box = image.getBoundingClientRect(); "
    "emit([(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height]); }"
)


def run_script(call: str, *arguments: Any) -> None:
    """Call a function of `page.js`."""
    ui.run_javascript(f"{call}({', '.join(map(json.dumps, arguments))})")
