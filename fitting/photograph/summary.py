"""From an optimum to a result: quantities, standard deviations, budget, warnings and pictures."""

import time

import numpy as np

from fitting.estimate import Fitted, Residuals, finest
from fitting.model import PARTS
from fitting.parameters import Quantities
from fitting.photo import Photograph
from fitting.photograph.camera_prior import with_prior
from fitting.photograph.numbers import measured
from fitting.photograph.picture import Picture
from fitting.photograph.result import Evidence, FitResult
from fitting.photograph.rival import CONSEQUENCES
from fitting.photograph.rivals import findings_of
from fitting.photograph.selection import UNFITTED, Choice
from fitting.photograph.task import Task
from fitting.photograph.uncertainty import image_rows
from fitting.reasons import Reason

# Fringes finer than this [cycles per pixel] are near the camera's limit of a half.
_NYQUIST = 0.42
# What single precision leaves of the sum of squares.
_ROUNDING = 1e-14


def report(task: Task, choice: Choice, began: float) -> FitResult:
    """The result of a fit that was not refused; without a radius where the fit does not determine it."""
    fit, given, photograph = choice.found, task.quantities, choice.photograph
    variance, inflation = variance_of(fit)
    priors = {name: prior for name, prior in task.priors.items() if _is_let(name, task)}
    if priors and fit.converged and task.scene is None:
        fit = with_prior(fit, priors, variance)
        choice = choice._replace(found=fit)
    common = {
        "measured": given.unknown or "radius",
        "explained_variance": fit.explained,
        "warnings": _warnings(choice, inflation, given),
        "model": _model(fit, photograph, given) | choice.evidence,
        "picture": Picture(photograph, fit),
    }
    common["rivals"], rival_rows = findings_of(fit)
    by_kind = {kind: [finding for finding in common["rivals"] if finding.consequence == kind] for kind in CONSEQUENCES}
    common["warnings"] += [finding.words for finding in by_kind["warning"]]
    common["model"] |= {finding.rival: str(finding.words) for finding in by_kind["budget"]}
    try:
        if not fit.converged:
            return FitResult("not-converged", Reason.NOT_CONVERGED(), seconds=time.perf_counter() - began, **common)
        if task.scale is not None and task.scene is None:
            common["warnings"] += task.scale.stretch_warning(fit, variance)
        if by_kind["refusal"]:
            return FitResult("refused", by_kind["refusal"][0].words, seconds=time.perf_counter() - began, **common)
        covariance, rows = image_rows(fit, variance, choice.rivals, given)
    except np.linalg.LinAlgError as error:
        return FitResult(
            "refused", Reason.UNDETERMINED(error=str(error)), seconds=time.perf_counter() - began, **common
        )
    numbers = measured(fit, given, task.contact_phase, covariance, rows + rival_rows)
    if numbers["fringe_scale_sd"] > 0.2 * numbers["fringe_scale_per_px2"]:
        return FitResult("refused", Reason.CURVATURE_UNCERTAIN(), seconds=time.perf_counter() - began, **common)
    evidence = Evidence(fit, given, variance, covariance)
    return FitResult(**numbers, seconds=time.perf_counter() - began, evidence=evidence, **common)


def _is_let(number: str, task: Task) -> bool:
    """Whether the user has not excluded the part that a number belongs to."""
    return all(task.wishes.get(name, True) for name, part in PARTS.items() if number in part.parameters)


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


def _warnings(choice: Choice, inflation: float, given: Quantities) -> list[str]:
    warnings = list(choice.photograph.warnings)
    if inflation > 1.5:
        warnings.append(Reason.CORRELATED_RESIDUALS(inflation=inflation))
    missing = [name for name in ("pixel_size", "wavelength") if name in given.given and name not in given.sd]
    if given.unknown and missing:
        warnings.append(Reason.TREATED_AS_EXACT(names=" and ".join(missing)))
    warnings += [
        Reason.PART_NOT_FITTED(part=part, why=why) for part, why in choice.evidence.items() if why.startswith(UNFITTED)
    ]
    if float(choice.found.solution.point.modulus.mean()) < 0:
        warnings.append(Reason.BRIGHT_FOR_DARK())
    if (cycles := finest(choice.found)) > _NYQUIST:
        warnings.append(Reason.NEAR_SAMPLING_LIMIT(width=1 / cycles))
    return warnings


def _model(fit: Fitted, photograph: Photograph, given: Quantities) -> dict[str, str]:
    rounded = f"degree {fit.shape[0]} background, degree {fit.shape[1]} contrast (least BIC)"
    outliers = "none weighted down" if fit.scale is None else "weighted down (Tukey)"
    used, block = fit.left.weights > 0, fit.reduced.grid.block
    in_blocks = "" if block == 1 else f", means over {block} x {block}"
    pixels = round(float(fit.reduced.weights[used].sum(dtype=float)) * block**2)
    return {
        "fringes": fit.model.words.format(sphere="exact sphere" if given.unknown else "r² (no scale, so no sphere)"),
        "illumination": rounded,
        "outliers": outliers,
        "channel": f"{photograph.channel}, transfer {photograph.transfer}",
        "pixels": f"{pixels} of {photograph.mask.size}{in_blocks}",
    }
