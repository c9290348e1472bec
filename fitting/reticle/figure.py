"""The picture of a ruled grid: the photograph with the lines as they were measured."""

import numpy as np
from matplotlib.figure import Figure

from fitting.photo import Photograph
from fitting.reticle.grid import Grid


def of_grid(photograph: Photograph, grid: Grid, title: str) -> Figure:
    """The photograph with the measured lines."""
    rows, columns = photograph.image.shape
    figure = Figure(figsize=(9, 9 * rows / columns + 0.6), layout="constrained")
    draw_lines(photograph, grid, title, figure.subplots())
    return figure


def draw_lines(photograph: Photograph, grid: Grid, title: str, axes) -> None:
    """The photograph with the measured lines, into matplotlib axes."""
    image = photograph.image
    low, high = np.percentile(image[photograph.lit], [1, 99])
    axes.imshow(image, cmap="gray", vmin=low, vmax=high)
    x, y = np.arange(image.shape[1], dtype=float), np.arange(image.shape[0], dtype=float)[:, None]
    for direction, colour in enumerate(("tab:red", "tab:cyan")):
        # A line is where the turns are whole.
        turns = grid.turns(direction, x, y, image.shape)
        axes.contour(
            turns, levels=np.arange(np.ceil(turns.min()), np.floor(turns.max()) + 1), colors=colour, linewidths=0.6
        )
    axes.set_title(title)
