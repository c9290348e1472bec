"""The picture of a form: the photograph, its fringes as fitted, the departure from the best sphere and its sd."""

import numpy as np
from matplotlib.figure import Figure

from fitting.irregularity.disc import Pupil
from fitting.irregularity.maps import departure
from fitting.irregularity.zernike import on_grid
from fitting.photo import Photograph


def of_form(
    photograph: Photograph, pupil: Pupil, form: np.ndarray, covariance: np.ndarray, nm_per_turn: float | None
) -> Figure:
    """Four panels."""
    figure = Figure(figsize=(11, 10), layout="constrained")
    panels = figure.subplots(2, 2)
    _draw_photograph(photograph, pupil, panels[0, 0])
    panels[0, 0].set_title("photograph and pupil")
    draw_fringes(photograph, pupil, form, panels[0, 1])
    unit, scale = ("fringe spacings", 1.0) if nm_per_turn is None else ("nm", nm_per_turn)
    maps = departure(form, covariance, 201)
    for panel, values, title, colours in zip(
        panels[1],
        maps,
        ("departure from the best sphere", "its standard deviation"),
        ("RdBu_r", "viridis"),
        strict=True,
    ):
        most = scale * float(np.nanmax(np.abs(values)))
        least = -most if colours == "RdBu_r" else 0.0
        extent = (pupil.x - pupil.radius, pupil.x + pupil.radius, pupil.y + pupil.radius, pupil.y - pupil.radius)
        drawing = panel.imshow(scale * values, cmap=colours, vmin=least, vmax=most or 1.0, extent=extent)
        panel.set_title(f"{title} [{unit}]")
        figure.colorbar(drawing, ax=panel, shrink=0.8)
    return figure


def count_pixels(panels, factor: int) -> None:
    """Ticks in pixels of the file, of axes in those of a picture that was read so many times smaller."""
    if factor == 1:
        return
    for panel in panels:
        for axis in (panel.xaxis, panel.yaxis):
            axis.set_major_formatter(lambda place, _: f"{factor * place:.0f}")


def of_aperture(photograph: Photograph, pupil: Pupil) -> Figure:
    """The picture with the aperture's rim."""
    rows, columns = photograph.image.shape
    figure = Figure(figsize=(8, 8 * rows / columns + 0.5), layout="constrained")
    _draw_photograph(photograph, pupil, figure.subplots())
    return figure


def draw_fringes(photograph: Photograph, pupil: Pupil, form: np.ndarray, axes) -> None:
    """The photograph with the middles of the dark fringes as fitted, into matplotlib axes."""
    _draw_photograph(photograph, pupil, axes)
    rows, columns = photograph.image.shape
    x, y = (np.linspace(middle - pupil.radius, middle + pupil.radius, 600) for middle in (pupil.x, pupil.y))
    turns = on_grid(form, (x - pupil.x) / pupil.radius, (y - pupil.y) / pupil.radius)
    outside = np.hypot((x - pupil.x)[None], (y - pupil.y)[:, None]) > pupil.radius
    turns = np.where(outside, np.nan, turns)
    dark = np.arange(np.ceil(np.nanmin(turns) - 0.5), np.nanmax(turns) - 0.5) + 0.5
    if dark.size:
        axes.contour(x, y, turns, levels=dark, colors="tab:red", linewidths=0.7, linestyles="solid")
    axes.set_xlim(-0.5, columns - 0.5)
    axes.set_ylim(rows - 0.5, -0.5)
    axes.set_title("dark fringes of the fitted form")


def _draw_photograph(photograph: Photograph, pupil: Pupil, axes) -> None:
    image = photograph.image
    low, high = np.percentile(image[photograph.mask], [1, 99])
    axes.imshow(image, cmap="gray", vmin=low, vmax=high)
    angle = np.linspace(0, 2 * np.pi, 200)
    axes.plot(pupil.x + pupil.radius * np.cos(angle), pupil.y + pupil.radius * np.sin(angle), color="tab:cyan", lw=1)
