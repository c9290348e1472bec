"""Weights of pixels by the camera's noise: one over its variance at the light that the model says.

Not at the light that was seen: where noise made a pixel darker it would count more, which biases the fit.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from fitting.estimate.fitted import Fitted
from fitting.parameters import number
from fitting.photo import Photograph, block_means, median
from newtonjax.numerics import shown
from newtonjax.scene import Scene

# A variance below this share of the mean one is that, and one of "shot" below that: a code is rounded, and a dark
# fringe holds the camera's read noise.
_LEAST, _DARK = 1e-3, 0.01
# Levels of light at which the variance is estimated, each of as many blocks; blocks that each needs.
_LEVELS, _FEWEST = 16, 200
# Median of the absolute value of a normal deviate.
_MEDIAN = 0.67449
_ALLOWED = (
    '"estimated", "shot", a pair (full well, read noise) in photoelectrons, or variances of the image\'s shape, which '
    "are positive"
)


@dataclass(frozen=True)
class Noise:
    """What is known of the noise: that it is to be `estimated`, photoelectrons, or the variance of each pixel.

    - `electrons`: full well and read noise, (1, 0) where shot noise is all.
    - `variances` [rows, columns] in any unit.
    """

    words: str
    electrons: tuple[float, float] | None = None
    variances: Float[np.ndarray, "rows columns"] | None = None

    def variance(self, fit: Fitted, photograph: Photograph) -> Float[np.ndarray, "rows columns"]:
        """Of the noise of a pixel in every block of a fit, in any unit."""
        reduced = fit.reduced
        level = (reduced.light + reduced.offset - fit.left.value).astype(float)
        if self.variances is not None:
            return _at_blocks(self.variances, fit)
        if self.electrons is not None:
            full_well, read_noise = self.electrons
            variance = full_well * photograph.codes.curve.unit * np.maximum(level, 0.0) + read_noise**2
        else:
            variance = _estimated(fit, level)
        least = _DARK if self.electrons is not None and not self.electrons[1] else _LEAST
        return np.maximum(variance, least * float(variance[reduced.used].mean()))


def checked_noise(noise: Any, shape: tuple[int, ...], scene: Scene | None) -> Noise:
    """What the user says of the noise. Raises ValueError for anything else, and beside a bench of many beams."""
    if scene is not None and scene.all_orders is not None:
        raise ValueError("noise is of rings of two beams, and the scene has all orders; leave noise out")
    if isinstance(noise, str):
        if noise not in ("estimated", "shot"):
            raise ValueError(f"noise is {shown(noise)}; allowed: {_ALLOWED}")
        return Noise(noise, (1.0, 0.0) if noise == "shot" else None)
    if isinstance(noise, tuple | list) and len(noise) == 2 and all(np.ndim(one) == 0 for one in noise):
        full_well, read_noise = (number("noise", one) for one in noise)
        if not (full_well > 0 and read_noise >= 0):
            raise ValueError(f"noise is {shown(noise)}; allowed: a full well above 0, and a read noise of 0 or more")
        return Noise(f"full well {full_well:g}, read noise {read_noise:g} photoelectrons", (full_well, read_noise))
    variances = np.asarray(noise)
    if (
        variances.shape != shape
        or variances.dtype.kind not in "iuf"
        or not np.all((variances > 0) & (variances < np.inf))
    ):
        raise ValueError(f"noise is {shown(noise)}; allowed: {_ALLOWED}")
    return Noise("variances of the pixels", variances=variances)


def _at_blocks(variances: np.ndarray, fit: Fitted) -> np.ndarray:
    """Means over blocks; those that the frame's far edges cut off are of their nearest pixels."""
    grid = fit.reduced.grid
    beyond = [(0, -n % grid.block) for n in variances.shape]
    means = block_means(np.pad(variances.astype(float), beyond, mode="edge"), grid.block)
    return means[slice(*grid.rows), slice(*grid.columns)]


def _estimated(fit: Fitted, level: np.ndarray) -> np.ndarray:
    """By level of light, from the median of what the fit leaves over there."""
    reduced = fit.reduced
    at = level[reduced.used]
    residual = np.abs(fit.left.value * np.sqrt(reduced.weights))[reduced.used]
    levels = min(_LEVELS, len(at) // _FEWEST)
    if levels < 2:
        return np.ones_like(level)
    order = np.array_split(np.argsort(at), levels)
    middles = np.array([at[one].mean() for one in order])
    return np.interp(level, middles, [(median(residual[one]) / _MEDIAN) ** 2 for one in order])
