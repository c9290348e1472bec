"""The command `newtonjax`: its verbs and their options. What is heavy is imported inside the verbs."""

import gc
import io
import sys
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from fitting.files import output
from fitting.shell import quantities, stopping
from fitting.shell.bench_options import with_bench_options
from fitting.shell.options import (
    Contact,
    Epsilon,
    Force,
    Json,
    MaskImage,
    OutputDir,
    Page,
    Pixel,
    PixelSd,
    PlateRadius,
    PlateSd,
    ScaleFrom,
    ScreenPixel,
    Shape,
    Transfer,
    View,
    Wave,
    WaveSd,
    one_by_one,
    option,
    own_columns,
)
from fitting.shell.study_verbs import design, sensitivity, tradeoff
from fitting.studies import exit_status

app = typer.Typer(
    name="newtonjax",
    help="Newton's rings: render them, and measure a lens radius from a photograph of them.",
    epilog="Quantities carry their unit (589.3nm, 12.75um, 2m). Exit status: 0 done, 2 wrong usage or unreadable "
    "input, 3 refused (no rings, straight fringes, undetermined), 4 not converged.",
    add_completion=False,
)


def main(arguments: list[str] | None = None) -> int:
    """Run the command; its exit status. Errors go to stderr in one line."""
    arguments = sys.argv[1:] if arguments is None else arguments
    # Importing and tracing make hundreds of thousands of objects that stay: looking through them for cycles at the
    # usual intervals takes as long as importing JAX.
    gc.set_threshold(200_000, 20, 20)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a λ must not cost the answer where the terminal has none
    if not arguments:
        return _fail("no verb given; give render, fit, scale, rings or another one (newtonjax --help explains them)")
    try:
        with stopping.watched():
            return app(args=one_by_one(arguments), prog_name="newtonjax", standalone_mode=False) or 0
    except typer.TyperException as error:
        return _fail(error.format_message())
    except (ValueError, OSError) as error:
        return _fail(str(error), exit_status(error))
    except typer.Abort:
        return 130


def _fail(message: str, status: int = 2) -> int:
    output.remove_empty_folders()
    print("newtonjax:", " ".join(message.split()), file=sys.stderr)
    return status


def _show_version(asked: bool) -> bool:
    if asked:
        from newtonjax import __version__

        print(f"newtonjax {__version__}")
        raise typer.Exit
    return asked


@app.callback()
def _command(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    """Options that come before a verb."""


@app.command()
@with_bench_options
def render(
    scene: Annotated[str, typer.Argument(metavar="SCENE", help="transmitted, reflected, wedge, or a file SCENE.toml.")],
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", metavar="FILE", help="PNG to write; or TIFF (.tif), which may be larger than memory."
        ),
    ],
    bench: dict[str, Any],
    shape: Shape = None,
    pixel_size: ScreenPixel = None,
    method: Annotated[
        Literal["closed-form", "chebyshev", "traced", "splat"] | None,
        typer.Option(help="Method; by default the cheapest one that meets the tolerance."),
    ] = None,
    nodes: Annotated[int | None, typer.Option(min=2, max=129, help="Nodes to a side, for chebyshev.")] = None,
    epsilon: Epsilon = None,
    tolerance: Annotated[
        float | None,
        typer.Option(help="Largest error of intensity over the peak.", show_default="0.001 without a method"),
    ] = None,
    expose: Annotated[
        bool, typer.Option("--expose", help="Add shot and read noise: a photograph of the image.")
    ] = False,
    seed: Annotated[int, typer.Option(min=0, max=2**63 - 1, help="Seed of the noise.")] = 0,
    bits: Annotated[Literal["8", "16"], typer.Option(help="16: linear; 8: sRGB.")] = "16",
    explain: Annotated[
        bool,
        typer.Option(
            "--explain", help="Also print what is modelled, what is not, and by how much that changes the image."
        ),
    ] = False,
    force: Force = False,
) -> int:
    """Render an image of Newton's rings, of an air wedge or of a scene file.

    Says which method was used, with how many nodes, and the estimated error.
    """
    from fitting.shell import render_verb

    how = render_verb.How(method, nodes, epsilon, tolerance)
    noise = seed if expose else None
    what = render_verb.Request(scene, output, bench, shape, pixel_size, how, noise, int(bits), explain, force)
    return render_verb.run(what)


@app.command()
def fit(
    photo: Annotated[Path, typer.Argument(metavar="PHOTO", help="Photograph of rings.")],
    wavelength: Wave = None,
    pixel_size: Pixel = None,
    pixel_size_sd: PixelSd = None,
    wavelength_sd: WaveSd = None,
    radius: Annotated[
        float | None,
        option(
            quantities.positive_length, "LENGTH", "Known radius; then the wavelength or the pixel size is measured."
        ),
    ] = None,
    view: View = None,
    scene: Annotated[
        Path | None, typer.Option(metavar="SCENE.toml", help="Scene to trace instead of the gap formula.")
    ] = None,
    transfer: Transfer = None,
    scale_from: ScaleFrom = None,
    contact: Contact = None,
    plate_radius: PlateRadius = None,
    plate_radius_sd: PlateSd = None,
    mask: MaskImage = None,
    page: Page = None,
    mcmc: Annotated[bool, typer.Option("--mcmc", help="Also draw from the posterior (emcee).")] = False,
    json: Json = None,
    output_dir: OutputDir = None,
    force: Force = False,
) -> int:
    """Measure the lens radius from a photograph of rings, with its standard deviation and where that comes from.

    Two of wavelength, pixel size and radius give the third. Without a pixel size the answer is the fringe scale.
    The fit adds an oblique view, a camera distortion and a flattened contact to the model if the image shows evidence
    for them.
    """
    from fitting.shell import fit_verb
    from fitting.shell.answer import Outputs

    options = fit_verb.FitOptions(
        wavelength, pixel_size, wavelength_sd, pixel_size_sd, radius, view, scene, transfer, scale_from, contact, mask,
        mcmc, plate_radius, plate_radius_sd, page,
    )  # fmt: skip
    return fit_verb.run(photo, options, Outputs(json, output_dir, force))


@app.command()
def scale(
    reticle: Annotated[Path, typer.Argument(metavar="RETICLE", help="Photograph of a ruled grid, at any angle.")],
    division: Annotated[float, option(quantities.positive_length, "LENGTH", "Distance of two lines of the grid.")],
    division_sd: Annotated[
        Any, option(quantities.length_sd, "LENGTH|PERCENT", "Standard deviation of that distance.")
    ] = None,
    transfer: Transfer = None,
    page: Page = None,
    json: Json = None,
    output_dir: OutputDir = None,
    force: Force = False,
) -> int:
    """Measure the pixel size on the object from a photograph of a ruled grid, with its standard deviation.

    The JSON that it writes is what `newtonjax fit --scale-from` reads.
    """
    from fitting.shell import scale_verb
    from fitting.shell.answer import Outputs

    options = {"division": division, "division_sd": division_sd, "transfer": transfer, "page": page}
    return scale_verb.run(reticle, options, Outputs(json, output_dir, force))


@app.command()
def rings(
    table: Annotated[Path, typer.Argument(metavar="TABLE.csv", help="Ring readings: a header and one row a reading.")],
    wavelength: Wave = None,
    wavelength_sd: WaveSd = None,
    pixel_size: Pixel = None,
    pixel_size_sd: PixelSd = None,
    radius: Annotated[
        float | None, option(quantities.positive_length, "LENGTH", "A known radius: then the wavelength comes out.")
    ] = None,
    radius_sd: Annotated[
        Any, option(quantities.length_sd, "LENGTH|PERCENT", "Standard deviation of the known radius.")
    ] = None,
    view: View = None,
    bright: Annotated[bool, typer.Option("--bright", help="The readings are of bright rings.")] = False,
    view_angle: Annotated[
        float | None, option(quantities.angle, "ANGLE", "Angle of view against the normal.", "0deg")
    ] = None,
    view_angle_sd: Annotated[
        float | None, option(quantities.angle, "ANGLE", "Standard deviation of the angle of view.")
    ] = None,
    gap_index: Annotated[float, typer.Option(help="Refractive index of what fills the gap.")] = 1.0,
    gap_index_sd: Annotated[float | None, typer.Option(help="Standard deviation of the gap's index.")] = None,
    expected_radius: Annotated[
        float | None,
        option(
            quantities.positive_length, "LENGTH", "Rough radius: warns where diameters, radii or units look swapped."
        ),
    ] = None,
    column: Annotated[
        list[str] | None, typer.Option(metavar="NAME=COLUMN", help="The table's own name of a column; may be repeated.")
    ] = None,
    json: Json = None,
    output_dir: OutputDir = None,
    force: Force = False,
) -> int:
    """Measure the lens radius from a table of ring readings: the slope of r² against order.

    Columns: order; left_mm with right_mm, or diameter_mm, or radius_mm, the first
    that is there (also um, cm, m, px; "diameter (mm)" and "diameter, mm" are the
    same); sd_mm (or sigma, error) of that reading, if stated; series, if several.
    With --radius instead of --wavelength the wavelength is measured.

    Ring 1 is the first dark ring outside of the centre: in contact r² = m λ R
    reflected, (2m - 1) λ R / 2 transmitted. With --bright it is the first bright
    one, and the formulas change places. The first order need not be right: only
    steps from ring to ring count. Readings off the line and orders that were
    miscounted are flagged; what is no line, or does not determine the radius, is
    refused with exit status 3.
    """
    from fitting.shell import rings_verb
    from fitting.shell.answer import Outputs

    options = {
        "wavelength": None if wavelength is None else wavelength.within(1.0),
        "wavelength_sd": wavelength.sd if wavelength is not None and wavelength_sd is None else wavelength_sd,
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
    }
    return rings_verb.run(table, options, Outputs(json, output_dir, force))


app.command()(tradeoff)
app.command()(sensitivity)
app.command()(design)


@app.command()
def demo(
    output_dir: Annotated[Path, typer.Option(metavar="FOLDER", help="Folder for the results.")] = Path(
        "newtonjax-demo"
    ),
    force: Force = False,
) -> int:
    """Fit the sample photograph that comes along, and show the true radius beside the answer."""
    from fitting.shell import fit_verb

    return fit_verb.demo(output_dir, force)
