"""From photoelectrons to the codes of a photograph: colour filters, scale, transfer and compression."""

from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from newtonjax.numerics import is_concrete

# Colour filters of the first four pixels of a sensor, row by row (Bayer, US patent 3971065, 1976).
MOSAICS = ("RGGB", "BGGR", "GRBG", "GBRG")
# What neighbours count in a bilinear mean of those that have a filter.
_NEAR = np.array([[0.25, 0.5, 0.25], [0.5, 1.0, 0.5], [0.25, 0.5, 0.25]])


def _sites(mosaic: str, shape: tuple[int, ...]) -> Float[np.ndarray, "rows columns 3"]:
    """Which pixels have which filter: 1 or 0."""
    rows, columns = np.indices(shape[:2]) % 2
    filters = np.array(["RGB".index(colour) for colour in mosaic]).reshape(2, 2)[rows, columns]
    return np.eye(3)[filters]


def filtered(light: Float[Array, "rows columns 3"], mosaic: str) -> Float[Array, "rows columns"]:
    """What the filters of a mosaic let through to each pixel."""
    return (light * _sites(mosaic, light.shape)).sum(axis=-1)


def demosaiced(codes: Float[Array, "rows columns"], mosaic: str) -> Float[Array, "rows columns 3"]:
    """Three colours in every pixel, those that it has no filter for as means of its neighbours that have one."""
    sites = _sites(mosaic, codes.shape)
    filtered_codes = codes[..., None] * sites
    return filtered_codes + (1 - sites) * (_near(filtered_codes) / _near(sites))


def _near(values: Any) -> Any:
    """Weighted sums over 3 x 3 pixels; beyond the rim stand the pixels next to it, mirrored about it."""
    xp = np if isinstance(values, np.ndarray) else jnp
    rows, columns = values.shape[:2]
    wide = xp.pad(values, ((1, 1), (1, 1), (0, 0)), mode="reflect")
    parts = [_NEAR[i, j] * wide[i : i + rows, j : j + columns] for i in range(3) for j in range(3)]
    return sum(parts[1:], parts[0])


def _srgb(light: Float[Array, "..."]) -> Float[Array, "..."]:
    """Of linear light from 0 to 1 (IEC 61966-2-1)."""
    bright = jnp.maximum(light, 0.0031308)
    return jnp.where(light <= 0.0031308, 12.92 * light, 1.055 * bright ** (1 / 2.4) - 0.055)


def developed(electrons: Float[Array, "rows columns *channels"], camera: Any) -> Any:
    """The codes of a `Camera` of what its pixels have counted [photoelectrons]: uint8 of 8 bits, else uint16.

    Raises ValueError for a JPEG within a transformation.
    """
    top = 2**camera.bits - 1
    black = 0.0 if camera.black_level is None else camera.black_level
    full_scale = camera.full_well if camera.full_scale is None else camera.full_scale
    counted = electrons if camera.full_scale is None else jnp.minimum(electrons, camera.full_well)
    codes = jnp.clip(black + counted / full_scale * (top - black), 0, top)
    if camera.transfer == "linear":  # a curve is applied to more bits than a file has
        codes = jnp.round(codes)
    if camera.mosaic is not None:
        codes = demosaiced(codes, camera.mosaic)
    if camera.transfer == "srgb":
        codes = top * _srgb(jnp.clip((codes - black) / (top - black), 0, 1))
    codes = jnp.clip(jnp.round(codes), 0, top).astype(jnp.uint8 if camera.bits == 8 else jnp.uint16)
    return codes if camera.jpeg is None else _compressed(codes, camera.jpeg)


def _compressed(codes: Any, quality: int) -> Any:
    """Codes of 8 bits as they come out of a JPEG of a quality."""
    if not is_concrete(codes):
        raise ValueError("jpeg within a transformation: leave it out there, where codes are not known")
    import imageio.v3 as iio  # here: few cameras compress, and to import it takes a tenth of a second

    file = iio.imwrite("<bytes>", np.asarray(codes), extension=".jpg", quality=quality)
    return jnp.asarray(iio.imread(file, extension=".jpg"))
