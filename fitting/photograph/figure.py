"""The picture of a fit: the photograph with the rings drawn over it, the residual, and the unwrapped view."""

import numpy as np
from matplotlib.figure import Figure
from scipy import ndimage

from fitting.photograph.picture import DrawnPicture, Picture

# Of the unwrapped view and the profile.
_PHASE = "phase [turns], whole where it is bright"
# No more rings than this are drawn: beyond, they would hide the photograph.
_RINGS = 40


def of_picture(picture: Picture | DrawnPicture, centre: tuple[float, float], title: str) -> Figure:
    """Photograph with the fitted dark rings over it, residual, and the order across against angle down; centre [px]."""
    figure = Figure(figsize=(11, 9.2), layout="constrained")
    (over, left), (below, profile) = figure.subplots(2, 2)
    image = picture.photograph.image
    draw_photograph(picture, centre, over)
    residual = np.where(picture.weights > 0, image - picture.fitted, np.nan)
    span = np.nanpercentile(np.abs(residual), 99)
    drawn = left.imshow(residual, cmap="RdBu_r", vmin=-span, vmax=span)
    left.set_title("photograph less model")
    figure.colorbar(drawn, ax=left, shrink=0.8, label="share of the brightest")
    data, model, order = draw_unwrapped(picture, centre, below)
    covered = np.isfinite(data).sum(axis=0) > 0.02 * len(data)
    mean = [np.nanmean(np.where(np.isfinite(data), table, np.nan)[:, covered], axis=0) for table in (data, model)]
    profile.plot(order[covered], mean[0], ".", ms=3, color="0.4", label="photograph")
    profile.plot(order[covered], mean[1], color="tab:red", lw=1, label="model")
    profile.set(xlabel=_PHASE, ylabel="mean over angle", title="profile")
    profile.legend(loc="upper right")
    figure.suptitle(title)
    return figure


def draw_unwrapped(
    picture: Picture | DrawnPicture, centre: tuple[float, float], axes
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Order across against angle down into matplotlib axes; photograph and model as they are drawn, and the orders."""
    data, model, order, angle = unwrap(picture, centre)
    stripes = np.where(np.arange(len(angle))[:, None] // max(1, len(angle) // 12) % 2, model, data)
    extent = (order[0], order[-1], np.degrees(angle[-1]), np.degrees(angle[0]))
    low, high = _black_and_white(picture)
    axes.imshow(stripes, cmap="gray", aspect="auto", extent=extent, vmin=low, vmax=high, interpolation="nearest")
    axes.set(xlabel=_PHASE, ylabel="angle [°]", title="unwrapped: bands of photograph and model in turn")
    return data, model, order


def of_trial(picture: Picture | DrawnPicture) -> Figure:
    """The photograph with the dark rings of a fit that gave no answer."""
    rows, columns = picture.photograph.image.shape
    figure = Figure(figsize=(8, 8 * rows / columns + 0.5), layout="constrained")
    draw_photograph(picture, None, figure.subplots())
    return figure


def draw_photograph(picture: Picture | DrawnPicture, centre: tuple[float, float] | None, axes) -> None:
    """The photograph and the fitted dark rings into matplotlib axes."""
    image = picture.photograph.image
    low, high = _black_and_white(picture)
    axes.imshow(image, cmap="gray", vmin=low, vmax=high)
    _draw_rings(axes, picture.phase, picture.weights)
    if centre is not None:
        axes.plot(*centre, "+", color="tab:red", markersize=12, clip_on=True)
    _limits(axes, image.shape)
    axes.set_title("photograph, fitted dark rings in red")


def _black_and_white(picture: Picture | DrawnPicture) -> tuple[float, float]:
    low, high = np.nanpercentile(np.where(picture.weights > 0, picture.photograph.image, np.nan), [1, 99])
    return float(low), float(high)


def unwrap(
    picture: Picture | DrawnPicture, centre: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Photograph and model on a grid of angle (down) and order (across), NaN where masked; order [turns], angle [rad].

    The order is the fit's phase less that of the ring's centre, so that an ellipse or a distortion bends no line.
    """
    image, (x0, y0) = picture.photograph.image, centre
    rows, columns = np.nonzero(picture.weights > 0)
    dx, dy = columns - x0, rows - y0
    r2 = np.linspace(np.min(dx * dx + dy * dy), np.max(dx * dx + dy * dy), 900)
    # Counted from the lit field's side, so that arcs are not cut where the angle wraps.
    side = np.arctan2(dy.mean(), dx.mean())
    angles = np.angle(np.exp(1j * (np.arctan2(dy, dx) - side)))
    angle = np.linspace(angles.min(), angles.max(), 360) + side
    x, y = x0 + np.sqrt(r2) * np.cos(angle)[:, None], y0 + np.sqrt(r2) * np.sin(angle)[:, None]
    inside = (x >= 0) & (y >= 0) & (x <= image.shape[1] - 1) & (y <= image.shape[0] - 1)
    weight = ndimage.map_coordinates((picture.weights > 0).astype(float), [y, x], order=1, mode="constant")

    def sample(table):
        values = ndimage.map_coordinates(table, [y, x], order=1, mode="nearest")
        return np.where(inside & (weight > 0.99), values, np.nan)

    tables = [sample(table) for table in (image, picture.fitted, picture.phase)]
    return *_by_order(*tables), angle


def _by_order(data: np.ndarray, model: np.ndarray, phase: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows of photograph and model at even steps of the phase instead of even steps outwards; the phases."""
    order = np.linspace(np.nanmin(phase), np.nanmax(phase), phase.shape[1])
    step = order[1] - order[0]
    rows: list[list[np.ndarray]] = [[], []]
    for turns, *values in zip(phase, data, model, strict=True):
        shown = np.isfinite(turns)
        turns, shown = turns[shown], np.flatnonzero(shown)
        ranks = np.argsort(turns)
        for kept, value in zip(rows, values, strict=True):
            if len(turns) < 2:
                kept.append(np.full(len(order), np.nan))
                continue
            line = np.interp(order, turns[ranks], value[shown][ranks], left=np.nan, right=np.nan)
            # Where the field has a hole, nothing is drawn between its edges.
            near = np.abs(turns[ranks][np.clip(np.searchsorted(turns[ranks], order), 0, len(turns) - 1)] - order)
            kept.append(np.where(near < 6 * step, line, np.nan))
    return np.stack(rows[0]), np.stack(rows[1]), order


def _draw_rings(axes, phase: np.ndarray, weights: np.ndarray) -> None:
    """Contours of half-integer phase, where the fringes are darkest."""
    used = phase[weights > 0]
    # A pressed lens is dark all over its disc: no ring is drawn there.
    phase = np.where(np.abs(phase % 1.0 - 0.5) < 2e-3 * (np.abs(np.hypot(*np.gradient(phase))) < 1e-3), np.nan, phase)
    orders = np.arange(np.ceil(used.min() - 0.5), np.floor(used.max() - 0.5) + 1) + 0.5
    step = max(1, -(-len(orders) // _RINGS))
    if len(orders):
        axes.contour(phase, levels=orders[::step], colors="tab:red", linewidths=0.7, alpha=0.8)


def _limits(axes, shape: tuple[int, int]) -> None:
    axes.set_xlim(-0.5, shape[1] - 0.5)
    axes.set_ylim(shape[0] - 0.5, -0.5)
