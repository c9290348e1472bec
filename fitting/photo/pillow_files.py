"""Pictures that Pillow decodes as arrays of their codes: PNG, JPEG, GIF, WebP, BMP, and TIFFs of few bits."""

from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

# Formats whose further frames are pictures like the first; those of a JPEG are its own, smaller or for the other eye.
_MOVING = ("GIF", "PNG", "WEBP", "TIFF")


@contextmanager
def opened(path: Path) -> Generator[Any, None, None]:
    """A file as Pillow has it, without its limit of 179 Mpx: here the memory that there is sets the limit."""
    from PIL import Image

    limit, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, None
    try:
        with Image.open(path) as picture:
            yield picture
    finally:
        Image.MAX_IMAGE_PIXELS = limit


def layout(path: Path) -> tuple[tuple[int, int], int, int]:
    """Shape [px], bytes a pixel and the number of frames of a file."""
    with opened(path) as picture:
        mode = picture.mode
        # A palette becomes colours; two bytes a sample, for some have 16 bits.
        size = 4 if mode in ("I", "F", "P", "PA") else 2 * len(picture.getbands())
        frames = getattr(picture, "n_frames", 1) if picture.format in _MOVING else 1
        return (picture.height, picture.width), size, frames


def load(path: Path, number: int) -> np.ndarray:
    """Codes [rows, columns] or [rows, columns, channels] of a frame, the first one number 0, turned as EXIF says.

    Bool where the file has one bit a pixel.
    """
    from PIL import ImageOps

    with path.open("rb") as file:
        head = file.read(26)
    # Signature, then the header's depth and kind of colour: 16 bits with colours or opacity.
    if head.startswith(b"\x89PNG\r\n\x1a\n") and head[24] == 16 and head[25] in (2, 4, 6):
        return _deep_png(path)
    with opened(path) as picture:
        if number:
            picture.seek(number)
        mode = _mode(picture)
        kind = picture.format
        ImageOps.exif_transpose(picture, in_place=True)  # otherwise a copy, turned or not
        codes = np.asarray(picture if picture.mode == mode else picture.convert(mode))
        # Older releases have grey PNGs of 16 bits in 32.
        return codes.astype(np.uint16) if mode == "I" and kind == "PNG" else codes


def _mode(picture: Any) -> str:
    """The mode of which light can be had: colours in place of palettes, inks and other spaces."""
    if picture.mode in ("P", "PA"):
        return "RGBA" if picture.mode == "PA" or "transparency" in picture.info else "RGB"
    if picture.mode in ("CMYK", "YCbCr", "LAB", "HSV", "RGBX"):
        return "RGB"
    straight = {"La": "LA", "RGBa": "RGBA"}
    return straight.get(picture.mode) or picture.mode


def _deep_png(path: Path) -> np.ndarray:
    """Codes of a PNG with 16 bits and several channels, which Pillow reads as 8 bits (python-pillow issue 1888)."""
    import png

    with path.open("rb") as file:
        columns, rows, lines, about = png.Reader(file=file).read()
        codes = np.empty((rows, columns * about["planes"]), np.uint16)
        for row, line in zip(codes, lines, strict=True):
            row[:] = line
    return codes.reshape(rows, columns, about["planes"])
