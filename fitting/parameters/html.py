"""A result as one HTML file: answer, pictures, budget, the model's parts, and how to get it again."""

import base64
import html
import io
import json
import platform
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path

from fitting.parameters.digits import with_sd
from fitting.parameters.table import TABLE

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
@media print{:root{color-scheme:light}body{margin:0;max-width:none;font-size:11px}figure,tr{break-inside:avoid}}"""
# Of pictures in the page: a quarter of the PNG's size, and no difference to the eye.
_QUALITY = 70


def page(result, photo: Path, command: str, pictures: Mapping[str, bytes], chain=None) -> str:
    """The page; `command` is what was run, `pictures` PNG files by their titles."""
    answer = result.parameters.get(result.measured)
    parts = [
        f"<p class=answer>{html.escape(result.headline())}</p>",
        *(f"<p class=warning>{html.escape(text)}</p>" for text in result.warnings),
        _budget(result, answer),
        *(_figure(title, png) for title, png in pictures.items()),
        _table("Numbers", _numbers(result), ("name", "value", "from")),
        _table("The model", [(part, html.escape(why)) for part, why in result.model.items()], ("part", "why")),
        _table("How to get it again", _history(photo, result.origin.sha256, command), ("what", "which")),
        _text("Report as text", result.report()),
        "" if chain is None else _text("Posterior as text", chain.report()),
    ]
    title = html.escape(f"newtonjax: {photo.name}")
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{title}</title><style>{_STYLE}</style></head><body><main><h1>{title}</h1>"
        + "\n".join(parts)
        + "</main></body></html>"
    )


def _budget(result, answer) -> str:
    if not result.budget or answer is None or not answer.sd:
        return ""
    largest = max(sd for _, sd in result.budget)
    rows = [
        (source, f"{sd:.2g}", f"{(sd / answer.sd) ** 2:.1%}", f'<div style="width:{sd / largest:.1%}"></div>')
        for source, sd in sorted(result.budget, key=lambda row: -row[1])
    ]
    rows.append(("total", f"{answer.sd:.2g}", "100 %", ""))
    head = ("source", "standard deviation", "share of the variance", "bar")
    return _table(f"Budget of {result.measured}", rows, head) + f"<p>{html.escape(result.dominant())}</p>"


def _numbers(result) -> list[tuple[str, str, str]]:
    """Name, value with its deviation, and whether it was given, of each number of the result."""
    rows = []
    for name, parameter in result.parameters.items():
        unit = TABLE[name].unit if name in TABLE else ""
        exact = parameter.fixed and not parameter.sd
        text = f"{parameter.value:.10g} {unit}" if exact else with_sd(parameter.value, parameter.sd or None, unit)
        rows.append((name, html.escape(text.strip()), "given" if parameter.fixed else "measured"))
    return rows


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


def _figure(title: str, png: bytes) -> str:
    from PIL import Image

    file = io.BytesIO()
    Image.open(io.BytesIO(png)).convert("RGB").save(file, "WEBP", quality=_QUALITY)
    data, name = base64.b64encode(file.getvalue()).decode(), html.escape(title, quote=True)
    return f'<figure><figcaption>{name}</figcaption><img alt="{name}" src="data:image/webp;base64,{data}"></figure>'


def _text(title: str, text: str) -> str:
    """Lines that are shown on demand."""
    name = html.escape(title, quote=True)
    return (
        f'<details><summary>{name}</summary><pre role="region" tabindex="0" aria-label="{name}">'
        f"{html.escape(text)}</pre></details>"
    )


def _history(photo: Path, digest: str, command: str) -> list[tuple[str, str]]:
    programs = {name: version(name) for name in ("newtonjax", "jax", "numpy", "scipy", "optimistix")}
    return [
        ("command", f"<code>{html.escape(command)}</code>"),
        ("photograph", f"{html.escape(photo.name)}, SHA-256 <code>{digest}</code>"),
        ("programs", html.escape(json.dumps({"python": platform.python_version(), **programs}))),
    ]
