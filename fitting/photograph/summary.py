"""From an optimum to a result: quantities, standard deviations, budget, warnings and pictures."""

import time

import numpy as np

from fitting.estimate import Fitted, Residuals, finest
from fitting.model import SceneModel
from fitting.parameters import Quantities
from fitting.photo import Photograph
from fitting.photograph.numbers import measured
from fitting.photograph.picture import Picture
from fitting.photograph.result import Evidence, FitResult
from fitting.photograph.selection import UNFITTED, Choice
from fitting.photograph.uncertainty import image_rows

# Fringes finer than this [cycles per pixel] are near the camera's limit of a half.
_NYQUIST = 0.42
# What single precision leaves of the sum of squares.
_ROUNDING = 1e-14


def refused(reason: str, photograph: Photograph, began: float) -> FitResult:
    """A result without a radius, and why."""
    return FitResult("refused", reason, warnings=list(photograph.warnings), seconds=time.perf_counter() - began)


def summarize(photograph: Photograph, known: Quantities, view: str, choice: Choice, began: float) -> FitResult:
    """The result of a fit that was not refused."""
    found, evidence, rivals = choice
    variance, inflation = variance_of(found)
    warnings = [*photograph.warnings, *_warnings(inflation, known)]
    warnings += [f"{part}: {why}" for part, why in evidence.items() if why.startswith(UNFITTED)]
    if float(found.solution.point.modulus.mean()) < 0:
        warnings.append("the fringes are bright where the given gap makes them dark: check gap and view")
    if (cycles := finest(found)) > _NYQUIST:
        warnings.append(
            f"the finest fringes are {1 / cycles:.2g} pixels wide, near the two below which they pass for wider "
            "ones: mask the rim, or take more pixels"
        )
    picture = Picture(photograph, found)
    common = {
        "measured": known.unknown or "radius",
        "explained_variance": found.explained,
        "model": _model(found, photograph, known) | evidence,
        "picture": picture,
    }
    if not found.converged:
        message = "least squares did not converge; mask what is not rings, or give start"
        return FitResult("not-converged", message, warnings=warnings, seconds=time.perf_counter() - began, **common)
    try:
        covariance = found.matrix.covariance(variance)
        rows = image_rows(found, variance, rivals, known.given.get("wavelength"))
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


def variance_of(found: Fitted) -> tuple[float, float]:
    """Variance of the light per unit weight, errors that neighbours share included, and their factor in it."""
    # Below the rounding of single precision nothing is known of the residuals.
    known_noise = found.chi2 > _ROUNDING * found.solution.normal.square
    inflation = found.correlation if known_noise else 1.0
    chi2 = max(found.chi2, _ROUNDING * found.solution.normal.square)
    variance = chi2 / max(found.weight - float(np.sum(found.matrix.active)), 1.0) * inflation
    return variance * (_of_biweight(found.left, found.reduced.weights) if known_noise else 1.0), inflation


def _of_biweight(left: Residuals, weights: np.ndarray) -> float:
    """By how much Tukey's estimate scatters more than least squares with its weights; 1 without outliers.

    E[ψ²] / E[ψ']² of ψ = w r, with w = (1 - u)² and ψ' = (1 - u)(1 - 5 u) (Huber 1981, Robust Statistics, 7.6).
    `weights`: of the blocks alone.
    """
    used = weights > 0
    share, r, block = (left.weights[used] / weights[used]).astype(float), left.value[used], weights[used].astype(float)
    slope = block * np.sqrt(share) * (5 * np.sqrt(share) - 4)
    spread, whole = (block * (share * r) ** 2).sum(), (block * share).sum()
    return float(spread / slope.sum() ** 2 * whole**2 / max((block * share * r * r).sum(), 1e-300))


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
    outliers = "none weighted down" if found.scale is None else "weighted down (Tukey)"
    used = found.left.weights > 0
    pixels = round(float(found.reduced.weights[used].sum(dtype=float)) * found.reduced.grid.block**2)
    return {
        "fringes": "traced bench" if isinstance(found.model, SceneModel) else gap,
        "illumination": rounded,
        "outliers": outliers,
        "channel": f"{photograph.channel}, transfer {photograph.transfer}",
        "pixels": f"{pixels} of {photograph.mask.size}{_in_blocks(found)}",
    }


def _in_blocks(found: Fitted) -> str:
    block = found.reduced.grid.block
    return "" if block == 1 else f", means over {block} x {block}"
