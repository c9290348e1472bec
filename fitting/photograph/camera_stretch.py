"""Whether rings are stretched as the grid was by which their camera was measured."""

import numpy as np

from fitting.estimate import Fitted
from fitting.parameters import CameraScale
from fitting.reasons import Reason

# Two stretches whose difference noise alone makes larger once in 370 pictures: chi-squared with two degrees of freedom.
_APART = 11.8


def stretch_warning(scale: CameraScale, fit: Fitted, variance: float) -> list[str]:
    """That the rings are stretched otherwise than the grid, by more than the noise of both explains."""
    values, covariance = fit.matrix.if_free(("stretch", "shear"), variance)
    difference, spread = values - scale.stretches, covariance + np.diag(scale.variances)
    try:
        square = float(difference @ np.linalg.solve(spread, difference))
    except np.linalg.LinAlgError:
        return []
    if not square > _APART:
        return []
    size = float(np.hypot(*difference))
    (rings, _), (rings_sd, _), (grid, _) = values, np.sqrt(np.diag(covariance)), scale.stretches
    grid_sd = float(np.sqrt(scale.variances[0]))
    return [
        Reason.STRETCHED_OTHERWISE(
            rings=rings, rings_sd=rings_sd, grid=grid, grid_sd=grid_sd, ratio=np.sqrt(square), size=size
        )
    ]
