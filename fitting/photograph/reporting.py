"""From an optimum to a result: quantities, standard deviations, budget, warnings and pictures."""

from collections.abc import Callable, Collection
from dataclasses import replace

import numpy as np

from fitting.estimate import FEW, Fitted, finest, stay
from fitting.model import PARTS
from fitting.parameters import TABLE, Quantities, exact
from fitting.photo import Photograph
from fitting.photograph.averaging import variance_of
from fitting.photograph.camera_stretch import stretch_warning
from fitting.photograph.choice import Choice
from fitting.photograph.evidence import Evidence
from fitting.photograph.fringe_rivals import Astray, SecondSystem, Waveform, WeakLight
from fitting.photograph.held_numbers import contradictions
from fitting.photograph.image_rows import image_rows
from fitting.photograph.model_rivals import VIEW_OR_FORM, Form, PriorTension, RingLaw, ViewOrForm
from fitting.photograph.numbers import measured
from fitting.photograph.picture import Picture
from fitting.photograph.remainder import Remainder
from fitting.photograph.result import FitResult
from fitting.photograph.ring_radii import rings_of
from fitting.photograph.rival import CONSEQUENCES, AbstractRival, Finding
from fitting.photograph.selection import UNFITTED
from fitting.photograph.task import Task
from fitting.reasons import Reason
from newtonjax.numerics import Statement

# Fringes finer than this [cycles per pixel] are near the camera's limit of a half.
_NYQUIST = 0.42
# What else may have made the rings, in the order in which it is asked; the first refusal is the answer.
RIVALS: tuple[AbstractRival, ...] = (
    Astray(),
    Waveform(),
    SecondSystem(),
    WeakLight(),
    RingLaw(),
    Form(),
    ViewOrForm(),
    PriorTension(),
)
# Shares of a picture from which on it is said why they are not used.
_NAMED = 0.01
# What leaves less of the variance over was no photograph, and holds rounding.
_ROUNDED = 1e-8


def report(task: Task, choice: Choice, further: Callable[[float], Finding | None] | None = None) -> FitResult:
    """The result of a fit that was not refused; without a radius where the fit does not determine it.

    `further`: as in `_findings_of`.
    """
    fit, given, photograph, averaging = choice.found, task.quantities, choice.photograph, choice.averaging
    answer = _at_the_mean(choice)
    variance, inflation = variance_of(fit)
    common = {
        "measured": given.unknown or "radius",
        "explained_variance": fit.explained,
        "warnings": _warnings(choice, inflation, given),
        "model": _model(fit, photograph, given) | choice.part_words,
        "picture": Picture(photograph, fit),
    }
    if task.noise is not None:
        common["model"]["weights"] = f"one over the variance of the noise ({task.noise.words})"
    parts = _parts_with_priors(choice)
    decided = () if task.view_angle is None else (VIEW_OR_FORM,)
    common["rivals"], rival_rows = _findings_of(fit, photograph, decided, further)
    common["priors"] = {} if averaging is None else averaging.members[choice.place].priors.table(parts)
    by_kind = {kind: [finding for finding in common["rivals"] if finding.consequence == kind] for kind in CONSEQUENCES}
    common["warnings"] += [finding.words for finding in by_kind["warning"]]
    common["model"] |= {finding.rival: str(finding.words) for finding in by_kind["budget"]}
    try:
        if not fit.converged:
            return FitResult("not-converged", Reason.NOT_CONVERGED(), **common)
        if task.scale is not None and task.scene is None:
            common["warnings"] += stretch_warning(task.scale, fit, variance)
        if fit.fixed:
            common["warnings"] += contradictions(fit, given, task.contact_phase)
        if by_kind["refusal"]:
            return FitResult("refused", by_kind["refusal"][0].words, **common)
        covariance, rows = image_rows(choice, variance, given)
    except np.linalg.LinAlgError as error:
        return FitResult("refused", Reason.UNDETERMINED(error=str(error)), **common)
    if task.view_angle is not None:
        common["model"][VIEW_OR_FORM] = f"{task.view_angle.words}; the radius is that of the two radii's mean curvature"
    numbers = measured(answer, given, task.contact_phase, covariance, rows + rival_rows, task.view_angle)
    if numbers["fringe_scale_sd"] > 0.2 * numbers["fringe_scale_per_px2"]:
        return FitResult("refused", Reason.CURVATURE_UNCERTAIN(), **common)
    if numbers["status"] == "ok":
        name, size = common["measured"], numbers["parameters"][common["measured"]].value
        (low, high), (least, most) = TABLE[name].sensible, TABLE[name].bounds
        if not least <= size <= most:
            return FitResult("refused", _unlikely(name, size), **common)
        if not low <= size <= high:
            common["warnings"].append(_unlikely(name, size))
    rings = rings_of(answer, given, task.contact_phase, covariance)
    evidence = Evidence(fit, given, variance, covariance, averaging, choice.ratio)
    return FitResult(**numbers, evidence=evidence, rings=rings, **common)


def _unlikely(name: str, size: float) -> Statement:
    """That what is measured has a size that it cannot have: a unit was mistaken."""
    value, low, high = (exact(float(f"{one:.4g}"), TABLE[name].unit) for one in (size, *TABLE[name].sensible))
    return Reason.UNLIKELY_SIZE(measured=name.replace("_", " "), value=value, low=low, high=high)


def _warnings(choice: Choice, inflation: float, given: Quantities) -> list[str]:
    warnings = list(choice.photograph.warnings)
    if inflation > 1.5:
        warnings.append(Reason.CORRELATED_RESIDUALS(inflation=inflation))
    missing = [name for name in ("pixel_size", "wavelength") if name in given.given and name not in given.sd]
    if given.unknown and missing:
        warnings.append(Reason.TREATED_AS_EXACT(names=" and ".join(missing)))
    warnings += [
        Reason.PART_NOT_FITTED(part=part, why=why)
        for part, why in choice.part_words.items()
        if why.startswith(UNFITTED)
    ]
    if float(choice.found.solution.point.modulus.mean()) < 0:
        warnings.append(Reason.BRIGHT_FOR_DARK())
    if (cycles := finest(choice.found)) > _NYQUIST:
        warnings.append(Reason.NEAR_SAMPLING_LIMIT(width=1 / cycles))
    return warnings


def _at_the_mean(choice: Choice) -> Fitted:
    """The fit moved to the mean over all sets of parts, for its numbers alone: that is no optimum."""
    if choice.shift is None:
        return choice.found
    solution = choice.found.solution
    numbers = solution.numbers + choice.shift
    return replace(choice.found, solution=stay(solution.problem, solution.normal, numbers, solution.converged))


def _parts_with_priors(choice: Choice) -> list[str]:
    """The parts that may be there, in their order, where sets of them are averaged."""
    if choice.averaging is None:
        return []
    member = choice.averaging.members[choice.place]
    parts = {*max(member.sets, key=len), *choice.found.parts}
    return [part for part in PARTS if part in parts]


def _model(fit: Fitted, photograph: Photograph, given: Quantities) -> dict[str, str]:
    rounded = f"degree {fit.shape[0]} background, degree {fit.shape[1]} contrast (least BIC)"
    outliers = "none weighted down" if fit.scale is None else "weighted down (Tukey)"
    used, block = fit.left.weights > 0, fit.reduced.grid.block
    in_blocks = "" if block == 1 else f", means over {block} x {block}"
    pixels = round(float(fit.reduced.weights[used].sum(dtype=float)) * block**2)
    left_out = _left_out(fit, photograph, pixels)
    return {
        "fringes": fit.model.words.format(sphere="exact sphere" if given.unknown else "r² (no scale, so no sphere)"),
        "illumination": rounded,
        "outliers": outliers,
        "channel": f"{photograph.channel}, transfer {photograph.transfer}",
        "pixels": f"{pixels} of {photograph.mask.size}{in_blocks}" + (f"; left out: {left_out}" if left_out else ""),
    }


def _left_out(fit: Fitted, photograph: Photograph, pixels: int) -> str:
    """Why pixels are not used, and of how many: shares of the picture from a percent on, the largest first."""
    usable, blocks = int(np.count_nonzero(photograph.mask)), round(fit.reduced.pixels)
    counts = photograph.left_out | {
        "spots, or beyond the middle": photograph.mask.size - sum(photograph.left_out.values()) - usable,
        "at edges": usable - blocks,
        "outliers": blocks - pixels,
    }
    shares = {why: count / photograph.mask.size for why, count in counts.items()}
    named = [why for why in sorted(shares, key=shares.__getitem__, reverse=True) if shares[why] >= _NAMED]
    return ", ".join(f"{shares[why]:.0%} {why}" for why in named)


def _findings_of(
    fit: Fitted,
    photograph: Photograph,
    decided: Collection[str] = (),
    further: Callable[[float], Finding | None] | None = None,
) -> tuple[list[Finding], list[tuple[str, float]]]:
    """What rivals say of a finished fit, and the rows that they add: (source, deviation of its first number).

    `decided`: names of those on which something else that is given decides; `further`: what speaks for the scale of the
    fit [turns per px²] beside what it leaves over. Nothing where it leaves rounding alone, or
    has too few fringes to tell.
    """
    if not fit.converged or fit.orders < FEW or not 1 - fit.explained > _ROUNDED:
        return [], []
    remainder = Remainder(fit, photograph)
    answers = [rival.finding(remainder) for rival in RIVALS if rival.name not in decided]
    if further is not None:
        answers.append(further(abs(remainder.scale)))
    findings = [finding for finding in answers if finding is not None]
    return findings, [(finding.rival, finding.deviation * remainder.first) for finding in findings if finding.deviation]
