"""Maps of a form over its pupil: the departure from the best sphere, and its standard deviation."""

import io

import numpy as np

from fitting.irregularity.disc import Pupil
from fitting.irregularity.zernike import terms_at

# Points of a map to a diameter, and the first term of the departure.
SIDE = 101
_IRREGULAR = 5


def departure(form: np.ndarray, covariance: np.ndarray, side: int = SIDE) -> tuple[np.ndarray, np.ndarray]:
    """The terms from 5 on over a square about the pupil [side, side], turns, and their sd; NaN outside."""
    axis = np.linspace(-1, 1, side)
    u, v = np.meshgrid(axis, axis)
    inside = np.hypot(u, v) <= 1
    values = terms_at(u[inside], v[inside], len(form)) * (np.arange(1, len(form) + 1) >= _IRREGULAR)
    heights, sds = np.full((2, side, side), np.nan)
    heights[inside] = values @ form
    sds[inside] = np.sqrt(np.maximum(np.einsum("ni,ij,nj->n", values, covariance, values, optimize=True), 0.0))
    return heights, sds


def map_csv(pupil: Pupil, form: np.ndarray, covariance: np.ndarray, nm_per_turn: float | None) -> str:
    """A map as CSV text: column and row in pixels, the departure and its sd in nm or fringe spacings."""
    unit, scale = ("fringe", 1.0) if nm_per_turn is None else ("nm", nm_per_turn)
    heights, sds = departure(form, covariance)
    axis = np.linspace(-1, 1, SIDE) * pupil.radius
    x, y = np.meshgrid(axis + pupil.x, axis + pupil.y)
    inside = np.isfinite(heights)
    table = np.column_stack([x[inside], y[inside], scale * heights[inside], scale * sds[inside]])
    text = io.StringIO()
    np.savetxt(text, table, "%.6g", ",", header=f"column_px,row_px,departure_{unit},sd_{unit}", comments="")
    return text.getvalue()
