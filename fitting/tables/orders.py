"""The lens radius from ring orders and ring radii: Newton's straight line."""

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy import optimize, stats

from fitting.parameters import absolute_sd, check_quantity, number, says_its_origin
from fitting.tables.line import Line, ring_line, straight_line
from fitting.tables.result import Ring, RingsResult
from fitting.tables.table import Readings, readings

_OFFSET = 0.3
# Rings wider than this share of the lens's radius bend the line of r² by a percent.
_STEEP = 0.2


@says_its_origin
def rings(
    table: str | Path | Mapping[str, Any],
    *,
    wavelength: float,
    wavelength_sd: float | str | None = None,
    pixel_size: float | None = None,
    pixel_size_sd: float | str | None = None,
    view: str = "reflected",
    bright: bool = False,
    angle: float = 0.0,
    angle_sd: float | str | None = None,
    gap_index: float = 1.0,
    gap_index_sd: float | str | None = None,
    expected_radius: float | None = None,
    columns: Mapping[str, str] | None = None,
) -> RingsResult:
    """The lens radius from a table of ring readings: the slope of r² against order is R λ / (n cos θ).

    Ring 1 is the first dark ring outside of the centre: in contact r² = m λ R reflected and (2m - 1) λ R / 2
    transmitted; bright rings the other way round (Born and Wolf, Principles of Optics, section 7.5.3). The line's
    intercept is free, so that a gap or a wrong first order does not matter. Angle θ is that in the gap, by Snell's law.
    The sphere is exact. Readings off the line and orders counted wrong are flagged.

    Args:
      table: a CSV file, or columns by name; `fitting.tables.table.readings` tells which.
      wavelength: in vacuum, or in air with air as the index 1 [m].
      pixel_size: [m], for readings in pixels; without it the answer is the slope.
      bright: the readings are of bright rings.
      angle: of view against the plate's normal, outside [rad].
      gap_index: of the gap's medium.
      wavelength_sd, pixel_size_sd, angle_sd, gap_index_sd: standard deviations, in the same units or as "0.1%".
      expected_radius: rough [m]; a radius four times as large or as small is then warned of.
      columns: names of the table's own columns, as {"diameter_mm": "D"}.

    Raises ValueError and FileNotFoundError for input that cannot be used; what the readings cannot give comes back as a
    status and a message.

    """
    began = time.perf_counter()
    sds = _checked_sds(locals())
    read = readings(table, columns)
    scale = (pixel_size or 1.0) if read.unit == "px" else 1.0
    unit = "px" if read.unit == "px" and pixel_size is None else "m"
    radius, sd = read.radius * scale, None if read.sd is None else read.sd * scale
    # A ring's path difference is 2 t n cos θ' = 2 t sqrt(n² - sin² θ).
    path = float(np.sqrt(gap_index**2 - np.sin(angle) ** 2))
    contact = -0.5 if (view == "transmitted") != bright else 0.0
    model = _model(read, view, bright, angle, gap_index)

    def answer(status: str, message: str = "", **values) -> RingsResult:
        seconds = time.perf_counter() - began
        return RingsResult(status, message, warnings=warnings, model=model, unit=unit, seconds=seconds, **values)

    warnings = [*read.warnings]
    if (count := len(np.unique(read.order))) < 2:
        return answer("refused", f"readings of {count} ring; a radius needs at least two orders")
    line, ordinate = _line(read.order, radius, sd, contact, path / wavelength if unit == "m" else None)
    if line is None:
        return answer("refused", "no sphere has these rings: they are wider than the lens they tell; check the units")
    if line.slope <= 0:
        return answer("refused", "the radii do not grow with the order; count orders from the centre outwards")
    offset = line.intercept / line.slope - contact
    slope_sd, offset_sd = _line_sds(line)
    warnings += _line_warnings(line, offset, offset_sd)
    if slope_sd is None:
        warnings.append("two readings give a line but no standard deviation; read more rings, or state sd_mm")
    common = {
        "slope": line.slope,
        "slope_sd": slope_sd,
        "order_offset": offset,
        "order_offset_sd": offset_sd,
        "gap": -(offset - round(offset)) * wavelength / (2 * path),
        "rings": _rings(line, read, radius, ordinate),
    }
    if unit == "px":
        message = "without pixel_size there is no radius: the fringe scale is the answer"
        return answer("no-scale", message, fringe_scale_per_px2=1 / line.slope, **common)
    radius_m = line.slope * path / wavelength
    warnings += _factor_of_four(radius_m, expected_radius)
    if slope_sd is None:
        return answer("ok", radius=radius_m, **common)
    relative = {
        "reading": slope_sd / line.slope,
        "pixel_size": 2 * sds["pixel_size"] / scale if read.unit == "px" else 0.0,
        "wavelength": sds["wavelength"] / wavelength,
        "angle": abs(np.sin(angle) * np.cos(angle)) / path**2 * sds["angle"],
        "gap_index": gap_index / path**2 * sds["gap_index"],
    }
    budget = [(name, radius_m * float(sd)) for name, sd in relative.items() if sd or name == "reading"]
    noise, total = budget[0][1], float(np.sqrt(sum(sd**2 for _, sd in budget)))
    return answer(
        "ok",
        radius=radius_m,
        radius_sd=total,
        radius_interval=_interval(radius_m, total, noise, line.freedom),
        radius_sd_noise=noise,
        budget=budget,
        **common,
    )


def _checked_sds(arguments: dict) -> dict[str, float]:
    """Standard deviations by name, 0 for those not given. Raises ValueError for arguments that cannot be used."""
    if arguments["view"] not in ("reflected", "transmitted"):
        raise ValueError(f"view is {arguments['view']!r}; allowed: 'reflected' or 'transmitted'")
    for name in ("wavelength", "pixel_size", "gap_index"):
        check_quantity(name, arguments[name])
    check_quantity("expected_radius", arguments["expected_radius"], "radius")
    if not abs(number("angle", arguments["angle"])) < np.pi / 2:
        raise ValueError(f"angle is {arguments['angle']}; allowed: less than a right angle, in radians")
    if np.sin(arguments["angle"]) ** 2 >= arguments["gap_index"] ** 2:
        raise ValueError(f"gap_index is {arguments['gap_index']}: light at this angle does not enter the gap")
    names = ("wavelength", "pixel_size", "angle", "gap_index")
    return {name: absolute_sd(name, arguments[f"{name}_sd"], arguments[name]) or 0.0 for name in names}


def _line(order, radius, sd, contact: float, turns: float | None) -> tuple[Line | None, np.ndarray]:
    """The line and its ordinate: for a sphere r² + h² = 2 R h, the R being that of the line. None where none is."""
    # The variance of r², to second order: at the centre the first order vanishes.
    deviation = None if sd is None else np.sqrt((2 * radius * sd) ** 2 + 2 * sd**4)
    ordinate = radius**2
    line = ring_line(order, ordinate, deviation, contact)
    if turns is None or line.slope <= 0:
        return line, ordinate

    def on_sphere(lens: float) -> np.ndarray:
        share = np.minimum(radius / lens, 1.0)  # a misread ring may be wider than the lens
        return radius**2 + (radius**2 / (lens * (1 + np.sqrt(1 - share**2)))) ** 2

    # Where the lens is steep, r² alone is so bent that good rings look misread.
    steep = radius[line.used].max() > _STEEP * line.slope * turns
    used, counted = (np.ones(len(radius), bool), order) if steep else (line.used, line.order)
    errors = None if deviation is None else deviation[used]

    def excess(lens: float) -> float:
        """By how much the line on a sphere makes it larger than it was taken for: falls with its radius."""
        (slope, _), _ = straight_line(counted[used], on_sphere(lens)[used], errors)
        return float(slope) * turns - lens

    smallest = float(radius[used].max())
    largest = 4 * max(smallest, line.slope * turns)
    if excess(smallest) <= 0:
        return None, ordinate
    lens = optimize.bisect(excess, smallest, largest, xtol=1e-15 * largest, maxiter=200)
    ordinate = on_sphere(float(np.asarray(lens)))
    return ring_line(order, ordinate, deviation, contact), ordinate


def _line_sds(line: Line) -> tuple[float | None, float | None]:
    """Standard deviations of slope and offset; None where two readings leave them unknown."""
    if not np.isfinite(line.covariance).all():
        return None, None
    # Of the slope, and of the offset in orders, their quotient.
    return line.sd_of(1.0, 0.0), line.sd_of(-line.intercept / line.slope**2, 1.0 / line.slope)


def _interval(radius: float, total: float, noise: float, freedom: float) -> tuple[float, float]:
    """95 % by Student's t, for the effective degrees of freedom of Welch and Satterthwaite (GUM, G.4)."""
    effective = freedom * (total / noise) ** 4 if noise > 0 and np.isfinite(freedom) else np.inf
    half = total * float(stats.norm.ppf(0.975) if np.isinf(effective) else stats.t.ppf(0.975, effective))
    return radius - half, radius + half


def _rings(line: Line, read: Readings, radius: np.ndarray, ordinate: np.ndarray) -> list[Ring]:
    residual = line.residual(ordinate) / np.maximum(2 * radius, 1e-300)
    rows = zip(read.order, radius, residual, line.flags, strict=True)
    return [Ring(float(m), float(r), float(residual_radius), flag) for m, r, residual_radius, flag in rows]


def _line_warnings(line: Line, offset: float, offset_sd: float | None) -> list[str]:
    warnings = []
    out = [f"{m:g}" for m, used in zip(line.order, line.used, strict=True) if not used]
    if out:
        warnings.append(f"readings of order {', '.join(out)} lie off the line of the others and were left out")
    counted = [flag for flag in line.flags if flag.startswith("counted")]
    if counted:
        warnings.append(f"{len(counted)} orders were miscounted by a whole ring and set right; see their flags")
    suspects = [f"{m:g}" for m, flag in zip(line.order, line.flags, strict=True) if flag.startswith("does not")]
    if suspects:
        warnings.append(
            f"the readings do not lie on a line; order {', '.join(suspects)} is the likeliest to be misread"
        )
    if offset_sd is not None and abs(offset) > max(_OFFSET, 3 * offset_sd):
        miscount = round(offset)
        count = (
            f"the orders may be counted {abs(miscount)} too {'low' if miscount > 0 else 'high'}, or "
            if miscount
            else ""
        )
        warnings.append(
            f"the line misses contact by {offset:+.2g} orders: {count}the glasses do not touch; the radius is from the "
            "slope and does not depend on it"
        )
    return warnings


def _factor_of_four(radius: float, expected: float | None) -> list[str]:
    if expected is None:
        return []
    ratio = radius / expected
    if abs(np.log(ratio)) <= min(abs(np.log(ratio / 4)), abs(np.log(ratio * 4))):
        return []
    look, called, corrected = ("diameters", "radii", radius / 4) if ratio > 1 else ("radii", "diameters", radius * 4)
    return [
        f"the radius is {ratio:.2g} times the expected one: what the table calls {called} look like {look}; "
        f"if they are, the radius is {corrected:.4g} m (name the column with columns or --column)"
    ]


def _model(read: Readings, view: str, bright: bool, angle: float, gap_index: float) -> dict[str, str]:
    return {
        "rings": f"{'bright' if bright else 'dark'}, {view}, read from {read.column}",
        "line": f"r² against order, free intercept, {'weighted' if read.sd is not None else 'equal weights'}",
        "gap": f"exact sphere, gap index {gap_index:g}, seen at {np.degrees(angle):g}°",
    }
