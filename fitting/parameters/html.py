"""A measurement as one HTML file: answer, budget, pictures, what was given, the model, and how to get it again."""

import base64
import html
import io
import math
import platform
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from typing import Any, NamedTuple

from fitting.parameters.digits import between, exact, text_of, with_sd
from fitting.parameters.glossary import explained
from fitting.parameters.result import Origin
from fitting.parameters.table import UNITS

_STYLE = """:root{color-scheme:light dark}
body{font:15px/1.45 sans-serif;max-width:60em;margin:2em auto;padding:0 1em;color:light-dark(#222,#e8eaf0);
background:light-dark(#fff,#16181d);overflow-wrap:anywhere}
table{border-collapse:collapse;margin:.5em 0;overflow-wrap:normal}code{overflow-wrap:anywhere}
caption{text-align:left;font-weight:bold;font-size:1.15em;padding:.6em 0 .2em}
td,th{border-bottom:1px solid light-dark(#ccc,#4a505c);padding:.2em .8em .2em 0;text-align:left;vertical-align:top}
td.bar{min-width:6em}td.bar div{height:.8em;min-width:1px;background:light-dark(#1a4f9c,#8ab4f8)}
img{max-width:100%;height:auto}figure{margin:.5em 0}figcaption{font-weight:bold}
pre{background:light-dark(#f4f4f4,#23272f);padding:.8em;overflow-x:auto}
.wide{overflow-x:auto}.answer{font-size:1.4em}.warning{color:light-dark(#8a3b00,#ffb27a)}
@media print{:root{color-scheme:light}body{margin:0;max-width:none;font-size:9.5px}figure,tr{break-inside:avoid}
main{columns:2;column-gap:2em}h1,.answer,figure,pre{column-span:all}img{max-height:11cm}pre{padding:.3em 0}}"""
# Quality and size of pictures in the page, the first by which all together are small enough: most often the first one,
# a quarter of the PNG's size, and no difference to the eye.
_FORMS = ((70, 1.0), (50, 1.0), (50, 0.7), (40, 0.5), (30, 0.35))
_MOST_BYTES = 190_000

# Arguments that are lengths [m] and no parameter's name.
_LENGTHS = frozenset(
    ("length", "division", "ruler", "disc_diameter", "distance", "reference_radius", "expected_radius")
)


class Source(NamedTuple):
    """A file that was measured: its name, and the SHA-256 of its bytes."""

    name: str
    sha256: str


def page(result, sources: Sequence[Source], command: str, pictures: Mapping[str, bytes], text: str) -> str:
    """The page of an `AbstractMeasurement` of these files.

    `command` is what was run, `pictures` PNG files by their titles, `text` the report.
    """
    model = [(html.escape(part), html.escape(why)) for part, why in result.model.items()]
    checks = [(html.escape(name), html.escape(outcome)) for name, outcome in result.alternatives()]
    parts = [
        f"<p class=answer>{html.escape(result.headline())}</p>",
        *(f"<p>{html.escape(text)}</p>" for text in (_interval(result), result.unstated()) if text),
        *(f"<p class=warning>{html.escape(warning)}</p>" for warning in result.warnings),
        *_budgets(result),
        *(_figure(title, data) for title, data in _webp(pictures).items()),
        _table("Numbers", _numbers(result), ("name", "value", "from")),
        _table("Given", _arguments(result), ("argument", "value")),
        _table("The model", model, ("part", "why")),
        _table("What else was tried", checks, ("what", "outcome")),
        _table("How to get it again", _history(result.origin, sources, command), ("what", "which")),
        _text("Report as text", text),
    ]
    words = explained(" ".join(parts))
    parts.append(_table("Words", [(word, html.escape(meaning)) for word, meaning in words], ("word", "what it means")))
    title = html.escape(f"newtonjax: {_title(result, sources)}")
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{title}</title><style>{_STYLE}</style></head><body><main><h1>{title}</h1>"
        + "\n".join(parts)
        + "</main></body></html>"
    )


def _interval(result) -> str:
    """The interval of what is measured, where it has one."""
    ends = getattr(result, f"{getattr(result, 'measured', '')}_interval", None)
    if result.status != "ok" or not ends:
        return ""
    sd = getattr(result, f"{result.measured}_sd", None)
    return f"95 %: {between(ends, sd, UNITS.get(result.measured, ''))}"


def _title(result, sources: Sequence[Source]) -> str:
    if not sources:
        return type(result).__name__
    further = f" and {len(sources) - 1} more" if len(sources) > 1 else ""
    return sources[0].name + further


def _budgets(result) -> list[str]:
    """The tables of the budgets; below the first one its largest row in words."""
    tables = [_budget(of, rows) for of, rows in result.budgets().items()]
    return [*tables[:1], f"<p>{html.escape(result.dominant())}</p>" if result.dominant() else "", *tables[1:]]


def _budget(of: str, rows: Sequence[tuple[str, float]]) -> str:
    """A table of one budget; the total is the root of the sum of squares."""
    total = math.hypot(*(sd for _, sd in rows))
    if not total:
        return ""
    cells = [
        (html.escape(source), f"{sd:.2g}", f"{share:.1%}", f'<div style="width:{share:.1%}"></div>')
        for source, sd in sorted(rows, key=lambda row: -row[1])
        if (share := (sd / total) ** 2)
    ]
    cells.append(("total", f"{total:.2g}", "100 %", ""))
    return _table(f"Budget of {of}", cells, ("source", "standard deviation", "share of the variance", "bar"))


def _numbers(result) -> list[tuple[str, str, str]]:
    """Name, value with its deviation, and whether it was given, of each number of the result."""
    scale = getattr(result, "fringe_scale_per_px2", None)
    scale_sd = getattr(result, "fringe_scale_sd", None)
    rows = [("fringe scale", with_sd(scale, scale_sd, "per px²"), "measured")] if scale else []
    for name, number in result.parameters.items():
        rows.append((html.escape(name), html.escape(text_of(number)), "given" if number.fixed else "measured"))
    return rows


def _arguments(result) -> list[tuple[str, str]]:
    """The arguments that are not among the numbers, with their deviations."""
    arguments = {} if result.origin is None else result.origin.given
    numbers = {name for name, number in result.parameters.items() if number.fixed}
    rows = []
    for name, value in arguments.items():
        is_deviation = name.endswith("_sd") and name.removesuffix("_sd") in arguments
        if name in numbers or is_deviation or value in (False, "", [], {}):
            continue
        unit = "m" if name in _LENGTHS else UNITS.get(name, "")
        rows.append((html.escape(name), html.escape(_with_sd(value, arguments.get(f"{name}_sd"), unit))))
    return rows


def _with_sd(value: Any, sd: Any, unit: str) -> str:
    """A value with its standard deviation; what are no two numbers as they were given."""
    if isinstance(value, float | int) and isinstance(sd, float) and sd:
        return with_sd(value, sd, unit)
    if isinstance(value, float | int):
        return exact(float(value), unit) + (f" ± {sd}" if sd else "")
    text = ", ".join(map(str, value)) if isinstance(value, list) else str(value)
    return f"{text} {unit}".rstrip() + (f" ± {sd}" if sd else "")


def _table(title: str, rows, head: tuple[str, ...]) -> str:
    """A table; the first cell of a row names it, and cells are HTML. Nothing without rows."""
    if not rows:
        return ""
    kinds = ['<td class="bar">' if cell == "bar" else "<td>" for cell in head]
    lines = "".join(
        f'<tr><th scope="row">{row[0]}</th>'
        + "".join(f"{kind}{cell}</td>" for kind, cell in zip(kinds[1:], row[1:], strict=True))
        + "</tr>"
        for row in rows
    )
    top = "".join(f'<th scope="col">{html.escape(cell)}</th>' for cell in head)
    name = html.escape(title, quote=True)
    return (
        f'<div class="wide" role="region" tabindex="0" aria-label="{name}">'
        f"<table><caption>{name}</caption><tr>{top}</tr>{lines}</table></div>"
    )


def _figure(title: str, data: bytes) -> str:
    text, name = base64.b64encode(data).decode(), html.escape(title, quote=True)
    return f'<figure><figcaption>{name}</figcaption><img alt="{name}" src="data:image/webp;base64,{text}"></figure>'


def _webp(pictures: Mapping[str, bytes]) -> dict[str, bytes]:
    """The pictures as WebP files that are small enough together."""
    from PIL import Image

    images = {title: Image.open(io.BytesIO(png)).convert("RGB") for title, png in pictures.items()}
    files: dict[str, bytes] = {}
    for quality, share in _FORMS:
        files = {title: _encoded(image, quality, share) for title, image in images.items()}
        if sum(map(len, files.values())) <= _MOST_BYTES:
            break
    return files


def _encoded(image: Any, quality: int, share: float) -> bytes:
    file = io.BytesIO()
    size = tuple(max(1, round(share * side)) for side in image.size)
    (image if share == 1 else image.resize(size)).save(file, "WEBP", quality=quality)
    return file.getvalue()


def _text(title: str, text: str) -> str:
    """Lines that are shown on demand."""
    name = html.escape(title, quote=True)
    return (
        f'<details><summary>{name}</summary><pre role="region" tabindex="0" aria-label="{name}">'
        f"{html.escape(text)}</pre></details>"
    )


def _history(origin: Origin | None, sources: Sequence[Source], command: str) -> list[tuple[str, str]]:
    programs = {"python": platform.python_version()}
    programs |= {name: version(name) for name in ("newtonjax", "jax", "numpy", "scipy", "optimistix")}
    files = [("file", f"{html.escape(name)}, SHA-256 <code>{digest}</code>") for name, digest in sources]
    return [
        ("command", f"<code>{html.escape(command)}</code>"),
        *files,
        *([] if origin is None else [("date", html.escape(f"{origin.date}, newtonjax {origin.version}"))]),
        ("programs", html.escape(", ".join(f"{name} {number}" for name, number in programs.items()))),
    ]
