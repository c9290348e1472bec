"""Blur in frames of smooth light: what it takes from each frame, its size by least squares, and what that leaves open.

A blurred frame is blur(E g), g = s (1 + V cos 2πφ). Where E is smooth this is blur(E) g + c, with c of the blur's
variance s² [px²] small: c is taken out of the frames, whose light stays free at every pixel.
"""

from typing import NamedTuple

import numpy as np

from fitting.irregularity.blurring import blurred
from fitting.irregularity.frames import Frames
from fitting.irregularity.joint_frames import FramesFit, FramesState, refit_frames
from fitting.irregularity.moments import products_at
from fitting.irregularity.zernike import on_grid

# Variance of the blur, mean and standard deviation [px²], and its bounds, as of one picture.
_BLUR, _BLUR_SD, _BLUR_BOUNDS = 1.0, 2.0, (0.0, 25.0)
_ROUNDS, _DEGREE = 3, 6
# Pixels about the aperture from which blur may bring light; the change of variance of a difference quotient [px²].
_MARGIN, _CHANGE = 12, 0.1


class Unblurred(NamedTuple):
    """Frames without what blur did to them.

    - `frames`; `fit`: their optimum with the terms that were given; `variance` of the blur [px²] and its `sd`.
    - `change` [terms - 3]: of the form, from power on, with this sd, for an inflation of 1.
    """

    frames: Frames
    fit: FramesFit
    variance: float
    sd: float
    change: np.ndarray


def without_blur(frames: Frames, fit: FramesFit) -> Unblurred:
    """The frames of an optimum [terms - 3], and its own change, with the blur that explains them best."""
    variance = _BLUR
    sharp, fit = _refitted(frames, fit, variance)
    slope, precision, rate = 0.0, 1.0, np.zeros_like(fit.form)
    for _ in range(_ROUNDS):
        slope, precision, rate = _by_variance(sharp, frames, fit, variance)
        variance = float(np.clip(variance + slope / precision, *_BLUR_BOUNDS))
        sharp, fit = _refitted(frames, fit, variance)
    sd = float(precision**-0.5)
    return Unblurred(sharp, fit, variance, sd, sd * rate)


def _refitted(frames: Frames, fit: FramesFit, variance: float) -> tuple[Frames, FramesFit]:
    sharp = frames._replace(light=frames.light - _taken(frames, fit, variance))
    return sharp, refit_frames(sharp, fit, 3 + len(fit.form))


def _by_variance(sharp: Frames, frames: Frames, fit: FramesFit, variance: float) -> tuple[float, float, np.ndarray]:
    """Slope and curvature of half of chi-squared by the blur's variance, and how the form follows [terms - 3]."""
    state = FramesState(sharp, fit.form, fit.own, fit.gains, fit.visibility)
    low = max(variance - _CHANGE, 0.0)
    change = _taken(frames, fit, variance + _CHANGE) - _taken(frames, fit, low)
    column = state.free_of_light(state.weights * change / np.float32(variance + _CHANGE - low)).reshape(-1)
    columns = state.columns()
    follows = np.linalg.lstsq((columns @ columns.T).astype(float), (columns @ column).astype(float), rcond=1e-12)[0]
    alone = column - follows.astype(np.float32) @ columns
    residual = state.residual.reshape(-1)
    precision = float(alone @ alone) / fit.variance + _BLUR_SD**-2.0
    slope = float(alone @ residual) / fit.variance - (variance - _BLUR) / _BLUR_SD**2
    return slope, precision, -follows[: len(fit.form)]


def _taken(frames: Frames, fit: FramesFit, variance: float) -> np.ndarray:
    """What a blur adds to each frame [frames, pixels]: blur(E g) - blur(E) g."""
    used = np.pad(frames.cells >= 0, _MARGIN)
    u, v = (_axis(points, places) for points, places in zip((frames.u, frames.v), _places(frames.cells), strict=True))
    grid_v, grid_u = np.meshgrid(v(used.shape[0]), u(used.shape[1]), indexing="ij")
    even = np.linalg.lstsq(products_at(frames.u, frames.v, _DEGREE), fit.even, rcond=None)[0]
    inside = np.hypot(grid_u, grid_v) <= 1 + _MARGIN * abs(grid_u[0, 1] - grid_u[0, 0])
    light = np.where(inside, (products_at(grid_u.ravel(), grid_v.ravel(), _DEGREE) @ even).reshape(inside.shape), 0.0)
    blurred_light = blurred(light, variance)
    rows = []
    for (piston, *tilt), gain in zip(fit.own, fit.gains, strict=True):
        turns = on_grid(np.concatenate([[piston], tilt, fit.form]), u(used.shape[1]), v(used.shape[0]))
        fringes = gain * (1 + fit.visibility * np.cos(2 * np.pi * turns))
        rows.append((blurred(light * fringes, variance) - blurred_light * fringes)[used])
    return np.array(rows, np.float32)


def _places(cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Columns and rows of the used pixels."""
    rows, columns = np.nonzero(cells >= 0)
    return columns, rows


def _axis(points: np.ndarray, places: np.ndarray):
    """Coordinates of so many columns or rows, the margin among them, by those of the used pixels."""
    step, start = np.polyfit(places, points, 1)
    return lambda count: start + step * (np.arange(count) - _MARGIN)
