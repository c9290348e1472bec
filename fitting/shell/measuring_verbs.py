"""The verbs that measure: `fit`, `scale`, `rings`, `compare`. What is heavy is imported inside them."""

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from fitting.shell import quantities
from fitting.shell.lamps import in_air
from fitting.shell.options import (
    CameraResponse,
    Channel,
    Columns,
    Encoding,
    Force,
    GapIndex,
    GapIndexSd,
    Json,
    KnownRadius,
    Light,
    MaskImage,
    OutputDir,
    Page,
    Pixel,
    PixelSd,
    PlateRadius,
    PlateSd,
    RadiusSd,
    ScaleFrom,
    SceneFile,
    Separator,
    Transfer,
    Vernier,
    View,
    Wave,
    WaveSd,
    option,
    own_columns,
    with_model_options,
)

Quantity = Literal["radius", "wavelength", "pixel-size", "gap-index"]


@with_model_options
def fit(
    photo: Annotated[Path, typer.Argument(metavar="PHOTO", help="Photograph of rings.")],
    wavelength: Wave = None,
    pixel_size: Pixel = None,
    pixel_size_sd: PixelSd = None,
    wavelength_sd: WaveSd = None,
    radius: KnownRadius = None,
    radius_sd: RadiusSd = None,
    view: View = None,
    scene: SceneFile = None,
    transfer: Transfer = None,
    scale_from: ScaleFrom = None,
    plate_radius: PlateRadius = None,
    plate_radius_sd: PlateSd = None,
    mask: MaskImage = None,
    page: Page = None,
    light: Light = None,
    response: CameraResponse = None,
    channel: Channel = None,
    mcmc: Annotated[bool, typer.Option("--mcmc", help="Also draw from the posterior (emcee).")] = False,
    steps: Annotated[
        int | None, typer.Option(min=8, metavar="STEPS", help="Of each walker, with --mcmc.", show_default="2000")
    ] = None,
    json: Json = None,
    output_dir: OutputDir = None,
    force: Force = False,
    **model: Any,
) -> int:
    """Measure the lens radius from a photograph of rings, with its standard deviation and where that comes from.

    Two of wavelength, pixel size and radius give the third. Without a pixel size the answer is the fringe scale.
    The fit adds an oblique view, a camera distortion and a flattened contact to the model if the image shows evidence
    for them.
    """
    from fitting.shell import fit_verb
    from fitting.shell.answer import Outputs
    from fitting.shell.fit_arguments import FitOptions

    options = FitOptions(
        wavelength, pixel_size, wavelength_sd, pixel_size_sd, radius, view, scene, transfer, scale_from,
        mask=mask, mcmc=mcmc, steps=steps, plate_radius=plate_radius, plate_radius_sd=plate_radius_sd, page=page,
        radius_sd=radius_sd, light=light, response=response, channel=channel, **fit_verb.model_of(model),
    )  # fmt: skip
    return fit_verb.run(photo, options, Outputs(json, output_dir, force))


def scale(
    reticle: Annotated[
        Path | None, typer.Argument(metavar="[PHOTO]", help="Photograph of a grid, a ruler or a disc, at any angle.")
    ] = None,
    division: Annotated[
        float | None, option(quantities.positive_length, "LENGTH", "Distance of two lines of the grid.")
    ] = None,
    division_sd: Annotated[
        Any, option(quantities.length_sd, "LENGTH|PERCENT", "Standard deviation of that distance.")
    ] = None,
    ruler: Annotated[
        float | None, option(quantities.positive_length, "LENGTH", "Of a ruler: distance of neighbouring lines.")
    ] = None,
    ruler_sd: Annotated[
        Any, option(quantities.length_sd, "LENGTH|PERCENT", "Standard deviation of that distance.")
    ] = None,
    disc_diameter: Annotated[
        float | None, option(quantities.positive_length, "LENGTH", "Diameter of a disc; outer one of a ring.")
    ] = None,
    disc_diameter_sd: Annotated[
        Any, option(quantities.length_sd, "LENGTH|PERCENT", "Standard deviation of the diameter.")
    ] = None,
    point: Annotated[
        list[str] | None, typer.Option(metavar="X,Y", help="A place in pixels, given twice, with --distance.")
    ] = None,
    distance: Annotated[
        float | None, option(quantities.positive_length, "LENGTH", "Distance of the two points on the object.")
    ] = None,
    distance_sd: Annotated[
        Any, option(quantities.length_sd, "LENGTH|PERCENT", "Standard deviation of that distance.")
    ] = None,
    pointing_sd: Annotated[float, typer.Option(help="Standard deviation of each point, in pixels.")] = 0.5,
    transfer: Transfer = None,
    mask: MaskImage = None,
    page: Page = None,
    json: Json = None,
    output_dir: OutputDir = None,
    force: Force = False,
) -> int:
    """Measure the pixel size on the object from a photograph of a grid, a ruler or a disc, or from two points.

    The JSON that it writes is what `newtonjax fit --scale-from` reads. Photograph at
    the same place a grid (--division 0.1mm), which tells both axes and is best; a
    ruler (--ruler 1mm), which tells the axis along it; a disc, or a ring by its outer
    diameter (--disc-diameter 2mm), least of all overexposed; or read two lines of a ruler in pixels, and give them as
    --point 120,340 --point 980,352 --distance 10mm.
    """
    from fitting.shell import scale_verb
    from fitting.shell.answer import Outputs

    options = {
        "division": division,
        "division_sd": division_sd,
        "ruler": ruler,
        "ruler_sd": ruler_sd,
        "disc_diameter": disc_diameter,
        "disc_diameter_sd": disc_diameter_sd,
        "transfer": transfer,
        "mask": mask,
        "page": page,
    }
    if point or distance is not None:
        places = scale_verb.points_of(point or [])
        options = {"points": places, "distance": distance, "distance_sd": distance_sd, "pointing_sd": pointing_sd}
    return scale_verb.run(reticle, options, Outputs(json, output_dir, force))


def rings(
    tables: Annotated[
        list[Path],
        typer.Argument(
            metavar="TABLE", help="Ring readings (CSV, text, .xlsx, .ods): a header and one row a reading; - is stdin."
        ),
    ],
    wavelength: Wave = None,
    wavelength_sd: WaveSd = None,
    pixel_size: Pixel = None,
    pixel_size_sd: PixelSd = None,
    radius: Annotated[
        float | None, option(quantities.positive_length, "LENGTH", "A known radius: then the wavelength comes out.")
    ] = None,
    radius_sd: RadiusSd = None,
    view: View = None,
    bright: Annotated[bool, typer.Option("--bright", help="The readings are of bright rings.")] = False,
    view_angle: Annotated[
        float | None, option(quantities.angle, "ANGLE", "Angle of view against the normal.", "0deg")
    ] = None,
    view_angle_sd: Annotated[
        Any, option(quantities.angle_sd, "ANGLE|PERCENT", "Standard deviation of the angle of view.")
    ] = None,
    gap_index: GapIndex = None,
    gap_index_sd: GapIndexSd = None,
    compare: Annotated[
        Quantity | None, typer.Option(help="Of several tables: one quantity; of gap-index the first table is in air.")
    ] = None,
    expected_radius: Annotated[
        float | None,
        option(
            quantities.positive_length, "LENGTH", "Rough radius: warns where diameters, radii or units look swapped."
        ),
    ] = None,
    column: Columns = None,
    separator: Separator = None,
    encoding: Encoding = None,
    vernier: Vernier = None,
    json: Json = None,
    output_dir: OutputDir = None,
    force: Force = False,
) -> int:
    """Measure the lens radius from a table of ring readings: the slope of r² against order.

    Columns: order; left_mm with right_mm, or diameter_mm, or radius_mm, the first
    that is there (also um, cm, m, px; "diameter (mm)", "D / mm", "Durchmesser in mm"
    are the same); sd_mm (or sigma, error) of that reading, if stated; series, if
    several. The report says what was understood; --column, --separator, --encoding
    overrule it. With --radius instead of --wavelength the wavelength is measured,
    with both the pixel size (readings in px), or the index of what fills the gap.

    Ring 1 is the first dark ring outside of the centre: in contact r² = m λ R
    reflected, (2m - 1) λ R / 2 transmitted. With --bright it is the first bright
    one, and the formulas change places. The first order need not be right: only
    steps from ring to ring count. Readings off the line and orders that were
    miscounted are flagged; what is no line, or does not determine the radius, is
    refused with exit status 3.

    A table with position_mm, of straight fringes, is measured by `newtonjax wedge`.
    """
    from fitting.shell import rings_verb
    from fitting.shell.answer import Outputs

    options = {
        **in_air(wavelength, wavelength_sd),
        "pixel_size": pixel_size,
        "pixel_size_sd": pixel_size_sd,
        "radius": radius,
        "radius_sd": radius_sd,
        "view": view or "reflected",
        "bright": bright,
        "view_angle": view_angle or 0.0,
        "view_angle_sd": view_angle_sd,
        "gap_index": gap_index,
        "gap_index_sd": gap_index_sd,
        "expected_radius": expected_radius,
        "columns": own_columns(column or []),
        "separator": separator,
        "encoding": encoding,
        "vernier": vernier,
    }
    outputs = Outputs(json, output_dir, force)
    if compare is not None:
        return rings_verb.run_all(tables, options, compare.replace("-", "_"), outputs)
    if len(tables) > 1:
        raise ValueError("several tables are given; say what is asked of them, such as --compare gap-index or radius")
    return rings_verb.run(tables[0], options, outputs)


def compare(
    results: Annotated[list[Path], typer.Argument(metavar="RESULT.json", help="Results that fit or rings wrote.")],
    of: Annotated[Quantity, typer.Option(help="What is asked; of gap-index the first result is in air.")],
    json: Json = None,
    output_dir: OutputDir = None,
    force: Force = False,
) -> int:
    """Compare saved results: their mean with the spread between them, each over the first, or a liquid's index.

    Rings of one lens in a liquid are narrower than in air: the ratio of the slopes is the index, whatever the lens,
    the scale and the wavelength are.
    """
    from fitting.shell import rings_verb
    from fitting.shell.answer import Outputs

    return rings_verb.run_compare(results, of.replace("-", "_"), Outputs(json, output_dir, force))
