"""The picture of a table of rings: r² against order with the line, and what is left over it."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from fitting.tables.ring import Ring


def of_rings(rings: Sequence[Ring], unit: str, title: str) -> Figure:
    """r² against order with the fitted line, and residual radii; flagged readings in red. `unit`: "m" or "px"."""
    figure = Figure(figsize=(9, 4.2), layout="constrained")
    line_axes, residual_axes = figure.subplots(1, 2)
    draw_line(rings, unit, line_axes)
    _draw_readings(rings, unit, residual_axes, "residual")
    residual_axes.axhline(0, color="tab:red", lw=1)
    residual_axes.set_ylabel(f"residual radius [{_drawn_in(unit)[1]}]")
    figure.suptitle(title)
    return figure


def draw_line(rings: Sequence[Ring], unit: str, axes) -> None:
    """r² against order into matplotlib axes, with the fitted line."""
    factor, name = _drawn_in(unit)
    order, radius, residual = np.array([(ring.order, ring.radius, ring.residual) for ring in rings]).T
    _draw_readings(rings, unit, axes, "radius")
    by_order = np.argsort(order)
    line = factor**2 * (radius**2 - 2 * radius * residual)
    axes.plot(order[by_order], line[by_order], color="tab:red", lw=1, label="line")
    axes.set_ylabel(f"r² [{name}²]")
    axes.legend()


def _draw_readings(rings: Sequence[Ring], unit: str, axes, name: str) -> None:
    factor, power = _drawn_in(unit)[0], 2 if name == "radius" else 1
    order = np.array([ring.order for ring in rings])
    values = (factor * np.array([getattr(ring, name) for ring in rings])) ** power
    flagged = np.array([bool(ring.flag) for ring in rings])
    axes.plot(order[~flagged], values[~flagged], "o", ms=4, color="0.3", label="readings")
    if flagged.any():
        axes.plot(order[flagged], values[flagged], "o", ms=6, mfc="none", color="tab:red", label="flagged")
    axes.set_xlabel("order as given")


def _drawn_in(unit: str) -> tuple[float, str]:
    """Factor and name of what radii are drawn in."""
    return (1e3, "mm") if unit == "m" else (1.0, "px")
