"""Pictures that the page shows of a photograph and of its fit, as JPEG."""

import io
from collections.abc import Mapping

import numpy as np

import fitting

# No wider than this [px]; a screen shows no more, and the fit itself takes the photograph as it is.
_WIDEST = 1024
# Share of a colour that is laid over what the fit leaves out.
_TINT = 0.45
_QUALITY = 88


def region_mask(region: Mapping[str, float] | None, shape: tuple[int, int]) -> np.ndarray:
    """True within a circle (x, y, radius) or a rectangle (x, y, to_x, to_y) [px]; everywhere without a region.

    Raises ValueError for a region without pixels.
    """
    if region is None:
        return np.ones(shape, bool)
    y, x = np.ogrid[: shape[0], : shape[1]]
    if "radius" in region:
        inside = (x - region["x"]) ** 2 + (y - region["y"]) ** 2 <= region["radius"] ** 2
    else:
        (low_x, high_x), (low_y, high_y) = (sorted((region[name], region[f"to_{name}"])) for name in ("x", "y"))
        inside = (x >= low_x) & (x <= high_x) & (y >= low_y) & (y <= high_y)
    if not inside.any():
        raise ValueError("the region holds no pixel of the photograph; draw it again")
    return inside


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


def of_result(result: fitting.FitResult) -> dict[str, bytes]:
    """The fitted rings over the photograph, and what the model leaves, where there is a fit."""
    if result.residual is None or result.centre_px is None:
        return {}
    residual = result.residual
    span = float(np.nanpercentile(np.abs(residual), 99)) or 1.0
    return {"rings.jpg": _rings(result), "residual.jpg": preview(np.clip(residual, -span, span))}


def jpeg(values: np.ndarray) -> bytes:
    """An image [rows, columns] or [rows, columns, 3] of 0 to 1 as JPEG."""
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray((255 * values).astype(np.uint8)).save(file, "JPEG", quality=_QUALITY)
    return file.getvalue()


def _rings(result: fitting.FitResult) -> bytes:
    """The picture of the result's own axes, without frame and title."""
    from matplotlib.figure import Figure

    rows, columns = result.residual.shape if result.residual is not None else (1, 1)
    scale = min(1.0, _WIDEST / max(rows, columns)) / 100
    figure = Figure(figsize=(columns * scale, rows * scale), dpi=100)
    axes = figure.add_axes((0, 0, 1, 1))
    result.figure(axes)
    axes.set_title("")
    axes.set_axis_off()
    file = io.BytesIO()
    figure.savefig(file, format="jpeg", pil_kwargs={"quality": _QUALITY})
    return file.getvalue()
