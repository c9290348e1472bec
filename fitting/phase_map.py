"""Where fringes lie against a fit of them: an image demodulated by the fit's phase, and unwrapped."""

from dataclasses import replace
from itertools import chain

import jax.numpy as jnp
import numpy as np
from scipy import ndimage

from fitting.illumination import Fitted, fringes_seen, numbers_of
from fitting.models import PARTS, SceneModel, as_arrays, localize
from fitting.photo import Photograph
from fitting.smoothing import reduce

# A phase that misses the fringes by more than this (root mean square) [turns] is followed from block to block first;
# that takes so many fringes, and so many blocks to a side.
_ASTRAY, _MANY, _BLOCKS = 0.1, 20.0, 40


def followed(found: Fitted, photograph: Photograph, parts: tuple[str, ...]) -> np.ndarray:
    """Numbers to start a fit with parts from: the fit's, or where these leave whole fringes astray, the phase map's."""
    numbers = numbers_of(found)
    if isinstance(found.model, SceneModel) or fringes_seen(found.solution.image[2], photograph.mask) < _MANY:
        return numbers
    x, y, away, strength = phase_map(found, photograph)
    if not np.any(strength) or np.sqrt(np.average(away**2, weights=strength)) < _ASTRAY:
        return numbers
    frame = found.model.frame._replace(x=x, y=y)
    model = as_arrays(replace(found.model, frame=frame))
    moving = [0, 1, 2, 3, *chain.from_iterable(PARTS[part] for part in parts)]
    wanted, root = np.asarray(localize(model, jnp.asarray(numbers)).value[0]) + away, np.sqrt(strength)
    trial = numbers.copy()
    for _ in range(4):
        local = localize(model, jnp.asarray(trial))
        slope = np.asarray(local.slope[0])[:, moving] * root[:, None]
        trial[moving] += np.linalg.lstsq(slope, (wanted - np.asarray(local.value[0])) * root, rcond=1e-12)[0]
    return trial if np.isfinite(trial).all() else numbers


def phase_map(found: Fitted, photograph: Photograph) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """By how much the fringes are ahead of the fit, block by block: places x, y [px], turns, and strength.

    The image is demodulated by the fit's phase, averaged over blocks, and its argument unwrapped over the field.
    """
    from skimage.restoration import unwrap_phase

    factor = max(2, min(photograph.image.shape) // _BLOCKS)
    background = reduce(np.where(photograph.mask, photograph.image, 0.0), factor)
    turns = np.exp(-2j * np.pi * found.phase) * photograph.mask
    total, share = reduce(photograph.image * turns, factor), reduce(turns, factor)
    covered = reduce(photograph.mask.astype(float), factor)
    phasors = total - share * background / np.maximum(covered, 1e-3)
    phasors = ndimage.gaussian_filter(phasors.real, 0.7) + 1j * ndimage.gaussian_filter(phasors.imag, 0.7)
    good = covered > 0.5
    strength = np.where(good, np.abs(phasors) ** 2, 0.0)
    good &= strength > 0.1 * np.median(strength[good]) if good.any() else False
    away = np.ma.filled(unwrap_phase(np.ma.array(np.angle(phasors), mask=~good)), 0.0) / (2 * np.pi)
    rows, columns = (np.arange(n) * factor + (factor - 1) / 2 for n in phasors.shape)
    y, x = np.meshgrid(rows, columns, indexing="ij")
    away -= np.round(np.average(away[good], weights=strength[good])) if good.any() else 0.0
    return x.ravel(), y.ravel(), away.ravel(), np.where(good, strength, 0.0).ravel()
