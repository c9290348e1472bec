"""From an optimum to a result: quantities, standard deviations, budget, warnings and pictures."""

import time

import numpy as np

from fitting import least_squares as ls
from fitting.illumination import Fitted
from fitting.models import SceneModel
from fitting.moments import at_pixels
from fitting.numbers import measured
from fitting.photo import Photograph
from fitting.quantity import Quantities
from fitting.result import Evidence, FitResult, Picture
from fitting.smoothing import reduce

# Residuals are averaged over blocks of this many pixels a side to see whether neighbours err together.
_BLOCK = 16


def refused(reason: str, photograph: Photograph, began: float) -> FitResult:
    """A result without a radius, and why."""
    return FitResult("refused", reason, warnings=list(photograph.warnings), seconds=time.perf_counter() - began)


def summarize(photograph: Photograph, known: Quantities, view: str, found: Fitted, began: float) -> FitResult:
    """The result of a fit that was not refused."""
    inflation = correlation(photograph.image - found.fitted, found.weights)
    pixels = float(found.weights.sum())
    # Chi-squared is a difference of large sums: below their rounding nothing is known of it.
    chi2 = max(float(found.solution.chi2), 1e-14 * float(found.kept.power))
    variance = chi2 / max(pixels - float(np.sum(found.solution.active)), 1.0) * inflation
    warnings = [*photograph.warnings, *_warnings(inflation, known)]
    if float(found.solution.image[1].mean()) < 0:
        warnings.append("the fringes are bright where the given gap makes them dark: check gap and view")
    picture = Picture(
        photograph, found.fitted, np.asarray(at_pixels(found.solution.image[2], photograph.image.shape)), found.weights
    )
    common = {
        "measured": known.unknown or "radius",
        "explained_variance": found.explained,
        "model": _model(found, photograph, known),
        "picture": picture,
    }
    if not bool(found.solution.converged):
        message = "least squares did not converge; mask what is not rings, or give start"
        return FitResult("not-converged", message, warnings=warnings, seconds=time.perf_counter() - began, **common)
    try:
        covariance = ls.covariance(found.solution, variance)
    except np.linalg.LinAlgError as error:
        return FitResult(
            "refused", f"undetermined: {error}", warnings=warnings, seconds=time.perf_counter() - began, **common
        )
    numbers = measured(found, known, view, covariance)
    if numbers["fringe_scale_sd"] > 0.2 * numbers["fringe_scale_per_px2"]:
        message = "the curvature is not determined: its standard deviation exceeds a fifth of its value"
        return FitResult("refused", message, warnings=warnings, seconds=time.perf_counter() - began, **common)
    evidence = Evidence(found, known, variance, covariance)
    seconds = time.perf_counter() - began
    return FitResult(**numbers, warnings=warnings, seconds=seconds, evidence=evidence, **common)


def correlation(residual: np.ndarray, weights: np.ndarray) -> float:
    """By how much errors that neighbours share raise the variance of smooth quantities; 1 for white noise.

    Block means of white residuals have 1/n of the pixels' variance. A ratio within three standard errors of 1 is 1.
    """
    weight, total = (reduce(table, _BLOCK) * _BLOCK**2 for table in (weights, weights * residual))
    whole = weight > 0.5 * _BLOCK**2
    if whole.sum() < 16:
        return 1.0
    variance = (weights * residual**2).sum() / weights.sum()
    ratio = float(np.mean(total[whole] ** 2 / weight[whole]) / variance)
    return ratio if ratio > 1 + 3 * np.sqrt(2 / whole.sum()) else 1.0


def _warnings(inflation: float, known: Quantities) -> list[str]:
    found = []
    if inflation > 1.5:
        found.append(
            f"residuals of neighbouring pixels err together ({inflation:.3g} times the variance of independent ones): "
            "the image holds what the model does not; the noise row is raised, other errors of the model are not in it"
        )
    missing = [name for name in ("pixel_size", "wavelength") if name in known.given and name not in known.sd]
    if known.unknown and missing:
        found.append(f"no standard deviation given for {' and '.join(missing)}: taken as exact, the error bar lacks it")
    return found


def _model(found: Fitted, photograph: Photograph, known: Quantities) -> dict[str, str]:
    rounded = f"degree {found.shape[0]} background, degree {found.shape[1]} contrast (least BIC)"
    sphere = "exact sphere" if known.unknown else "r² (no scale, so no sphere)"
    gap = f"2 n t at normal incidence, {sphere}"
    outliers = "none weighted down" if np.all((found.weights == 0) | (found.weights == 1)) else "weighted down (Tukey)"
    return {
        "fringes": "traced bench" if isinstance(found.model, SceneModel) else gap,
        "illumination": rounded,
        "outliers": outliers,
        "channel": f"{photograph.channel}, transfer {photograph.transfer}",
        "pixels": f"{int((found.weights > 0).sum())} of {found.weights.size}",
    }
