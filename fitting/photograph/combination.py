"""From the curvatures of several pictures to one value, their ratios, and who contradicts whom."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy import optimize, stats

from fitting.parameters import TABLE, with_sd
from fitting.photograph.joint import View, contradiction, joined
from fitting.photograph.result import FitResult
from fitting.photograph.together_result import PictureRow, Together
from fitting.photograph.uncertainty import COMMON_WAVES, GAP_WAVES
from fitting.reasons import Reason

# Chance that a picture is named that does not contradict the others, over all pictures.
_ALARM = 0.01
# Farther from the others, in standard deviations and as a share, no picture is of the same lens: the deviations of
# photographs of one lens have been too small by a factor of 3.5 in one of a hundred pairs. What is closer together is
# what an exact picture's model leaves out: the spread says so.
_MOST_APART, _LEAST_SHARE = 10.0, 0.01


class Logarithms(NamedTuple):
    """A picture's number.

    - `level`: its logarithm, of the radius up to a constant without a scale; `value`: the number itself, as shown.
    - `slope`: how the level changes with the logarithm of the `curvature`, which is that of the picture alone.
    - `beside`: relative deviation of the curvature beside what normal equations say; `waves`: by the gap's whole waves.
    - `quantities`: relative deviations by the quantity that brings them.
    """

    view: View
    curvature: float
    level: float
    value: float
    slope: float
    beside: float
    waves: float
    quantities: dict[str, float]


class _Levels(NamedTuple):
    """Logarithms of all pictures' numbers, and their covariance by where it comes from."""

    values: np.ndarray
    parts: dict[str, np.ndarray]

    @property
    def covariance(self) -> np.ndarray:
        return np.sum(list(self.parts.values()), axis=0)

    def sd(self, weights: np.ndarray) -> float:
        return float(np.sqrt(max(weights @ self.covariance @ weights, 0.0)))


def combined(
    numbers: Sequence[Logarithms],
    labels: Sequence[str],
    alike: frozenset[str],
    shared: frozenset[str],
    warnings: list[str],
    fits: list[FitResult],
) -> Together:
    """The answer of two pictures and more; `alike`: quantities whose errors are the same in all of them."""
    has_camera, is_one = "distortion" in shared, fits[0].measured in shared
    levels, camera = _levels(numbers, alike, has_camera)
    count = len(numbers)
    reduced = {
        k: _levels([number for j, number in enumerate(numbers) if j != k], alike, has_camera)[0]
        for k in (range(count) if count > 2 else ())
    }
    apart = _apart(numbers, levels, is_one, has_camera)
    warnings = warnings + _warnings(apart, labels)
    alone, _ = _levels(numbers, alike, has_camera=False)
    rows, excess = [], 0.0
    for k, number in enumerate(numbers):
        unit = np.eye(count)[k]
        sd = float(np.hypot(levels.sd(unit), _excess(levels, reduced, unit)))
        step = unit - np.eye(count)[0]
        excess_of_ratio = _excess(levels, reduced, step) if k else 0.0
        excess = excess_of_ratio if k == 1 else excess
        value = number.value * float(np.exp((levels.values[k] - number.level) * _sense(fits[k])))
        ratio = float(np.exp(step @ levels.values))
        ratio_sd = ratio * float(np.hypot(levels.sd(step), excess_of_ratio)) if k else None
        alone_sd = number.value * alone.sd(unit)
        rows.append(PictureRow(labels[k], value, value * sd, number.value, alone_sd, ratio, ratio_sd, apart[k]))
    measured = fits[0].measured if fits[0].status == "ok" else "fringe_scale"
    status = fits[0].status
    common = {"members": rows, "shared": camera, "covariance": levels.covariance, "warnings": warnings, "fits": fits}
    pair = {"ratio": rows[1].ratio, "ratio_sd": rows[1].ratio_sd}
    if not (is_one and status == "ok"):
        budget = _budget(levels, np.eye(count)[1] - np.eye(count)[0], rows[1].ratio, excess)
        return Together(status, fits[0].message, measured, budget=budget, **pair, **common)
    if max(_from_the_others(levels)) > _MOST_APART and np.ptp(levels.values) > _LEAST_SHARE:
        message = _no_common_value(_from_the_others(levels), rows, fits[0].measured)
        return Together("refused", message, measured, warnings=warnings, fits=fits)
    levels = levels._replace(parts=levels.parts | {"spread": _spread(levels) * np.eye(count)})
    weights = _weights(levels.covariance)
    mean = float(np.exp(weights @ levels.values))
    spread = _excess_of_mean(levels, reduced, weights)
    sd = mean * float(np.hypot(levels.sd(weights), spread))
    return Together(status, "", measured, mean, sd, budget=_budget(levels, weights, mean, spread), **pair, **common)


def _sense(fit: FitResult) -> float:
    """A fringe scale falls as the radius grows."""
    return 1.0 if fit.status == "ok" else -1.0


def _levels(numbers: Sequence[Logarithms], alike: frozenset[str], has_camera: bool) -> tuple[_Levels, dict]:
    """All pictures' levels; with a camera its numbers too, which move them."""
    singles = [joined([number.view]) for number in numbers]
    joint = joined([number.view for number in numbers]) if has_camera else None
    slopes = np.array([number.slope for number in numbers])
    curvatures = np.array([number.curvature for number in numbers])
    levels = np.array([number.level for number in numbers])
    if joint is None:
        of_image = np.diag([single.covariance.item() for single in singles])
        of_camera = np.zeros_like(of_image)
    else:
        levels = levels + slopes * np.log(joint.curvatures / curvatures)
        curvatures, of_image, of_camera = joint.curvatures, joint.covariance, joint.of_camera
    scale = np.outer(slopes / curvatures, slopes / curvatures)
    parts = {
        "pictures": scale * (of_image - of_camera),
        "camera": scale * of_camera,
        "beside the pictures": np.diag(np.square(slopes * [number.beside for number in numbers])),
    }
    waves = slopes * [number.waves for number in numbers]
    if waves.any():
        parts[GAP_WAVES] = COMMON_WAVES * np.outer(waves, waves) + (1 - COMMON_WAVES) * np.diag(np.square(waves))
    for name in sorted({name for number in numbers for name in number.quantities}):
        sds = np.array([number.quantities.get(name, 0.0) for number in numbers])
        parts[name] = np.outer(sds, sds) if name in alike else np.diag(np.square(sds))
    return _Levels(levels, parts), {} if joint is None else joint.shared


def _spread(levels: _Levels) -> float:
    """The variance of pictures of one lens beyond their own: chi-squared is its mean then (Paule and Mandel 1982)."""
    own, values = levels.covariance + _ridge(levels.covariance), levels.values

    def beyond(spread: float) -> float:
        covariance = own + spread * np.eye(len(values))
        residual = values - _weights(covariance) @ values
        return float(residual @ np.linalg.solve(covariance, residual)) - (len(values) - 1)

    # Chi-squared is at most a half there: of exact pictures it differs from 1 by no more than rounding at half of it.
    most = 2 * float(np.square(values - values.mean()).sum())
    return optimize.root_scalar(beyond, bracket=(0.0, most)).root if beyond(0.0) > 0 else 0.0


def _ridge(covariance: np.ndarray) -> np.ndarray:
    """A deviation of a millionth of the mean one, since exact pictures have a singular covariance."""
    return 1e-12 * np.trace(covariance) / len(covariance) * np.eye(len(covariance))


def _weights(covariance: np.ndarray) -> np.ndarray:
    """Of the best mean (Aitken 1935)."""
    weights = np.linalg.solve(covariance + _ridge(covariance), np.ones(len(covariance)))
    return weights / weights.sum()


def _excess(levels: _Levels, reduced: dict[int, _Levels], weights: np.ndarray) -> float:
    """What the deviation by leaving out pictures has beyond the formal one, of a number that some pictures have.

    Tukey's jackknife over those that are not among these.
    """
    values = []
    for k, rest in reduced.items():
        if not weights[k]:
            values.append(float(np.delete(weights, k) @ rest.values))
    if len(values) < 2:
        return 0.0
    square = (len(values) - 1) / len(values) * float(np.square(np.subtract(values, np.mean(values))).sum())
    return float(np.sqrt(max(square - levels.sd(weights) ** 2, 0.0)))


def _excess_of_mean(levels: _Levels, reduced: dict[int, _Levels], weights: np.ndarray) -> float:
    """The same of the mean of all pictures."""
    values = [float(_weights(rest.covariance) @ rest.values) for rest in reduced.values()]
    if len(values) < 2:
        return 0.0
    square = (len(values) - 1) / len(values) * float(np.square(np.subtract(values, np.mean(values))).sum())
    return float(np.sqrt(max(square - levels.sd(weights) ** 2, 0.0)))


def _apart(numbers: Sequence[Logarithms], levels: _Levels, is_one: bool, has_camera: bool) -> list[float | None]:
    """By how many standard deviations each picture disagrees with the others, in the radius and in the camera."""
    views = [number.view for number in numbers]
    in_camera = [[contradiction(views, k)] if has_camera else [] for k in range(len(numbers))]
    in_value = [[distance] for distance in _from_the_others(levels)] if is_one else [[] for _ in numbers]
    pairs = [camera + value for camera, value in zip(in_camera, in_value, strict=True)]
    return [max(sizes) if sizes else None for sizes in pairs]


def _from_the_others(levels: _Levels) -> list[float]:
    """By how many standard deviations each picture's number differs from the mean of the others."""
    count, distances = len(levels.values), []
    for k in range(count):
        beside = np.delete(np.arange(count), k)
        weights = np.eye(count)[k]
        weights[beside] -= _weights(levels.covariance[np.ix_(beside, beside)])
        distances.append(abs(float(weights @ levels.values)) / max(levels.sd(weights), 1e-300))
    return distances


def _no_common_value(distances: list[float], rows: Sequence[PictureRow], measured: str) -> str:
    """Why pictures that were to share a number do not."""
    unit = TABLE[measured].unit
    values = ", ".join(f"{row.name} {with_sd(row.alone, row.alone_sd, unit)}" for row in rows)
    farthest = rows[int(np.argmax(distances))].name if len(rows) > 2 else "one of them"
    return Reason.NO_COMMON_VALUE(
        measured=measured.replace("_", " "), values=values, size=max(distances), most=_MOST_APART, picture=farthest
    )


def _warnings(apart: list[float | None], labels: Sequence[str]) -> list[str]:
    """The picture that contradicts the others most, beyond what chance does."""
    sizes = np.array([0.0 if size is None else size for size in apart])
    if not sizes.max() > stats.norm.isf(_ALARM / 2 / len(apart)):
        return []
    if len(apart) == 2:
        return [Reason.PICTURES_CONTRADICT(size=float(sizes.max()))]
    return [Reason.PICTURE_CONTRADICTS(name=labels[int(sizes.argmax())], size=float(sizes.max()))]


def _budget(levels: _Levels, weights: np.ndarray, value: float, excess: float) -> list[tuple[str, float]]:
    """Rows in units of the value; what does not count is left out."""
    rows = {name: float(np.sqrt(max(weights @ part @ weights, 0.0))) for name, part in levels.parts.items()}
    rows["leaving out pictures"] = excess
    return [(name, value * row) for name, row in rows.items() if row > 1e-9]
