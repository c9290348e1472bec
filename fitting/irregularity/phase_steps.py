"""The start of a form from stepped frames: phase and steps by turns, then the phase's terms without unwrapping."""

import numpy as np

from fitting.irregularity.demodulation import robust
from fitting.irregularity.frames import Frames
from fitting.irregularity.zernike import terms_at

# Rounds of steps and phases in turn, and the steps [turns] that are tried: what people mean them to be.
_ROUNDS = 30
_MEANT = (1 / 4, 1 / 3, 1 / 5, 1 / 8)
# Pixels that a start uses, at most.
_PIXELS = 6000


def starts(frames: Frames, terms: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Forms [terms] and steps [frames], both in turns, that stepped frames may come from."""
    count = len(frames.light)
    light = frames.light / np.maximum(frames.light.mean(axis=0), 1e-6)
    return [_followed(frames, light, np.arange(count) * step, terms) for step in _MEANT]


def _followed(frames: Frames, light: np.ndarray, steps: np.ndarray, terms: int) -> tuple[np.ndarray, np.ndarray]:
    """Phases by given steps, steps by given phases, and so on (Wang and Han 2004, Opt. Lett. 29, 1671)."""
    sample = slice(None, None, max(light.shape[1] // _PIXELS, 1))
    for _ in range(_ROUNDS):
        cosine, sine = _quadratures(light[:, sample], steps)
        design = np.stack([np.ones_like(cosine), cosine, sine], axis=1)
        answer = np.linalg.lstsq(design, light[:, sample].T, rcond=None)[0]
        turns = np.arctan2(-answer[2], answer[1]) / (2 * np.pi)
        steps = turns - turns[0]
    cosine, sine = _quadratures(light, steps)
    return _unwrapped(frames, np.arctan2(sine, cosine) / (2 * np.pi), np.hypot(cosine, sine), terms), steps


def _quadratures(light: np.ndarray, steps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """M cos and M sin of the phase at each pixel, of frames B + M cos 2π(φ + step)."""
    angle = 2 * np.pi * steps
    design = np.column_stack([np.ones(len(steps)), np.cos(angle), -np.sin(angle)])
    _, cosine, sine = np.linalg.lstsq(design, light, rcond=1e-6)[0]
    return cosine, sine


def _unwrapped(frames: Frames, turns: np.ndarray, weights: np.ndarray, terms: int) -> np.ndarray:
    """Terms of a wrapped phase: of its steps from pixel to pixel, modulo turns, then of the phase about these."""
    values = terms_at(frames.u, frames.v, terms)
    cells = frames.cells
    pairs = [(cells[:, :-3], cells[:, 3:]), (cells[:-3], cells[3:])]
    joined = [(a[(a >= 0) & (b >= 0)], b[(a >= 0) & (b >= 0)]) for a, b in pairs]
    first, second = (np.concatenate([pair[k] for pair in joined])[::4] for k in (0, 1))
    rise = turns[second] - turns[first]
    rise -= np.round(rise)
    weight = np.minimum(weights[first], weights[second])
    form = np.zeros(terms)
    form[1:] = robust(values[second, 1:] - values[first, 1:], rise, weight)
    for _ in range(6):
        residual = turns - values @ form
        form[0] += np.angle((weights * np.exp(2j * np.pi * residual)).sum()) / (2 * np.pi)
        residual = turns - values @ form
        form += robust(values, residual - np.round(residual), weights)
    return form
