"""Made photographs in colour: rings under a lamp's spectrum, seen by a camera's three channels.

Each channel is a sum over 401 wavelengths of 380 to 780 nm; then blur, the mean over a pixel, vignette, shot and read
noise, Bayer mosaic and bilinear demosaic; on demand a JPEG of quality 90.
"""

from typing import NamedTuple

import imageio.v3 as iio
import numpy as np
from scipy import ndimage

from newtonjax.scene import LAMPS

NM = 1e-9
WAVELENGTHS = np.arange(380.0, 780.5, 1.0) * NM
# Middles and widths (standard deviations) of a Bayer camera's responses [nm], as (share, middle, width).
_CURVES = (
    ((1.0, 600.0, 32.0), (0.12, 540.0, 30.0)),
    ((1.0, 535.0, 36.0), (0.10, 600.0, 30.0)),
    ((1.0, 460.0, 28.0), (0.10, 520.0, 25.0)),
)
# Pixels around the frame that are made and cut off; even, for the mosaic.
_MARGIN = 10
# Powers of a mercury arc's lines, and of the bands beside them.
_MERCURY = {404.656: 0.5, 407.783: 0.04, 435.833: 1.2, 546.074: 1.5, 576.960: 0.7, 579.066: 0.75}


class Truth(NamedTuple):
    """What a picture was made of; lengths in metres, blur in pixels."""

    radius: float
    pixel_size: float
    gap: float
    centre: tuple[float, float]
    blur: float
    lamp: str


def responses(shift_nm: np.ndarray | None = None, crosstalk: float = 0.0) -> np.ndarray:
    """Response of each channel to each wavelength [3, 401]; channels shifted [nm], and mixed with their mean."""
    shifts = np.zeros(3) if shift_nm is None else shift_nm
    at = WAVELENGTHS / NM
    curves = np.stack(
        [
            sum(share * np.exp(-0.5 * ((at - middle - shift) / width) ** 2) for share, middle, width in bumps)
            for bumps, shift in zip(_CURVES, shifts, strict=True)
        ]
    )
    return (1 - crosstalk) * curves + crosstalk * curves.mean(axis=0)


def overlapping_responses() -> np.ndarray:
    """Response of a camera of another kind, whose channels overlap as those of stacked photodiodes [3, 401]."""
    bumps = (
        ((1.0, 600.0, 60.0), (0.5, 500.0, 60.0)),
        ((1.0, 540.0, 60.0), (0.4, 620.0, 50.0)),
        ((1.0, 490.0, 50.0), (0.5, 570.0, 60.0)),
    )
    at = WAVELENGTHS / NM
    return np.stack([sum(share * np.exp(-0.5 * ((at - m) / w) ** 2) for share, m, w in rows) for rows in bumps])


def changed(curves: np.ndarray, powers: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Responses times exp(tilt x - curvature x²), x in 50 nm from each channel's mean under a lamp, both 0.3 (sd)."""
    product = curves * powers
    x = (WAVELENGTHS - (product @ WAVELENGTHS / product.sum(axis=1))[:, None]) / 50e-9
    tilt, curvature = rng.normal(0, 0.3, (2, len(curves), 1))
    return curves * np.exp(tilt * x - curvature * x**2)


def banded_light(lamp: str) -> np.ndarray:
    """Powers [401] of "led" or "white", of "halogen" (a black body of 2856 K), "filtered" (white behind 60 nm)."""
    at = WAVELENGTHS / NM
    if lamp == "halogen":
        return (560 / at) ** 5 / np.expm1(1.4388e7 / (at * 2856))
    if lamp == "filtered":
        return spectrum("white")[1] * np.exp(-4 * np.log(2) * ((at - 520) / 60) ** 2)
    return spectrum(lamp)[1]


def arc(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Spectrum of a mercury arc of its own pressure: each line's power is off by a fifth or so."""
    wavelengths, powers = spectrum("mercury")
    scatter = np.ones(len(powers))
    scatter[: len(_MERCURY)] = np.exp(rng.normal(0, 0.2, len(_MERCURY)))
    return wavelengths, powers * scatter


def spectrum(lamp: str) -> tuple[np.ndarray, np.ndarray]:
    """Wavelengths [m] and powers of a light.

    "mercury", another lamp of lines, "white" (a black body of 5500 K), "led" (white) or "green led".
    """
    at = WAVELENGTHS / NM
    if lamp == "mercury":
        lines = np.array(list(_MERCURY))
        bands = 0.004 + 0.012 * np.exp(-0.5 * ((at - 615) / 22) ** 2) + 0.006 * np.exp(-0.5 * ((at - 490) / 40) ** 2)
        return np.concatenate([lines * NM, WAVELENGTHS]), np.concatenate([list(_MERCURY.values()), bands])
    if lamp == "white":
        return WAVELENGTHS, (560 / at) ** 5 / np.expm1(1.4388e7 / (at * 5500))
    if lamp == "led":
        return WAVELENGTHS, np.exp(-0.5 * ((at - 450) / 10) ** 2) + 0.5 * np.exp(-0.5 * ((at - 565) / 50) ** 2)
    if lamp == "green led":
        return WAVELENGTHS, np.exp(-0.5 * ((at - 525) / 13) ** 2)
    if lamp in LAMPS:
        lines, powers = np.array(LAMPS[lamp]).T
        return np.concatenate([lines * NM, WAVELENGTHS]), np.concatenate([powers / powers.max(), np.full(401, 0.002)])
    raise ValueError(f"lamp {lamp!r} is not made")


def picture(
    truth: Truth,
    rng: np.random.Generator,
    curves: np.ndarray,
    shape: tuple[int, int] = (300, 400),
    jpeg: bool = False,
    light: tuple[np.ndarray, np.ndarray] | None = None,
) -> np.ndarray:
    """Codes [rows, columns, 3] of a photograph in reflection: 12 bits in 16, or bytes out of a JPEG.

    `light`: wavelengths [m] and powers in place of the lamp's.
    """
    wavelengths, powers = spectrum(truth.lamp) if light is None else light
    # Beyond the frame, where a filter would mirror the rings.
    wide = (shape[0] + 2 * _MARGIN, shape[1] + 2 * _MARGIN)
    rows, columns = np.mgrid[: 2 * wide[0], : 2 * wide[1]] / 2 - 0.25 - _MARGIN
    x, y = (columns - truth.centre[0]) * truth.pixel_size, (rows - truth.centre[1]) * truth.pixel_size
    gap = truth.radius - np.sqrt(truth.radius**2 - x**2 - y**2) + truth.gap
    table = np.linspace(gap.min(), gap.max(), 4096)
    fringes = np.cos(4 * np.pi * table[:, None] / wavelengths)
    light = np.empty((*wide, 3))
    far = ((columns - shape[1] / 2) ** 2 + (rows - shape[0] / 2) ** 2) / np.hypot(*shape) ** 2
    for channel in range(3):
        product = powers * np.interp(wavelengths, WAVELENGTHS, curves[channel])
        waveform = 1 - 0.9 * (fringes @ product) / product.sum()
        fine = np.interp(gap, table, waveform) * (1 - 0.8 * far)
        fine = ndimage.gaussian_filter(fine, 2 * truth.blur)
        light[..., channel] = fine.reshape(wide[0], 2, wide[1], 2).mean(axis=(1, 3))
    light *= np.array([0.45, 0.48, 0.42])
    electrons = rng.poisson(15_000 * light) + rng.normal(0, 15, light.shape)
    colours = demosaic(electrons / 15_000)[_MARGIN:-_MARGIN, _MARGIN:-_MARGIN]
    if jpeg:
        codes = np.clip(_srgb(np.clip(colours, 0, 1)) * 255, 0, 255).round().astype(np.uint8)
        return iio.imread(iio.imwrite("<bytes>", codes, extension=".jpg", quality=90), extension=".jpg")
    return (np.clip(colours, 0, 1) * 4095).round().astype(np.uint16) * 16


def demosaic(light: np.ndarray) -> np.ndarray:
    """What a Bayer mosaic (red, green; green, blue) keeps of three channels, and bilinear means fill in again."""
    rows, columns = np.indices(light.shape[:2])
    sites = [(rows % 2 == 0) & (columns % 2 == 0), (rows + columns) % 2 == 1, (rows % 2 == 1) & (columns % 2 == 1)]
    kernel = np.array([[0.25, 0.5, 0.25], [0.5, 1.0, 0.5], [0.25, 0.5, 0.25]])
    filled = []
    for channel, site in enumerate(sites):
        weight = ndimage.convolve(site.astype(float), kernel, mode="mirror")
        total = ndimage.convolve(np.where(site, light[..., channel], 0.0), kernel, mode="mirror")
        filled.append(total / weight)
    return np.stack(filled, axis=2)


def _srgb(light: np.ndarray) -> np.ndarray:
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 1e-9) ** (1 / 2.4) - 0.055)


def random_truth(rng: np.random.Generator, lamp: str, shape: tuple[int, int] = (300, 400)) -> Truth:
    """A lens of 120 to 180 mm near contact, its rings near the middle of the frame."""
    centre = (shape[1] / 2 + rng.uniform(-20, 20), shape[0] / 2 + rng.uniform(-20, 20))
    gap = rng.uniform(-10e-9, 60e-9)
    return Truth(rng.uniform(0.12, 0.18), 5.461e-6, gap, centre, rng.uniform(0.7, 1.6), lamp)
