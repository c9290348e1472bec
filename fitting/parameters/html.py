"""A result as one HTML file: answer, pictures, budget, the model's parts, and how to get it again."""

import base64
import html
import json
import platform
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path

from fitting.parameters.output import json_text

_STYLE = """body{font:15px/1.45 sans-serif;max-width:60em;margin:2em auto;padding:0 1em;color:#222}
table{border-collapse:collapse;margin:.5em 0}td,th{border-bottom:1px solid #ccc;padding:.2em .8em .2em 0;
text-align:left}
img{max-width:100%}
pre{background:#f4f4f4;padding:.8em;overflow-x:auto}
.answer{font-size:1.4em}.warning{color:#9a4a00}"""


def page(result, photo: Path, command: str, pictures: Mapping[str, bytes], chain=None) -> str:
    """The page; `command` is what was run, `pictures` PNG files by their titles."""
    answer = result.parameters.get(result.measured)
    parts = [
        f"<p class=answer>{html.escape(result.headline())}</p>",
        *(f"<p class=warning>{html.escape(text)}</p>" for text in result.warnings),
        _budget(result, answer),
        _table("The model", [(part, html.escape(why)) for part, why in result.model.items()]),
        *(f"<h2>{html.escape(title)}</h2>{_image(png)}" for title, png in pictures.items()),
        f"<h2>Report</h2><pre>{html.escape(result.report())}</pre>",
        "" if chain is None else f"<pre>{html.escape(chain.report())}</pre>",
        _table("How to get it again", _history(photo, result.origin.sha256, command)),
        f"<h2>All numbers</h2><pre>{html.escape(json_text(result.to_dict()))}</pre>",
    ]
    title = html.escape(f"newtonjax: {photo.name}")
    return (
        f"<!doctype html><meta charset=utf-8><title>{title}</title><style>{_STYLE}</style><h1>{title}</h1>"
        + "\n".join(parts)
    )


def _budget(result, answer) -> str:
    if not result.budget or answer is None or not answer.sd:
        return ""
    rows = [
        (source, f"{sd:.2g}", f"{(sd / answer.sd) ** 2:.1%}")
        for source, sd in sorted(result.budget, key=lambda row: -row[1])
    ]
    rows.append(("total", f"{answer.sd:.2g}", "100 %"))
    table = _table(f"Budget of {result.measured}", rows, ("source", "standard deviation", "share of the variance"))
    return table + f"<p>{html.escape(result.dominant())}</p>"


def _table(title: str, rows, head: tuple[str, ...] = ()) -> str:
    lines = "".join("<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in rows)
    top = "<tr>" + "".join(f"<th>{html.escape(cell)}</th>" for cell in head) + "</tr>" if head else ""
    return f"<h2>{html.escape(title)}</h2><table>{top}{lines}</table>"


def _image(png: bytes) -> str:
    return f'<img src="data:image/png;base64,{base64.b64encode(png).decode()}">'


def _history(photo: Path, digest: str, command: str) -> list[tuple[str, str]]:
    programs = {name: version(name) for name in ("newtonjax", "jax", "numpy", "scipy", "optimistix")}
    return [
        ("command", f"<code>{html.escape(command)}</code>"),
        ("photograph", f"{html.escape(photo.name)}, SHA-256 <code>{digest}</code>"),
        ("programs", html.escape(json.dumps({"python": platform.python_version(), **programs}))),
    ]
