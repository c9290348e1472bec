"""The ordinate in which a sphere's rings lie on a line: r² + h² = 2 R h, the R being that of the line."""

import numpy as np
from scipy import optimize

from fitting.tables.line import Line, ring_line
from fitting.tables.regression import regression
from fitting.tables.sample import Sample

# Rings wider than this share of the lens's radius bend the line of r² by a percent.
_STEEP = 0.2


def line_on_sphere(flat: Sample, contact: float, turns: float, series=None) -> tuple[Line, Sample] | None:
    """The line with its sample, on the sphere whose radius is slope times `turns`; None where no sphere has such rings.

    `flat`: the readings with r² for ordinate; `contact`: the contact's intercept, in orders; `turns`: path over
    wavelength [1/m]; `series` [readings]: where each series has an intercept of its own.
    """
    order, radius = flat.order, flat.radius
    line = ring_line(flat, contact, series)
    if line.slope <= 0 or line.mixture is not None:
        return line, flat
    # Where the lens is steep, r² alone is so bent that good rings look misread.
    steep = radius[line.used].max() > _STEEP * line.slope * turns
    used, counted = (np.ones(len(radius), bool), order) if steep else (line.used, line.order)
    group = np.zeros(len(radius), int) if steep else np.unique(line.level, return_inverse=True)[1]

    def excess(lens: float) -> float:
        """By how much the line on a sphere makes it larger than it was taken for: falls with its radius."""
        ordinate = on_sphere(radius, lens)
        return regression(counted[used], ordinate[used], flat.weight[used], group[used]).slope * turns - lens

    smallest = float(radius[used].max())
    largest = 4 * max(smallest, line.slope * turns)
    if excess(smallest) <= 0 or excess(largest) >= 0:
        return None
    lens = float(np.asarray(optimize.brentq(excess, smallest, largest, xtol=1e-15 * largest, maxiter=200)))
    sample = Sample(order, radius, on_sphere(radius, lens), flat.sd, flat.rounding)
    return ring_line(sample, contact, series), sample


def on_sphere(radius: np.ndarray, lens: float) -> np.ndarray:
    """r² + h² of rings of a lens [m²]."""
    share = np.minimum(radius / lens, 1.0)  # a misread ring may be wider than the lens
    return radius**2 + (radius**2 / (lens * (1 + np.sqrt(1 - share**2)))) ** 2
