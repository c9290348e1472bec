"""The angle of an air wedge from positions of its straight fringes: the other straight line of the laboratory."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy import stats

from fitting.parameters import absolute_sd, check_quantity, number, says_its_origin
from fitting.reasons import Reason
from fitting.tables.breaks import best_break
from fitting.tables.outliers import misread
from fitting.tables.regression import Regression, regression
from fitting.tables.table import Readings, readings
from fitting.tables.wedge_result import Fringe, WedgeResult
from newtonjax.numerics import Statement

# A wedge is thinner than long; steeper, its fringes are finer than a wavelength.
_LARGEST_ANGLE = np.pi / 4
# Chance of honest fringes to be called unevenly spaced.
_BENT = 0.003
_COUNTED = ("wavelength", "gap_index")


class _Line(NamedTuple):
    """The line through the readings used [readings], the variance of unit weight, its degrees of freedom, warnings.

    `sign`: -1 where positions fall with the orders; the line is that of the position times it.
    """

    line: Regression
    sign: float
    used: np.ndarray
    variance: float
    freedom: float
    warnings: list[Statement]


@says_its_origin
def wedge(
    table: str | Path | Mapping[str, Any],
    *,
    wavelength: float,
    wavelength_sd: float | str | None = None,
    length: float | None = None,
    length_sd: float | str | None = None,
    gap_index: float = 1.0,
    gap_index_sd: float | str | None = None,
    columns: Mapping[str, str] | None = None,
    separator: str | None = None,
    encoding: str | None = None,
    vernier: float | None = None,
) -> WedgeResult:
    """The angle of a wedge, tan α = λ / (2 n s), from positions of its fringes at a spacing s, seen along the normal.

    The thickness at the end, such as that of a hair between two plates, is L tan α. (Born and Wolf, Principles of
    Optics, section 7.5.3.) Orders may be counted from any fringe, in either direction.

    Args:
      table: a CSV file, or columns by name: `order`, and `position_mm` across the fringes (or um, cm, m), as for
        `rings`; `sd_mm` of the positions, if stated.
      wavelength: in vacuum, or in air with air as the index 1 [m].
      length: from the line of contact to where the thickness is wanted [m].
      gap_index: of what fills the wedge.
      wavelength_sd, length_sd, gap_index_sd: standard deviations, in the same units or as "0.1%".
      columns: names of the table's own columns, as {"position_mm": "x"}.
      separator, encoding, vernier: as in `rings`.

    Raises ValueError and FileNotFoundError for input that cannot be used; what the readings cannot give comes back as a
    status and a message.

    """
    inputs = {"wavelength": wavelength, "gap_index": gap_index}
    sds = {"wavelength": wavelength_sd, "gap_index": gap_index_sd}
    for name, value in inputs.items():
        check_quantity(name, number(name, value))
    if length is not None and not 1e-6 < number("length", length) < 100:
        raise ValueError(f"length is {length}; allowed: 1e-6 to 100 m")
    relative = {name: (absolute_sd(name, sds[name], inputs[name]) or 0.0) / inputs[name] for name in _COUNTED}
    of_length = (absolute_sd("length", length_sd, length) or 0.0) / (length or 1.0)
    read = readings(table, columns, separator=separator, encoding=encoding, vernier=vernier)
    if not read.is_wedge or read.unit == "px":
        raise ValueError(
            f"the table's {read.column} gives no positions of fringes; give a column position_mm (or um, cm, m); "
            "sizes of rings are measured by newtonjax rings"
        )
    model = {
        "table": read.understood,
        "fringes": f"straight, {len(read.order)} readings of {read.column}",
        "wedge": f"tan α = λ / (2 n s), index {gap_index:g}, seen along the normal",
    }
    status, message, values, warnings = _outcome(
        read, relative, inputs, None if length is None else float(length), of_length
    )
    return WedgeResult(status, message, model=model, warnings=[*read.warnings, *warnings], **values)


def _outcome(
    read: Readings, relative: dict[str, float], inputs: dict[str, float], length: float | None, of_length: float
) -> tuple[str, str, dict[str, Any], list[Statement]]:
    """Status, message, the values of the result by name, and warnings."""
    if (count := len(np.unique(read.order))) < 3:
        return "refused", Reason.FEW_FRINGES_OF_WEDGE(count=count), {}, []
    line, sign, used, variance, freedom, warnings = _line(read)
    spacing, spacing_sd = line.slope, float(np.sqrt(variance / line.spread))
    quantile = float(stats.t.ppf(0.975, freedom)) if np.isfinite(freedom) else float(stats.norm.ppf(0.975))
    if spacing <= quantile * spacing_sd:
        return "refused", Reason.NO_SPACING(spacing=spacing, sd=spacing_sd), {}, warnings
    slope = inputs["wavelength"] / (2 * inputs["gap_index"] * spacing)
    angle = float(np.arctan(slope))
    if angle > _LARGEST_ANGLE:
        return "refused", Reason.WEDGE_TOO_STEEP(spacing=spacing), {}, warnings
    budget = [("reading", spacing_sd / spacing), *((name, sd) for name, sd in relative.items() if sd)]
    total = float(np.sqrt(sum(sd**2 for _, sd in budget)))
    half = float(np.hypot(quantile * budget[0][1], 1.96 * np.sqrt(sum(sd**2 for _, sd in budget[1:]))))
    # d tan α = dα / cos² α.
    per_slope = slope / (1 + slope**2)
    level = float(line.intercept())
    residual = read.radius - sign * (line.slope * read.order + level)
    flags = np.where(used, "", "off the line, left out")
    values: dict[str, Any] = {
        "spacing": spacing,
        "spacing_sd": spacing_sd,
        "wedge_angle": angle,
        "wedge_angle_sd": per_slope * total,
        "wedge_angle_interval": _interval(angle, per_slope * half),
        "budget": budget,
        "fringes": [
            Fringe(float(m), float(x), float(r), str(flag))
            for m, x, r, flag in zip(read.order, read.radius, residual, flags, strict=True)
        ],
    }
    if length is not None:
        thickness = length * slope
        values |= {
            "thickness": thickness,
            "thickness_sd": thickness * float(np.hypot(total, of_length)),
            "thickness_interval": _interval(thickness, thickness * float(np.hypot(half, 1.96 * of_length))),
        }
    return "ok", "", values, warnings


def _interval(value: float, half: float) -> tuple[float, float]:
    """95 %, normal in the logarithm: neither a thickness nor an angle is negative."""
    factor = float(np.exp(half / value))
    return value / factor, value * factor


def _line(read: Readings) -> _Line:
    """The line of position against order, without misread fringes; counted so that positions grow with orders."""
    sign = 1.0 if np.polyfit(read.order, read.radius, 1)[0] > 0 else -1.0
    weight = np.ones(len(read.order)) if read.sd is None else read.sd**-2.0
    floor = max(read.rounding**2, (1e-9 * np.ptp(read.radius)) ** 2) if read.sd is None else 1.0
    used, warnings = np.ones(len(read.order), bool), []
    for _ in range(len(used)):
        line = regression(read.order[used], sign * read.radius[used], weight[used])
        if (outliers := misread(line, len(used), floor)) is None:
            break
        used[np.flatnonzero(used)[outliers.places]] = False
    line = regression(read.order[used], sign * read.radius[used], weight[used])
    if not used.all():
        orders = ", ".join(f"order {m:g}" for m in read.order[~used][:8])
        count = int((~used).sum())
        warnings.append(
            Reason.READING_LEFT_OUT(listed=orders)
            if count == 1
            else Reason.READINGS_LEFT_OUT(count=count, listed=orders)
        )
    variance, freedom = max(line.chi2 / line.freedom, floor), float(line.freedom)
    if read.sd is not None and stats.chi2.sf(line.chi2, line.freedom) > 0.1:
        variance, freedom = 1.0, np.inf
    warnings += _contradiction(line, floor)
    return _Line(line, sign, used, variance, freedom, warnings)


def _contradiction(line: Regression, floor: float) -> list[Statement]:
    """That a step of the count, or a bend, explains more than chance would; the one that explains more."""
    step, bend = best_break(line, floor), line.added(line.centred**2)
    if step is not None and step.gain >= bend.gain:
        return [Reason.FRINGES_MISCOUNTED(before=step.before, after=step.after, rings=step.rings, sd=step.sd)]
    if line.freedom < 2:
        return []
    ratio = bend.gain / max((line.chi2 - bend.gain) / (line.freedom - 1), floor)
    if stats.f.sf(ratio, 1, line.freedom - 1) > _BENT:
        return []
    # From end to end the spacing changes by twice the coefficient times the span of orders.
    change = 2 * bend.coefficient * float(np.ptp(line.order)) / line.slope
    return [Reason.UNEVEN_FRINGES(deviations=float(np.sqrt(ratio)), change=change)]
