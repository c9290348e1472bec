"""Made pictures of a ruler, a disc and a ring: pixels that average their area, blur, uneven light, noise, clipping.

The pixel size is that in the middle of the picture, along the ruler, or in the mean of both axes of the disc.
"""

import numpy as np
from scipy import ndimage, special

SIZE = 2e-6
_SHAPE = (240, 320)
_HALF_DIAGONAL = float(np.hypot(_SHAPE[0] - 1, _SHAPE[1] - 1) / 2)
# Samples of a pixel along each axis.
_FINE = 3
# Digits as rows of three dots.
_DIGITS = ("757", "262", "717", "717", "557", "747", "747", "711", "757", "757"), (
    "55", "22", "14", "31", "71", "71", "75", "11", "75", "71",
)  # fmt: skip


def ruler(seed: int) -> tuple[np.ndarray, float]:
    """A picture of a ruler, and the distance of its lines [m].

    Lines of three lengths, a numeral at every tenth; any of both axes, turned by up to 0.5 rad, up to 25 px beside the
    middle; a radial distortion of up to 3 %, a slant that changes the scale by up to 1 % towards the corner.
    """
    rng = np.random.default_rng((seed, 1))
    period, width = rng.uniform(9, 22), rng.uniform(0.06, 0.14)
    angle = rng.uniform(-0.5, 0.5) + rng.choice([0, np.pi / 2])
    distortion, slants = rng.uniform(-0.03, 0.03), rng.uniform(-0.01, 0.01, 2)
    x, y = _places()
    stretch = (1 + distortion * (x**2 + y**2)) / (1 + slants[0] * x + slants[1] * y) * _HALF_DIAGONAL
    along = (np.cos(angle) * x + np.sin(angle) * y) * stretch / period + rng.uniform(-0.5, 0.5)
    across = (-np.sin(angle) * x + np.cos(angle) * y) * stretch + rng.uniform(-25, 25)
    number = np.round(along)
    length = np.where(number % 10 == 0, 75, np.where(number % 5 == 0, 60, 45))
    is_line = (np.abs(along - number) < width) & (across > -40) & (across < length - 40)
    is_dark = is_line | _is_numeral(along, (across - 40) / period, rng.uniform(0.25, 0.5))
    image = np.where(is_dark, 0.15, 0.8)
    return _photographed(rng, _blurred(image, rng.uniform(0.6, 2.0)), rng.choice([1.0, 1.25])), SIZE * period


def _is_numeral(along: np.ndarray, across: np.ndarray, dot: float) -> np.ndarray:
    """Whether a place is ink of the number of a tenth line; places and dots in distances of lines."""
    tens = np.round(along / 10).astype(int)
    column = np.floor((along - 10 * tens) / dot + 1.5).astype(int)
    row = np.floor(across / dot).astype(int)
    is_inside = (column >= 0) & (column < 3) & (row >= 0) & (row < 5)
    rows = np.array([[int(a[0]), int(b[0]), int(a[1]), int(b[1]), int(a[2])] for a, b in zip(*_DIGITS, strict=True)])
    bits = rows[np.abs(tens) % 10, np.clip(row, 0, 4)] >> (2 - np.clip(column, 0, 2))
    return is_inside & (bits % 2 == 1)


def disc(seed: int, kind: str) -> tuple[np.ndarray, float]:
    """A picture of a dark or bright disc, or of a dark ring, and its outer diameter [m].

    `kind`: "disc", "disc, tilted" by up to 4 degrees, "disc, clipped", a bright one whose inner level lies up to 60 %
    above the largest code, or "ring", of 6 to 20 px width.
    """
    rng = np.random.default_rng((seed, 2))
    radius, blur = rng.uniform(30, 95), rng.uniform(0.6, 3.0)
    centre = rng.uniform(-10, 10, 2)
    x, y = (_HALF_DIAGONAL * place for place in _places())
    dx, dy, turn = x - centre[0], y - centre[1], rng.uniform(0, np.pi)
    along, across = np.cos(turn) * dx + np.sin(turn) * dy, -np.sin(turn) * dx + np.cos(turn) * dy
    narrow = np.cos(np.radians(4) * rng.uniform()) if kind == "disc, tilted" else 1.0
    reach = np.hypot(along, across / narrow)
    edge = _step(reach - radius, blur)
    if kind == "ring":
        edge = 1 - _step(reach - radius + rng.uniform(6, 20), blur) + edge
        return _photographed(rng, _binned(0.1 + 0.7 * edge), rng.choice([1.0, 1.6])), 2 * SIZE * radius
    is_bright = kind == "disc, clipped" or rng.uniform() < 0.25
    exposure = rng.uniform(1.3, 2.0) if kind == "disc, clipped" else rng.choice([1.0, 1.6])
    return _photographed(rng, _binned(0.1 + 0.7 * (1 - edge if is_bright else edge)), exposure), 2 * SIZE * radius


def _step(distance: np.ndarray, blur: float) -> np.ndarray:
    return 0.5 * (1 + special.erf(distance / (np.sqrt(2) * blur)))


def _places() -> tuple[np.ndarray, np.ndarray]:
    """Samples from the middle of the picture, in half diagonals."""
    rows, columns = (count * _FINE for count in _SHAPE)
    y, x = np.mgrid[:rows, :columns].astype(float)
    unit = _FINE * _HALF_DIAGONAL
    return (x - (columns - 1) / 2) / unit, (y - (rows - 1) / 2) / unit


def _blurred(image: np.ndarray, blur: float) -> np.ndarray:
    return _binned(ndimage.gaussian_filter(image, blur * _FINE))


def _binned(image: np.ndarray) -> np.ndarray:
    rows, columns = _SHAPE
    return image.reshape(rows, _FINE, columns, _FINE).mean(axis=(1, 3))


def _photographed(rng: np.random.Generator, image: np.ndarray, exposure: float) -> np.ndarray:
    """With uneven light, noise and clipping, as codes of 8 bits that are linear."""
    y, x = np.mgrid[: image.shape[0], : image.shape[1]] / max(image.shape)
    slope, noise = rng.uniform(-0.1, 0.1, 2), rng.uniform(0.01, 0.03)
    light = image * exposure * (1 + slope[0] * x + slope[1] * y) + noise * rng.normal(size=image.shape)
    return np.clip(np.round(255 * light), 0, 255).astype(np.uint8)
