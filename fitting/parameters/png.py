"""Images as PNG files that read back as linear light: 16 bits linear, 8 bits in sRGB."""

import struct
import zlib

import numpy as np
from jaxtyping import Float, UInt8, UInt16


def encode(fraction: Float[np.ndarray, "rows columns *three"], bits: int) -> bytes:
    """A PNG (ISO/IEC 15948) of an image whose white is 1, grey or of three channels; values outside 0 to 1 are clipped.

    16 bits hold the linear values, 8 bits those of the sRGB curve (IEC 61966-2-1): `fit` reads them back the same way.
    Three channels are red, green and blue as they stand in the file.
    """
    return of_codes(codes(fraction, bits))


def of_codes(image: UInt8[np.ndarray, "rows columns *_"] | UInt16[np.ndarray, "rows columns *_"]) -> bytes:
    """A PNG of the numbers that stand in it, of 8 or 16 bits, grey or of three channels."""
    rows, columns, *channels = image.shape
    bits = 8 * image.dtype.itemsize
    image = image.reshape(rows, -1)
    data = np.ascontiguousarray(image, image.dtype.newbyteorder(">")).view(np.uint8)
    # Each row less the one above it (filter 2), which for fringes compresses best.
    lines = np.empty((rows, 1 + data.shape[1]), np.uint8)
    lines[:, 0] = 2
    lines[0, 1:] = data[0]
    np.subtract(data[1:], data[:-1], out=lines[1:, 1:])
    header = struct.pack(">IIBBBBB", columns, rows, bits, 2 if channels else 0, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(lines.data, 3)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(name, content) for name, content in chunks)


def _chunk(name: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))


def codes(fraction, bits: int) -> UInt8[np.ndarray, "rows columns *_"] | UInt16[np.ndarray, "rows columns *_"]:
    """The numbers that a file holds of an image whose white is 1; three channels have the file's curve already."""
    values = np.clip(fraction, 0.0, 1.0)
    white, kind = (65535, np.uint16) if bits == 16 else (255, np.uint8)
    values = values if bits == 16 or values.ndim == 3 else to_srgb(values)
    values *= white  # in place: images may be large
    return np.rint(values, out=values).astype(kind)


def to_srgb(fraction: Float[np.ndarray, "..."]) -> Float[np.ndarray, "..."]:
    """The sRGB value of linear light, both 0 to 1 (IEC 61966-2-1)."""
    curve = 1.055 * np.maximum(fraction, 0.0031308) ** (1 / 2.4) - 0.055
    return np.where(fraction <= 0.0031308, 12.92 * fraction, curve)
