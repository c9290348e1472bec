"""The vector of a fit's numbers: the one file that knows at which place each of them stands.

Compiled programs depend on the vector's length only, so it always holds the numbers of all parts of the model; those of
parts that are absent are 0 and do not move.
"""

from collections import namedtuple
from collections.abc import Iterable, Mapping

import numpy as np
from jaxtyping import Float, Int

from fitting.parameters.table import TABLE

NUMBERS = ("curvature", "centre_x", "centre_y", "phase", *(spec.name for spec in TABLE.values() if spec.in_fit))
# A fit's numbers by name: `Numbers(*vector)` reads a vector, `np.array(numbers)` makes one. Centres are counted from
# the image's middle, in half diagonals, the phase in turns; what the others mean, the models say. The first four are
# always there; each of the others belongs to a part of the model, and is 0 without it.
Numbers = namedtuple("Numbers", NUMBERS, defaults=(0.0,) * (len(NUMBERS) - 4))


def slots_of(names: Iterable[str]) -> Int[np.ndarray, " n"]:
    """Where numbers stand, in the order of their names."""
    return np.array([NUMBERS.index(name) for name in names], int)


def block_of(matrix: np.ndarray, names: Iterable[str] = NUMBERS) -> Float[np.ndarray, "n n"]:
    """Rows and columns of a matrix, in the order of the names."""
    slots = slots_of(names)
    return matrix[np.ix_(slots, slots)]


def rescaled(
    covariance: Float[np.ndarray, "numbers numbers"], factors: Mapping[str, float]
) -> Float[np.ndarray, "numbers numbers"]:
    """A covariance in other units, in which each number is so many times larger; 1 where nothing is said."""
    factor = np.array([factors.get(name, 1.0) for name in NUMBERS])
    return factor[:, None] * covariance * factor


def result_names(unknown: str | None) -> dict[str, str]:
    """What a result calls each number, for the quantity that is measured (None: the fringe scale).

    A result's numbers are in SI units or pixels: a gap for the phase; the parts' may have other names there.
    """
    return dict(zip(NUMBERS, NUMBERS, strict=True)) | {
        "curvature": unknown or "fringe_scale_per_px2",
        "centre_x": "centre_x_px",
        "centre_y": "centre_y_px",
        "phase": "gap",
    }
