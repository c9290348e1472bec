"""Where the dark rings of given numbers would be in a photograph: what a person compares with it before a fit."""

from collections.abc import Mapping

import numpy as np

from fitting.model import Frame, GapModel, gap_phase
from fitting.parameters import Numbers

# Points of the grid along the longer side, on which rings are looked for; rings that are finer are left out.
_POINTS = 300
# No more rings than this: beyond, they would hide the photograph.
_RINGS = 40
# A ring is to be at least so many points of the grid away from the next one.
_APART = 4.0


def expected_rings(
    shape: tuple[int, int],
    centre_px: tuple[float, float],
    fringe_scale_per_px2: float,
    *,
    gap_turns: float = 0.0,
    view: str = "reflected",
    numbers: Mapping[str, float] | None = None,
) -> list[np.ndarray]:
    """Lines (x, y) [px] of the dark rings of a sphere in a photograph of this shape [rows, columns].

    They are contours of the gap formula's phase (`GapModel`), without what a microscope adds. `gap_turns`: 2 n gap / λ;
    `numbers`: of parts of the model, by the names that a fit's vector has. Rings that lie closer than four
    points of a grid of 300 to a side are left out, and so are all but the first forty.
    """
    from skimage.measure import find_contours

    rows, columns = shape
    middle = (columns - 1) / 2, (rows - 1) / 2
    unit = float(np.hypot(*middle))
    nothing = np.zeros(0)
    frame = Frame(nothing, nothing, middle, unit)
    centre = ((at - half) / unit for at, half in zip(centre_px, middle, strict=True))
    turns = gap_turns + (0.5 if view == "reflected" else 0.0)
    vector = Numbers(fringe_scale_per_px2 * unit**2, *centre, turns, **(numbers or {}))
    step = max(1.0, max(shape) / _POINTS)
    x, y = np.arange(0, columns, step), np.arange(0, rows, step)
    phase = gap_phase.phase(GapModel(frame, (0.0, 1.0)), x[None, :], y[:, None], np.array(vector))
    slope = np.hypot(*np.gradient(phase))
    phase = np.where(slope * _APART < 1, phase, np.nan)
    if np.isnan(phase).all():
        return []
    first, last = np.ceil(np.nanmin(phase) - 0.5), np.floor(np.nanmax(phase) - 0.5)
    levels = np.arange(first, min(last, first + _RINGS - 1) + 1) + 0.5
    # The exact order of a dark centre is no contour.
    lines = [line for level in levels for line in find_contours(phase, level + 1e-9)]
    return [step * line[:, ::-1] for line in lines if len(line) > 2]
