"""From an optimum to a result: quantities, standard deviations, budget, warnings and pictures."""

import time

import numpy as np

from fitting import least_squares as ls
from fitting.illumination import Fitted
from fitting.models import SceneModel
from fitting.numbers import measured
from fitting.photo import Photograph
from fitting.quantity import Quantities
from fitting.result import Evidence, FitResult, Picture
from fitting.selection import UNFITTED, Choice
from fitting.smoothing import fringe_correlation, thin
from fitting.uncertainty import image_rows

# Fringes finer than this [cycles per pixel] are near the camera's limit of a half.
_NYQUIST = 0.42


def refused(reason: str, photograph: Photograph, began: float) -> FitResult:
    """A result without a radius, and why."""
    return FitResult("refused", reason, warnings=list(photograph.warnings), seconds=time.perf_counter() - began)


def summarize(photograph: Photograph, known: Quantities, view: str, choice: Choice, began: float) -> FitResult:
    """The result of a fit that was not refused."""
    found, evidence, rivals = choice
    pixels, floor = float(found.weights.sum()), 1e-14 * float(found.kept.power)
    # Chi-squared is a difference of large sums: below their rounding nothing is known of it.
    chi2, known_noise = max(float(found.solution.chi2), floor), float(found.solution.chi2) > floor
    residual = photograph.image - found.fitted
    inflation = fringe_correlation(residual, found.weights, found.phase) if known_noise else 1.0
    variance = chi2 / max(pixels - float(np.sum(found.solution.active)), 1.0) * inflation
    variance *= _of_biweight(residual, found.weights, photograph.mask) if known_noise else 1.0
    warnings = [*photograph.warnings, *_warnings(inflation, known)]
    warnings += [f"{part}: {why}" for part, why in evidence.items() if why.startswith(UNFITTED)]
    if float(found.solution.image[1].mean()) < 0:
        warnings.append("the fringes are bright where the given gap makes them dark: check gap and view")
    if (finest := _finest(found)) > _NYQUIST:
        warnings.append(
            f"the finest fringes are {1 / finest:.2g} pixels wide, near the two below which they pass for wider "
            "ones: mask the rim, or take more pixels"
        )
    picture = Picture(photograph, found.fitted, found.phase, found.weights)
    common = {
        "measured": known.unknown or "radius",
        "explained_variance": found.explained,
        "model": _model(found, photograph, known) | evidence,
        "picture": picture,
    }
    if not bool(found.solution.converged):
        message = "least squares did not converge; mask what is not rings, or give start"
        return FitResult("not-converged", message, warnings=warnings, seconds=time.perf_counter() - began, **common)
    try:
        covariance = ls.covariance(found.solution, variance)
        rows = image_rows(found, photograph, variance, rivals, known.given.get("wavelength"))
    except np.linalg.LinAlgError as error:
        return FitResult(
            "refused", f"undetermined: {error}", warnings=warnings, seconds=time.perf_counter() - began, **common
        )
    numbers = measured(found, known, view, covariance, rows)
    if numbers["fringe_scale_sd"] > 0.2 * numbers["fringe_scale_per_px2"]:
        message = "the curvature is not determined: its standard deviation exceeds a fifth of its value"
        return FitResult("refused", message, warnings=warnings, seconds=time.perf_counter() - began, **common)
    seen = Evidence(found, known, variance, covariance)
    seconds = time.perf_counter() - began
    return FitResult(**numbers, warnings=warnings, seconds=seconds, evidence=seen, **common)


def _of_biweight(residual: np.ndarray, weights: np.ndarray, mask: np.ndarray) -> float:
    """By how much Tukey's estimate scatters more than least squares with its weights; 1 without outliers.

    E[ψ²] / E[ψ']² of ψ = w r, with w = (1 - u)² and ψ' = (1 - u)(1 - 5 u) (Huber 1981, Robust Statistics, 7.6).
    """
    w, r = weights[mask], residual[mask]
    slope = np.sqrt(w) * (5 * np.sqrt(w) - 4)
    return float(((w * r) ** 2).sum() / slope.sum() ** 2 * w.sum() ** 2 / max((w * r * r).sum(), 1e-300))


def _finest(found: Fitted) -> float:
    """Largest frequency of the fringes where they were used [cycles per pixel]."""
    sample = thin(found.weights > 0, 20_000)
    rows, columns = (np.gradient(found.phase, axis=axis)[sample] for axis in (0, 1))
    used = found.weights[sample] > 0
    return float(np.percentile(np.hypot(rows, columns)[used], 99.9)) if used.any() else 0.0


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
