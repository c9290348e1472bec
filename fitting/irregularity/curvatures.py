"""Two radii and their axis from power and astigmatism."""

from typing import NamedTuple

import numpy as np

# Places of power and of the two terms of astigmatism among the terms.
QUADRATIC = (3, 4, 5)


class Curvatures(NamedTuple):
    """Curvatures of the gap 2t = λ φ along two axes at right angles [1/m], their mean values over the pupil.

    - `along`: the larger one, along `axis` [rad, from the rows' direction towards the columns']; `across` the other.
    """

    along: float
    across: float
    axis: float
    along_sd: float
    across_sd: float
    axis_sd: float


def curvatures(quadratic: np.ndarray, covariance: np.ndarray, scale: float, scale_sd: float) -> Curvatures:
    """The curvatures of terms 4, 5, 6 (turns, rms) with `scale` = λ/a², its sd relative.

    k = (λ/a²)(2√3 p4 ± √6 hypot(p5, p6)), the axis of the larger one at half the angle of (p6, p5).
    """
    _, sine, cosine = quadratic
    size = float(np.hypot(sine, cosine))
    direction = np.array([0.0, sine, cosine]) / max(size, 1e-300)
    sphere = np.array([2 * np.sqrt(3), 0.0, 0.0])
    values, sds = [], []
    for slope in (sphere + np.sqrt(6) * direction, sphere - np.sqrt(6) * direction):
        value = scale * float(slope @ quadratic)
        noise = scale * np.sqrt(max(slope @ covariance @ slope, 0.0))
        values.append(value)
        sds.append(float(np.hypot(noise, value * scale_sd)))
    turn = np.array([0.0, cosine, -sine]) / max(2 * size**2, 1e-300)
    axis_sd = min(float(np.sqrt(max(turn @ covariance @ turn, 0.0))), float(np.pi / np.sqrt(12)))
    axis = float(np.arctan2(sine, cosine) / 2)
    return Curvatures(values[0], values[1], axis, sds[0], sds[1], axis_sd)
