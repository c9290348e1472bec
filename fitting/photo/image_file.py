"""Image files as arrays of their codes, with all bits."""

from contextlib import contextmanager
from pathlib import Path

import numpy as np

from newtonjax.numerics import require_memory

# Names under which cameras keep what their sensors saw.
_RAW = (".arw", ".cr2", ".cr3", ".dng", ".nef", ".orf", ".pef", ".raf", ".raw", ".rw2")
# What is advised where a photograph is larger than the memory.
SMALLER = "crop the photograph to its rings, or reduce its pixels (`magick photo.png -resize 50% small.png`)"


def load(path: str | Path) -> np.ndarray:
    """Codes [rows, columns] or [rows, columns, channels] of the first picture in a file, turned as its EXIF data say.

    Raises FileNotFoundError, and ValueError for what is no image or needs more memory than there is.
    """
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"{path} is no file; give the path of a photograph (PNG, JPEG, TIFF, WebP)")
    if path.stat().st_size == 0:
        raise ValueError(f"{path} is empty; give the path of a photograph")
    try:
        rows, columns, size = _header(path)
    except Exception as error:
        raise _unreadable(path, error) from error
    # The decoder's buffer and the array made of it.
    require_memory(f"reading {path}, {rows} x {columns} pixels,", 2.0 * rows * columns * size, SMALLER)
    try:
        return _read(path)
    except Exception as error:
        raise _unreadable(path, error) from error


def _unreadable(path: Path, error: Exception) -> ValueError:
    """What is said of a file that a decoder refuses: these raise whatever they like."""
    reason = str(error).splitlines()[0] if str(error) else type(error).__name__
    return ValueError(f"{path} cannot be read as an image ({reason}); allowed: PNG, JPEG, TIFF, WebP, camera raw")


def _header(path: Path) -> tuple[int, int, int]:
    """Rows, columns and bytes a pixel of a file's first picture, as its header has them; a raw file's are its size."""
    if _is_tiff(path):
        import tifffile

        with tifffile.TiffFile(path) as pages:
            page = pages.pages.first
            return page.imagelength, page.imagewidth, page.samplesperpixel * max(1, page.bitspersample // 8)
    if path.suffix.lower() in _RAW:
        return 1, path.stat().st_size, 1
    from PIL import Image

    with _any_size(), Image.open(path) as picture:
        return picture.height, picture.width, len(picture.getbands()) * (4 if picture.mode in ("I", "F") else 2)


@contextmanager
def _any_size():
    """Pillow without its limit of 179 Mpx: here the memory that there is sets the limit."""
    from PIL import Image

    limit, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, None
    try:
        yield
    finally:
        Image.MAX_IMAGE_PIXELS = limit


def _is_tiff(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(4) in (b"II*\0", b"MM\0*")


def has_more(path: str | Path) -> bool:
    """Whether a file holds further pictures of the first one's size: pages of a TIFF, frames of a GIF, PNG or WebP."""
    from PIL import Image

    with Path(path).open("rb") as file:
        head = file.read(4)
    if Path(path).suffix.lower() in _RAW:
        return False
    if head in (b"II*\0", b"MM\0*"):
        import tifffile

        with tifffile.TiffFile(path) as file:
            first, second = file.pages.first, next(iter(file.pages[1:2]), None)
            return second is not None and second.shape == first.shape
    if head not in (b"GIF8", b"\x89PNG", b"RIFF"):
        return False  # the further pictures of a JPEG are its own, smaller or for the other eye
    with Image.open(path) as picture:
        return getattr(picture, "is_animated", False)


def _read(path: Path) -> np.ndarray:
    with path.open("rb") as file:
        head = file.read(26)
    # Pillow reads colours of 16 bits as 8 (python-pillow issue 1888): these two formats have readers of their own.
    if head[:8] == b"\x89PNG\r\n\x1a\n" and head[24] == 16 and head[25] in (2, 6):
        return _deep_png(path)
    if _is_tiff(path):
        import tifffile

        with tifffile.TiffFile(path) as pages:
            page = pages.pages.first
            if page.samplesperpixel > 1 and page.bitspersample > 8:
                codes = page.asarray()
                return np.moveaxis(codes, 0, -1) if page.planarconfig == 2 else codes
    if path.suffix.lower() in _RAW:
        return _raw(path)
    import imageio.v3 as iio

    with _any_size():
        codes = np.asarray(iio.imread(path, index=0, plugin="pillow", rotate=True, **_as_colours(path)))
    return codes.astype(np.uint8) * 255 if codes.dtype == bool else codes


def _as_colours(path: Path) -> dict:
    """What turns inks (CMYK) and other spaces into colours, of which light can be had."""
    from PIL import Image

    with Image.open(path) as picture:
        return {"mode": "RGB"} if picture.mode in ("CMYK", "YCbCr", "LAB", "HSV") else {}


def _deep_png(path: Path) -> np.ndarray:
    import png

    with path.open("rb") as file:
        columns, rows, lines, about = png.Reader(file=file).read()
        codes = np.vstack([np.asarray(line, np.uint16) for line in lines])
    return codes.reshape(rows, columns, about["planes"])


def _raw(path: Path) -> np.ndarray:
    """Colours of a camera's raw file, 16 bits, linear in the light (LibRaw; the extra `raw`)."""
    try:
        import rawpy  # pyright: ignore[reportMissingImports]  # an extra
    except ImportError as error:
        raise ValueError("raw files need rawpy; install it: pip install 'newtonjax[raw]'") from error
    with rawpy.imread(str(path)) as file:
        return file.postprocess(gamma=(1, 1), no_auto_bright=True, output_bps=16, use_camera_wb=True)
