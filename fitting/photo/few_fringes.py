"""Few fringes and the light behind them, fitted together.

A background taken off before the search takes part of few fringes with it: of three or four, with the centre outside of
the field, it moved the scale by up to 30 %. Here the background is a polynomial whose coefficients, with the fringes'
amplitude and phase, are solved for at each step (variable projection: Golub and Pereyra 1973).
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.polynomial.chebyshev import chebvander

from fitting.photo.matched_filter import Rings
from fitting.photo.reading import Photograph
from fitting.photo.view import box_of, view_of

# More fringes than this lose nothing to a background taken off first.
MANY = 10.0
# Blocks to a side of the image that is fitted, and cycles of the finest fringe in one.
_ACROSS, _RESOLVED = 72, 0.2
# Scales to start from, over the search's; its wave vector at the field's middle is kept.
_FACTORS = (1.0, 0.6, 1.6)
# An optimum that many times the search's scale away is another one.
_FURTHEST = 5.0
_STEPS, _DONE = 25, 1e-6
_DEGREE = 4


def with_background(photograph: Photograph, rings: Rings) -> Rings:
    """The rings next to some of few fringes, fitted together with a background; those given where none are nearer."""
    longest = max(part.stop - part.start for part in box_of(photograph))
    view = view_of(photograph, max(1, -(-longest // _ACROSS)))
    on_blocks = view.shown(rings)
    if on_blocks.finest(view.means.shape) > _RESOLVED or view.mask.sum() < 10 * _DEGREE**2:
        return rings
    blocks = _Blocks(view.means, view.mask)
    start = blocks.phase_of(on_blocks)
    optima = [blocks.converged(start._replace(bend=factor * start.bend)) for factor in _FACTORS]
    square, phase = min(optima, key=lambda pair: pair[0])
    if not np.isfinite(square) or not 1 / _FURTHEST < abs(phase.bend) / start.bend < _FURTHEST:
        return rings
    return view.placed(blocks.rings(phase, rings.match))


class _Phase(NamedTuple):
    """Turns of phase but for a constant: bend ρ² + along_u u + along_v v, in the units of `_Blocks`."""

    bend: float
    along_u: float
    along_v: float


@dataclass(frozen=True)
class _Blocks:
    """Block means of a field; u, v and ρ are from its middle, over half the longer side."""

    means: np.ndarray
    mask: np.ndarray

    @cached_property
    def half(self) -> float:
        return max(self.means.shape) / 2

    @cached_property
    def middle(self) -> np.ndarray:
        rows, columns = self.means.shape
        return np.array([(columns - 1) / 2, (rows - 1) / 2])

    @cached_property
    def places(self) -> np.ndarray:
        """ρ², u, v of the used blocks [blocks, 3]."""
        y, x = np.nonzero(self.mask)
        u, v = (x - self.middle[0]) / self.half, (y - self.middle[1]) / self.half
        return np.stack([u**2 + v**2, u, v], axis=1)

    @cached_property
    def background(self) -> np.ndarray:
        """Polynomials of degree 4 [blocks, 15]."""
        u, v = (chebvander(self.places[:, k], _DEGREE) for k in (1, 2))
        return np.stack([v[:, j] * u[:, i] for j in range(_DEGREE + 1) for i in range(_DEGREE + 1 - j)], axis=1)

    def phase_of(self, rings: Rings) -> _Phase:
        """The phase of rings on the blocks."""
        bend = rings.scale * self.half**2
        along_u, along_v = -2 * bend * (np.array(rings.centre) - self.middle) / self.half
        return _Phase(bend, float(along_u), float(along_v))

    def rings(self, phase: _Phase, match: float) -> Rings:
        """The rings on the blocks that have such a phase, with a positive scale."""
        basis = self._basis(phase)
        cosine, sine = np.linalg.lstsq(basis, self.means[self.mask], rcond=1e-12)[0][-2:]
        k = phase.bend
        u, v = -np.array([phase.along_u, phase.along_v]) / (2 * k)
        turns = -float(np.arctan2(sine, cosine)) / (2 * np.pi) - k * (u**2 + v**2)
        x, y = self.middle + self.half * np.array([u, v])
        sign = 1.0 if k > 0 else -1.0
        scale, constant = abs(k) / self.half**2, (sign * turns + 0.5) % 1.0 - 0.5
        return Rings(float(scale), (float(x), float(y)), float(constant), match)

    def converged(self, start: _Phase) -> tuple[float, _Phase]:
        """Sum of squares and phase at the optimum next to a start (Levenberg and Marquardt)."""
        damping, phase = 1e-3, start
        residual, slope = self._residual(phase)
        for _ in range(_STEPS):
            normal = slope.T @ slope
            step = np.linalg.lstsq(normal + damping * np.diag(np.diag(normal)), slope.T @ residual, rcond=1e-14)[0]
            further = _Phase(*(np.array(phase) + step))
            trial = self._residual(further)
            gain = residual @ residual - trial[0] @ trial[0]
            if gain <= 0:
                damping *= 10.0
                if damping > 1e6:
                    break
                continue
            done = gain < _DONE * (residual @ residual)
            phase, (residual, slope), damping = further, trial, 0.3 * damping
            if done:
                break
        return float(residual @ residual), phase

    def _basis(self, phase: _Phase) -> np.ndarray:
        angle = 2 * np.pi * (self.places @ np.array(phase))
        return np.concatenate([self.background, np.stack([np.cos(angle), np.sin(angle)], axis=1)], axis=1)

    def _residual(self, phase: _Phase) -> tuple[np.ndarray, np.ndarray]:
        """The residual, and the model's derivatives with what the linear coefficients take of them projected out."""
        basis = self._basis(phase)
        directions, triangle = np.linalg.qr(basis)
        along = directions.T @ self.means[self.mask]
        cosine, sine = np.linalg.lstsq(triangle, along, rcond=1e-12)[0][-2:]
        turned = 2 * np.pi * (sine * basis[:, -2] - cosine * basis[:, -1])
        slope = turned[:, None] * self.places
        return self.means[self.mask] - directions @ along, slope - directions @ (directions.T @ slope)
