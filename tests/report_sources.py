"""Pictures and tables that the verbs measure, or refuse, made anew in each test."""

from pathlib import Path

import imageio.v3 as iio
import numpy as np

COLUMN, ROW = np.arange(320.0), np.arange(320.0)[:, None]


def grey(image) -> np.ndarray:
    noise = np.random.default_rng(1).normal(0, 0.01, image.shape)
    return np.uint8(np.clip(255 * (image + noise), 0, 255))


def wedge() -> np.ndarray:
    return grey(0.5 + 0.4 * np.cos(2 * np.pi * (COLUMN / 22.0 + ROW / 60.0)))


def grid() -> np.ndarray:
    lines = [np.abs((place + 8) % 20 - 10) < 2 for place in (COLUMN + 0 * ROW, ROW + 0 * COLUMN)]
    return grey(0.8 - 0.6 * (lines[0] | lines[1]))


def form() -> np.ndarray:
    x, y = (COLUMN - 160) / 140, (ROW - 160) / 140
    fringes = 0.5 + 0.4 * np.cos(2 * np.pi * (8 * x + 0.6 * (x * x + y * y)))
    return grey(np.where(np.hypot(x, y) < 1, fringes, 0.02))


def noise() -> np.ndarray:
    return grey(np.random.default_rng(0).uniform(0.2, 0.8, (320, 320)))


TABLE = "order,diameter_mm\n" + "\n".join(f"{m},{2e3 * (m * 589.3e-9) ** 0.5:.4f}" for m in range(3, 14))
STRAIGHT = "order,position_mm\n" + "\n".join(f"{m},{0.5 * m + 0.003 * (-1) ** m:.4f}" for m in range(12))


def picture_file(path: Path, image: np.ndarray) -> Path:
    """A picture as a file."""
    iio.imwrite(path, image)
    return path


def picture_bytes(image: np.ndarray) -> bytes:
    """A picture as the bytes of a PNG file."""
    return iio.imwrite("<bytes>", image, extension=".png")
