"""The variance of the light that a fit's deviations go by."""

import numpy as np

from fitting.estimate import Fitted, Residuals

# What single precision leaves of the sum of squares.
_ROUNDING = 1e-14


def variance_of(fit: Fitted) -> tuple[float, float]:
    """Variance of the light per unit weight, errors that neighbours share included, and their factor in it."""
    # Below the rounding of single precision nothing is known of the residuals.
    above_rounding = fit.chi2 > _ROUNDING * fit.solution.normal.square
    inflation = fit.correlation if above_rounding else 1.0
    chi2 = max(fit.chi2, _ROUNDING * fit.solution.normal.square)
    variance = chi2 / max(fit.weight - float(np.sum(fit.matrix.active)), 1.0) * inflation
    return variance * (_of_biweight(fit.left, fit.reduced.weights) if above_rounding else 1.0), inflation


def _of_biweight(residuals: Residuals, weights: np.ndarray) -> float:
    """By how much Tukey's estimate scatters more than least squares with its weights; 1 without outliers.

    E[ψ²] / E[ψ']² of ψ = w r, with w = (1 - u)² and ψ' = (1 - u)(1 - 5 u) (Huber 1981, Robust Statistics, 7.6).
    `weights`: of the blocks alone.
    """
    used = weights > 0
    block, r = weights[used].astype(float), residuals.value[used]
    share = (residuals.weights[used] / weights[used]).astype(float)
    slope = block * np.sqrt(share) * (5 * np.sqrt(share) - 4)
    scatter, total = (block * (share * r) ** 2).sum(), (block * share).sum()
    return float(scatter / slope.sum() ** 2 * total**2 / max((block * share * r * r).sum(), 1e-300))
