"""What the worker does with a table of rings that was pasted."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import fitting
from fitting.parameters import output
from fitting.shell import lamps, quantities
from fitting.shell.answer import as_png
from fitting.shell.page.settings import check_lamp

# What may be typed beside a table, with what reads it.
_READERS: dict[str, Callable[[str], Any]] = {
    "wavelength": lamps.wavelength,
    "wavelength_sd": quantities.length_sd,
    "pixel_size": quantities.positive_length,
}


def measure(files: Path, tell: Callable[[str, Any], None], text: str, texts: Mapping[str, str]) -> dict[str, Any]:
    """Report and files of a table of rings. Raises ValueError for what is none."""
    del files, tell
    check_lamp(texts.get("wavelength", ""))
    if not text.strip():
        raise ValueError("there is no table yet; paste the cells of a spreadsheet with their header")
    arguments = {name: _READERS[name](words) for name, words in texts.items() if words}
    if "wavelength" in arguments:
        arguments |= lamps.in_air(arguments["wavelength"], arguments.get("wavelength_sd"))
    # A text with a line break is a table; without one it would be the name of a file.
    result = fitting.rings(f"{text.strip()}\n", **arguments)
    answer = {"status": result.status, "headline": result.report().splitlines()[:2], "report": result.report()}
    drawn = {"rings.json": output.json_text(result.to_dict()).encode(), "rings.txt": f"{result.report()}\n".encode()}
    if result.status == "ok":
        drawn["rings.png"] = as_png(result.figure())
    return {**answer, "warnings": [str(words) for words in result.warnings], "files": drawn}
