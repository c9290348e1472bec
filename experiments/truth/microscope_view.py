"""What a microscope that looks at the gap through the ready bench's lens adds to made rings.

The rays are those of `fitting.model.microscope`; that they are newtonjax's own, `experiments.truth.round_trip` shows
on rendered pictures.
"""

import numpy as np
from numpy.polynomial import Chebyshev

from fitting.model import microscope

# Degree of its polynomial in r², and how far beyond the picture's rays have to arrive, as a fit asks.
_DEGREE, _MARGIN = 24, 1.5


def added_path(radius: float, r2: np.ndarray, gap: float, **glass: float) -> np.ndarray:
    """Metres beyond 2 t at squared distances from the centre [m²], in reflection; zero where no rays arrive.

    `glass`: `lens_index` and `lens_thickness` [m] of another lens than the ready bench's.
    """
    view = microscope.View(radius, np.inf, 1.0, True, **glass)
    farthest = _MARGIN * float(r2.max())
    if not farthest < radius**2:
        return np.zeros_like(r2)

    def excess(at: np.ndarray) -> np.ndarray:
        path = microscope.path_difference(view, gap, np.append(0.0, np.sqrt(np.maximum(at, 0.0))))
        return path[1:] - path[0] - 2 * at / radius / (1 + np.sqrt(1 - at / radius**2))

    polynomial = Chebyshev.interpolate(excess, _DEGREE, domain=[0.0, farthest])
    return polynomial(r2) if np.isfinite(polynomial.coef).all() else np.zeros_like(r2)
