"""The picture of a table of rings: r² against order with the line, and what is left over it."""

import numpy as np
from matplotlib.figure import Figure

from fitting.tables.result import RingsResult


def rings_figure(result: RingsResult) -> Figure:
    """r² against order with the fitted line, and residual radii; flagged readings in red. The reason where refused."""
    figure = Figure(figsize=(9, 4.2), layout="constrained")
    if not result.rings or result.slope is None or result.order_offset is None:
        figure.text(0.5, 0.5, f"{result.status}: {result.message}", ha="center", va="center", wrap=True)
        return figure
    line_axes, residual_axes = figure.subplots(1, 2)
    factor, unit = (1e3, "mm") if result.unit == "m" else (1.0, "px")
    order, radius, residual = (
        np.array([getattr(r, name) for r in result.rings]) for name in ("order", "radius", "residual")
    )
    flagged = np.array([bool(r.flag) for r in result.rings])
    line = factor**2 * (radius**2 - 2 * radius * residual)
    for axes, values in ((line_axes, (factor * radius) ** 2), (residual_axes, factor * residual)):
        axes.plot(order[~flagged], values[~flagged], "o", ms=4, color="0.3", label="readings")
        if flagged.any():
            axes.plot(order[flagged], values[flagged], "o", ms=6, mfc="none", color="tab:red", label="flagged")
        axes.set_xlabel("order as given")
    by_order = np.argsort(order)
    line_axes.plot(order[by_order], line[by_order], color="tab:red", lw=1, label="line")
    line_axes.set_ylabel(f"r² [{unit}²]")
    line_axes.legend()
    residual_axes.axhline(0, color="tab:red", lw=1)
    residual_axes.set_ylabel(f"residual radius [{unit}]")
    if result.radius is not None:
        sd = "" if result.radius_sd is None else f" ± {result.radius_sd:.2g}"
        figure.suptitle(f"radius {result.radius:.6g}{sd} m")
    return figure
