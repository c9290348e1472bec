"""The verb `testplate` and its options."""

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from fitting.shell import quantities
from fitting.shell.form_command import circle
from fitting.shell.lamps import in_air
from fitting.shell.options import Force, Json, MaskImage, OutputDir, Page, Transfer, Wave, WaveSd, option


def plate(
    photos: Annotated[
        list[Path],
        typer.Argument(metavar="PHOTO", help="Picture of the fringes; or three and more, each pressed further."),
    ],
    plate_radius: Annotated[
        float | None,
        option(quantities.length, "LENGTH", "Radius of the test plate, positive where it is hollow."),
    ] = None,
    plate_radius_sd: Annotated[
        Any, option(quantities.length_sd, "LENGTH|PERCENT", "Standard deviation of the plate's radius.")
    ] = None,
    wavelength: Wave = None,
    wavelength_sd: WaveSd = None,
    diameter: Annotated[
        float | None, option(quantities.positive_length, "LENGTH", "Diameter of the aperture that is seen.")
    ] = None,
    diameter_sd: Annotated[
        Any, option(quantities.length_sd, "LENGTH|PERCENT", "Standard deviation of the diameter.")
    ] = None,
    light_picture: Annotated[
        Path | None, typer.Option(metavar="PHOTO", help="Picture of the light without fringes, by the same camera.")
    ] = None,
    rings_move: Annotated[
        Literal["outwards", "inwards"] | None,
        typer.Option(help="Which way rings move on pressing: outwards where the gap grows outwards."),
    ] = None,
    pupil: Annotated[
        tuple | None, option(circle, "X,Y,R", "The aperture: its centre and radius in pixels.", "looked for")
    ] = None,
    pupil_sd: Annotated[float | None, typer.Option(help="Standard deviation of the aperture's rim, in pixels.")] = None,
    transfer: Transfer = None,
    mask: MaskImage = None,
    page: Page = None,
    json: Json = None,
    output_dir: OutputDir = None,
    force: Force = False,
) -> int:
    """Measure a part under a test plate: power, irregularity and radius from 0.3 to 10 fringes.

    Power in fringes of half a wavelength, irregularity in the words of ISO 10110-5, with
    --plate-radius, --wavelength and --diameter the part's radius. Where few fringes do
    not suffice, one of these is asked for: three pictures, each pressed by about a third
    of a fringe more; 3 fringes of tilt; --light-picture.
    """
    from fitting.shell import testplate_verb
    from fitting.shell.answer import Outputs

    options = {
        "plate_radius": plate_radius,
        "plate_radius_sd": plate_radius_sd,
        **in_air(wavelength, wavelength_sd),
        "diameter": diameter,
        "diameter_sd": diameter_sd,
        "light_picture": light_picture,
        "rings_move": rings_move,
        "pupil": pupil,
        "pupil_sd": pupil_sd,
        "transfer": transfer,
        "mask": mask,
        "page": page,
    }
    return testplate_verb.run(photos, options, Outputs(json, output_dir, force))
