"""The lens radius from ring orders and ring radii: Newton's straight line."""

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fitting.parameters import UNITS, Parameter, absolute_sd, check_quantity, number, says_its_origin
from fitting.tables.bench import Bench
from fitting.tables.judgement import Judgement
from fitting.tables.result import RingsResult
from fitting.tables.table import readings
from newtonjax.numerics import require_choice, shown

# The largest standard deviation of an angle [rad].
_LARGEST_ANGLE_SD = np.pi / 4


@says_its_origin
def rings(
    table: str | Path | Mapping[str, Any],
    *,
    wavelength: float | None = None,
    wavelength_sd: float | str | None = None,
    pixel_size: float | None = None,
    pixel_size_sd: float | str | None = None,
    radius: float | None = None,
    radius_sd: float | str | None = None,
    view: str = "reflected",
    bright: bool = False,
    view_angle: float = 0.0,
    view_angle_sd: float | str | None = None,
    gap_index: float | None = None,
    gap_index_sd: float | str | None = None,
    expected_radius: float | None = None,
    columns: Mapping[str, str] | None = None,
    separator: str | None = None,
    encoding: str | None = None,
    vernier: float | None = None,
) -> RingsResult:
    """The lens radius from a table of ring readings: the slope of r² against order is R λ / (n cos θ).

    Ring 1 is the first dark ring outside of the centre: in contact r² = m λ R reflected and (2m - 1) λ R / 2
    transmitted; bright rings the other way round (Born and Wolf, Principles of Optics, section 7.5.3). The line's
    intercept is free, so that a gap or a wrong first order does not matter. Angle θ is that in the gap, by Snell's law.
    The sphere is exact. Readings off the line, orders counted wrong, r² that is no line, several series, scatter that
    is not as stated, and radii that no lens has are said in the warnings, or are the reason of a refusal.

    Args:
      table: a CSV file or a workbook, a text with line breaks, or columns by name; `fitting.tables.table.readings`
        tells which.
      wavelength: in vacuum, or in air with air as the index 1 [m]. Without it `radius` gives it.
      pixel_size: [m], for readings in pixels; without it the answer is the slope.
      radius: of the lens where it is known [m]: the wavelength is measured instead. With both known, readings in pixels
        give the pixel size, others the index of what fills the gap.
      bright: the readings are of bright rings.
      view_angle: of view against the plate's normal, outside [rad].
      gap_index: of the gap's medium; 1 where it is not given and not measured.
      wavelength_sd, pixel_size_sd, radius_sd, view_angle_sd, gap_index_sd: standard deviations, in the same units or as
        "0.1%".
      expected_radius: rough [m]; radii and diameters, or units, that look mistaken are then warned of.
      columns: names of the table's own columns, as {"diameter_mm": "D"}; "row" for order are the rows' numbers.
      separator, encoding: of the file where they are taken wrongly: "comma", "semicolon", "tab", "bar", "blank"; a name
        that Python knows.
      vernier: what a division of a vernier beside a main scale is worth [m].

    Raises ValueError and FileNotFoundError for input that cannot be used; what the readings cannot give comes back as a
    status and a message.

    """
    began = time.perf_counter()
    sds = _checked_sds(locals())
    read = readings(table, columns, separator=separator, encoding=encoding, vernier=vernier)
    if read.is_wedge:
        raise ValueError(
            f"the table has no ring sizes but {read.column}: positions of straight fringes, as of a wedge, give no "
            "radius, but the wedge's angle (newtonjax wedge, fitting.wedge); for rings give left_mm with "
            "right_mm, diameter_mm or radius_mm"
        )
    both = wavelength is not None and radius is not None
    in_pixels = read.unit == "px" and pixel_size is None
    if both and gap_index is not None and not in_pixels:
        raise ValueError("wavelength, radius and gap_index are given: nothing is left to measure; leave one out")
    # A ring's path difference is 2 t n cos θ' = 2 t sqrt(n² - sin² θ).
    bench = Bench(
        None if wavelength is None else number("wavelength", wavelength),
        None if radius is None else number("radius", radius),
        gap_index=None if both and not in_pixels else 1.0 if gap_index is None else float(gap_index),
        view_angle=float(view_angle),
        contact=-0.5 if (view == "transmitted") != bright else 0.0,
        scale=float(pixel_size or 1.0) if read.unit == "px" else 1.0,
        unit="px" if in_pixels else "m",
    )
    if read.unit != "px":
        sds["pixel_size"] = 0.0
    model = {
        "table": read.understood,
        "rings": f"{'bright' if bright else 'dark'}, {view}, read from {read.column}",
        "line": f"r² against order, free intercept, {'weighted' if read.sd is not None else 'equal weights'}",
        "gap": f"exact sphere, index {'measured' if bench.gap_index is None else f'{bench.gap_index:g}'}, "
        f"seen at {np.degrees(view_angle):g}°",
    }
    judgement = Judgement(read, bench, sds, expected_radius)
    status, message, values = judgement.outcome()
    given = {
        "wavelength": wavelength,
        "radius": radius,
        "pixel_size": pixel_size if read.unit == "px" else None,
        "view_angle": view_angle,
        "gap_index": bench.gap_index,
    }
    parameters = {
        name: Parameter(float(value), sds[name] or None, True, name, UNITS[name])
        for name, value in given.items()
        if value is not None
    }
    if (measured := bench.measured) in values:
        answer = Parameter(values[measured], values.get(f"{measured}_sd"), False, measured, UNITS[measured])
        parameters = {measured: answer} | parameters
    return RingsResult(
        status,
        message,
        measured=bench.measured,
        warnings=[*read.warnings, *judgement.warnings],
        model=model | judgement.model,
        unit=bench.unit,
        seconds=time.perf_counter() - began,
        parameters=parameters,
        **values,
    )


def _checked_sds(arguments: dict) -> dict[str, float]:
    """Standard deviations by name, 0 for those not given. Raises ValueError for arguments that cannot be used."""
    require_choice("view", arguments["view"], ("reflected", "transmitted"))
    if not isinstance(arguments["bright"], bool | np.bool_):
        raise ValueError(f"bright is {shown(arguments['bright'])}; allowed: True or False")
    for name in ("wavelength", "pixel_size", "gap_index", "radius"):
        check_quantity(name, arguments[name])
    check_quantity("expected_radius", arguments["expected_radius"], "radius")
    if arguments["wavelength"] is None and arguments["radius"] is None:
        raise ValueError(
            "give wavelength to measure the radius, or radius to measure the wavelength, or both to measure the pixel "
            "size or the gap's index"
        )
    if arguments["radius"] is not None and arguments["expected_radius"] is not None:
        raise ValueError("expected_radius is of a radius that is measured; leave it out where radius is given")
    if not abs(number("view_angle", arguments["view_angle"])) < np.pi / 2:
        raise ValueError(f"view_angle is {arguments['view_angle']}; allowed: less than a right angle, in radians")
    if arguments["gap_index"] is not None and np.sin(arguments["view_angle"]) ** 2 >= arguments["gap_index"] ** 2:
        raise ValueError(f"gap_index is {arguments['gap_index']}: light at this angle does not enter the gap")
    names = ("wavelength", "pixel_size", "radius", "view_angle", "gap_index")
    values = {name: arguments[name] for name in names}
    if values["gap_index"] is None and arguments["gap_index_sd"] is not None:
        if None not in (arguments["wavelength"], arguments["radius"]):
            raise ValueError("gap_index_sd is given without gap_index; give both")
        values["gap_index"] = 1.0
    sds = {name: absolute_sd(name, arguments[f"{name}_sd"], value) or 0.0 for name, value in values.items()}
    if sds["view_angle"] > _LARGEST_ANGLE_SD:
        raise ValueError(
            f"view_angle_sd is {sds['view_angle']:g}; allowed: up to {_LARGEST_ANGLE_SD:.3g} rad (45 degrees)"
        )
    return sds
