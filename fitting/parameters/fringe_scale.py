"""Which quantity a fit measures: n s² / (R λ) is one number, so three of the four must be given."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from fitting.parameters.table import TABLE
from fitting.reasons import Reason
from newtonjax.numerics import Statement, is_real, shown
from newtonjax.scene import RELATIVE_SD

# What may be 0, and have a deviation all the same.
_ABOUT_ZERO = ("view_angle",)
# A standard deviation: a number in the unit of what it belongs to, or a text such as "0.1%".
Deviation = float | int | str
# ln k = Σ exponent ln quantity, for the fringe scale k = n s² / (R λ).
EXPONENTS = {"radius": -1, "wavelength": -1, "pixel_size": 2, "gap_index": 1}


def number(name: str, value) -> float:
    """A finite number out of what was given. Raises ValueError for anything else."""
    try:
        result = float(value) if is_real(value) and np.ndim(value) == 0 else np.nan
    except (TypeError, ValueError, OverflowError):
        result = np.nan
    if not np.isfinite(result):
        raise ValueError(f"{name} is {shown(value)}; allowed: one finite number in SI units")
    return result


def check_quantity(name: str, value, kind: str = "") -> None:
    """Raise ValueError for what cannot be meant; `kind` is the quantity whose bounds it has, if not its own."""
    spec = TABLE[kind or name]
    low, high = spec.bounds
    if value is not None and not low <= number(name, value) <= high:
        raise ValueError(f"{name} is {value}; allowed: {low:g} to {high:g}{spec.in_unit}")


def absolute_sd(name: str, sd: Deviation | None, value: Any) -> float | None:
    """The standard deviation of a given quantity, in its unit; None where there is none.

    Raises ValueError for what is not a standard deviation, for one of a quantity that is not given, and for more than a
    quarter of its value.
    """
    if sd is None:
        return None
    is_relative, size = read_sd(sd)
    if not 0 <= size < np.inf:
        allowed = 'zero or a positive number in SI units, or a text such as "0.1%"'
        raise ValueError(f"{name}_sd is {shown(sd)}; allowed: {allowed}")
    if size and value is None:
        raise ValueError(f"{name}_sd is given without {name}; give both, or neither")
    if value is None:
        return size
    if is_relative and size and not float(value):
        raise ValueError(f"{name}_sd is {sd} of {name}, which is 0; give {name}_sd in SI units")
    absolute = size * abs(float(value)) if is_relative else size
    if name not in _ABOUT_ZERO and absolute > RELATIVE_SD * abs(float(value)):
        raise ValueError(
            f"{name}_sd is {sd} of {name}, {float(value):g}; allowed: up to a quarter of it; check the units"
        )
    return absolute


def read_sd(sd: Any) -> tuple[bool, float]:
    """Whether it is a percentage, and its size: a fraction then; NaN for what is not a number."""
    text = sd.strip() if isinstance(sd, str) else ""
    is_relative = text.endswith("%")
    try:
        # Masked elements are 0 in an array, and warn in a list.
        if isinstance(sd, list | tuple | np.ma.MaskedArray) or (not isinstance(sd, str) and np.ndim(sd)):
            return False, np.nan
        return is_relative, 0.01 * float(text[:-1]) if is_relative else float(np.asarray(sd).item())
    except (TypeError, ValueError, OverflowError):
        return is_relative, np.nan


def checked_fixed(fixed) -> dict:
    """What the user holds, as numbers. Raises ValueError for other names or values."""
    return _checked("fixed", fixed, {"gap"})


def checked_start(start) -> dict:
    """What the user starts from, as numbers. Raises ValueError for other names or values, or where one is missing."""
    numbers = _checked("start", start, {"radius", "fringe_scale_per_px2"})
    for name in ("radius", "fringe_scale_per_px2"):
        if name in numbers and numbers[name] <= 0:
            raise ValueError(f"start: {name} is {numbers[name]:g}; allowed: above zero")
    if numbers and ("centre_px" not in numbers or len(numbers) < 2):
        raise ValueError("start needs centre_px, and radius or fringe_scale_per_px2; without it the rings are searched")
    return numbers


def _checked(argument: str, values, scalars: set[str]) -> dict:
    if values is None:
        return {}
    allowed = sorted({"centre_px", *scalars})
    if not isinstance(values, Mapping) or set(values) - set(allowed):
        raise ValueError(f"{argument} is {shown(values)}; allowed: a mapping of {', '.join(allowed)}")
    numbers: dict = {name: number(f"{argument}: {name}", values[name]) for name in values if name in scalars}
    if "centre_px" in values:
        pair = np.atleast_1d(np.asarray(values["centre_px"], dtype=object))
        if pair.shape != (2,):
            raise ValueError(
                f"{argument}: centre_px is {shown(values['centre_px'])}; allowed: two numbers, (x, y) in pixels"
            )
        numbers["centre_px"] = tuple(number(f"{argument}: centre_px", value) for value in pair)
    return numbers


@dataclass(frozen=True)
class Quantities:
    """What is given (SI units), with standard deviations, and the one that is measured (None: not enough given).

    `plate`: radius and standard deviation of the other face [m], None for a flat one.
    """

    given: dict[str, float]
    sd: dict[str, float]
    unknown: str | None
    plate: tuple[float, float] | None = None

    @property
    def measured(self) -> str:
        """The unknown quantity. Raises ValueError where too little is given to measure one."""
        if self.unknown is None:
            missing = ", ".join(name for name in EXPONENTS if name not in self.given)
            raise ValueError(f"{missing} are not given; one quantity can be measured when the other three are given")
        return self.unknown

    def solve(self, scale, changed: Mapping = MappingProxyType({})):
        """The unknown quantity for a fringe scale [1/px²], with `changed` values in place of given ones; arrays too."""
        exponent = EXPONENTS[self.measured]
        logarithm = sum(EXPONENTS[name] * np.log(value) for name, value in {**self.given, **changed}.items())
        return np.exp((np.log(scale) - logarithm) / exponent)

    def measured_at(self, scale, changed: Mapping):
        """The same as `solve`, for JAX too."""
        values = {**self.given, **changed}
        factor = math.prod(value ** EXPONENTS[name] for name, value in values.items())
        return (scale / factor) ** (1 / EXPONENTS[self.measured])

    def scale(self, measured, changed: Mapping = MappingProxyType({})):
        """The fringe scale [1/px²] of a value of the measured quantity; as in `solve`."""
        values = {**self.given, **changed, self.measured: measured}
        return math.prod(values[name] ** exponent for name, exponent in EXPONENTS.items())

    def values(self, scale: float) -> dict[str, float]:
        """All four quantities for a fringe scale."""
        return {**self.given, self.measured: float(self.solve(scale))}


def held_turns(fixed: dict, quantities: Quantities) -> float:
    """Phase of a held gap [turns], but for the view's half turn.

    Raises ValueError where what it takes is not known.
    """
    for name in ("wavelength", "gap_index"):
        if name not in quantities.given and fixed["gap"] != 0:
            raise ValueError(f"a fixed gap needs the {name}, which is free; give it, or fix the gap at 0")
    return 2 * quantities.given.get("gap_index", 1.0) * fixed["gap"] / quantities.given.get("wavelength", 1.0)


def lensless(plate: float, effective: float, reach: float) -> Statement | None:
    """Why no lens stands on a plate [m], for rings of a radius [m] that reach so far [m]; None where one can."""
    curvature = 1 / effective - 1 / plate
    if not curvature > 0:
        return Reason.PLATE_LENS_NOT_CONVEX(plate=plate, effective=effective)
    if curvature * reach >= 1:
        return Reason.PLATE_LENS_TOO_SMALL(plate=plate, lens=1 / curvature, reach=reach)
    return None


def lens_misfit(known: Quantities, scale: float, reach_px: float) -> Statement | None:
    """Why no lens of these quantities has rings of a fringe scale [1/px²] that reach so far; None where one can."""
    if known.unknown is None:
        return None
    values = known.values(scale)
    reach = values["pixel_size"] * reach_px
    if reach < values["radius"]:
        return lensless(known.plate[0], values["radius"], reach) if known.plate else None
    return Reason.LENS_SMALLER_THAN_FIELD(radius=values["radius"], reach=reach)


def checked_plate(radius, sd) -> tuple[float, float] | None:
    """Radius and standard deviation of a curved test plate. Raises ValueError for what cannot be one."""
    if radius is not None:
        check_quantity("plate_radius", abs(number("plate_radius", radius)), "radius")
    absolute = absolute_sd("plate_radius", sd, radius)
    return None if radius is None else (float(radius), absolute or 0.0)


def quantities(given: dict[str, float | None], sd: dict[str, Deviation | None], free: tuple[str, ...]) -> Quantities:
    """Sort what is given from what is to be measured.

    Raises ValueError for values that are not positive, and where nothing is left to measure.
    """
    for name, value in given.items():
        check_quantity(name, value)
    absolute = {name: absolute_sd(name, sd[name], value) for name, value in given.items()}
    values = {name: float(value) for name, value in given.items() if value is not None and name not in free}
    missing = [name for name in EXPONENTS if name not in values]
    if not missing:
        raise ValueError(
            "radius, wavelength and pixel_size are all given, and a gap_index: nothing is left to measure; leave out "
            "what is to be measured"
        )
    return Quantities(
        values,
        {name: size for name, size in absolute.items() if size is not None and name in values},
        missing[0] if len(missing) == 1 else None,
    )
