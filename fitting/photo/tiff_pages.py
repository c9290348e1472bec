"""Pages of TIFF files as arrays of their codes, with all bits, whatever lossless compression they have."""

from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from fitting.photo import pillow_files

NAMES, SUFFIXES = ("TIFF",), ()
HEADS = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
# Values of TIFF tags (TIFF 6.0; Adobe's supplement 3): no compression; those of bytes that libtiff unpacks, LZW,
# deflate twice, PackBits, LZMA and Zstandard; differences of samples, and of the bytes of floats.
_PLAIN, _PACKED = 1, (5, 8, 32946, 32773, 34925, 50000)
# Those whose strips or tiles are picture files: JPEG 2000, WebP.
_PICTURES = (34712, 50001)
_DIFFERENCES, _FLOAT_DIFFERENCES = 2, 3
# Photometric interpretations that are light as they stand: white is zero, black is zero, RGB.
_WHITE_IS_ZERO, _LIGHT = 0, (0, 1, 2)


def layout(path: Path) -> tuple[tuple[int, int], int, int]:
    """Shape [px], bytes a pixel and the number of pages of a file, thumbnails left out."""
    import tifffile

    with tifffile.TiffFile(path) as file:
        pages = _full_pages(file)
        page = pages[0]
        size = page.samplesperpixel * max(1, page.bitspersample // 8)
        frames = _headless_frames(file)
        return (page.imagelength, page.imagewidth), size, len(pages) if frames is None else frames.shape[0]


def load(path: Path, number: int) -> np.ndarray:
    """Codes [rows, columns] or [rows, columns, channels] of a page, the first one number 0."""
    import tifffile

    with tifffile.TiffFile(path) as file:
        frames = _headless_frames(file)
        return np.asarray(frames.asarray(out="memmap")[number]) if frames else _codes(_full_pages(file)[number], path)


def each_frame(path: Path) -> Iterator[np.ndarray | Exception]:
    """Codes of one page after the other; for a page that cannot be decoded, what its decoder raised."""
    import tifffile

    with tifffile.TiffFile(path) as file:
        if frames := _headless_frames(file):
            yield from frames.asarray(out="memmap")
            return
        for page in _full_pages(file):
            try:
                yield _codes(page, path)
            except Exception as error:  # the decoders raise whatever they like
                yield error


def _full_pages(file: Any) -> list:
    """The pages that are no smaller copies of others (NewSubfileType 1)."""
    return [page for page in file.pages if not getattr(page, "is_reduced", False)] or [file.pages.first]


def _headless_frames(file: Any) -> Any:
    """The frames that ImageJ keeps behind one header in files beyond 4 GB; None for pages with a header each."""
    if len(file.pages) > 1 or file.pages.first.samplesperpixel > 1:
        return None
    frames = file.series[0]
    return frames if frames.ndim > 2 and frames.shape[-2:] == file.pages.first.shape else None


def _codes(page: Any, path: Path) -> np.ndarray:
    bits, is_light = page.bitspersample, page.photometric in _LIGHT
    if not (is_light and bits in (8, 16, 32, 64) and page.compression in (_PLAIN, *_PACKED)):
        if page.compression in _PICTURES and page.planarconfig == 1 and is_light:
            return _of_pictures(page)
        return _by_pillow(path, page)
    if page.compression == _PLAIN:
        codes = page.asarray()
        codes = np.moveaxis(codes, 0, -1) if page.planarconfig == 2 and codes.ndim == 3 else codes
    else:
        codes = _unpacked(page)
    if page.photometric == _WHITE_IS_ZERO and np.issubdtype(codes.dtype, np.integer):
        codes = np.iinfo(codes.dtype).max - codes
    if codes.ndim == 3 and not any(page.extrasamples):
        # Samples beyond grey or red, green and blue that stand for nothing are no opacity.
        codes = codes[:, :, : 3 if page.photometric == 2 else 1]
    orientation = page.tags.get("Orientation")
    turn = pillow_files.TURNS.get(int(orientation.value)) if orientation is not None else None
    return codes if turn is None else turn(codes)


def _by_pillow(path: Path, page: Any) -> np.ndarray:
    """What has fewer than 8 bits, a palette, inks, or the compression of a JPEG."""
    try:
        return pillow_files.load(path, page.index)
    except (OSError, ValueError) as error:
        name = getattr(page.compression, "name", page.compression)
        raise ValueError(
            f"{path} is a TIFF of {page.bitspersample} bits with compression {name}, which is not read; save it "
            "without compression, or with LZW or deflate"
        ) from error


def _of_pictures(page: Any) -> np.ndarray:
    """Codes of a page whose strips or tiles are each a picture file of its own."""
    from PIL import Image

    width, height = (page.tilewidth, page.tilelength) if page.is_tiled else (page.imagewidth, page.rowsperstrip)
    across, codes = -(-page.imagewidth // width), None
    for number, (offset, count) in enumerate(zip(page.dataoffsets, page.databytecounts, strict=True)):
        page.parent.filehandle.seek(offset)
        part = np.asarray(Image.open(BytesIO(page.parent.filehandle.read(count))))
        if codes is None:
            codes = np.zeros((page.imagelength, page.imagewidth, *part.shape[2:]), part.dtype)
        down, along = divmod(number, across)
        area = codes[down * height : (down + 1) * height, along * width : (along + 1) * width]
        area[:] = part[: area.shape[0], : area.shape[1]]
    return codes if codes is not None else np.zeros((0, 0), np.uint8)


def _unpacked(page: Any) -> np.ndarray:
    """Codes of a compressed page, its differences summed.

    libtiff, which comes with Pillow, unpacks the bytes as those of a grey picture that is as many times as wide as a
    pixel has bytes: Pillow itself cuts colours of 16 bits to 8.
    """
    samples = page.samplesperpixel if page.planarconfig == 1 else 1
    planes = page.samplesperpixel // samples
    kind = np.dtype(page.dtype).newbyteorder(page.parent.byteorder)
    width = page.tilewidth if page.is_tiled else page.imagewidth
    columns = -(-page.imagewidth // width) * width
    segments = len(page.dataoffsets) // planes
    codes = []
    for plane in range(planes):
        part = slice(plane * segments, (plane + 1) * segments)
        lines = _bytes(page, part, columns * samples * kind.itemsize)
        # Differences begin anew in every tile.
        tiles = lines.reshape(len(lines), columns // width, -1)
        summed = _sums(tiles, kind, page.predictor, samples)
        codes.append(summed.reshape(len(lines), columns, samples)[: page.imagelength, : page.imagewidth])
    joined = codes[0] if planes == 1 else np.concatenate(codes, axis=2)
    return joined[:, :, 0] if joined.shape[2] == 1 else joined


def _sums(tiles: np.ndarray, kind: np.dtype, predictor: int, samples: int) -> np.ndarray:
    """Samples of bytes [rows, tiles, bytes] that are no, or differences of neighbouring pixels."""
    if predictor == _FLOAT_DIFFERENCES:
        # The bytes of floats, those of the sign first, all of a row together (Adobe Photoshop TIFF technical note 3).
        pixels = tiles.reshape(*tiles.shape[:2], -1, samples)
        lines = np.cumsum(pixels, axis=2, dtype=np.uint8).reshape(*tiles.shape[:2], kind.itemsize, -1)
        return np.ascontiguousarray(np.moveaxis(lines, 2, 3)).view(kind.newbyteorder(">"))[..., 0]
    if predictor != _DIFFERENCES:
        return tiles.view(kind)
    unsigned = np.dtype(f"u{kind.itemsize}").newbyteorder(kind.byteorder)
    pixels = tiles.view(unsigned).reshape(*tiles.shape[:2], -1, samples)
    return np.cumsum(pixels, axis=2, dtype=unsigned.newbyteorder("=")).view(kind.newbyteorder("="))


def _bytes(page: Any, part: slice, width: int) -> np.ndarray:
    """Unpacked bytes [rows, width] of some of a page's strips or tiles."""
    from PIL import Image

    counts, offsets = page.databytecounts[part], page.dataoffsets[part]
    file, content, places = page.parent.filehandle, BytesIO(), []
    content.write(b"II*\0" + bytes(4))
    for count, offset in zip(counts, offsets, strict=True):
        file.seek(offset)
        places.append(content.tell())
        content.write(file.read(count))
    rows = page.imagelength
    tags = {256: width, 257: rows, 258: 8, 259: page.compression, 262: 1, 266: page.fillorder, 277: 1}
    if page.is_tiled:
        across = -(-page.imagewidth // page.tilewidth)
        rows = -(-rows // page.tilelength) * page.tilelength
        tags |= {257: rows, 322: width // across, 323: page.tilelength, 324: places, 325: counts}
    else:
        tags |= {273: places, 278: page.rowsperstrip, 279: counts}
    _write_directory(content, tags)
    with Image.open(content) as picture:
        return np.asarray(picture)


def _write_directory(content: BytesIO, tags: dict) -> None:
    """A directory of 32-bit numbers at the end of a little-endian TIFF, and its place in the head."""
    entries = []
    for tag, value in sorted(tags.items()):
        values = np.atleast_1d(np.asarray(value, "<u4"))
        place = int(values[0])
        if len(values) > 1:
            place = content.tell()
            content.write(values.tobytes())
        entries.append(np.array([(tag, 4, len(values), place)], "<u2,<u2,<u4,<u4").tobytes())
    start = content.tell()
    content.write(len(entries).to_bytes(2, "little") + b"".join(entries) + bytes(4))
    content.seek(4)
    content.write(start.to_bytes(4, "little"))
    content.seek(0)
