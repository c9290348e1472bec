"""The options of the command: what each reads, and what its help says."""

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from fitting.parameters import PART_OPTIONS
from fitting.shell import assignments, lamps, quantities


def option(parse: Callable[[str], Any], metavar: str, what: str, default: str = "", panel: str | None = None) -> Any:
    """An option whose text one function reads; the function's ValueError becomes the message of a wrong option.

    `default` is shown only: the option itself is None where it is not given. `panel`: title of a table of its own in
    the help. The shell completes names of lamps.
    """

    def read(text: str):
        try:
            return parse(text)
        except ValueError as error:
            raise typer.BadParameter(str(error)) from None

    words = lamps.NAMES.get(parse)

    def beginning_with(incomplete: str) -> list[str]:
        return [word for word in words or () if word.startswith(incomplete.lower())]

    complete = beginning_with if words else None
    about: dict[str, Any] = {"help": what, "show_default": default or False, "rich_help_panel": panel}
    return typer.Option(parser=read, metavar=metavar, autocompletion=complete, **about)


def expanded(verb: Callable[..., int], before: str, options: list[inspect.Parameter]) -> Callable[..., int]:
    """The verb, which takes any keywords, with options for some, in its help before one of its parameters."""
    parameters = []
    for parameter in inspect.signature(verb).parameters.values():
        parameters += options if parameter.name == before else []
        parameters += [parameter] if parameter.kind is not inspect.Parameter.VAR_KEYWORD else []
    vars(verb).update(
        __signature__=inspect.Signature(parameters, return_annotation=int),
        __annotations__={parameter.name: parameter.annotation for parameter in parameters} | {"return": int},
    )
    return verb


def parameter_of(name: str, annotation: Any) -> inspect.Parameter:
    """A parameter that is an option, None where it is not given."""
    return inspect.Parameter(name, inspect.Parameter.POSITIONAL_OR_KEYWORD, default=None, annotation=annotation)


def with_model_options(verb: Callable[..., int]) -> Callable[..., int]:
    """The verb with `--NAME/--no-NAME` for every part of the rings' model, and what is known of the parts' numbers."""
    options = []
    for name, what in PART_OPTIONS.items():
        flag = name.replace("_", "-")
        # In a table of their own: beside other options' columns 80 characters do not hold two names.
        about: dict[str, Any] = {"show_default": "if the image has it", "rich_help_panel": "Parts of the model"}
        switch = typer.Option(f"--{flag}/--no-{flag}", help=what, **about)
        options.append(parameter_of(name, Annotated[bool | None, switch]))
    options += [parameter_of(name, annotation) for name, annotation in MODEL_OPTIONS.items()]
    return expanded(verb, "plate_radius", options)


def _show_version(asked: bool) -> bool:
    if asked:
        from newtonjax import __version__

        print(f"newtonjax {__version__}")
        raise typer.Exit
    return asked


def before_a_verb(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    """Options that come before a verb."""


def own_columns(texts: list[str]) -> dict[str, str]:
    """A table's own names of columns, of `--column diameter_mm=D`."""
    columns = {}
    for text in texts:
        name, sign, column = (part.strip() for part in text.partition("="))
        if not (name and sign and column):
            raise ValueError(f"--column {text!r}; give NAME=COLUMN, such as diameter_mm=D")
        columns[name] = column
    return columns


def transfer_curve(text: str) -> float | str:
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


def _bits(text: str) -> int:
    if text not in ("8", "16"):
        raise ValueError(f"{text!r}; give 8 or 16")
    return int(text)


Shape = Annotated[Any, option(_shape, "ROWSxCOLUMNS", "Pixels of the image.", "those of the file, or 1024x1024")]
Bits = Annotated[Any, option(_bits, "8|16", "Bits of a pixel's value: 16, linear, or 8, sRGB.", "16")]
Wave = Annotated[Any, option(lamps.wavelength, "LENGTH|LINE", "Vacuum wavelength, or a line such as sodium.")]
Pixel = Annotated[
    float | None, option(quantities.positive_length, "LENGTH", "Size of a pixel at the object, in the gap.")
]
ScreenPixel = Annotated[
    float | None,
    option(
        quantities.positive_length, "LENGTH", "Distance of pixel centres on the screen.", "that of the file, or 5um"
    ),
]
PixelSd = Annotated[Any, option(quantities.length_sd, "LENGTH|PERCENT", "Standard deviation of the pixel size.")]
Light = Annotated[
    Any,
    option(
        lamps.light,
        "LAMP",
        "In place of the wavelength: a lamp of several lines, or of bands with --response, for all channels together.",
    ),
]
CameraResponse = Annotated[
    Path | None,
    typer.Option(
        "--response",
        metavar="CAMERA.csv",
        help="With light of bands: the camera's curves, columns wavelength_nm, red, green, blue.",
    ),
]
Channel = Annotated[
    Literal["red", "green", "blue"] | None,
    typer.Option(help="Channel that is measured.", show_default="the one with the clearest rings"),
]
WaveSd = Annotated[Any, option(quantities.length_sd, "LENGTH|PERCENT", "Standard deviation of the wavelength.")]
RadiusSd = Annotated[Any, option(quantities.length_sd, "LENGTH|PERCENT", "Standard deviation of the known radius.")]
KnownRadius = Annotated[
    float | None,
    option(quantities.positive_length, "LENGTH", "Known radius; then the wavelength or the pixel size is measured."),
]
SceneFile = Annotated[
    Path | None, typer.Option(metavar="SCENE.toml", help="Scene to trace instead of the gap formula.")
]
View = Annotated[
    Literal["reflected", "transmitted"] | None,
    typer.Option(help="Side that the rings are seen on.", show_default="reflected"),
]
Force = Annotated[bool, typer.Option("--force", help="Overwrite existing files.")]
OutputDir = Annotated[
    Path | None,
    typer.Option(
        metavar="FOLDER", help="Folder for the picture, the report (of a measurement also report.html) and the answer."
    ),
]
Json = Annotated[str | None, typer.Option("--json", metavar="FILE|-", help="Write the answer as JSON (- is stdout).")]
Transfer = Annotated[
    Any,
    option(transfer_curve, "linear|srgb|GAMMA", "Transfer curve of the file. Default: 8 bits sRGB, 16 bits linear."),
]
ScaleFrom = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Pixel size and distortion, from the JSON of `newtonjax scale`.")
]
WedgeLength = Annotated[
    float | None,
    option(quantities.positive_length, "LENGTH", "From the line of contact to what holds the wedge open."),
]
WedgeLengthSd = Annotated[Any, option(quantities.length_sd, "LENGTH|PERCENT", "Standard deviation of that length.")]
Columns = Annotated[
    list[str] | None,
    typer.Option("--column", metavar="NAME=COLUMN", help="The table's own name of a column; may be repeated."),
]
Separator = Annotated[
    Literal["comma", "semicolon", "tab", "bar", "blank"] | None,
    typer.Option(help="What stands between the table's cells.", show_default="found"),
]
Encoding = Annotated[
    str | None, typer.Option(metavar="NAME", help="Encoding of the table, such as cp1251.", show_default="found")
]
Vernier = Annotated[
    float | None,
    option(quantities.positive_length, "LENGTH", "Worth of a division of the vernier beside a main scale."),
]
GapIndex = Annotated[float | None, typer.Option(help="Refractive index of what fills the gap.", show_default="1.0")]
GapIndexSd = Annotated[Any, option(quantities.number_sd, "NUMBER|PERCENT", "Standard deviation of the gap's index.")]
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
MODEL_OPTIONS = {
    "prior": Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUE:SD",
            help="What is known of a number of a part, such as distortion=0:0.02, or with --mcmc of any that is drawn, "
            "such as radius=1m:2cm; may be repeated.",
            show_default="those that the report prints",
        ),
    ],
    "fix": Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUE", help="What the fit holds: gap=0nm, or centre=X,Y in pixels; may be repeated."
        ),
    ],
    "start": Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUE",
            help="What it starts from in place of a search: centre=X,Y with radius=1m or fringe-scale=1e-5 per px²; "
            "may be repeated.",
        ),
    ],
    "axis": Annotated[
        Any,
        option(
            assignments.place, "X,Y", "Pixel that the camera's axis goes through, of a cut photograph.", "the middle"
        ),
    ],
    "axis_sd": Annotated[
        float | None,
        option(quantities.number, "PIXELS", "Standard deviation of that, each way.", "1.5 % of half a diagonal"),
    ],
    "view_angle": Annotated[
        float | None,
        option(quantities.angle, "ANGLE", "Angle of view against the normal; 0deg: elliptic rings are the lens's."),
    ],
    "view_angle_sd": Annotated[
        Any, option(quantities.angle_sd, "ANGLE|PERCENT", "Standard deviation of the angle of view.")
    ],
    "noise": Annotated[
        Any,
        option(
            assignments.noise,
            "estimated|shot|FULL_WELL,READ_NOISE",
            "Noise that pixels are weighed by: its variance at each level of light, in proportion to the light, or in "
            "photoelectrons.",
            "all pixels alike",
        ),
    ],
}
