"""Made photographs of air wedges: rendered by the bench, then turned, distorted, unevenly lit, and noisy."""

from dataclasses import dataclass
from functools import cache
from io import BytesIO

import imageio.v3 as iio
import numpy as np
from scipy import ndimage

from newtonjax import Camera, Chebyshev, air_wedge, render

WAVELENGTH, PIXEL = 589.3e-9, 4e-5
# The rendered picture, from whose middle smaller ones are taken at any angle.
_SIDE, _SHAPE = 560, (300, 360)
# Faults beyond the model; each picture off the model has two of them.
FAULTS = ("bent plate", "slant", "second distortion", "dust", "camera curve", "JPEG", "shadow", "cross-hair")


@dataclass(frozen=True)
class WedgePicture:
    """Light [rows, columns], and the angle of its wedge [rad]."""

    image: np.ndarray
    angle: float


@cache
def _camera() -> Camera:
    return Camera(shape=(_SIDE, _SIDE), pixel_size=PIXEL)


def wedge_picture(seed: int, fault_count: int = 0) -> WedgePicture:
    """Fringes of 7 to 40 pixels at any angle, blurred, with vignette, distortion and 1 to 10 % of noise."""
    rng = np.random.default_rng([seed, fault_count, 26])
    spacing = np.exp(rng.uniform(np.log(7), np.log(40)))
    angle = float(np.arctan(WAVELENGTH / 2 / (spacing * PIXEL)))
    scene = air_wedge(angle, WAVELENGTH, gap=rng.uniform(2e-5, 3e-5))
    rendered = np.asarray(render(scene, _camera(), Chebyshev()), dtype=float)
    faults = set(rng.choice(FAULTS, fault_count, replace=False))
    image = ndimage.map_coordinates(rendered / rendered.max(), _places(rng, faults, spacing), order=5, mode="reflect")
    return WedgePicture(_photographed(image, rng, faults), angle)


def _places(rng: np.random.Generator, faults: set[str], spacing: float) -> np.ndarray:
    """Where in the rendered picture the pixels look [2, rows, columns]; exact in scale in the middle."""
    y, x = (axis - (size - 1) / 2 for axis, size in zip(np.mgrid[: _SHAPE[0], : _SHAPE[1]], _SHAPE, strict=True))
    half_diagonal = np.hypot(*_SHAPE) / 2
    squares = (x**2 + y**2) / half_diagonal**2
    stretch = 1 + rng.uniform(-0.03, 0.03) * squares
    if "second distortion" in faults:
        stretch = stretch + rng.uniform(-0.02, 0.02) * squares**2
    turn = rng.uniform(0, 2 * np.pi)
    along, across = (np.cos(turn) * x + np.sin(turn) * y) * stretch, (np.cos(turn) * y - np.sin(turn) * x) * stretch
    if "slant" in faults:
        # A perspective: nearer one way, so larger there; no scale of the middle changes.
        slope = rng.uniform(-0.02, 0.02, 2) / half_diagonal
        shrink = 1 / (1 + slope[0] * x + slope[1] * y)
        along, across = along * shrink, across * shrink
    if "bent plate" in faults:
        # Fractions of a fringe spacing over the field.
        bends = rng.uniform(-0.5, 0.5, 3) * spacing / half_diagonal**2
        along = along + bends[0] * along**2 + bends[1] * along * across + bends[2] * across**2
    middle = (_SIDE - 1) / 2
    return np.stack([middle + across, middle + along])


def _photographed(image: np.ndarray, rng: np.random.Generator, faults: set[str]) -> np.ndarray:
    rows, columns = image.shape
    y, x = np.mgrid[:rows, :columns]
    v, u = (y - rows / 2) / rows * 2, (x - columns / 2) / columns * 2
    image = ndimage.gaussian_filter(0.1 + 0.9 * image, rng.uniform(0, 1.5))
    slope = rng.uniform(-0.2, 0.2, 2)
    light = image * (1 + slope[0] * u + slope[1] * v) * (1 - rng.uniform(0.1, 0.5) * (u**2 + v**2) / 2)
    if "shadow" in faults:
        place, width = rng.uniform(-0.8, 0.8), rng.uniform(0.05, 0.3)
        light = light * (1 - 0.3 / (1 + np.exp(-(u - place) / width)))
    if "dust" in faults:
        for across, down, size in rng.uniform((0, 0, 1), (columns, rows, 5), (25, 3)):
            light[(x - across) ** 2 + (y - down) ** 2 < size**2] *= 0.4
    if "cross-hair" in faults:
        light[np.abs(u + 0.1 * v - 0.1) < 0.008] *= 0.4
        light[np.abs(v - 0.1 * u + 0.1) < 0.008] *= 0.4
    light = light + np.exp(rng.uniform(np.log(0.01), np.log(0.1))) * rng.normal(size=light.shape)
    if "camera curve" in faults:
        light = np.maximum(light, 0) ** (1 / rng.uniform(1.0, 2.2))
    return _compressed(light) if "JPEG" in faults else light


def _compressed(light: np.ndarray) -> np.ndarray:
    """Codes of a JPEG file of quality 60, taken for light."""
    code = np.uint8(np.round(255 * np.clip(light, 0, 1)))
    file = BytesIO(iio.imwrite("<bytes>", code, extension=".jpg", quality=60))
    return np.asarray(iio.imread(file, extension=".jpg"), dtype=float) / 255
