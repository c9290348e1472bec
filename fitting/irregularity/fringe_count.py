"""How many fringes a picture can hold at most, before any form is looked for."""

import numpy as np

from fitting.irregularity.disc import EDGE, Disc, Pupil, around, disc_of, reduced

# Diameter of the reduced picture [px]; share of the variance that it must keep, so that fine fringes, which it
# averages out, are not judged.
_DIAMETER, _RETAINED = 110, 0.8
# Of 160 made pictures of 6 fringes and more (blur, dust, gamma, 20 % of noise, light that falls to a tenth) the least
# count is 8.0; phase-stepped pictures of a mirror, with 3 fringes and speckle, have 4.2 to 4.5.
LEAST_COUNT = 5.0


def fringe_count(image: np.ndarray, mask: np.ndarray, pupil: Pupil) -> float | None:
    """Fringes per diameter by the root mean square gradient of the light [rows, columns], its quadratic taken out.

    sqrt(<|grad I|²> / <I²>) / 2π is the rms frequency of a cosine; over a diameter it is at least the number of fringes
    of a tilt, 1.4 times that of a saddle, 2.8 times that of a bowl, and noise adds to it. None where the reduced
    picture has lost much of the variance, and says nothing of its fringes.
    """
    image, mask, pupil = around(image, mask, pupil)
    factor = max(int(2 * pupil.radius / _DIAMETER), 1)
    means, used = reduced(image, mask, factor)
    small = pupil.reduced(factor)
    disc = disc_of(means, used, small)
    if _variance(means, used, small) < _RETAINED * _variance(image, mask, pupil):
        return None
    light = _without_quadratic(disc)
    frequency = np.sqrt(_gradient(light, disc.weights) / max(_mean(np.square(light), disc.weights), 1e-30))
    return float(frequency / (np.pi * disc.pixel))


def _variance(image: np.ndarray, mask: np.ndarray, pupil: Pupil) -> float:
    """The variance of the light in the pupil."""
    rows, columns = image.shape
    v = (np.arange(rows, dtype=np.float32) - np.float32(pupil.y)) / np.float32(EDGE * pupil.radius)
    u = (np.arange(columns, dtype=np.float32) - np.float32(pupil.x)) / np.float32(EDGE * pupil.radius)
    used = mask & (np.square(v)[:, None] + np.square(u) <= 1)
    return float(image[used].var(dtype=float)) if used.any() else 0.0


def _without_quadratic(disc: Disc) -> np.ndarray:
    """The light less its polynomial of degree 2, which is that of the illumination."""
    u, v = np.meshgrid(disc.u, disc.v)
    used = disc.weights > 0
    design = np.stack([np.ones_like(u), u, v, u * u, u * v, v * v], axis=-1)
    terms = np.linalg.lstsq(design[used], disc.light[used].astype(float), rcond=None)[0]
    return np.where(used, disc.light - design @ terms, 0.0)


def _gradient(light: np.ndarray, weights: np.ndarray) -> float:
    """Mean of |gradient|² [1/px²], by central differences between used pixels."""
    total = 0.0
    for values, used in ((light, weights), (light.T, weights.T)):
        rises = (values[2:] - values[:-2]) / 2
        total += _mean(np.square(rises), used[2:] * used[1:-1] * used[:-2])
    return total


def _mean(values: np.ndarray, weights: np.ndarray) -> float:
    return float((values * weights).sum(dtype=float) / max(weights.sum(dtype=float), 1.0))
