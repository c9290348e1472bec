"""The picture of speed against accuracy, of `MethodTiming`s."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

_MEASURES = {
    "intensity_error": "largest error of intensity, over the peak (red: ignores a part of the scene)",
    "radius_bias": "bias of the radius, relative (below 1e-12 at 1e-12)",
}
# Smaller errors are drawn here.
_LEAST = 1e-12


def of_timings(timings: tuple[Any, ...], ax=None) -> Any:
    """Time against error of intensity and against the bias of the radius: lower left is better."""
    if ax is not None:
        _draw(timings, "intensity_error", _MEASURES["intensity_error"], ax)
        return ax.figure
    measures = ["intensity_error"]
    if any(timing.radius_bias is not None for timing in timings if timing.name != "Traced"):
        measures.append("radius_bias")
    canvas = Figure(figsize=(5.4 * len(measures), 4.4), layout="constrained")
    panels = canvas.subplots(1, len(measures), sharey=True, squeeze=False)[0]
    for axes, measure in zip(panels, measures, strict=True):
        _draw(timings, measure, _MEASURES[measure], axes)
    panels[0].set_ylabel("time of an image [ms]")
    return canvas


def _draw(timings: tuple[Any, ...], measure: str, label: str, axes) -> None:
    """A point for each method, a line for the reference."""
    methods = [timing for timing in timings if timing.name != "Traced"]
    values = [abs(value) for timing in methods if (value := getattr(timing, measure)) is not None]
    middle = np.sqrt(max(min(values, default=1.0), _LEAST) * max(max(values, default=1.0), _LEAST))
    for timing in methods:
        value = getattr(timing, measure)
        if timing.seconds is None or value is None:
            continue
        point = max(abs(value), _LEAST), 1e3 * timing.seconds
        axes.loglog(*point, "o", color="tab:red" if timing.note.startswith("ignores") else "tab:blue")
        side = {"xytext": (4, 4)} if point[0] <= middle else {"xytext": (-5, 5), "ha": "right"}
        axes.annotate(timing.name, point, textcoords="offset points", fontsize=8, **side)
    for timing in timings:
        if timing.name == "Traced" and timing.seconds is not None:
            axes.axhline(1e3 * timing.seconds, color="0.6", lw=1, ls="--")
            axes.annotate("Traced: the reference", (0.02, 1e3 * timing.seconds), xycoords=("axes fraction", "data"),
                          xytext=(0, 3), textcoords="offset points", fontsize=8, color="0.4")  # fmt: skip
    axes.set_xlabel(label, fontsize=9)
    axes.margins(x=0.2)
    axes.grid(alpha=0.3)
