"""The start of a form from stepped frames: phase and steps by turns, then the phase's terms without unwrapping."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from fitting.irregularity.demodulation import robust
from fitting.irregularity.frames import Frames
from fitting.irregularity.zernike import terms_at

# Rounds of steps and phases in turn, and the steps [turns] that are tried: what people mean them to be.
_ROUNDS = 30
_MEANT = (1 / 4, 1 / 3, 1 / 5, 1 / 8)
# Pixels that a start uses, at most, and one of the many starts with tilts.
_PIXELS, _FEW = 6000, 4000
# Starts whose frames have tilts of their own; standard deviation of these, turns rms.
_TILTED, _TILT_SD = 96, 0.1
_PLANE = 3


class Start(NamedTuple):
    """A form [terms], and piston and tilts of each frame [frames, 3], in turns."""

    form: np.ndarray
    own: np.ndarray


def starts(frames: Frames, terms: int) -> list[Start]:
    """Forms and steps that stepped frames may come from."""
    count = len(frames.light)
    light = frames.light / np.maximum(frames.light.mean(axis=0), 1e-6)
    return [_followed(frames, light, np.arange(count) * step, terms) for step in _MEANT]


def tilted_starts(frames: Frames, terms: int, first: Start) -> Iterator[Start]:
    """The same where the tilt, too, changed from frame to frame, by draws of it; steps and first frame of a start.

    A third of a fringe of tilt makes the steps at one rim twice those at the other: phases by equal steps then lead
    beside the form.
    """
    rng = np.random.default_rng(0)
    light = frames.light / np.maximum(frames.light.mean(axis=0), 1e-6)
    plane = terms_at(frames.u, frames.v, _PLANE)
    for _ in range(_TILTED):
        steps = first.own - first.own[0]
        steps[1:, 1:] += _TILT_SD * rng.standard_normal((len(steps) - 1, 2))
        cosine, sine = _quadratures_by_pixel(light, steps @ plane.T)
        form = _unwrapped(frames, np.arctan2(sine, cosine) / (2 * np.pi), np.hypot(cosine, sine), terms)
        yield Start(form, form[:_PLANE] + steps)


def coarse(frames: Frames) -> Frames:
    """Every so many rows and columns of frames that a start with tilts uses."""
    step = max(round((frames.light.shape[1] / _FEW) ** 0.5), 1)
    cells = frames.cells[::step, ::step]
    kept = cells[cells >= 0]
    places = np.full(cells.shape, -1)
    places[cells >= 0] = np.arange(len(kept))
    return frames._replace(light=frames.light[:, kept], u=frames.u[kept], v=frames.v[kept], cells=places)


def _followed(frames: Frames, light: np.ndarray, steps: np.ndarray, terms: int) -> Start:
    """Phases by given steps, steps by given phases, and so on (Wang and Han 2004, Opt. Lett. 29, 1671)."""
    sample = slice(None, None, max(light.shape[1] // _PIXELS, 1))
    for _ in range(_ROUNDS):
        cosine, sine = _quadratures(light[:, sample], steps)
        design = np.stack([np.ones_like(cosine), cosine, sine], axis=1)
        answer = np.linalg.lstsq(design, light[:, sample].T, rcond=None)[0]
        turns = np.arctan2(-answer[2], answer[1]) / (2 * np.pi)
        steps = turns - turns[0]
    cosine, sine = _quadratures(light, steps)
    form = _unwrapped(frames, np.arctan2(sine, cosine) / (2 * np.pi), np.hypot(cosine, sine), terms)
    return Start(form, np.column_stack([form[0] + steps, np.tile(form[1:_PLANE], (len(steps), 1))]))


def _quadratures_by_pixel(light: np.ndarray, steps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same of steps [frames, pixels] that are others at each pixel."""
    angle = 2 * np.pi * steps
    design = np.stack([np.ones_like(angle), np.cos(angle), -np.sin(angle)], axis=2).transpose(1, 2, 0)
    # Steps that coincide at a pixel leave it without a phase, of no weight.
    normal = design @ design.transpose(0, 2, 1) + 1e-6 * np.eye(3)
    _, cosine, sine = np.linalg.solve(normal, design @ light.T[:, :, None])[:, :, 0].T
    return cosine, sine


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
