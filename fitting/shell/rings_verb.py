"""The verbs `rings` and `wedge`: from a table of readings to an answer on the screen and in files."""

import shlex
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import fitting
from fitting.shell.answer import Outputs
from fitting.tables import readings, text_of

# What a wedge takes of the options of `rings`, by its own name.
_OF_WEDGE = {"wedge_length": "length", "wedge_length_sd": "length_sd"}
_READING = ("columns", "separator", "encoding", "vernier")
_COMMON = ("wavelength", "wavelength_sd", "gap_index", "gap_index_sd", *_READING)
STANDARD_INPUT = Path("-")


def run(table: Path, options: dict, outputs: Outputs) -> int:
    """Fit the line, report, write; the exit status."""
    source = source_of(table, options["encoding"])
    outputs.check((table,))
    is_wedge = readings(source, **{name: options[name] for name in _READING}).is_wedge
    of_wedge = {_OF_WEDGE[name]: options.pop(name) for name in _OF_WEDGE}
    if not is_wedge:
        if of_wedge["length"] is not None:
            raise ValueError("--wedge-length goes with positions of straight fringes (position_mm); leave it out")
        return outputs.write(fitting.rings(source, **options))
    if options["wavelength"] is None:
        raise ValueError("positions of straight fringes give the wedge's angle by the wavelength; give --wavelength")
    refused = [name for name in ("pixel_size", "radius", "expected_radius") if options[name] is not None]
    if refused or options["bright"] or options["view_angle"]:
        named = ", ".join(f"--{name.replace('_', '-')}" for name in refused) or "--bright and --view-angle"
        raise ValueError(f"{named}: not of straight fringes; leave it out")
    options["gap_index"] = 1.0 if options["gap_index"] is None else options["gap_index"]
    return outputs.write(fitting.wedge(source, **{name: options[name] for name in _COMMON}, **of_wedge))


def run_all(tables: Sequence[Path], options: dict, of: str, outputs: Outputs) -> int:
    """The same for several tables in one question; with the index of a liquid the first one is in air."""
    sources = [source_of(table, options["encoding"]) for table in tables]
    outputs.check(tuple(tables))
    arguments = {name: value for name, value in options.items() if name not in _OF_WEDGE}
    results = [fitting.rings(source, **arguments) for source in sources]
    names = [table.name for table in tables]
    result = fitting.compare(results, of, names=names)
    return outputs.write(replace(result, origin=results[0].origin))


def run_compare(files: Sequence[Path], of: str, outputs: Outputs) -> int:
    """Compare results that were saved as JSON by `rings` or `fit`."""
    outputs.check(tuple(files))
    results = []
    for file in files:
        if not file.is_file():
            raise FileNotFoundError(f"{file} is not a file; give the JSON of a result of fit or rings")
        kind = fitting.FitResult if b'"FitResult"' in file.read_bytes() else fitting.RingsResult
        results.append(kind.load(file))
    return outputs.write(fitting.compare(results, of, names=[file.name for file in files]))


def run_wedge(table: Path, options: dict, outputs: Outputs) -> int:
    """The same for a table of positions of straight fringes."""
    source = source_of(table, options["encoding"])
    outputs.check((table,))
    return outputs.write(fitting.wedge(source, **options))


def source_of(table: Path, encoding: str | None) -> Path | str:
    """The table's file, or the text on standard input where it is "-". Raises FileNotFoundError."""
    if table == STANDARD_INPUT:
        text, _ = text_of(sys.stdin.buffer.read(), "standard input", encoding)
        return text + "\n"
    if not table.is_file():
        raise FileNotFoundError(f"{table} is not a file; give the path of a table of ring readings (CSV with a header)")
    return table


def command_with(columns: Mapping[str, str], arguments: Sequence[str]) -> str:
    """The command of these arguments with columns named, as the shell takes it."""
    remaining, is_column = [], False
    for argument in arguments:
        if not is_column and argument != "--column" and not argument.startswith("--column="):
            remaining.append(argument)
        is_column = argument == "--column"
    named = [part for name, header in columns.items() for part in ("--column", f"{name}={header}")]
    return shlex.join(["newtonjax", *remaining, *named])
