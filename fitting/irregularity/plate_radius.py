"""The radius of a part from that of the test plate and the power between them."""

from typing import NamedTuple

import numpy as np

# Two-sided 95 % of a normal distribution.
_COVERAGE = 1.959963984540054


class PlateLengths(NamedTuple):
    """What was given, in metres, None where it was not; a radius is positive where the plate is hollow."""

    plate_radius: float | None = None
    plate_radius_sd: float | None = None
    wavelength: float | None = None
    wavelength_sd: float | None = None
    diameter: float | None = None
    diameter_sd: float | None = None


class PartRadius(NamedTuple):
    """The part's radius [m], positive where it is convex, its standard deviation and 95 % interval.

    - `difference`, `difference_sd`: the part's radius less the plate's [m].
    - `budget`: (source, standard deviation of the radius [m]).
    """

    radius: float
    radius_sd: float
    radius_interval: tuple[float, float]
    difference: float
    difference_sd: float
    budget: list[tuple[str, float]]


def part_radius(lengths: PlateLengths, power: float, power_sd: float) -> PartRadius | None:
    """1/R = 1/R₀ + λ P / a²: the gap of two spheres is r² / 2 times the difference of their curvatures.

    `power` [fringes], positive where the gap grows outwards. Of steep surfaces the gap has a term in r⁴ and is seen at
    a slant: both are within a² / 2 R₀² of the difference. None where a length is missing, or the part flat.
    """
    plate, wavelength, diameter = lengths.plate_radius, lengths.wavelength, lengths.diameter
    if plate is None or wavelength is None or diameter is None:
        return None
    half = diameter / 2
    change = wavelength * power / half**2
    curvature = 1 / plate + change
    of_change = {
        "power": wavelength * power_sd / half**2,
        "wavelength": abs(change) * (lengths.wavelength_sd or 0.0) / wavelength,
        "diameter": 2 * abs(change) * (lengths.diameter_sd or 0.0) / diameter,
        "steepness": abs(change) * half**2 / (2 * plate**2),
    }
    of_plate = (lengths.plate_radius_sd or 0.0) / plate**2
    change_sd = float(np.linalg.norm(list(of_change.values())))
    if not abs(curvature) > 3 * np.hypot(change_sd, of_plate):
        return None
    radius = 1 / curvature
    budget = [(name, float(sd * radius**2)) for name, sd in {"plate_radius": of_plate, **of_change}.items()]
    sd = float(np.linalg.norm([row for _, row in budget]))
    ends = radius - _COVERAGE * sd, radius + _COVERAGE * sd
    # The plate's own error moves both radii alike: of the difference only their unlike change remains.
    shared = abs(radius**2 / plate**2 - 1) * (lengths.plate_radius_sd or 0.0)
    difference_sd = float(np.hypot(change_sd * radius**2, shared))
    return PartRadius(radius, sd, ends, radius - plate, difference_sd, budget)
