"""The picture of a scale: the photograph with the lines, or the edge, as they were measured."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from fitting.photo import Photograph
from fitting.reticle.grid import Grid


def of_lines(photograph: Photograph, measured: Grid | np.ndarray | None, title: str) -> Figure:
    """The photograph with a grid, or marks [mark, point, (x, y)] as of a ruler or a disc."""
    rows, columns = photograph.image.shape
    figure = Figure(figsize=(9, 9 * rows / columns + 0.6), layout="constrained")
    draw(photograph, measured, title, figure.subplots())
    return figure


def of_points(places: np.ndarray, title: str, axes: Any) -> Any:
    """Two places [2, (x, y)] as in a picture, whose y runs downwards."""
    axes = axes or Figure(figsize=(7, 4), layout="constrained").subplots()
    axes.plot(*places.T, "o-", color="tab:red", lw=0.8)
    axes.set(aspect="equal", adjustable="datalim", xlabel="x [px]", ylabel="y [px]", title=title)
    axes.invert_yaxis()
    return axes.figure


def draw(photograph: Photograph, measured: Grid | np.ndarray | None, title: str, axes) -> None:
    """The same into matplotlib axes."""
    image = photograph.image
    low, high = np.percentile(image[photograph.lit], [1, 99])
    axes.imshow(image, cmap="gray", vmin=low, vmax=high)
    if isinstance(measured, Grid):
        _draw_grid(image, measured, axes)
    else:
        for mark in () if measured is None else measured:
            axes.plot(*np.transpose(mark), color="tab:red", lw=0.8)
    axes.set_title(title)


def _draw_grid(image: np.ndarray, grid: Grid, axes) -> None:
    x, y = np.arange(image.shape[1], dtype=float), np.arange(image.shape[0], dtype=float)[:, None]
    for direction, colour in enumerate(("tab:red", "tab:cyan")):
        # A line is where the turns are whole.
        turns = grid.turns(direction, x, y, image.shape)
        axes.contour(
            turns, levels=np.arange(np.ceil(turns.min()), np.floor(turns.max()) + 1), colors=colour, linewidths=0.6
        )
