"""The ordinate in which a sphere's rings lie on a line: r² + h² = 2 R h, the R being that of the line."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy import optimize

from fitting.tables.line import Line, ring_line
from fitting.tables.regression import regression
from fitting.tables.sample import Sample

# Rings wider than this share of the lens's radius bend the line of r² by a percent.
_STEEP = 0.2
# Rounds of lens and line at most.
_ROUNDS = 6


def line_on_sphere(flat: Sample, contact: float, turns: float, series=None) -> tuple[Line, Sample] | None:
    """The line with its sample, on the sphere whose radius is slope times `turns`; None where no sphere has such rings.

    `flat`: the readings with r² for ordinate; `contact`: the contact's intercept, in orders; `turns`: path over
    wavelength [1/m]; `series` [readings]: where each series has an intercept of its own.

    Lens and line are found in turns: each lens is that of the readings, orders and groups that the line before it uses.
    """
    line, sample = ring_line(flat, contact, series), flat
    if line.slope <= 0 or line.mixture is not None:
        return line, flat
    largest = 4 * max(float(flat.radius.max()), line.slope * turns)
    # Where the lens is steep, r² alone is so bent that good rings look misread: the first line is then a robust one.
    if flat.radius[line.used].max() > _STEEP * line.slope * turns:
        group = np.zeros(len(flat.radius), int) if series is None else series
        lens = _lens_of(lambda ordinate: _median_slope(flat.order, ordinate, group), flat.radius, turns, largest)
        if lens is not None:
            sample = replace(flat, ordinate=on_sphere(flat.radius, lens))
            line = ring_line(sample, contact, series)
    for _ in range(_ROUNDS):
        lens, previous = _lens_of(_slope_of(line, flat), flat.radius[line.used], turns, largest), line
        if lens is None:
            return None
        sample = replace(flat, ordinate=on_sphere(flat.radius, lens))
        line = ring_line(sample, contact, series)
        if _have_same_readings(line, previous):
            break
    return line, sample


def _have_same_readings(line: Line, previous: Line) -> bool:
    """Whether two lines use the same readings, with the same orders and groups: then their lens is the same."""
    return (
        np.array_equal(line.used, previous.used)
        and np.array_equal(line.order, previous.order)
        and np.array_equal(line.regression.group, previous.regression.group)
    )


def _lens_of(slope: Callable[[np.ndarray], float], radius: np.ndarray, turns: float, largest: float) -> float | None:
    """The lens radius [m] whose sphere's ordinate has the slope that belongs to it; None where there is none.

    `slope`: of an ordinate [readings]; `radius` [readings]: of the rings, none of them wider than the lens.
    """

    def excess(lens: float) -> float:
        """By how much the line on a sphere makes it larger than it was taken for: falls with its radius."""
        return slope(on_sphere(radius, lens)) * turns - lens

    smallest = float(radius.max())
    if excess(smallest) <= 0 or excess(largest) >= 0:
        return None
    return float(np.asarray(optimize.brentq(excess, smallest, largest, xtol=1e-15 * largest, maxiter=200)))


def _slope_of(line: Line, flat: Sample) -> Callable[[np.ndarray], float]:
    """The slope of an ordinate of the readings that a line uses, by its orders and groups."""
    used, group = line.used, line.regression.group
    return lambda ordinate: regression(line.order[used], ordinate, flat.weight[used], group).slope


def _median_slope(order: np.ndarray, y: np.ndarray, group: np.ndarray) -> float:
    """Median of the slopes between readings half a group apart: a few misread ones do not move it (Theil 1950)."""
    slopes = []
    for number in np.unique(group):
        rows = np.flatnonzero(group == number)
        rows = rows[np.argsort(order[rows], kind="stable")]
        half = (len(rows) + 1) // 2
        rise, steps = y[rows[half:]] - y[rows[:-half]], order[rows[half:]] - order[rows[:-half]]
        slopes.append(rise[steps > 0] / steps[steps > 0])
    joined = np.concatenate(slopes)
    return float(np.median(joined)) if len(joined) else 0.0


def on_sphere(radius: np.ndarray, lens: float) -> np.ndarray:
    """r² + h² of rings of a lens [m²]."""
    share = np.minimum(radius / lens, 1.0)  # a misread ring may be wider than the lens
    return radius**2 + (radius**2 / (lens * (1 + np.sqrt(1 - share**2)))) ** 2
