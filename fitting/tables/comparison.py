"""Several results in one question: the index of a liquid by rings in air and in it, lenses, repeated series."""

from collections.abc import Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
from scipy import stats

from fitting.parameters import AbstractResult
from fitting.reasons import Reason
from fitting.tables.bench import MEASURED
from fitting.tables.comparison_result import Compared, Comparison
from fitting.tables.result import RingsResult
from newtonjax.numerics import Statement, require_choice, shown

# Quantities that results may share, so that their errors are the same in all of them.
_SHARED = ("wavelength", "pixel_size", "radius", "gap_index", "view_angle", "plate_radius")
# Chance that honest results are taken for different ones.
_ALARM = 0.005


class _Part(NamedTuple):
    """A result's value, the relative sd of its own readings, their freedom, and relative sds of what is shared."""

    value: float
    own_sd: float
    freedom: float
    shared: dict[str, float]


def compare(results: Sequence[Any], of: str, *, names: Sequence[str] | None = None) -> Comparison:
    """One quantity of several results of `rings` or `fit`.

    "gap_index": the first result is in air (or in what its own gap_index says), the others in a liquid: rings of one
    lens are narrower by n, so that n is the ratio of the slopes. Wavelength, scale and lens cancel. "radius",
    "wavelength", "pixel_size": the weighted mean, with what the results differ by beyond their own errors as a row of
    the budget (DerSimonian and Laird 1986), and each result over the first one, where what they share cancels.

    Args:
      results: two or more, all of one kind of quantity.
      of: "gap_index", or what all results measured.
      names: of the results; their files' where they are not given.

    Raises ValueError for fewer than two results, for one given twice, and for results that have no such quantity.

    """
    require_choice("of", of, MEASURED)
    is_list = isinstance(results, Sequence) and all(isinstance(result, AbstractResult) for result in results)
    if not is_list or len(results) < 2:
        raise ValueError(f"results is {shown(results)}; give a list of two results of rings or fit, or more")
    labels = [_name(result, k) for k, result in enumerate(results, 1)] if names is None else names
    is_list = isinstance(labels, list | tuple) and all(isinstance(label, str) for label in labels)
    if not is_list or len(labels) != len(results):
        raise ValueError(f"names is {shown(names)}; allowed: a text for each of the {len(results)} results")
    labels = list(labels)
    for (first, result), (second, another) in combinations(enumerate(results, 1), 2):
        if result == another:
            raise ValueError(f"results {first} and {second} are one, {labels[first - 1]}; give different ones")
    quantity = "radius" if of == "gap_index" else of
    parts = [_part(result, quantity, label) for result, label in zip(results, labels, strict=True)]
    return _index(parts, results, labels) if of == "gap_index" else _mean(parts, of, labels)


def _name(result: Any, number: int) -> str:
    origin = getattr(result, "origin", None)
    return (origin and origin.file) or f"result {number}"


def _part(result: Any, quantity: str, label: str) -> _Part:
    """What is compared of a result: its value, or its slope where there is no scale. Raises ValueError without one."""
    value, budget = getattr(result, quantity, None), dict(getattr(result, "budget", None) or [])
    slope, slope_sd = getattr(result, "slope", None), getattr(result, "slope_sd", None)
    if value is not None and budget:
        shared = {name: sd / value for name, sd in budget.items() if name in _SHARED}
        own_sd = float(np.sqrt(sum(sd**2 for name, sd in budget.items() if name not in _SHARED))) / value
    elif quantity == "radius" and slope and slope_sd and result.status in ("ok", "no-scale"):
        value, own_sd, shared = slope, slope_sd / slope, {}
    else:
        raise ValueError(
            f"{label} has no {quantity} with a standard deviation: {result.status} {result.message}".strip()
        )
    return _Part(float(value), own_sd, _freedom(result), shared)


def _freedom(result: Any) -> float:
    """Readings of a table beyond the two numbers of its line; of a photograph as many as one likes."""
    if not isinstance(result, RingsResult):
        return np.inf
    used = sum(not ring.flag.startswith("off the line") for ring in result.rings)
    return max(used - 2.0, 1.0)


def _index(parts: list[_Part], results: Sequence[Any], labels: list[str]) -> Comparison:
    """The index of a liquid: sqrt((n₀² - sin² θ) (slope in air / slope in it)² + sin² θ)."""
    reference, *liquids = parts
    units = {getattr(result, "unit", "m") if getattr(result, "radius", None) is None else "m" for result in results}
    if len(units) > 1:
        raise ValueError("some results have a scale and others have none; give the pixel size of all, or of none")
    given = results[0].parameters
    angles = [_given(result, "view_angle", 0.0) for result in results]
    if np.ptp(angles) > 1e-9:
        raise ValueError("the results are seen at different angles; give one angle of view for both")
    index = given["gap_index"].value if "gap_index" in given else 1.0
    sine = float(np.sin(angles[0]))
    rows = [Compared(labels[0], index, None, 1.0, None)]
    for part, result, label in zip(liquids, results[1:], labels[1:], strict=True):
        # A radius was computed with an index that was assumed, the slope was not.
        paths = [np.sqrt(_given(r, "gap_index", 1.0) ** 2 - sine**2) for r in (results[0], result)]
        by_slope = reference.value / part.value * (paths[1] / paths[0] if part.shared or _has_radius(result) else 1.0)
        own_sd = float(np.hypot(reference.own_sd, part.own_sd))
        value = float(np.hypot(by_slope * np.sqrt(index**2 - sine**2), sine))
        power = (value**2 - sine**2) / value**2
        rows.append(Compared(label, value, value * power * own_sd, float(by_slope), float(by_slope * own_sd)))
    found = [
        _Part(row.value, float(part.own_sd), part.freedom, {}) for row, part in zip(rows[1:], liquids, strict=True)
    ]
    power = float((found[0].value ** 2 - sine**2) / found[0].value ** 2)
    own = [part._replace(own_sd=power * part.own_sd) for part in found]
    return _united(own, "gap_index", rows, {labels[0]: (power * reference.own_sd, reference.freedom)})


def _has_radius(result: Any) -> bool:
    return getattr(result, "radius", None) is not None


def _given(result: Any, name: str, default: float) -> float:
    parameters = result.parameters
    return float(parameters[name].value) if name in parameters else default


def _mean(parts: list[_Part], of: str, labels: list[str]) -> Comparison:
    first = parts[0]
    rows = []
    for part, label in zip(parts, labels, strict=True):
        total = part.value * float(np.hypot(part.own_sd, np.linalg.norm(list(part.shared.values()))))
        ratio = part.value / first.value
        ratio_sd = None if part is first else ratio * float(np.hypot(part.own_sd, first.own_sd))
        rows.append(Compared(label, part.value, total, ratio, ratio_sd))
    names = {name for part in parts for name in part.shared}
    shared = {name: (max(part.shared.get(name, 0.0) for part in parts), np.inf) for name in sorted(names)}
    return _united(parts, of, rows, shared)


def _united(parts: list[_Part], of: str, rows: list[Compared], shared: dict[str, tuple[float, float]]) -> Comparison:
    """The weighted mean of parts, with rows for their own errors, their spread, and what they share."""
    values = np.array([part.value for part in parts])
    # In the logarithm: all errors are relative.
    logs, variances = np.log(values), np.maximum(np.array([part.own_sd for part in parts]) ** 2, 1e-30)
    weights, count, warnings = 1 / variances, len(parts), []
    excess = 0.0
    if count > 1:
        mean = float(weights @ logs) / weights.sum()
        square = float(weights @ (logs - mean) ** 2)
        excess = max(square - (count - 1), 0.0) / (weights.sum() - weights @ weights / weights.sum())
        freedoms = np.array([part.freedom for part in parts])
        chance = float(stats.f.sf(square / (count - 1), count - 1, max(float(freedoms.min()), 1.0)))
        if chance < _ALARM:
            ratio = float(np.sqrt(square / (count - 1)))
            warnings.append(Reason.RESULTS_DIFFER(measured=of.replace("_", " "), ratio=ratio))
    weights = 1 / (variances + excess)
    shares = weights / weights.sum()
    value = float(np.exp(shares @ logs))
    own_sd, spread = float(np.sqrt(shares**2 @ variances)), float(np.sqrt(excess * (shares @ shares)))
    freedom = float(sum(part.freedom for part in parts))
    terms = {"reading": (own_sd, freedom)} | ({"spread": (spread, float(count - 1))} if spread else {}) | shared
    total = float(np.sqrt(sum(sd**2 for sd, _ in terms.values())))
    uncertain = sum(sd**4 / degrees for sd, degrees in terms.values())
    effective = total**4 / uncertain if uncertain > 0 else np.inf
    half = total * float(stats.t.ppf(0.975, effective) if np.isfinite(effective) else stats.norm.ppf(0.975))
    budget = [(name, value * sd) for name, (sd, _) in terms.items()]
    interval = (value * float(np.exp(-half)), value * float(np.exp(half)))
    messages: list[Statement] = warnings
    return Comparison("ok", "", of, value, value * total, interval, budget, rows, list(messages))
