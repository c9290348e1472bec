"""The verbs that study a bench: `tradeoff`, `sensitivity`, `design`. What is heavy is imported inside them."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from fitting.shell.options import Force, OutputDir, ScreenPixel, Shape

Known = Annotated[
    list[str] | None,
    typer.Option(metavar="NAME=SD", help="How well a number that the fit holds is known: 5nm, or 0.1%."),
]
Bench = Annotated[Path, typer.Argument(metavar="SCENE.toml", help="The bench, with its camera.")]


def tradeoff(
    scene: Bench,
    shape: Shape = None,
    pixel_size: ScreenPixel = None,
    splat: Annotated[bool, typer.Option("--splat", help="The algorithm of 2021 too, which takes long.")] = False,
    output_dir: OutputDir = None,
    force: Force = False,
) -> int:
    """Time every method for a scene, beside its errors and the bias of the radius.

    Of a fit with that method as its model, in parts per million. Rays at every pixel
    are the reference. With --output-dir a picture and the table as CSV and JSON.
    """
    from fitting.shell import tradeoff_verb

    return tradeoff_verb.run(scene, shape, pixel_size, output_dir, force, splat)


def sensitivity(
    scene: Bench,
    accuracy: Annotated[float, typer.Option(help="Of the target, as a fraction of it.")] = 1e-3,
    target: Annotated[str, typer.Option(metavar="NAME", help="The number that is measured.")] = "radius",
    free: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="What a fit finds beside it; may be repeated.", show_default="as fit does"),
    ] = None,
    known: Known = None,
    draws: Annotated[
        int | None,
        typer.Option(
            metavar="N", help="With --known: N fits, times the numbers and two; 32, 64, 128 ...", show_default="128"
        ),
    ] = None,
    shape: Shape = None,
    pixel_size: ScreenPixel = None,
    output_dir: OutputDir = None,
    force: Force = False,
) -> int:
    """Say how well every number of a bench must be known to measure the radius.

    By what a fit with that number wrong would find, and what noise alone
    leaves. With --output-dir a picture of it, of the image's derivatives too,
    and CSV and JSON.

    With --known also what errors of these sizes do together, by fits: their
    shares of the variance (Sobol), and a file of all fits (NetCDF) that goes
    on, with --force, where Ctrl-C broke it off. A coarser --shape of the same
    field tells nearly the same.
    """
    from fitting.shell import sensitivity_verb

    return sensitivity_verb.run(
        scene, (shape, pixel_size), target, accuracy, free, known or [], draws, output_dir, force
    )


def design(
    scene: Bench,
    vary: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=LOW:HIGH", help="Bounds of a number, with units: wavelength=400nm:700nm, ..."),
    ] = None,
    minimize: Annotated[str, typer.Option(metavar="NAME_sd", help="Whose standard deviation.")] = "radius_sd",
    known: Known = None,
    choose: Annotated[
        list[str] | None, typer.Option(metavar="NAME=A,B,...", help="Values to choose from: wavelength=405nm,532nm.")
    ] = None,
    over: Annotated[
        str | None, typer.Option(metavar="LOW:HIGH", help="Range of the target that the bench must measure.")
    ] = None,
    robust: Annotated[Literal["worst", "mean"], typer.Option(help="Of that range.")] = "worst",
    pixels_per_fringe: Annotated[float, typer.Option(help="At the finest fringe, at least.")] = 2.5,
    fill: Annotated[float, typer.Option(help="Share of the full well that the brightest pixel takes.")] = 0.9,
    rings: Annotated[
        str, typer.Option(metavar="LEAST:MOST", help="Rings in the field; either may be left out.")
    ] = "0.5:",
    starts: Annotated[int, typer.Option(min=1, max=1024, help="Searches from other places.")] = 6,
    shape: Shape = None,
    pixel_size: ScreenPixel = None,
    output_dir: OutputDir = None,
    force: Force = False,
) -> int:
    """Find the bench that measures the radius best, within bounds and limits.

    What may vary are the numbers that `sensitivity` names, and the field (the side of the
    image that is used). Counted are noise and what --known says. With --output-dir the
    bench as a scene file, a picture, and the answer as CSV and JSON.
    """
    from fitting.shell import design_verb

    limits = {"pixels_per_fringe": pixels_per_fringe, "fill": fill, "rings": rings}
    ranges = {"vary": vary or [], "known": known or [], "choose": choose or [], "over": over}
    search = {"minimize": minimize, "robust": robust, "starts": starts}
    return design_verb.run(scene, (shape, pixel_size), ranges, limits, search, output_dir, force)
