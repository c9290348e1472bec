"""The verb `together`: one answer from several photographs. What is heavy is imported inside it."""

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from fitting.shell import quantities
from fitting.shell.options import (
    Force,
    Json,
    KnownRadius,
    MaskImage,
    OutputDir,
    Page,
    Pixel,
    PixelSd,
    PlateRadius,
    PlateSd,
    RadiusSd,
    ScaleFrom,
    Transfer,
    View,
    Wave,
    WaveSd,
    option,
    with_model_options,
)


@with_model_options
def together(
    photos: Annotated[
        list[Path], typer.Argument(metavar="PHOTOS", help="Two photographs or more, or a manifest MANIFEST.csv.")
    ],
    share: Annotated[
        str,
        typer.Option(
            metavar="NAMES",
            help="What is one in all: distortion, radius, pixel_size, wavelength, gap_index, gap; none for nothing.",
        ),
    ] = "pixel_size,distortion",
    wavelength: Wave = None,
    pixel_size: Pixel = None,
    pixel_size_sd: PixelSd = None,
    wavelength_sd: WaveSd = None,
    radius: KnownRadius = None,
    radius_sd: RadiusSd = None,
    light: Annotated[
        Literal["unknown"] | None,
        typer.Option(help="Of colour photographs of one set-up: neither lamp nor camera is known; ratios alone."),
    ] = None,
    view: View = None,
    transfer: Transfer = None,
    scale_from: ScaleFrom = None,
    plate_radius: PlateRadius = None,
    plate_radius_sd: PlateSd = None,
    mask: MaskImage = None,
    page: Page = None,
    gap_range: Annotated[
        Any,
        option(
            quantities.length_range,
            "LOW,HIGH",
            "With --share gap: where it is sought, as in 0um,5um.",
            "up to half of the synthetic wavelength",
        ),
    ] = None,
    json: Json = None,
    output_dir: OutputDir = None,
    force: Force = False,
    **model: Any,
) -> int:
    """Measure several photographs in one likelihood: lenses under one camera, or one lens in several pictures.

    The camera's distortion is one number for all; in the ratios of radii, each over
    the first, the scale cancels and may be unknown. With --share radius the pictures
    are of one lens, and one radius comes out. A picture that contradicts the others
    is named. With --light unknown all colours are fitted under one free spectrum: the
    ratios need no wavelength. A manifest, as of `newtonjax batch`, has wavelengths and so on by picture.
    """
    from fitting.shell import together_verb
    from fitting.shell.answer import Outputs
    from fitting.shell.fit_arguments import FitOptions
    from fitting.shell.fit_verb import model_of

    options = FitOptions(
        wavelength, pixel_size, wavelength_sd, pixel_size_sd, radius, view, None, transfer, scale_from,
        mask=mask, plate_radius=plate_radius, plate_radius_sd=plate_radius_sd, page=page, radius_sd=radius_sd,
        light=light, **model_of(model),
    )  # fmt: skip
    shared = tuple(name.strip().replace("-", "_") for name in share.split(",") if name.strip() not in ("", "none"))
    return together_verb.run(photos, shared, options, Outputs(json, output_dir, force), gap_range)
