"""TIFF files whose strips or tiles are pictures of their own; and those of which nothing here reads the compression."""

import io
import struct

import numpy as np
import pytest
from PIL import Image

import fitting

ROWS = np.arange(96.0)[:, None] - 40
CODES = np.uint8(128 + 90 * np.cos(5e-3 * (ROWS**2 + (np.arange(128.0) - 60) ** 2)))


def tiff(parts, compression, shape, tile=None, samples=1):
    """A TIFF 6.0 file by hand: `parts` are the bytes of strips of all rows, or of tiles [px]."""
    rows, columns = shape
    head = 8 + 2 + 12 * 11 + 4 + 8 * len(parts) + 6
    counts = [len(part) for part in parts]
    places = np.cumsum([head, *counts[:-1]])
    table = 8 + 2 + 12 * 11 + 4
    at = (table, table + 4 * len(parts)) if len(parts) > 1 else (places[0], counts[0])
    bits = (8, 1) if samples == 1 else (table + 8 * len(parts), 3)
    size = [(322, tile), (323, tile), (324, at[0]), (325, at[1])] if tile else [(273, at[0]), (278, rows), (279, at[1])]
    entries = [(256, columns), (257, rows), (258, bits[0]), (259, compression), (262, 1 if samples == 1 else 2), *size]
    entries = [*entries, (277, samples)]
    entries += [(339, 1)] * (11 - len(entries))
    lengths = {258: bits[1], 273: len(parts), 279: len(parts), 324: len(parts), 325: len(parts)}
    directory = b""
    for tag, value in sorted(entries)[:11]:
        kind = 3 if tag in (258, 259, 262, 277, 339) else 4
        is_short = kind == 3 and lengths.get(tag, 1) == 1
        directory += struct.pack("<HHI", tag, kind, lengths.get(tag, 1))
        directory += struct.pack("<HH", value, 0) if is_short else struct.pack("<I", value)
    lists = struct.pack(f"<{2 * len(parts)}I", *places, *counts) + struct.pack("<3H", 8, 8, 8)
    return b"II*\0" + struct.pack("<IH", 8, 11) + directory + struct.pack("<I", 0) + lists + b"".join(parts)


def packed(codes, kind, **options):
    file = io.BytesIO()
    Image.fromarray(codes).save(file, kind, **options)
    return file.getvalue()


@pytest.mark.parametrize("compression", ["JPEG 2000", "WebP"])
@pytest.mark.parametrize("tile", [None, 64])
def test_strips_and_tiles_that_are_pictures_are_read(tmp_path, compression, tile):
    codes = CODES if compression == "JPEG 2000" else np.stack([CODES] * 3, axis=-1)
    parts = [codes]
    if tile:
        padded = np.pad(codes, [(0, 32), (0, 0), *[(0, 0)] * (codes.ndim - 2)])
        parts = [padded[r : r + 64, c : c + 64] for r in (0, 64) for c in (0, 64)]
    if compression == "JPEG 2000":
        content = [packed(part, "JPEG2000", no_jp2=True) for part in parts]
    else:
        content = [packed(np.ascontiguousarray(part), "WEBP", lossless=True) for part in parts]
    file = tmp_path / "picture.tif"
    file.write_bytes(tiff(content, 34712 if codes.ndim == 2 else 50001, CODES.shape, tile, 1 if codes.ndim == 2 else 3))
    assert np.array_equal(fitting.read(file).image, fitting.read(CODES).image)


def test_a_compression_that_is_not_read_is_named(tmp_path):
    file = tmp_path / "picture.tif"
    file.write_bytes(tiff([b"nothing"], 34887, CODES.shape))
    with pytest.raises(
        ValueError, match="is a TIFF of 8 bits with compression LERC, which is not read; save it"
    ) as error:
        fitting.read(file)
    assert "\n" not in str(error.value)
