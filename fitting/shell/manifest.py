"""A manifest: a CSV file that lists photographs, with settings of their own where they differ."""

import csv
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from fitting.parameters import PART_OPTIONS
from fitting.shell import assignments, lamps, quantities
from fitting.shell.fit_arguments import FitOptions
from fitting.shell.options import transfer_curve
from newtonjax.numerics import shown

_PHOTO = "photo"
_SWITCH = {"yes": True, "true": True, "1": True, "no": False, "false": False, "0": False}


def _view(text: str) -> str:
    if text not in ("reflected", "transmitted"):
        raise ValueError(f"{text!r}; give reflected or transmitted")
    return text


def _channel(text: str) -> str:
    if text not in ("red", "green", "blue"):
        raise ValueError(f"{text!r}; give red, green or blue")
    return text


def _page(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise ValueError(f"{text!r}; give the number of a page, from 1 on")
    return int(text)


def _switch(text: str) -> bool:
    if text.lower() not in _SWITCH:
        raise ValueError(f"{text!r}; give yes or no, or leave the cell empty")
    return _SWITCH[text.lower()]


# Columns by the name of their option, with what reads a cell. The paths of files are relative to the manifest.
_READERS: dict[str, Callable[[str], Any]] = {
    "wavelength": lamps.wavelength,
    "wavelength_sd": quantities.length_sd,
    "pixel_size": quantities.positive_length,
    "pixel_size_sd": quantities.length_sd,
    "radius": quantities.positive_length,
    "radius_sd": quantities.length_sd,
    "view": _view,
    "scene": Path,
    "transfer": transfer_curve,
    "scale_from": Path,
    "mask": Path,
    "plate_radius": quantities.length,
    "plate_radius_sd": quantities.length_sd,
    "page": _page,
    "prior": lambda text: assignments.priors([text]),
    "fix": lambda text: assignments.held([text]),
    "start": lambda text: assignments.start([text]),
    "axis": assignments.place,
    "axis_sd": quantities.number,
    "view_angle": quantities.angle,
    "view_angle_sd": quantities.angle_sd,
    "noise": assignments.noise,
    "light": lamps.light,
    "response": Path,
    "channel": _channel,
}


def rows_of_manifest(path: Path, options: FitOptions) -> Iterator[tuple[Path, FitOptions]]:
    """Photographs of a manifest, each with `options` in which the cells of its line replace what they name.

    The first line names the columns: `photo`, and options of the command without their dashes, such as pixel_size. An
    empty cell leaves the option as it is. Raises FileNotFoundError, and ValueError with the line for what cannot be
    read.
    """
    if not path.is_file():
        raise FileNotFoundError(f"{path} is not a file; give the path of a manifest")
    with path.open(encoding="utf-8-sig", newline="") as file:
        reader = csv.DictReader(file)
        columns = [name.strip().replace("-", "_") for name in reader.fieldnames or ()]
        _check_columns(path, columns)
        reader.fieldnames = columns
        for cells in reader:
            try:
                yield _row(path.parent, cells, options)
            except ValueError as error:
                raise ValueError(f"{path}, line {reader.line_num}: {error}") from None


def _check_columns(path: Path, columns: list[str]) -> None:
    allowed = [_PHOTO, *_READERS, *PART_OPTIONS]
    if _PHOTO not in columns:
        first_line = ", ".join(columns)
        raise ValueError(
            f"{path} is no manifest of photographs: its first line, {shown(first_line)}, has no column {_PHOTO!r}; a "
            "table of readings is for `newtonjax rings` or `newtonjax wedge`"
        )
    if unknown := [name for name in columns if name not in allowed]:
        raise ValueError(f"{path} has a column {unknown[0]!r}; allowed in a manifest: {', '.join(allowed)}")


def _row(folder: Path, cells: dict[str | Any, Any], options: FitOptions) -> tuple[Path, FitOptions]:
    texts = {name: (text or "").strip() for name, text in cells.items() if isinstance(name, str)}
    photo = texts.pop(_PHOTO)
    if not photo or None in cells:
        raise ValueError("a line has a photo and a cell for each column at most; this one has not")
    return (folder / photo).absolute(), options_with(texts, options, folder)


def options_with(texts: Mapping[str, str], options: FitOptions, folder: Path = Path()) -> FitOptions:
    """`options` with texts by the names of the shell's options in place of theirs; empty texts change nothing.

    The paths of files are relative to `folder`. Raises ValueError with the name for a text that cannot be read.
    """
    values, parts = {}, dict(options.parts)
    for name, text in texts.items():
        if text and name in PART_OPTIONS:
            parts[name] = _read(name, _switch, text)
        elif text:
            value = _read(name, _READERS[name], text)
            values[name] = folder / value if isinstance(value, Path) else value
    # Of two ways to the pixel size the cell replaces the one that all photographs have.
    for name, twin in (("pixel_size", "scale_from"), ("scale_from", "pixel_size")):
        if name in values and twin not in values:
            values[twin] = None
    return options._replace(parts=parts, **values)


def _read(name: str, reader: Callable[[str], Any], text: str) -> Any:
    try:
        return reader(text)
    except ValueError as error:
        raise ValueError(f"{name} is {error}") from None
