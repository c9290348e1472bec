"""The verbs that study a bench: `tradeoff`, `sensitivity`. What is heavy is imported inside them."""

from pathlib import Path
from typing import Annotated

import typer

from fitting.options import Force, OutputDir, ScreenPixel, Shape

Bench = Annotated[Path, typer.Argument(metavar="SCENE.toml", help="The bench, with its [camera].")]


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
    from fitting import tradeoff_verb

    return tradeoff_verb.run(scene, shape, pixel_size, output_dir, force, splat)


def sensitivity(
    scene: Bench,
    accuracy: Annotated[float, typer.Option(help="Of the target, as a fraction of it.")] = 1e-3,
    target: Annotated[str, typer.Option(metavar="NAME", help="The number that is measured.")] = "radius",
    free: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="What a fit finds beside it; may be repeated.", show_default="as fit does"),
    ] = None,
    output_dir: OutputDir = None,
    force: Force = False,
) -> int:
    """Say how well every number of a bench must be known to measure the radius.

    By what a fit with that number wrong would find, and what noise alone leaves. With
    --output-dir a picture of it, of the image's derivatives too, and CSV and JSON.
    """
    from fitting import sensitivity_verb

    return sensitivity_verb.run(scene, target, accuracy, free, output_dir, force)
