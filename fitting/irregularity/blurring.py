"""A Gaussian blur of any small variance, which changes smoothly with it down to none."""

import numpy as np
from scipy import ndimage

# Below this variance [px²] samples of a Gaussian are no longer a blur of that variance; at it both kernels are equal
# to 1e-3.
_SAMPLED = 0.5


def blurred(field: np.ndarray, variance: float) -> np.ndarray:
    """A field [rows, columns] blurred by a Gaussian of a variance [px²], 0 and more.

    Below 0.5 px² the five weights of each axis have the Gaussian's second and fourth moments, s² and 3 s⁴: of a
    sampled Gaussian of 0.1 px² nothing would be left but the middle, whatever the variance is.
    """
    if variance >= _SAMPLED:
        return ndimage.gaussian_filter(field, np.sqrt(variance))
    next_but_one = (3 * variance**2 - variance) / 24
    next_one = variance / 2 - 4 * next_but_one
    weights = np.array([next_but_one, next_one, 1 - 2 * (next_one + next_but_one), next_one, next_but_one])
    return ndimage.correlate1d(ndimage.correlate1d(field, weights, axis=0), weights, axis=1)
