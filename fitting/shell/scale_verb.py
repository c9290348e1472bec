"""The verb `scale`: from a photograph of a grid, a ruler or a disc, or two points, to the pixel size."""

from pathlib import Path

import fitting
from fitting.shell.answer import Outputs
from fitting.shell.progress import progress
from fitting.shell.report_page import Measured

# Sizes of what is in a photograph; one of them is given.
_SIZES = ("division", "ruler", "disc_diameter")


def run(photo: Path | None, options: dict, outputs: Outputs) -> int:
    """Measure, report, write; the exit status."""
    if "points" not in options and all(options[name] is None for name in _SIZES):
        raise ValueError(
            "say what the photograph shows: a grid (--division 0.2mm), a ruler (--ruler 1mm, from line to line) or a "
            "disc or ring (--disc-diameter 10mm); or, without a photograph, two of its points in pixels "
            "(--point 120,340 --point 980,352 --distance 10mm)"
        )
    if photo is None:
        outputs.check(())
        return outputs.write(fitting.scale(**options), [])
    if not photo.is_file():
        raise FileNotFoundError(f"{photo} is not a file; give the path of a photograph of a grid, a ruler or a disc")
    if "points" in options:
        raise ValueError("two points and their distance need no photograph; leave it out, or give --division")
    outputs.check((photo,))
    with progress(f"measuring {photo.name}"):
        result = fitting.scale(photo, **options)
    return outputs.write(result, [Measured(photo, options)])


def points_of(texts: list[str]) -> list[list[float]]:
    """Places of `--point 120,340`. Raises ValueError for what is none."""
    try:
        return [[float(number) for number in text.split(",")] for text in texts]
    except ValueError:
        raise ValueError(f"--point {' '.join(texts)}; give X,Y in pixels, such as 120,340") from None
