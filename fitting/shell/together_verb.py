"""The verb `together`: from several photographs to one answer."""

from pathlib import Path
from typing import Any

import fitting
from fitting.shell import session
from fitting.shell.answer import Outputs
from fitting.shell.fit_arguments import FitOptions, arguments_of
from fitting.shell.fit_verb import check_files, check_options
from fitting.shell.manifest import rows_of_manifest
from fitting.shell.progress import progress
from fitting.shell.report_page import Measured

# Options of a single photograph's fit.
_OF_ONE = ("fix", "start")


def run(
    photos: list[Path],
    shared: tuple[str, ...],
    options: FitOptions,
    outputs: Outputs,
    gap_range: tuple[float, float] | None = None,
) -> int:
    """Fit, report, write; the exit status."""
    pictures = [pair for path in photos for pair in _pictures(path, options)]
    if len(pictures) < 2:
        raise ValueError(f"{len(pictures)} photograph is given; give two or more, or `newtonjax fit` it alone")
    check_files({path: "photograph" for path, _ in pictures})
    for _, own in pictures:
        check_options(own)
        if own.scene is not None:
            raise ValueError("a manifest names a scene; pictures are put together by the gap formula: leave it out")
        if of_one := [name for name in _OF_ONE if getattr(own, name)]:
            raise ValueError(f"--{of_one[0]} is of one photograph; leave it out, or fit each one alone")
        if own.lamp not in (None, "unknown"):
            raise ValueError(
                f"{own.lamp} is light of several lines; name one line for each photograph, or fit each one alone"
            )
    outputs.check(tuple(path for path, _ in pictures))
    names = [path.name for path, _ in pictures]
    with progress(f"fitting {len(names)} photographs"):
        session.prepare()
        result = fitting.fit_together(
            [path for path, _ in pictures],
            shared=shared,
            names=names,
            gap_range=gap_range,
            **_united([own for _, own in pictures]),
        )
    return outputs.write(result, [Measured(path, arguments_of(own)) for path, own in pictures])


def _pictures(path: Path, options: FitOptions) -> list[tuple[Path, FitOptions]]:
    return list(rows_of_manifest(path, options)) if path.suffix.lower() == ".csv" else [(path, options)]


def _united(options: list[FitOptions]) -> dict[str, Any]:
    """The arguments of all pictures: one value where it is the same in all, else a list."""
    arguments = [arguments_of(own) for own in options]
    united: dict[str, Any] = {}
    for name in {name: None for own in arguments for name in own}:
        values = [own.get(name) for own in arguments]
        united[name] = values[0] if all(value == values[0] for value in values) else values
    return united
