"""Camera raw files as colours (LibRaw; the extra `raw`)."""

from pathlib import Path

import numpy as np

NAMES, HEADS = ("camera raw",), ()
# Names under which cameras keep what their sensors saw.
SUFFIXES = (".arw", ".cr2", ".cr3", ".dng", ".nef", ".orf", ".pef", ".raf", ".raw", ".rw2")


def layout(path: Path) -> tuple[tuple[int, int], int, int]:
    """Shape [px], bytes a pixel and number of pictures; one row of the file's size, for want of a header."""
    return (1, path.stat().st_size), 1, 1


def load(path: Path, _: int) -> np.ndarray:
    """Colours of 16 bits, linear in the light. Raises ValueError where there is no decoder."""
    try:
        import rawpy  # pyright: ignore[reportMissingImports]  # an extra
    except ImportError as error:
        raise ValueError("raw files need rawpy; install it: pip install 'newtonjax[raw]'") from error
    with rawpy.imread(str(path)) as file:
        return file.postprocess(gamma=(1, 1), no_auto_bright=True, output_bps=16, use_camera_wb=True)
