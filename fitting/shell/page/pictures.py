"""Pictures that the page shows of a photograph and of its fit, as JPEG."""

import io
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

import fitting

# No wider than this [px]; a screen shows no more, and the fit itself takes the photograph as it is.
_WIDEST = 1024
# Share of a colour that is laid over what the fit leaves out.
_TINT = 0.45
_QUALITY = 88


# Shapes by their numbers [px], each with "leaves_out" where it is left out: a circle has "radius", a rectangle "to_x".
Region = tuple[Mapping[str, float], ...]


def region_mask(region: Region, shape: tuple[int, int]) -> np.ndarray:
    """True in one of the circles (x, y, radius) or rectangles (x, y, to_x, to_y) [px], and in none that is left out.

    Without a shape that is to be used, it is all the picture. Raises ValueError for a region without pixels.
    """
    y, x = np.ogrid[: shape[0], : shape[1]]
    used, left_out = np.zeros(shape, bool), np.zeros(shape, bool)
    for one in region:
        target = left_out if one.get("leaves_out") else used
        target |= _inside(one, x, y)
    if all(one.get("leaves_out") for one in region):
        used[:] = True
    used &= ~left_out
    if not used.any():
        raise ValueError("the region holds no pixel of the photograph; draw it again")
    return used


def _inside(one: Mapping[str, float], x: np.ndarray, y: np.ndarray) -> np.ndarray:
    if "radius" in one:
        return (x - one["x"]) ** 2 + (y - one["y"]) ** 2 <= one["radius"] ** 2
    (low_x, high_x), (low_y, high_y) = (sorted((one[name], one[f"to_{name}"])) for name in ("x", "y"))
    return (x >= low_x) & (x <= high_x) & (y >= low_y) & (y <= high_y)


def preview(image: np.ndarray, mask: np.ndarray | None = None) -> bytes:
    """An image of linear light for the screen; what the mask leaves out in red."""
    step = -(-max(image.shape) // _WIDEST)
    values = image[::step, ::step]
    low, high = np.nanpercentile(values, [0.5, 99.5])
    share = np.clip((values - low) / max(high - low, 1e-12), 0, 1) ** (1 / 2.2)
    colours = np.repeat(np.nan_to_num(share)[:, :, None], 3, axis=2)
    if mask is not None:
        out = ~mask[::step, ::step]
        colours[out] = (1 - _TINT) * colours[out] + _TINT * np.array([1.0, 0.1, 0.1])
    return jpeg(colours)


def of_result(result: fitting.FitResult) -> Iterator[tuple[str, bytes]]:
    """Names and JPEG of the rings over the photograph, of what the model leaves, and of the unwrapped view of a fit.

    Of a fit that was refused, the rings that were tried.
    """
    residual = result.residual
    if residual is None:
        return
    if result.centre_px is None:
        tried = result.tried_figure()
        if tried is not None:
            yield "tried.jpg", figure_jpeg(tried)
        return
    span = float(np.nanpercentile(np.abs(residual), 99)) or 1.0
    yield "rings.jpg", _rings(result, residual.shape)
    yield "residual.jpg", preview(np.clip(residual, -span, span))
    yield "unwrapped.jpg", figure_jpeg(result.unwrapped_figure())


def jpeg(values: np.ndarray) -> bytes:
    """An image [rows, columns] or [rows, columns, 3] of 0 to 1 as JPEG."""
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray((255 * values).astype(np.uint8)).save(file, "JPEG", quality=_QUALITY)
    return file.getvalue()


def figure_jpeg(figure: Any) -> bytes:
    """A matplotlib figure as JPEG."""
    file = io.BytesIO()
    figure.savefig(file, format="jpeg", dpi=100, pil_kwargs={"quality": _QUALITY})
    return file.getvalue()


def _rings(result: fitting.FitResult, shape: tuple[int, ...]) -> bytes:
    """The picture of the result's own axes, without frame and title."""
    from matplotlib.figure import Figure

    rows, columns = shape
    scale = min(1.0, _WIDEST / max(rows, columns)) / 100
    figure = Figure(figsize=(columns * scale, rows * scale), dpi=100)
    axes = figure.add_axes((0, 0, 1, 1))
    result.figure(axes)
    axes.set_title("")
    axes.set_axis_off()
    return figure_jpeg(figure)
