"""The verb that measures many photographs: `batch`. What is heavy is imported inside it."""

from pathlib import Path
from typing import Annotated, Any

import typer

from fitting.shell.options import (
    KnownRadius,
    MaskImage,
    Page,
    Pixel,
    PixelSd,
    PlateRadius,
    PlateSd,
    RadiusSd,
    ScaleFrom,
    SceneFile,
    Transfer,
    View,
    Wave,
    WaveSd,
    with_model_options,
)


@with_model_options
def batch(
    photos: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="PHOTOS",
            help="Photographs, folders, patterns ('*.tif'), or a manifest MANIFEST.csv.",
        ),
    ] = None,
    output_dir: Annotated[
        Path, typer.Option(metavar="FOLDER", help="Folder for the rows, the table and the control chart.")
    ] = Path("batch"),
    workers: Annotated[
        int | None, typer.Option(min=1, max=1024, help="Worker processes.", show_default="one a core")
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="Dask scheduler whose workers measure, as in tcp://10.0.0.1:8786."),
    ] = None,
    follow: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="Also measure photographs as they arrive here, until Ctrl-C.")
    ] = None,
    retry: Annotated[bool, typer.Option("--retry", help="Measure again what has failed.")] = False,
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
    **model: Any,
) -> int:
    """Measure many photographs, in several processes, and show which radius is not like the others.

    Every page of a file counts. Rows are written to results.jsonl as soon as they are
    there: after a stop, or a kill, the same command goes on where it was. summary.csv is
    the table, chart.png the radius against time with its limits.

    A manifest is a CSV file with a column photo, and columns named as options are
    (pixel_size, wavelength, ...) where photographs differ: 12.75um, sodium.

    Exit status: 0 all measured, 3 some refused, 4 some not converged, 5 some unreadable.
    """
    from fitting.shell import batch_verb
    from fitting.shell.fit_arguments import FitOptions
    from fitting.shell.fit_verb import model_of
    from fitting.shell.photographs import Workers

    options = FitOptions(
        wavelength, pixel_size, wavelength_sd, pixel_size_sd, radius, view, scene, transfer, scale_from,
        mask=mask, plate_radius=plate_radius, plate_radius_sd=plate_radius_sd, page=page, radius_sd=radius_sd,
        **model_of(model),
    )  # fmt: skip
    request = batch_verb.Request(photos or [], options, output_dir, Workers(workers, scheduler), follow, retry)
    return batch_verb.run(request)
