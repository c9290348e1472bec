"""Whether the codes follow the light: the fringes' second harmonic, and the exponent that takes it away."""

import numpy as np
from numpy.polynomial.chebyshev import chebvander

from fitting.illumination import Fitted
from fitting.photo import Photograph
from fitting.smoothing import fringe_correlation, thin

_PIXELS = 30_000
# A second harmonic below this share of the first moves no radius by its noise, and one within so many standard
# deviations is noise.
_SMALL, _SIGNIFICANT = 0.02, 6.0
_EXPONENTS = np.exp(np.linspace(np.log(0.3), np.log(3.5), 13))


def linearized(photograph: Photograph, found: Fitted) -> Photograph | None:
    """The photograph with its codes raised to the exponent that makes the fringes sinusoidal; None for no need of it.

    At the fit's phase, fringes of two beams are a background and one cosine; a power law of the camera adds harmonics.
    The exponent is the one that leaves the least share of the variance over.
    """
    phase = found.phase
    sample = thin(photograph.mask, _PIXELS)
    used = photograph.mask[sample] & (found.weights[sample] > 0)
    light, turns = photograph.image[sample][used], phase[sample][used]
    if not _is_bent(photograph, found, sample, used, turns):
        return None
    design = _design(photograph.image.shape, sample, used, turns)
    basis = np.linalg.qr(design)[0]

    def left(exponent: float) -> float:
        value = _raised(light, exponent)
        value = value - value.mean()
        return 1 - float(((basis.T @ value) ** 2).sum() / (value @ value))

    tried = [left(exponent) for exponent in _EXPONENTS]
    at = int(np.clip(np.argmin(tried), 1, len(tried) - 2))
    a, b, c = tried[at - 1 : at + 2]
    bend = a - 2 * b + c
    step = np.log(_EXPONENTS[1] / _EXPONENTS[0])
    exponent = float(_EXPONENTS[at] * np.exp(step * np.clip(0.5 * (a - c) / bend if bend > 0 else 0.0, -1, 1)))
    if left(exponent) > 0.98 * left(1.0):
        return None
    name = f"{photograph.transfer}, then exponent {exponent:.3g} (fitted)"
    return photograph.raised(exponent, name)


def _raised(light: np.ndarray, exponent: float) -> np.ndarray:
    return np.sign(light) * np.abs(light) ** exponent


def _is_bent(photograph: Photograph, found: Fitted, sample, used: np.ndarray, turns: np.ndarray) -> bool:
    """Whether the residual holds a second harmonic in phase with the fringes, beyond its noise."""
    residual = photograph.image - found.fitted
    modulus = found.fitted[sample][used]
    swing = float(np.std(modulus)) * np.sqrt(2)
    wave = np.cos(4 * np.pi * turns)
    wave = wave - wave.mean()
    amplitude = float(residual[sample][used] @ wave / (wave @ wave))
    inflation = fringe_correlation(residual, found.weights, 2 * found.phase)
    noise = float(np.std(residual[sample][used])) / np.sqrt(wave @ wave)
    spread = noise * np.sqrt(max(inflation * len(turns) / max(found.weights.sum(), 1.0), 1.0))
    return bool(abs(amplitude) > max(_SMALL * swing, _SIGNIFICANT * spread))


def _design(shape: tuple[int, int], sample, used: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Columns of a smooth background and a smooth contrast times the cosine, at some of the pixels."""
    along = [chebvander(np.linspace(-1, 1, n)[part], 4) for n, part in zip(shape, sample, strict=True)]
    pairs = [(j, i) for total in range(5) for j in range(total + 1) for i in [total - j]]
    smooth = np.stack([np.outer(along[0][:, j], along[1][:, i])[used] for j, i in pairs], axis=1)
    return np.concatenate([smooth, smooth[:, :6] * np.cos(2 * np.pi * turns)[:, None]], axis=1)
