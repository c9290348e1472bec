"""The verb `wedge`: from a photograph or a table of straight fringes to an answer on the screen and in files."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import fitting
from fitting.shell import rings_verb
from fitting.shell.answer import Outputs
from fitting.shell.progress import progress
from fitting.shell.report_page import STANDARD_INPUT, Measured
from fitting.tables import is_table

_OPTIONS = {"scale": "--scale-from", "columns": "--column"}


def run(source: Path, both: dict, of_photo: dict, of_table: dict, outputs: Outputs) -> int:
    """Measure, report, write; the exit status. `of_photo` and `of_table`: options of a photograph, of a table alone."""
    if source != STANDARD_INPUT and not source.is_file():
        raise FileNotFoundError(f"{source} is not a file; give a photograph of straight fringes, or a table of them")
    if source == STANDARD_INPUT or is_table(source):
        _refuse(of_photo, "a table")
        if both["wavelength"] is None:
            raise ValueError("a table of straight fringes gives the wedge's angle by the wavelength; give --wavelength")
        table = rings_verb.source_of(source, of_table["encoding"])
        outputs.check((source,))
        return outputs.write(fitting.wedge(table, **both, **of_table), [Measured(source)])
    _refuse(of_table, "a photograph")
    outputs.check(tuple(filter(None, (source, of_photo["mask"], of_photo["scale"]))))
    with progress(f"measuring {source.name}"):
        result = fitting.wedge_photo(source, **both, **of_photo)
    return outputs.write(result, [Measured(source, of_photo)])


def _refuse(options: Mapping[str, Any], kind: str) -> None:
    """Raises ValueError for options that the kind of source has not."""
    named = [_OPTIONS.get(name, f"--{name.replace('_', '-')}") for name, value in options.items() if value is not None]
    if named:
        raise ValueError(f"{', '.join(named)}: not of {kind}; leave it out")
