"""Claim: rulers and clipped discs give the pixel size within its interval.

Made pictures: a ruler at any angle whose ticks have three lengths, beside empty glass, and a dot whose bright surround
is clipped in a half of the pictures; blur of 0.6 to 3 pixels, uneven light, noise of 1 to 3 %, rulers behind a radial
distortion of up to 3 %. With `--tilt` the discs are seen at a slant of up to 4 degrees: the standard deviation then
holds half of the stretch, and covers more.

    python -m experiments.truth.scales [--pictures 300] [--quick]
"""

import argparse

import numpy as np
from scipy import ndimage, special

import fitting
from experiments import records

SIZE = 2e-6
_SHAPE = (240, 320)


def ruler(seed: int) -> tuple[np.ndarray, float]:
    """A picture of a ruler, and the distance of its lines [m]."""
    rng = np.random.default_rng((seed, 1))
    period, angle, kappa = (
        rng.uniform(9, 22),
        rng.uniform(-0.5, 0.5) + rng.choice([0, np.pi / 2]),
        rng.uniform(-0.03, 0.03),
    )
    y, x = np.mgrid[: _SHAPE[0], : _SHAPE[1]].astype(float)
    dx, dy = x - (_SHAPE[1] - 1) / 2, y - (_SHAPE[0] - 1) / 2
    stretch = 1 + kappa * (dx**2 + dy**2) / np.hypot(*(np.array(_SHAPE) - 1)) ** 2 * 4
    along = (np.cos(angle) * dx + np.sin(angle) * dy) * stretch / period + rng.uniform()
    across = (-np.sin(angle) * dx + np.cos(angle) * dy) * stretch
    number = np.round(along)
    length = np.where(number % 10 == 0, 75, np.where(number % 5 == 0, 60, 45))
    is_line = (np.abs(along - number) * period < 0.12 * period) & (across > -40) & (across < length - 40)
    image = ndimage.gaussian_filter(np.where(is_line, 0.15, 0.8), rng.uniform(0.6, 2.0))
    return _photographed(rng, image, 1.0), SIZE * period


def dot(seed: int, tilt: float = 0.0) -> tuple[np.ndarray, float]:
    """A picture of a dark dot, and its diameter [m]."""
    rng = np.random.default_rng((seed, 2))
    radius, blur = rng.uniform(30, 95), rng.uniform(0.6, 3.0)
    centre = np.array(_SHAPE[::-1]) / 2 + rng.uniform(-10, 10, 2)
    y, x = np.mgrid[: _SHAPE[0], : _SHAPE[1]].astype(float)
    dx, dy, turn = x - centre[0], y - centre[1], rng.uniform(0, np.pi)
    along, across = np.cos(turn) * dx + np.sin(turn) * dy, -np.sin(turn) * dx + np.cos(turn) * dy
    reach = np.hypot(along, across / np.cos(tilt * rng.uniform()))
    image = 0.1 + 0.7 * 0.5 * (1 + special.erf((reach - radius) / (np.sqrt(2) * blur)))
    return _photographed(rng, image, rng.choice([1.0, 1.6])), 2 * SIZE * radius


def _photographed(rng: np.random.Generator, image: np.ndarray, exposure: float) -> np.ndarray:
    """With uneven light, noise and clipping, as codes of 8 bits that are linear."""
    y, x = np.mgrid[: image.shape[0], : image.shape[1]] / max(image.shape)
    slope = rng.uniform(-0.1, 0.1, 2)
    light = image * exposure * (1 + slope[0] * x + slope[1] * y) + rng.uniform(0.01, 0.03) * rng.normal(
        size=image.shape
    )
    return np.clip(np.round(255 * light), 0, 255).astype(np.uint8)


def deviation(kind: str, seed: int) -> float | None:
    """By how many standard deviations the pixel size is off; None where it is refused."""
    if kind == "ruler":
        image, division = ruler(seed)
        result = fitting.scale(image, ruler=division, transfer="linear")
    else:
        image, diameter = dot(seed, np.radians(4) if kind == "disc, tilted" else 0.0)
        result = fitting.scale(image, disc_diameter=diameter, transfer="linear")
    return None if result.pixel_size is None else (result.pixel_size - SIZE) / result.pixel_size_sd


def main() -> None:
    """Count how often the interval covers, print and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pictures", type=int, default=300, help="of each kind")
    parser.add_argument("--quick", action="store_true", help="12 of each kind, nothing written")
    options = parser.parse_args()
    count, record = 12 if options.quick else options.pictures, {}
    for kind in ("ruler", "disc", "disc, tilted"):
        deviations = [deviation(kind, seed) for seed in range(count)]
        answered = np.array([value for value in deviations if value is not None])
        record[kind] = {"pictures": count, "refused": count - len(answered),
                        "covered": float(np.mean(np.abs(answered) < 1.96)),
                        "largest deviation": float(np.abs(answered).max())}  # fmt: skip
        print(kind, record[kind], flush=True)
    if not options.quick:
        records.save("scales", record)


if __name__ == "__main__":
    main()
