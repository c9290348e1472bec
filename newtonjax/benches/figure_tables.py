"""Figures of surfaces as tables of a TOML file."""

from typing import Any

import msgspec
import numpy as np

from newtonjax.scene import AbstractFigure, ChebyshevFigure, Zernike

FIGURE = msgspec.defstruct(
    "Figure",
    [
        ("radius", float),
        ("zernike", tuple[float, ...] | None, None),
        ("order", str, "noll"),
        ("chebyshev", tuple[tuple[float, ...], ...] | None, None),
    ],
    forbid_unknown_fields=True,
    omit_defaults=True,
)


def figure_of(table: Any) -> AbstractFigure | None:
    """The figure in a table. Raises ValueError for one of no kind, or of two."""
    if table is None:
        return None
    if (table.zernike is None) == (table.chebyshev is None):
        raise ValueError("figure has zernike and chebyshev or none of them; allowed: one of them, and its radius")
    if table.chebyshev is not None:
        return ChebyshevFigure(np.array(table.chebyshev, dtype=float), table.radius)
    return Zernike(table.zernike, table.radius, table.order)


def table_of(figure: AbstractFigure) -> Any:
    """The table of a figure. Raises ValueError for one of the user's own, which is a program."""
    radius = float(figure.radius)
    if isinstance(figure, Zernike):
        return FIGURE(radius, tuple(np.asarray(figure.coefficients).tolist()), figure.order)
    if isinstance(figure, ChebyshevFigure):
        return FIGURE(radius, chebyshev=tuple(map(tuple, np.asarray(figure.coefficients).tolist())))
    raise ValueError(f"figure is a {type(figure).__name__}, which no file can hold; allowed: Zernike, ChebyshevFigure")
