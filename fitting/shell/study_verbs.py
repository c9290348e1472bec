"""The verbs that study a bench: `tradeoff`, `sensitivity`, `design`. What is heavy is imported inside them."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from fitting.shell.options import Force, OutputDir, ScreenPixel, Shape

Sd = Annotated[
    list[str] | None,
    typer.Option("--sd", metavar="NAME=SD", help="Standard deviation of a number that the fit is given: 5nm, or 0.1%."),
]
Bench = Annotated[Path, typer.Argument(metavar="SCENE.toml", help="The scene, with its camera.")]
Target = Annotated[
    str | None,
    typer.Option(
        metavar="NAME", help="The number that is measured.", show_default="radius, or wedge_angle of plane faces"
    ),
]


def tradeoff(
    scene: Bench,
    shape: Shape = None,
    pixel_size: ScreenPixel = None,
    splat: Annotated[
        bool, typer.Option("--splat", help="Also the algorithm of 2021, which takes seconds to minutes.")
    ] = False,
    output_dir: OutputDir = None,
    force: Force = False,
) -> int:
    """Time every method for a scene, with its errors and the bias of the radius that it causes.

    The bias is that of a fit with the method as its model, in parts per million. Rays at
    every pixel are the reference. --output-dir adds a figure and the table as CSV and JSON.
    """
    from fitting.shell import tradeoff_verb

    return tradeoff_verb.run(scene, shape, pixel_size, output_dir, force, splat)


def sensitivity(
    scene: Bench,
    relative_accuracy: Annotated[
        float, typer.Option(help="Accuracy of the target to reach, as a fraction of it.")
    ] = 1e-3,
    target: Target = None,
    free: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="A number that the fit determines with it; may be repeated.",
            show_default="as fit does",
        ),
    ] = None,
    sd: Sd = None,
    draws: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            help="With --sd: number of draws, a power of two from 32 on. Fits: draws times (numbers + 2).",
            show_default="128",
        ),
    ] = None,
    shape: Shape = None,
    pixel_size: ScreenPixel = None,
    output_dir: OutputDir = None,
    force: Force = False,
) -> int:
    """Tolerance of each number of a scene for a given accuracy of the radius.

    The tolerance is the error of a number that moves the radius by that accuracy; noise
    alone is reported too. --output-dir adds a figure with the derivatives of the image,
    CSV and JSON.

    With --sd also the effect of errors of these sizes together, by fits: their fractions
    of the variance (Sobol), and a NetCDF file of all fits. After Ctrl-C the same command
    with --force continues it. A coarser --shape of the same field gives nearly the same.
    """
    from fitting.shell import sensitivity_verb

    return sensitivity_verb.run(
        scene, (shape, pixel_size), target, relative_accuracy, free, sd or [], draws, output_dir, force
    )


def design(
    scene: Bench,
    vary: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=LOW:HIGH", help="Bounds of a number that may change: wavelength=400nm:700nm."),
    ] = None,
    target: Target = None,
    sd: Sd = None,
    choose: Annotated[
        list[str] | None, typer.Option(metavar="NAME=A,B,...", help="Values to choose from: wavelength=405nm,532nm.")
    ] = None,
    over: Annotated[
        str | None, typer.Option(metavar="LOW:HIGH", help="Range of the target that the bench must measure.")
    ] = None,
    robust: Annotated[
        Literal["worst", "mean"],
        typer.Option(help="Minimize the worst or the mean relative standard deviation over that range."),
    ] = "worst",
    pixels_per_fringe: Annotated[float, typer.Option(help="Pixels to the finest fringe, at least.")] = 2.5,
    fill_fraction: Annotated[
        float, typer.Option(help="Fraction of the full well that the brightest pixel may take.")
    ] = 0.9,
    rings: Annotated[
        str, typer.Option(metavar="LEAST:MOST", help="Rings in the field; either may be left out.")
    ] = "0.5:",
    starts: Annotated[
        int,
        typer.Option(min=1, max=1024, help="Searches from quasi-random starts, besides that from the scene itself."),
    ] = 6,
    shape: Shape = None,
    pixel_size: ScreenPixel = None,
    output_dir: OutputDir = None,
    force: Force = False,
) -> int:
    """Find the scene that measures the radius with the smallest relative standard deviation.

    The numbers that `sensitivity` lists may vary, and the field (the side of the image that
    is used), within bounds and limits. Noise and the deviations of --sd count. --output-dir
    adds the designed scene as a file, a figure, and the result as CSV and JSON.
    """
    from fitting.shell import design_verb

    limits = {"pixels_per_fringe": pixels_per_fringe, "fill_fraction": fill_fraction, "rings": rings}
    ranges = {"vary": vary or [], "sd": sd or [], "choose": choose or [], "over": over}
    search = {"target": target, "robust": robust, "starts": starts}
    return design_verb.run(scene, (shape, pixel_size), ranges, limits, search, output_dir, force)
