"""The verbs `rings` and `compare`: from tables of readings to an answer on the screen and in files."""

import shlex
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import fitting
from fitting.shell.answer import Outputs
from fitting.shell.report_page import STANDARD_INPUT, Measured
from fitting.tables import text_of


def run(table: Path, options: dict, outputs: Outputs) -> int:
    """Fit the line, report, write; the exit status."""
    source = source_of(table, options["encoding"])
    outputs.check((table,))
    return outputs.write(fitting.rings(source, **options), [Measured(table)])


def run_all(tables: Sequence[Path], options: dict, of: str, outputs: Outputs) -> int:
    """The same for several tables in one question; with the index of a liquid the first one is in air."""
    sources = [source_of(table, options["encoding"]) for table in tables]
    outputs.check(tuple(tables))
    results = [fitting.rings(source, **options) for source in sources]
    names = [table.name for table in tables]
    result = fitting.compare(results, of, names=names)
    return outputs.write(replace(result, origin=results[0].origin), [Measured(table) for table in tables])


def run_compare(files: Sequence[Path], of: str, outputs: Outputs) -> int:
    """Compare results that were saved as JSON by `rings` or `fit`."""
    outputs.check(tuple(files))
    results = []
    for file in files:
        if not file.is_file():
            raise FileNotFoundError(f"{file} is not a file; give the JSON of a result of fit or rings")
        kind = fitting.FitResult if b'"FitResult"' in file.read_bytes() else fitting.RingsResult
        results.append(kind.load(file))
    result = fitting.compare(results, of, names=[file.name for file in files])
    return outputs.write(result, [Measured(file) for file in files])


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
