"""Images as PNG files that read back as linear light: 16 bits linear, 8 bits in sRGB."""

import io

import numpy as np
from jaxtyping import Float, UInt8, UInt16


def encode(fraction: Float[np.ndarray, "rows columns"], bits: int) -> bytes:
    """A grey PNG of an image whose white is 1; values outside 0 to 1 are clipped.

    16 bits hold the linear values, 8 bits those of the sRGB curve (IEC 61966-2-1): `fit` reads them back the same way.
    """
    import imageio.v3 as imageio

    file = io.BytesIO()
    imageio.imwrite(file, codes(fraction, bits), extension=".png")
    return file.getvalue()


def codes(fraction, bits: int) -> UInt8[np.ndarray, "rows columns"] | UInt16[np.ndarray, "rows columns"]:
    """The numbers that a file holds of an image whose white is 1."""
    values = np.clip(fraction, 0.0, 1.0)
    white, kind = (65535, np.uint16) if bits == 16 else (255, np.uint8)
    values = values if bits == 16 else to_srgb(values)
    values *= white  # in place: images may be large
    return np.rint(values, out=values).astype(kind)


def to_srgb(fraction: Float[np.ndarray, "..."]) -> Float[np.ndarray, "..."]:
    """The sRGB value of linear light, both 0 to 1 (IEC 61966-2-1)."""
    curve = 1.055 * np.maximum(fraction, 0.0031308) ** (1 / 2.4) - 0.055
    return np.where(fraction <= 0.0031308, 12.92 * fraction, curve)
