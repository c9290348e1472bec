"""The words of ISO 10110-5 for a form: 3/A(B/C) and RMSt, RMSi, RMSa, in fringe spacings, with standard deviations."""

from functools import cache

import numpy as np

from fitting.irregularity.disc import EDGE
from fitting.irregularity.zernike import noll, terms_at

# First term of the irregularity, and that of power.
_IRREGULAR, _POWER = 5, 4
_GRID, _RIM = 101, 360


@cache
def pupil_points() -> tuple[np.ndarray, np.ndarray]:
    """Points u, v of a grid over the pupil, and of its rim."""
    axis = np.linspace(-1, 1, _GRID)
    u, v = (grid.ravel() for grid in np.meshgrid(axis, axis))
    inside = np.hypot(u, v) <= 1
    angle = 2 * np.pi * np.arange(_RIM) / _RIM
    return np.concatenate([u[inside], np.cos(angle)]), np.concatenate([v[inside], np.sin(angle)])


@cache
def _pupil_values() -> np.ndarray:
    """All terms at the points of the pupil [n, 36]."""
    return terms_at(*pupil_points())


def indications(form: np.ndarray, covariance: np.ndarray) -> dict[str, tuple[float, float]]:
    """Value and standard deviation of A, B, C, RMSt, RMSi, RMSa, of a form in fringe spacings, Noll's order, rms.

    A = 2√3 |p4|: peak to valley of the best-fit sphere (sagitta error). B: peak to valley of the irregularity, the
    terms from 5 on; C: of its rotationally symmetric part. RMSt, RMSi, RMSa: rms of the terms from 4 on, of those from
    5 on, of those from 5 on that are not rotationally symmetric. The deviation of a peak-to-valley
    v = Z(peak) - Z(valley) is the square root of vᵀ C v.
    """
    terms = np.arange(1, len(form) + 1)
    symmetric = np.array([noll(int(term))[1] == 0 for term in terms])
    irregular = terms >= _IRREGULAR
    return {
        "A": _peak_to_valley(form, covariance, terms == _POWER),
        "B": _peak_to_valley(form, covariance, irregular),
        "C": _peak_to_valley(form, covariance, irregular & symmetric),
        "RMSt": _rms(form, covariance, terms >= _POWER),
        "RMSi": _rms(form, covariance, irregular),
        "RMSa": _rms(form, covariance, irregular & ~symmetric),
    }


def _peak_to_valley(form: np.ndarray, covariance: np.ndarray, is_counted: np.ndarray) -> tuple[float, float]:
    values = _pupil_values()[:, : len(form)] * is_counted
    heights = values @ form
    span = values[heights.argmax()] - values[heights.argmin()]
    return float(span @ form), float(np.sqrt(max(span @ covariance @ span, 0.0)))


def _rms(form: np.ndarray, covariance: np.ndarray, is_counted: np.ndarray) -> tuple[float, float]:
    part = form * is_counted
    size = float(np.linalg.norm(part))
    slope = part / size if size > 0 else np.zeros(len(form))
    return size, float(np.sqrt(max(slope @ covariance @ slope, 0.0)))


@cache
def _used_values() -> np.ndarray:
    u, v = pupil_points()
    return terms_at(EDGE * u, EDGE * v)


def fringes_of(form: np.ndarray) -> float:
    """Fringes over the light that is used: its phase from least to largest [turns]."""
    return float(np.ptp(_used_values()[:, : len(form)] @ form))
