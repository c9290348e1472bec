"""Images as TIFF files that are written block by block, and so may be larger than memory."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from fitting.parameters import output, png


def write(path: Path, shape: tuple[int, int], blocks: Iterable[tuple[int, np.ndarray]], bits: int, force: bool) -> None:
    """Write (first row, rows), from the top, of an image whose white is 1: the values of `png.encode`, or no file.

    Raises FileExistsError for a file that is there already, unless `force`.
    """
    import tifffile

    output.check_free([path], force)
    with output.in_one_step(path) as file:
        kind = np.uint16 if bits == 16 else np.uint8
        large = shape[0] * shape[1] * bits // 8 > 2**31
        offset = tifffile.memmap(file, shape=shape, dtype=kind, photometric="minisblack", bigtiff=large).offset
        # Written, not mapped: a mapped file counts as the program's memory.
        with file.open("r+b") as image:
            image.seek(offset)
            for _, part in blocks:
                image.write(png.codes(part, bits).tobytes())
