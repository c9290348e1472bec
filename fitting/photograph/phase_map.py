"""Where fringes lie against a fit of them: an image demodulated by the fit's phase, and unwrapped."""

import numpy as np
from scipy import ndimage

from fitting.estimate import Fitted
from fitting.model import gap_phase, numbers_of
from fitting.parameters import slots_of
from fitting.photo import block_means

# A phase that misses the fringes by more than this (root mean square) [turns] is followed from block to block first;
# that takes so many fringes, and so many blocks to a side.
_ASTRAY, _MANY, _BLOCKS = 0.1, 20.0, 40


def followed(fit: Fitted, parts: tuple[str, ...]) -> np.ndarray | None:
    """Numbers to start a fit with parts from where the fit leaves whole fringes astray: the phase map's, else None."""
    numbers, model = fit.numbers, fit.solution.problem.phase.exact
    if model is None or fit.orders < _MANY:
        return None
    x, y, difference, strength = phase_map(fit)
    if not np.any(strength) or np.sqrt(np.average(difference**2, weights=strength)) < _ASTRAY:
        return None
    names = ("curvature", "centre_x", "centre_y", "phase", *numbers_of(parts))
    target, root = gap_phase.phase(model, x, y, numbers) + difference, np.sqrt(strength)
    trial = numbers.copy()
    for _ in range(4):
        phase, slopes = gap_phase.phase_and_slopes(model, x, y, trial)
        slope = np.stack([slopes[name] for name in names], axis=1) * root[:, None]
        trial[slots_of(names)] += np.linalg.lstsq(slope, (target - phase) * root, rcond=1e-12)[0]
    return trial if np.isfinite(trial).all() else None


def phase_map(fit: Fitted) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """By how much the fringes are ahead of the fit, place by place: x, y [px], turns, and strength.

    The image is demodulated by the fit's phase, averaged over some forty places to a side, and its argument unwrapped.
    """
    from skimage.restoration import unwrap_phase

    reduced = fit.reduced
    factor = max(2, min(reduced.light.shape) // _BLOCKS)
    used = reduced.used
    background = block_means(reduced.light, factor)
    turns = np.exp(-2j * np.pi * fit.phase) * used
    total, share = block_means(reduced.light * turns, factor), block_means(turns, factor)
    covered = block_means(used.astype(float), factor)
    phasors = total - share * background / np.maximum(covered, 1e-3)
    phasors = ndimage.gaussian_filter(phasors.real, 0.7) + 1j * ndimage.gaussian_filter(phasors.imag, 0.7)
    good = covered > 0.5
    strength = np.where(good, np.abs(phasors) ** 2, 0.0)
    good &= strength > 0.1 * np.median(strength[good]) if good.any() else False
    difference = np.ma.filled(unwrap_phase(np.ma.array(np.angle(phasors), mask=~good)), 0.0) / (2 * np.pi)
    y, x = np.meshgrid(
        *(block_means(at[:, None] * np.ones(factor), factor)[:, 0] for at in (reduced.grid.y, reduced.grid.x)),
        indexing="ij",
    )
    difference -= np.round(np.average(difference[good], weights=strength[good])) if good.any() else 0.0
    return x.ravel(), y.ravel(), difference.ravel(), np.where(good, strength, 0.0).ravel()
