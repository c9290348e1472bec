"""Figures of surfaces as tables of a TOML file."""

from typing import Any

import msgspec
import numpy as np

from newtonjax.scene import AbstractFigure, ChebyshevFigure, Forbes, HeightMap, Zernike

FIGURE = msgspec.defstruct(
    "Figure",
    [
        ("radius", float),
        ("zernike", tuple[float, ...] | None, None),
        ("order", str, "noll"),
        ("chebyshev", tuple[tuple[float, ...], ...] | None, None),
        ("forbes", tuple[float, ...] | None, None),
        ("kind", str, "con"),
        ("curvature", float, 0.0),
        ("heights", tuple[tuple[float, ...], ...] | None, None),
        ("spacing", float | None, None),
        ("tolerance", float, 1e-10),
    ],
    forbid_unknown_fields=True,
    omit_defaults=True,
)


def figure_of(table: Any) -> AbstractFigure | None:
    """The figure in a table. Raises ValueError for one of no kind, or of two."""
    if table is None:
        return None
    if [table.zernike, table.chebyshev, table.forbes, table.heights].count(None) != 3:
        raise ValueError(
            "figure has several of zernike, chebyshev, forbes, heights, or none; allowed: one of them, and its radius"
        )
    if table.heights is not None:
        if table.spacing is None:
            raise ValueError("figure has heights without spacing; give the distance between neighbours in metres")
        return HeightMap(np.array(table.heights, dtype=float), table.spacing, table.radius, table.tolerance)
    if table.forbes is not None:
        return Forbes(table.forbes, table.radius, table.kind, table.curvature)
    if table.chebyshev is not None:
        return ChebyshevFigure(np.array(table.chebyshev, dtype=float), table.radius)
    return Zernike(table.zernike, table.radius, table.order)


def table_of(figure: AbstractFigure) -> Any:
    """The table of a figure. Raises ValueError for one of the user's own, which is a program."""
    radius = float(figure.radius)
    if isinstance(figure, Zernike):
        return FIGURE(radius, tuple(np.asarray(figure.coefficients).tolist()), figure.order)
    if isinstance(figure, Forbes):
        terms = tuple(np.asarray(figure.coefficients).tolist())
        return FIGURE(radius, forbes=terms, kind=figure.kind, curvature=float(figure.curvature))
    if isinstance(figure, ChebyshevFigure):
        return FIGURE(radius, chebyshev=tuple(map(tuple, np.asarray(figure.coefficients).tolist())))
    if isinstance(figure, HeightMap):
        heights = tuple(map(tuple, np.asarray(figure.heights).tolist()))
        return FIGURE(radius, heights=heights, spacing=float(figure.spacing), tolerance=figure.tolerance)
    kinds = "Zernike, ChebyshevFigure, Forbes, HeightMap"
    raise ValueError(f"figure is a {type(figure).__name__}, which no file can hold; allowed: {kinds}")
