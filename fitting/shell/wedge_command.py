"""The verb `wedge` and its options."""

from pathlib import Path
from typing import Annotated

import typer

from fitting.shell.lamps import in_air
from fitting.shell.options import (
    Columns,
    Encoding,
    Force,
    GapIndex,
    GapIndexSd,
    Json,
    MaskImage,
    OutputDir,
    Page,
    Pixel,
    PixelSd,
    ScaleFrom,
    Separator,
    Transfer,
    Vernier,
    Wave,
    WaveSd,
    WedgeLength,
    WedgeLengthSd,
    own_columns,
)


def wedge(
    source: Annotated[
        Path,
        typer.Argument(metavar="PHOTO|TABLE", help="Photograph of straight fringes, or a table of them; - is stdin."),
    ],
    wavelength: Wave = None,
    wavelength_sd: WaveSd = None,
    pixel_size: Pixel = None,
    pixel_size_sd: PixelSd = None,
    scale_from: ScaleFrom = None,
    length: WedgeLength = None,
    length_sd: WedgeLengthSd = None,
    gap_index: GapIndex = None,
    gap_index_sd: GapIndexSd = None,
    transfer: Transfer = None,
    mask: MaskImage = None,
    page: Page = None,
    column: Columns = None,
    separator: Separator = None,
    encoding: Encoding = None,
    vernier: Vernier = None,
    json: Json = None,
    output_dir: OutputDir = None,
    force: Force = False,
) -> int:
    """Measure the angle of an air wedge by its straight fringes, and with --length the thickness of what holds it open.

    Of a photograph: with --wavelength, and --pixel-size or --scale-from; without
    these the spacing in pixels is the answer. It wants 4 fringes and more.

    Of a table: columns order; position_mm across the fringes (also um, cm, m);
    sd_mm, if stated. With --length, from the line of contact, the thickness there
    comes out: of a hair, or a foil.
    """
    from fitting.shell import wedge_verb
    from fitting.shell.answer import Outputs

    both = {
        **in_air(wavelength, wavelength_sd),
        "length": length,
        "length_sd": length_sd,
        "gap_index": 1.0 if gap_index is None else gap_index,
        "gap_index_sd": gap_index_sd,
    }
    of_photo = {
        "pixel_size": pixel_size,
        "pixel_size_sd": pixel_size_sd,
        "scale": scale_from,
        "transfer": transfer,
        "mask": mask,
        "page": page,
    }
    of_table = {
        "columns": own_columns(column or []) or None,
        "separator": separator,
        "encoding": encoding,
        "vernier": vernier,
    }
    return wedge_verb.run(source, both, of_photo, of_table, Outputs(json, output_dir, force))
