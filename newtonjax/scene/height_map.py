"""Measured heights on a grid, with a cubic spline between them."""

from functools import cache
from itertools import product
from typing import Any

import equinox as eqx
import numpy as np
from jaxtyping import Float

from newtonjax.numerics import (
    Scalar,
    as_scalar,
    as_vector,
    chebyshev,
    finite,
    is_concrete,
    namespace,
    positive,
    require,
    require_number,
)
from newtonjax.scene.figures import SIZES, AbstractFigure

# Heights that a cubic spline takes, to a side.
_LEAST = 4


class HeightMap(AbstractFigure):
    """Heights [m] on a square grid about the vertex, and the cubic spline through them, on the disc of `radius`.

    The spline has no knot at the second and the last but one height (de Boor 1978, A Practical Guide to Splines, ch.
    IV), as SciPy's `RectBivariateSpline`. Rays meet its Chebyshev polynomials, of which 64 to a side at most leave
    `tolerance` of it.

    - `heights`: [m], rows in y, columns in x, 4 and more of each; finite on the whole square around the disc.
    - `spacing`: of the grid [m]; its middle is the vertex.
    - `radius`: of the disc [m], within the grid.
    - `tolerance`: what polynomials may leave of the spline [m].
    """

    heights: Float[Any, "ny nx"] = eqx.field(converter=as_vector)
    spacing: Scalar = eqx.field(converter=as_scalar)
    radius: Scalar = eqx.field(converter=as_scalar)
    tolerance: float = eqx.field(static=True, default=1e-10)

    def __check_init__(self):
        require_number("figure.spacing", self.spacing, "a positive distance in metres", positive)
        require_number("figure.radius", self.radius, "a positive radius in metres", positive)
        require_number("figure.tolerance", self.tolerance, "a positive height in metres", positive)
        shape = np.shape(self.heights)
        if len(shape) != 2 or min(shape) < _LEAST:
            raise ValueError(
                f"figure.heights has shape {shape}; allowed: a table [in y, in x] of {_LEAST} x {_LEAST} heights "
                "or more"
            )
        require("figure.heights", self.heights, "finite heights in metres on the whole square around the disc", finite)
        if is_concrete(self):
            reach = (min(shape) - 1) / 2 * float(self.spacing)
            if float(self.radius) > reach * (1 + 1e-9):
                raise ValueError(
                    f"figure.radius is {float(self.radius):.4g} m, and the heights reach {reach:.4g} m from the "
                    "vertex; allowed: a disc within the grid"
                )

    def sag(self, x: Float[Any, "..."], y: Float[Any, "..."]) -> Float[Any, "..."]:
        xp, (rows, columns) = namespace(self.heights, x, y), np.shape(self.heights)
        row, by_row = _weights(xp, y / self.spacing + (rows - 1) / 2, rows)
        column, by_column = _weights(xp, x / self.spacing + (columns - 1) / 2, columns)
        across = [xp.asarray(table) for table in (self.heights, self.heights @ _bends(columns).T)]
        down = [[table, _bends(rows) @ table] for table in across]
        height = 0.0
        for (of_bends, j, of_row), (of_bends_across, i, of_column) in product(by_row, by_column):
            height += of_row * of_column * down[of_bends_across][of_bends][row + j, column + i]
        return height

    def size(self) -> int:
        if not is_concrete(self):
            return SIZES[-1]
        left_out = np.inf
        for size in SIZES:
            left_out = chebyshev.shells(np.asarray(self.table(size), dtype=float))[-2:].sum()
            if left_out <= self.tolerance:
                return size
        raise ValueError(
            f"{SIZES[-1]} x {SIZES[-1]} polynomials leave {left_out:.2g} m of the heights; allowed: "
            f"{self.tolerance:g} m (tolerance); smooth the heights, or give a larger tolerance"
        )


@cache
def _bends(count: int) -> np.ndarray:
    """The matrix from heights to the spline's second derivatives at them, both by the grid's spacing."""
    matrix, differences = np.zeros((count, count)), np.zeros((count, count))
    for k in range(1, count - 1):
        matrix[k, k - 1 : k + 2] = 1.0, 4.0, 1.0
        differences[k, k - 1 : k + 2] = 6.0, -12.0, 6.0
    matrix[0, :3] = matrix[-1, -3:] = 1.0, -2.0, 1.0
    return np.linalg.solve(matrix, differences)


def _weights(xp: Any, at: Any, count: int) -> tuple[Any, list[tuple[int, int, Any]]]:
    """The place before `at`; whether a weight is that of a height or of a bend, how many places on, and the weight."""
    place = xp.clip(xp.floor(at), 0, count - 2)
    after = at - place
    before = 1 - after
    bends = [(1, side, (part**3 - part) / 6) for side, part in enumerate((before, after))]
    return place.astype(int), [(0, 0, before), (0, 1, after), *bends]
