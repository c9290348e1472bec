"""Pictures of fringes, and of none, that are no Newton's rings: negatives for the tests that refuse early."""

import numpy as np
from scipy import ndimage

# Kinds of pictures without Newton's rings, or with rings of another law.
KINDS = (
    "straight",
    "slightly bent",
    "grating",
    "two waves",
    "checkerboard",
    "spiral",
    "ellipses",
    "equidistant circles",
    "sharp rings",
    "arms",
    "speckle",
    "noise",
    "text",
    "dust",
    "gradient",
    "cloud",
)


def negative(kind: str, seed: int) -> np.ndarray:
    """Light [rows, columns] of about 0 to 1 with 1 to 20 % of noise."""
    rng = np.random.default_rng([seed, KINDS.index(kind), 31])
    rows, columns = rng.integers(260, 620, 2)
    y, x = np.mgrid[:rows, :columns].astype(float)
    image = _MAKERS[kind](rng, x, y)
    return image + np.exp(rng.uniform(np.log(0.01), np.log(0.2))) * rng.normal(size=image.shape)


def _wave(rng, x, y, period=None):
    """Turns of a plane wave with a period of 6 to 40 pixels in any direction."""
    period = period or np.exp(rng.uniform(np.log(6), np.log(40)))
    angle = rng.uniform(0, np.pi)
    return (np.cos(angle) * x + np.sin(angle) * y) / period + rng.uniform()


def _polar(rng, x, y):
    """Distance from a centre in or next to the frame, over half of its diagonal, and the angle."""
    rows, columns = x.shape
    cx, cy = rng.uniform(-0.2, 1.2, 2) * (columns, rows)
    return np.hypot(x - cx, y - cy) / (0.5 * np.hypot(rows, columns)), np.arctan2(y - cy, x - cx)


def _light(turns):
    return 0.5 + 0.5 * np.cos(2 * np.pi * turns)


def _straight(rng, x, y):
    return _light(_wave(rng, x, y))


def _bent(rng, x, y):
    """Straight fringes with the power that a camera's distortion may give them: up to 0.1 turn."""
    r, _ = _polar(rng, x, y)
    return _light(_wave(rng, x, y, rng.uniform(6, 30)) + rng.uniform(-0.1, 0.1) * r**2)


def _grating(rng, x, y):
    return (_wave(rng, x, y, rng.uniform(8, 60)) % 1 < rng.uniform(0.15, 0.5)).astype(float)


def _two(rng, x, y):
    return (_light(_wave(rng, x, y)) + _light(_wave(rng, x, y))) / 2


def _checkers(rng, x, y):
    side = rng.integers(10, 50)
    return ((x // side + y // side) % 2).astype(float)


def _spiral(rng, x, y):
    r, angle = _polar(rng, x, y)
    return _light(rng.uniform(5, 25) * r + rng.integers(1, 5) * angle / (2 * np.pi))


def _ellipses(rng, x, y):
    """Rings stretched by 1.15 to 1.6, more than a view at 25 degrees stretches them."""
    rows, columns = x.shape
    cx, cy = rng.uniform(0.1, 0.9, 2) * (columns, rows)
    angle, stretch = rng.uniform(0, np.pi), rng.uniform(1.15, 1.6)
    u, v = np.cos(angle) * (x - cx) + np.sin(angle) * (y - cy), np.cos(angle) * (y - cy) - np.sin(angle) * (x - cx)
    return _light(rng.uniform(8, 40) * (u**2 + (stretch * v) ** 2) / (0.25 * (rows**2 + columns**2)) / stretch)


def _equidistant(rng, x, y):
    r, _ = _polar(rng, x, y)
    return _light(rng.uniform(5, 25) * r + rng.uniform())


def _airy(rng, x, y):
    """Rings of many beams (Fabry and Perot), coefficient of finesse 5 to 60."""
    r, _ = _polar(rng, x, y)
    return 1 / (1 + rng.uniform(5, 60) * np.sin(np.pi * (rng.uniform(5, 20) * r**2 + rng.uniform())) ** 2)


def _arms(rng, x, y):
    """Rings that are arms of a spiral, their centre in the frame: from outside they are rings to the eye as well."""
    rows, columns = x.shape
    cx, cy = rng.uniform(0.1, 0.9, 2) * (columns, rows)
    r, angle = np.hypot(x - cx, y - cy) / (0.5 * np.hypot(rows, columns)), np.arctan2(y - cy, x - cx)
    return _light(rng.uniform(8, 25) * r**2 + rng.integers(2, 6) * angle / (2 * np.pi))


def _speckle(rng, x, _):
    width = rng.uniform(1, 8)
    field = [ndimage.gaussian_filter(rng.normal(size=x.shape), width) for _ in range(2)]
    light = field[0] ** 2 + field[1] ** 2
    return light / (4 * light.mean())


def _noise(rng, x, _):
    return 0.5 + 0.2 * rng.normal(size=x.shape)


def _text(rng, x, _):
    """Lines of blocks as wide as letters."""
    page, line = np.ones(x.shape), int(rng.integers(10, 30))
    for top in range(line, x.shape[0] - line, 2 * line):
        left = line
        while left < x.shape[1] - line:
            width = int(rng.integers(line // 4, line))
            page[top : top + line, left : left + width] = rng.uniform(0, 0.4) if rng.random() < 0.8 else 1.0
            left += width + line // 4
    return ndimage.gaussian_filter(page, 1.0)


def _dust(rng, x, y):
    image = 0.7 - 0.2 * _polar(rng, x, y)[0] ** 2
    for _ in range(int(rng.integers(20, 200))):
        at, width = rng.uniform(0, x.shape[::-1]), rng.uniform(2, 12)
        image[(x - at[0]) ** 2 + (y - at[1]) ** 2 < width**2] *= 0.3
    return image


def _gradient(rng, x, y):
    r, _ = _polar(rng, x, y)
    return 0.5 + 0.4 * x / x.max() * rng.uniform(-1, 1) + 0.4 * np.exp(-(r**2) / rng.uniform(0.1, 1))


def _cloud(rng, x, _):
    cloud = ndimage.gaussian_filter(rng.normal(size=x.shape), rng.uniform(10, 50))
    return 0.5 + 0.25 * cloud / cloud.std()


_MAKERS = {
    "straight": _straight,
    "slightly bent": _bent,
    "grating": _grating,
    "two waves": _two,
    "checkerboard": _checkers,
    "spiral": _spiral,
    "ellipses": _ellipses,
    "equidistant circles": _equidistant,
    "sharp rings": _airy,
    "arms": _arms,
    "speckle": _speckle,
    "noise": _noise,
    "text": _text,
    "dust": _dust,
    "gradient": _gradient,
    "cloud": _cloud,
}
