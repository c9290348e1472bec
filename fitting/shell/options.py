"""The options of the command: what each reads, and what its help says."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from fitting.shell import lamps, quantities


def option(parse: Callable[[str], Any], metavar: str, what: str, default: str = "") -> Any:
    """An option whose text one function reads; the function's ValueError becomes the message of a wrong option.

    `default` is shown only: the option itself is None where it is not given.
    """

    def read(text: str):
        try:
            return parse(text)
        except ValueError as error:
            raise typer.BadParameter(str(error)) from None

    return typer.Option(parser=read, metavar=metavar, help=what, show_default=default or False)


def one_by_one(arguments: list[str]) -> list[str]:
    """`--vary a=1 b=2` as `--vary a=1 --vary b=2`: of the options that take NAME=VALUE."""
    separated, option = [], ""
    for argument in arguments:
        if argument.startswith("-"):
            option = argument if argument in ("--vary", "--sd", "--choose") else ""
        elif option and "=" in argument and separated[-1] != option:
            separated.append(option)
        separated.append(argument)
    return separated


def own_columns(texts: list[str]) -> dict[str, str]:
    """A table's own names of columns, of `--column diameter_mm=D`."""
    columns = {}
    for text in texts:
        name, sign, column = (part.strip() for part in text.partition("="))
        if not (name and sign and column):
            raise ValueError(f"--column {text!r}; give NAME=COLUMN, such as diameter_mm=D")
        columns[name] = column
    return columns


def _transfer(text: str) -> float | str:
    if text in ("linear", "srgb"):
        return text
    try:
        exponent = float(text)
    except ValueError:
        exponent = 0.0
    if not 0.1 <= exponent <= 10:
        raise ValueError(f"{text!r}; give linear, srgb, or an exponent between 0.1 and 10, such as 2.2")
    return exponent


def _shape(text: str) -> tuple[int, int]:
    rows, cross, columns = text.partition("x")
    if not (cross and rows.isdecimal() and columns.isdecimal() and int(rows) and int(columns)):
        raise ValueError(f"{text!r}; give ROWSxCOLUMNS, such as 1024x1024")
    return int(rows), int(columns)


Shape = Annotated[Any, option(_shape, "ROWSxCOLUMNS", "Pixels of the image.", "1024x1024")]
Wave = Annotated[Any, option(lamps.wavelength, "LENGTH|LINE", "Vacuum wavelength, or a line such as sodium.")]
Pixel = Annotated[
    float | None, option(quantities.positive_length, "LENGTH", "Size of a pixel at the object, in the gap.")
]
ScreenPixel = Annotated[
    float | None,
    option(quantities.positive_length, "LENGTH", "Distance of pixel centres on the screen.", "5um"),
]
PixelSd = Annotated[Any, option(quantities.length_sd, "LENGTH|PERCENT", "Standard deviation of the pixel size.")]
WaveSd = Annotated[Any, option(quantities.length_sd, "LENGTH|PERCENT", "Standard deviation of the wavelength.")]
View = Annotated[
    Literal["reflected", "transmitted"] | None,
    typer.Option(help="Side that the rings are seen on.", show_default="reflected"),
]
Force = Annotated[bool, typer.Option("--force", help="Overwrite existing files.")]
OutputDir = Annotated[
    Path | None, typer.Option(metavar="FOLDER", help="Folder for the picture, the report and the answer.")
]
Json = Annotated[str | None, typer.Option("--json", metavar="FILE|-", help="Write the answer as JSON (- is stdout).")]
Transfer = Annotated[
    Any, option(_transfer, "linear|srgb|GAMMA", "Transfer curve of the file. Default: 8 bits sRGB, 16 bits linear.")
]
ScaleFrom = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Pixel size and distortion, from the JSON of `newtonjax scale`.")
]
Contact = Annotated[
    bool | None,
    typer.Option(
        "--contact/--no-contact", help="A lens pressed flat on the plate.", show_default="if the image has it"
    ),
]
PlateRadius = Annotated[
    float | None,
    option(quantities.length, "LENGTH", "Radius of a curved plate, negative where it is hollow to the lens.", "flat"),
]
PlateSd = Annotated[Any, option(quantities.length_sd, "LENGTH|PERCENT", "Standard deviation of the plate's radius.")]
Page = Annotated[
    int | None,
    typer.Option(min=1, help="Of a file with several pictures (TIFF, GIF, WebP, PNG, .npy).", show_default="1"),
]
MaskImage = Annotated[
    Path | None, typer.Option(metavar="IMAGE", help="An image of the photograph's size, black where it is not used.")
]
Epsilon = Annotated[
    float | None,
    option(
        quantities.positive_length,
        "LENGTH",
        "For splat: how far apart two rays of a source node may land to interfere.",
        "a pixel's diagonal",
    ),
]
