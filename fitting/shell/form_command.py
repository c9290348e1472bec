"""The verb `form` and its options."""

from pathlib import Path
from typing import Annotated

import typer

from fitting.shell import quantities
from fitting.shell.lamps import in_air
from fitting.shell.options import (
    Force,
    Json,
    MaskImage,
    OutputDir,
    Page,
    Pixel,
    PixelSd,
    Transfer,
    Wave,
    WaveSd,
    option,
)


def circle(text: str) -> tuple[float, float, float]:
    """Column, row and radius of "512,500,480". Raises ValueError for anything else."""
    parts = text.split(",")
    if len(parts) != 3:
        raise ValueError(f"{text!r} is no circle; give column, row and radius in pixels, as in 512,500,480")
    column, row, radius = map(quantities.number, parts)
    return column, row, radius


def form(
    photos: Annotated[
        list[Path],
        typer.Argument(metavar="PHOTO", help="Picture of fringes of equal thickness; or three frames and more."),
    ],
    wavelength: Wave = None,
    wavelength_sd: WaveSd = None,
    pixel_size: Pixel = None,
    pixel_size_sd: PixelSd = None,
    reference_radius: Annotated[
        float | None,
        option(quantities.length, "LENGTH", "Radius of the reference, positive where it is hollow.", "flat"),
    ] = None,
    pupil: Annotated[
        tuple | None, option(circle, "X,Y,R", "The aperture: its centre and radius in pixels.", "looked for")
    ] = None,
    pupil_sd: Annotated[float | None, typer.Option(help="Standard deviation of the aperture's rim, in pixels.")] = None,
    terms: Annotated[
        int | None,
        typer.Option(help="Zernike terms to report: 6, 10, 15, 21, 28 or 36.", show_default="by evidence"),
    ] = None,
    sign: Annotated[
        int | None,
        typer.Option(help="A term that is positive (4: power), or minus one that is negative: the sign of all."),
    ] = None,
    distortion_sd: Annotated[
        float, typer.Option(help="Standard deviation of the camera's distortion at the aperture's rim, as a share.")
    ] = 0.0,
    transfer: Transfer = None,
    mask: MaskImage = None,
    page: Page = None,
    json: Json = None,
    output_dir: OutputDir = None,
    force: Force = False,
) -> int:
    """Measure the form of a surface from its fringes, in the words of ISO 10110-5.

    Power, astigmatism and irregularity, each with a standard deviation and where it
    comes from. Heights are in fringe spacings, with a wavelength also in nanometres;
    with a pixel size two radii of curvature follow. One picture wants 6 fringes and
    more over the aperture, best open ones. Three frames and more, stepped in phase by
    parts of a fringe that need not be known, want none; the frame that contradicts
    the others is named.
    """
    from fitting.shell import form_verb
    from fitting.shell.answer import Outputs

    options = {
        **in_air(wavelength, wavelength_sd),
        "pixel_size": pixel_size,
        "pixel_size_sd": pixel_size_sd,
        "reference_radius": reference_radius,
        "pupil": pupil,
        "pupil_sd": pupil_sd,
        "terms": terms,
        "sign": sign,
        "distortion_sd": distortion_sd,
        "transfer": transfer,
        "mask": mask,
        "page": page,
    }
    return form_verb.run(photos, options, Outputs(json, output_dir, force))
