"""What an image leaves uncertain of its first number, row by row: noise, parts of the model, and what it left out."""

from collections.abc import Iterable

import numpy as np

from fitting.estimate import Fitted
from fitting.model import AXIS_ROW, LEAVING_OUT, PARTS, numbers_of
from fitting.parameters import NUMBERS, Numbers, Quantities
from fitting.photograph.averaging import Averaging
from fitting.photograph.choice import Choice
from fitting.photograph.uncertainty import halves_apart, of_assumptions, of_blur, of_doublet

_CURVATURE = NUMBERS.index("curvature")
# A law that a part leaves out counts up to so many standard deviations of the number that would tell it.
_APART = 3.0
# A blur and what is assumed of the bench stand in the budget from this share of all else on: less adds half a percent.
_COUNTS = 0.1


def image_rows(choice: Choice, variance: float, known: Quantities) -> tuple[np.ndarray, list[tuple[str, float]]]:
    """Covariance of all unknowns, and (source, deviation of the curvature) of all that is not a given quantity.

    Noise with the parts' numbers held; then what each part's own numbers add; what these leave out; models
    that the image does not rule out; sodium's second line; what halves of the field differ by beyond their noise;
    and what a blur, and what the model takes for granted of the bench, do where that counts.
    """
    fit, averaging = choice.found, choice.averaging
    numbers, present = Numbers(*fit.numbers), fit.parts
    matrix, averaged = fit.matrix, ()
    if averaging is None:
        covariance, rows = matrix.covariance(variance), _rows_of_parts(fit, variance)
    else:
        covariance = averaging.mean(variance, ratio=choice.ratio).covariance
        rows = _rows_of_average(averaging, variance, choice.ratio)
        averaged = numbers_of(max(averaging.members[0].sets, key=len))
    laws = [part.law(numbers, present) for part in LEAVING_OUT if part.name in present]
    # What is averaged over is not left out.
    for law in (law for law in laws if law is not None and law.number not in averaged):
        size = min(law.size, _APART * matrix.deviation_if_free(law.number, variance))
        rows.append((law.row, abs(float(Numbers(*matrix.shift_by(law.number)).curvature)) * size))
    curvature = float(numbers.curvature)
    rows += [(name, abs(float(Numbers(*second.numbers).curvature) - curvature)) for name, second in choice.undecided]
    beside = {
        "sodium's two lines": of_doublet(fit, known.given.get("wavelength")),
        "model, by halves of the field": halves_apart(fit, variance),
    }
    rows += [(name, row) for name, row in beside.items() if row > 0]
    size = _COUNTS * np.linalg.norm([row for _, row in rows])
    further = [("blur", of_blur(fit)), *of_assumptions(fit, known)]
    return covariance, rows + [(name, row) for name, row in further if row > size]


def _rows_of_parts(fit: Fitted, variance: float) -> list[tuple[str, float]]:
    """Noise with the parts' numbers held; then what each part's own add."""
    groups = [group for part in fit.parts for group in _groups_of(part)]

    def deviation(count: int) -> float:
        fixed_numbers = [name for _, numbers in groups[count:] for name in numbers]
        return fit.matrix.holding(fixed_numbers).deviation("curvature", variance)

    return _added(("noise", *(row for row, _ in groups)), map(deviation, range(len(groups) + 1)))


def _rows_of_average(averaging: Averaging, variance: float, ratio: float) -> list[tuple[str, float]]:
    """Noise with no part free; then what each part adds, sets without it and with it averaged."""
    sets = averaging.members[0].sets
    warps = [part for part in PARTS if any(part in names for names in sets)]
    fitted = {part for member in averaging.members for part in member.fit.parts}
    searched = [part for part in PARTS if part in fitted and PARTS[part].parameters and part not in warps]
    least = min(sets, key=len)

    def deviation(parts: list[str], fixed_parts: list[str], held: tuple[str, ...] = ()) -> float:
        average = averaging.mean(variance, lambda names: names <= {*parts, *least}, fixed_parts, ratio, held)
        return float(np.sqrt(max(average.covariance[_CURVATURE, _CURVATURE], 0.0)))

    steps: list[tuple[str, tuple]] = [("noise", ([], searched))]
    for count, part in enumerate(warps, 1):
        axis = PARTS[part].axis
        steps.append((part, (warps[:count], searched, axis)))
        steps += [(AXIS_ROW, (warps[:count], searched))] if axis else []
    steps += [(part, (warps, searched[count:])) for count, part in enumerate(searched, 1)]
    return _added((row for row, _ in steps), (deviation(*free) for _, free in steps))


def _groups_of(part: str) -> list[tuple[str, tuple[str, ...]]]:
    """(row, numbers) of a part: the camera's axis has a row of its own."""
    axis = PARTS[part].axis
    groups = [(part, tuple(name for name in PARTS[part].parameters if name not in axis)), (AXIS_ROW, axis)]
    return [(row, numbers) for row, numbers in groups if numbers]


def _added(rows: Iterable[str], deviations: Iterable[float]) -> list[tuple[str, float]]:
    """Rows of the deviations of ever more that is free: what each adds to the largest before it."""
    largest, added = 0.0, []
    for row, deviation in zip(rows, deviations, strict=True):
        added.append((row, float(np.sqrt(max(deviation**2 - largest**2, 0.0)))))
        largest = max(deviation, largest)
    return added
