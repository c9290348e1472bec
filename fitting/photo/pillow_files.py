"""Pictures that Pillow decodes as arrays of their codes: PNG, JPEG, GIF, WebP, BMP, and TIFFs of few bits."""

from collections.abc import Generator, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

NAMES, HEADS = ("PNG", "JPEG", "WebP", "GIF", "BMP"), ()
SUFFIXES = (".gif", ".png", ".apng", ".webp", ".jpg", ".jpeg", ".bmp")
# Formats whose further frames are pictures like the first; those of a JPEG are its own, smaller or for the other eye.
_MOVING = ("GIF", "PNG", "WEBP", "TIFF")
_ORIENTATION = 0x0112
# Rows that are copied at a time.
_BAND = 256
# What EXIF and TIFF call orientation.
TURNS = {
    2: lambda codes: codes[:, ::-1],
    3: lambda codes: codes[::-1, ::-1],
    4: lambda codes: codes[::-1],
    5: lambda codes: codes.swapaxes(0, 1),
    6: lambda codes: codes[::-1].swapaxes(0, 1),
    7: lambda codes: codes[::-1, ::-1].swapaxes(0, 1),
    8: lambda codes: codes.swapaxes(0, 1)[::-1],
}


@contextmanager
def _unlimited() -> Generator[None, None, None]:
    """Without Pillow's limit of 179 Mpx: here the memory that there is sets the limit."""
    from PIL import Image

    limit, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, None
    try:
        yield
    finally:
        Image.MAX_IMAGE_PIXELS = limit


@contextmanager
def opened(path: Path) -> Generator[Any, None, None]:
    """A file as Pillow has it, whatever its size."""
    from PIL import Image

    with _unlimited(), Image.open(path) as picture:
        yield picture


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

    Bool where the file has one bit a pixel. Raises ValueError for a later frame of a PNG with colours of 16 bits.
    """
    if _is_deep_png(path):
        return _deep_png(path, number)
    with opened(path) as picture:
        return _codes(picture, number)


def each_frame(path: Path) -> Iterator[np.ndarray | Exception]:
    """Codes of one frame after the other, as `load` gives them; for one that cannot be decoded, what was raised."""
    from PIL import Image

    *_, frames = layout(path)
    is_deep = _is_deep_png(path)
    with _unlimited():
        picture = Image.open(path)
    # It stays open: a frame is decoded from the one before.
    with picture:
        for number in range(frames):
            try:
                with _unlimited():
                    codes = _deep_png(path, number) if is_deep else _codes(picture, number)
            except Exception as error:  # decoders raise whatever they like
                codes = error
            yield codes


def _codes(picture: Any, number: int) -> np.ndarray:
    if number:
        picture.seek(number)
    mode = _mode(picture)
    codes = _array(picture if picture.mode == mode else picture.convert(mode))
    # Older releases have grey PNGs of 16 bits in 32.
    return _turned(picture, codes.astype(np.uint16) if mode == "I" and picture.format == "PNG" else codes)


def _array(picture: Any) -> np.ndarray:
    """What `np.asarray` gives, in bands of rows: all at once Pillow copies twice."""
    width, height = picture.size
    row = np.asarray(picture.crop((0, 0, width, 1)))
    codes = np.empty((height, *row.shape[1:]), row.dtype)
    for top in range(0, height, _BAND):
        bottom = min(top + _BAND, height)
        codes[top:bottom] = np.asarray(picture.crop((0, top, width, bottom)))
    return codes


def _turned(picture: Any, codes: np.ndarray) -> np.ndarray:
    """Codes as the camera was held."""
    turn = TURNS.get(picture.getexif().get(_ORIENTATION, 1))
    return codes if turn is None else turn(codes)


def _mode(picture: Any) -> str:
    """The mode of which light can be had: colours in place of palettes, inks and other spaces."""
    if picture.mode in ("P", "PA"):
        return "RGBA" if picture.mode == "PA" or "transparency" in picture.info else "RGB"
    if picture.mode in ("CMYK", "YCbCr", "LAB", "HSV", "RGBX"):
        return "RGB"
    straight = {"La": "LA", "RGBa": "RGBA"}
    return straight.get(picture.mode) or picture.mode


def _is_deep_png(path: Path) -> bool:
    """Whether it is a PNG of 16 bits with colours or opacity, by its signature and its header's depth and kind."""
    with path.open("rb") as file:
        head = file.read(26)
    return head.startswith(b"\x89PNG\r\n\x1a\n") and head[24:25] == b"\x10" and head[25] in (2, 4, 6)


def _deep_png(path: Path, number: int) -> np.ndarray:
    """Codes of a PNG with 16 bits and several channels, which Pillow reads as 8 bits (python-pillow issue 1888)."""
    import png

    if number:
        raise ValueError("of a PNG with 16 bits and several channels the first frame alone can be read; make it a TIFF")
    with path.open("rb") as file:
        columns, rows, lines, about = png.Reader(file=file).read()
        codes = np.empty((rows, columns * about["planes"]), np.uint16)
        for row, line in zip(codes, lines, strict=True):
            row[:] = line
    with opened(path) as picture:
        return _turned(picture, codes.reshape(rows, columns, about["planes"]))
