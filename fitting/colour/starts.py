"""Where a fit of several lines begins: the scale of the rings by the ratio of the lines, the gap by their phases."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from fitting.colour.amplitudes import background
from fitting.colour.profiles import Profiles
from fitting.colour.waveform import Curve, View

# Rates are tried up to so far from each that makes the search's rings those of a line; steps of so many turns at the
# outermost of so many rings.
_REACH, _TURNS, _RINGS = 0.05, 0.12, 40.0
# Lines closer than this [m] are one for a start.
_APART = 5e-9
# Gaps that are tried [um]: a lens pressed flat is nearer than contact.
_GAPS = np.arange(-0.5, 6.0, 0.01)
_RATES, _OFFSETS = 3, 4


class Start(NamedTuple):
    """A curve to start from, and the sum of squares that its lines leave with free phases."""

    curve: Curve
    square: float


def starts(profiles: Profiles, lines: Float[np.ndarray, " lines"], scale: float, view: View) -> list[Start]:
    """The most likely curves of light of these lines; `scale`: of the search's rings [turns per px²]."""
    lines = _merged(lines)
    inner = profiles.within(0.0, _RINGS / scale)
    rates = rates_about(lines, scale, float(inner.squares.max()))
    fits = [_free_phases(inner, lines, rate) for rate in rates]
    squares = np.array([square for square, _ in fits])
    order = [at for at in np.argsort(squares) if squares[at] == squares[max(0, at - 2) : at + 3].min()]
    curves = []
    for at in order[:_RATES]:
        for offset in _offsets(fits[at][1], lines, view.sign):
            curves.append(Start(Curve(float(np.log(rates[at])), offset), float(squares[at])))
    return curves


def _merged(lines: np.ndarray) -> np.ndarray:
    """Groups of lines that lie close together, by their middles [m]."""
    ordered = np.sort(lines)
    cuts = [k + 1 for k, (low, high) in enumerate(pairwise(ordered)) if high - low > _APART]
    return np.array([group.mean() for group in np.split(ordered, cuts)])


def rates_about(lines: np.ndarray, scale: float, rim: float) -> np.ndarray:
    """Rates [m per px²] about those that make the rings one line's."""
    turns = max(scale * rim, 1.0)
    steps = max(int(np.ceil(_REACH * turns / _TURNS)), 4)
    about = np.exp(np.linspace(-_REACH, _REACH, 2 * steps + 1))
    candidates = np.sort(np.concatenate([0.5 * scale * line * about for line in lines]))
    distinct = np.ones(len(candidates), bool)
    last = candidates[0]
    for k in range(1, len(candidates)):
        distinct[k] = candidates[k] > last * (1 + 0.4 * _REACH / steps)
        last = candidates[k] if distinct[k] else last
    return candidates[distinct]


def _free_phases(profiles: Profiles, lines: np.ndarray, rate: float) -> tuple[float, np.ndarray]:
    """Sum of squares that cosines and sines of all lines leave, and their amplitudes [channels, 2, lines]."""
    turns = 2 * rate * profiles.squares[:, None] / lines
    columns = np.concatenate([np.cos(2 * np.pi * turns), np.sin(2 * np.pi * turns)], axis=1)
    smooth = background(profiles.squares, 3)
    design = np.concatenate([columns, smooth], axis=1)
    square, amplitudes = 0.0, []
    for values, weight in zip(profiles.means, profiles.weight, strict=True):
        weighted = design * weight[:, None]
        normal = design.T @ weighted + 1e-6 * weight.sum() * np.eye(design.shape[1])
        right = weighted.T @ values
        numbers = np.linalg.solve(normal, right)
        total = float(weight @ (values - np.average(values, weights=weight)) ** 2)
        residual = values - design @ numbers
        square += float(weight @ residual**2) / max(total, 1e-30)
        amplitudes.append(numbers[: columns.shape[1]].reshape(2, -1))
    return square, np.stack(amplitudes)


def _offsets(amplitudes: np.ndarray, lines: np.ndarray, sign: float) -> list[float]:
    """Gaps at the centre [um] at which the phases of all lines agree best, the nearest to contact of equals first."""
    phase = 4e-6 * np.pi * _GAPS[:, None] / lines
    cosine, sine = amplitudes.sum(axis=0)
    match = sign * (np.cos(phase) @ cosine - np.sin(phase) @ sine)
    size = float(np.hypot(amplitudes[:, 0], amplitudes[:, 1]).sum()) or 1.0
    match = match / size - 1e-3 * np.abs(_GAPS)
    peaks = 1 + np.flatnonzero((match[1:-1] >= match[:-2]) & (match[1:-1] > match[2:]))
    best = peaks[np.argsort(-match[peaks])][:_OFFSETS]
    return [float(_GAPS[at]) for at in best] or [0.0]
