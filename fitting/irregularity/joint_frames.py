"""The form of stepped frames by least squares, their illumination free at every pixel (Golub and Pereyra 1973).

I_k(x) = s_k E(x) (1 + V cos 2π φ_k(x)), φ_k = Σ_{j>3} p_j Z_j + piston and tilts of frame k. For given numbers the best
E is one division a pixel; speckle multiplies, so a pixel weighs as the inverse of its mean light; in light without
speckle all weigh the same, as weights of noisy light would go together with its noise.
"""

from dataclasses import dataclass

import numpy as np

from fitting.irregularity.frames import Frames
from fitting.irregularity.zernike import terms_at

_STEPS, _STILL = 25, 1e-5
# The fit has converged where a step would lower chi-squared by no more.
_NOTHING = 1e-3
# Added to a pixel's mean light, as a share of that of all.
_FLOOR = 0.05
# Piston and two tilts, of each frame.
_OWN = 3


@dataclass(frozen=True)
class FramesFit:
    """Least squares at its optimum.

    - `form` [terms - 3]: turns, from power on; `own` [frames, 3]: piston and tilts; `gains` [frames]; `visibility`.
    - `covariance` [terms - 3, terms - 3]: of the form for white noise; `variance`: of a pixel's weighted light.
    - `even` [pixels]: the illumination.
    - `residual`, `score` [frames, pixels]: weighted; what is left, and its product with the phase's slope.
    """

    form: np.ndarray
    own: np.ndarray
    gains: np.ndarray
    visibility: float
    covariance: np.ndarray
    variance: float
    even: np.ndarray
    residual: np.ndarray
    score: np.ndarray
    converged: bool


def fit_frames(frames: Frames, form: np.ndarray, own: np.ndarray) -> FramesFit:
    """The optimum next to a form [terms], with piston and tilts of each frame [frames, 3], turns."""
    return _optimum(FramesState(frames, form[_OWN:], own, np.ones(len(own)), 0.7))


def refit_frames(frames: Frames, fit: FramesFit, terms: int) -> FramesFit:
    """The optimum with so many terms next to another one."""
    form = np.zeros(terms - _OWN)
    count = min(len(form), len(fit.form))
    form[:count] = fit.form[:count]
    return _optimum(FramesState(frames, form, fit.own, fit.gains, fit.visibility))


def _optimum(state: "FramesState") -> FramesFit:
    damping, converged = 1e-4, False
    for _ in range(_STEPS):
        matrix, slope = state.normal()
        scaled = matrix + damping * np.diag(np.diag(matrix))
        step = np.linalg.lstsq(scaled, slope, rcond=1e-12)[0]
        # Single precision does not show so small a gain in the sum of squares.
        if float(step @ slope) < _NOTHING * state.square / state.residual.size:
            converged = True
            break
        trial = state.moved(step)
        if trial.square > state.square * (1 + 1e-9):
            damping = min(100 * damping, 1e3)
            continue
        largest = float(np.abs(step[: len(state.form)]).max())
        state, damping = trial, damping / 30
        if largest < _STILL:
            converged = True
            break
    return state.answer(converged)


class FramesState:
    """Frames, model and residual at given numbers."""

    def __init__(self, frames: Frames, form: np.ndarray, own: np.ndarray, gains: np.ndarray, visibility: float):
        self.frames = frames
        self.form, self.own, self.gains, self.visibility = form, own, gains, visibility
        light = frames.light
        mean = light.mean(axis=0) if frames.is_speckled else light.mean()
        self.weights = 1 / (mean + _FLOOR * mean.mean())
        self.values = terms_at(frames.u, frames.v, _OWN + len(form)).astype(np.float32)
        turns = (self.values[:, _OWN:] @ form.astype(np.float32))[None] + own.astype(np.float32) @ self.values[
            :, :_OWN
        ].T
        angle = (2 * np.pi * (turns - np.round(turns))).astype(np.float32)
        self.cosine, self.sine = np.cos(angle), np.sin(angle)
        self.shape = gains[:, None].astype(np.float32) * (1 + np.float32(visibility) * self.cosine)
        self.even = (self.shape * light).sum(axis=0) / np.maximum((self.shape**2).sum(axis=0), 1e-12)
        self.residual = self.weights * (light - self.even * self.shape)
        self.square = float(np.square(self.residual, dtype=float).sum())

    def free_of_light(self, fields: np.ndarray) -> np.ndarray:
        """Fields [frames, pixels] without what the illumination takes up."""
        unit = self.shape / np.sqrt(np.maximum((self.shape**2).sum(axis=0), 1e-12))
        return fields - unit * (unit * fields).sum(axis=0)

    def _rates(self) -> np.ndarray:
        """How the weighted light of a frame changes with its phase [frames, pixels]."""
        factor = -2 * np.pi * self.visibility * self.gains[:, None] * self.sine
        return (self.weights * self.even * factor).astype(np.float32)

    def normal(self) -> tuple[np.ndarray, np.ndarray]:
        """Normal matrix and slope by form, own phases, gains but the first, and visibility."""
        flat = self.columns()
        return (flat @ flat.T).astype(float), (flat @ self.residual.reshape(-1).astype(np.float32)).astype(float)

    def columns(self) -> np.ndarray:
        """How the weighted light changes with each of these numbers [numbers, frames pixels]."""
        count, pixels = self.residual.shape
        rates, lit = self._rates(), self.weights * self.even
        terms, free_gains = len(self.form), count - 1
        size = terms + _OWN * count + free_gains + 1
        columns = np.zeros((size, count, pixels), np.float32)
        columns[:terms] = rates[None] * self.values[:, _OWN:].T[:, None]
        for k in range(count):
            columns[terms + _OWN * k : terms + _OWN * (k + 1), k] = rates[k] * self.values[:, :_OWN].T
        for k in range(free_gains):
            frame = k + count - free_gains
            columns[terms + _OWN * count + k, frame] = lit * (1 + self.visibility * self.cosine[frame])
        columns[-1] = lit * self.gains[:, None] * self.cosine
        return self._projected(columns)

    def columns_of(self, frame: int) -> np.ndarray:
        """The same by a form of its own of one frame."""
        columns = np.zeros((len(self.form), *self.residual.shape), np.float32)
        columns[:, frame] = self._rates()[frame] * self.values[:, _OWN:].T
        return self._projected(columns)

    def _projected(self, columns: np.ndarray) -> np.ndarray:
        unit = self.shape / np.sqrt(np.maximum((self.shape**2).sum(axis=0), 1e-12))
        columns -= unit[None] * np.einsum("kn,jkn->jn", unit, columns)[:, None]
        return columns.reshape(len(columns), -1)

    def moved(self, step: np.ndarray) -> "FramesState":
        """The state after a step."""
        count, terms = len(self.own), len(self.form)
        own = step[terms : terms + _OWN * count].reshape(count, _OWN)
        gains = self.gains.copy()
        free_gains = count - 1
        gains[count - free_gains :] += step[terms + _OWN * count : -1]
        visibility = float(np.clip(self.visibility + step[-1], 0.05, 1.5))
        return FramesState(self.frames, self.form + step[:terms], self.own + own, gains, visibility)

    def answer(self, converged: bool) -> FramesFit:
        """What is reported of it."""
        matrix, _ = self.normal()
        variance = self.square / max(self.residual.size - self.residual.shape[1] - len(matrix), 1)
        covariance = variance * np.linalg.pinv(matrix, hermitian=True)[: len(self.form), : len(self.form)]
        score = self.free_of_light(self._rates()) * self.residual
        return FramesFit(
            self.form,
            self.own,
            self.gains,
            self.visibility,
            covariance,
            variance,
            self.even,
            self.residual,
            score,
            converged,
        )


def own_forms(frames: Frames, fit: FramesFit) -> list[float]:
    """Chi-squared that a form of its own would take from each frame, in white noise (Rao's score test, 1948)."""
    state = FramesState(frames, fit.form, fit.own, fit.gains, fit.visibility)
    columns = state.columns()
    inverse = np.linalg.pinv((columns @ columns.T).astype(float), hermitian=True)
    residual, drops = state.residual.reshape(-1).astype(np.float32), []
    for frame in range(len(fit.own)):
        own = state.columns_of(frame)
        crossed = (columns @ own.T).astype(float)
        slope = (own @ residual).astype(float) - crossed.T @ (inverse @ (columns @ residual).astype(float))
        remaining = (own @ own.T).astype(float) - crossed.T @ inverse @ crossed
        drops.append(float(slope @ np.linalg.lstsq(remaining, slope, rcond=1e-10)[0]) / fit.variance)
    return drops
