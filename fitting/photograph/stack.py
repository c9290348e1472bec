"""A stack of frames of one view: the radius and the gap of each, from one frame to the next."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fitting.parameters import (
    EXPONENTS,
    Quantities,
    checked_fixed,
    checked_plate,
    checked_start,
    one_blas_thread,
    quantities,
)
from fitting.photo import frames_of
from fitting.photograph.frame_fit import FrameFit, FrameScale
from fitting.photograph.measure import fit
from fitting.photograph.meridians import View, checked_view
from fitting.photograph.priors import checked_axis, checked_priors
from fitting.photograph.task import checked_parts, priors_of_view
from fitting.photograph.tracking import LostError, Track, begin, follow
from fitting.reasons import Reason
from newtonjax.numerics import names_in, require_choice, x64


def fit_stack(
    frames: Any,
    *,
    wavelength: float | None = None,
    pixel_size: float | None = None,
    radius: float | None = None,
    gap_index: float | None = None,
    wavelength_sd: float | str | None = None,
    pixel_size_sd: float | str | None = None,
    radius_sd: float | str | None = None,
    gap_index_sd: float | str | None = None,
    plate_radius: float | None = None,
    plate_radius_sd: float | str | None = None,
    view: str | None = None,
    free: str | tuple[str, ...] | None = None,
    fixed: dict[str, float | tuple[float, float]] | None = None,
    start: dict[str, float | tuple[float, float]] | None = None,
    transfer: str | float | None = None,
    mask: str | Path | np.ndarray | None = None,
    parts: dict[str, bool] | None = None,
    priors: Mapping[str, tuple[float, float | str]] | None = None,
    axis_px: tuple[float, float] | None = None,
    axis_px_sd: float | None = None,
    view_angle: float | None = None,
    view_angle_sd: float | str | None = None,
) -> Iterator[FrameFit]:
    """A row for each frame of one view, whose radius, gap or centre changes slowly, in the frames' order.

    The first frame is measured by `fit`. Each other one starts from the last that was measured, with its channel, lit
    field, parts of the model and degrees of the illumination. A frame that is unreadable, of another shape, dark,
    saturated or without rings is a row that says so; rings that jumped are searched anew.

    The gap is followed from frame to frame: fringes that move by less than half a turn between two frames, a quarter of
    a wavelength in the gap, are told apart by their contrast. With more than a quarter turn, and noise or an
    illumination that changes, that is ambiguous; beyond half a turn it is not seen at all.

    Args:
      frames: an array [frames, rows, columns] or with channels; an iterable of arrays or paths; or the path of a TIFF
        with several pages, a GIF or a video (the extra `video`). Read one by one.
      wavelength, pixel_size, radius [m], gap_index: as in `fit`, and so are their deviations, plate_radius, view, free,
        fixed, start, transfer, mask and parts; there is no scene.
      priors, axis_px, axis_px_sd, view_angle, view_angle_sd: as in `fit`, and the same for all frames. With the view's
        angle a row's radius is that of the mean curvature, and its parameters have the two radii and their axis.

    A row is of the most probable set of parts of the frame that was searched, an answer of `fit` the mean over all
    sets. Where a part is doubtful they differ by 0.3 standard deviations, in no direction (docs/uncertainty.md).

    Raises ValueError and FileNotFoundError, at once, for arguments that cannot be used.

    """
    arguments = {name: value for name, value in locals().items() if name != "frames"}
    known_quantities, view_known = _checked(arguments), _checked_priors(arguments)
    return _rows(frames_of(frames), arguments, known_quantities, view_known)


def _checked_priors(arguments: dict) -> View | None:
    """What is known of the view. Raises ValueError for priors, an axis and a view that `fit` would not take."""
    wishes, view = checked_parts(arguments["parts"]), None
    priors = {} if arguments["priors"] is None else checked_priors(arguments["priors"], wishes)
    if arguments["view_angle"] is not None or arguments["view_angle_sd"] is not None:
        view = checked_view(arguments["view_angle"], arguments["view_angle_sd"])
        priors_of_view(view, priors, wishes, None)
    if arguments["axis_px"] is not None or arguments["axis_px_sd"] is not None:
        checked_axis(arguments["axis_px"], arguments["axis_px_sd"], priors)
    return view


def _checked(arguments: dict) -> Quantities:
    """What is given. Raises ValueError for what `fit` would not take."""
    if (view := arguments["view"]) is not None:
        require_choice("view", view, ("reflected", "transmitted"))
    checked_fixed(arguments["fixed"])
    checked_start(arguments["start"])
    checked_plate(arguments["plate_radius"], arguments["plate_radius_sd"])
    free = names_in("free", arguments["free"])
    values = {name: arguments[name] for name in EXPONENTS}
    if values["gap_index"] is None and "gap_index" not in free:
        values["gap_index"] = 1.0
    return quantities(values, {name: arguments[f"{name}_sd"] for name in EXPONENTS}, free)


def _rows(
    frames: Iterator, arguments: dict, known_quantities: Quantities, view_known: View | None
) -> Iterator[FrameFit]:
    track: Track | None = None
    half = 0.5 if (arguments["view"] or "reflected") == "reflected" else 0.0
    gap = (arguments["fixed"] or {}).get("gap")
    scale = FrameScale(known_quantities, half, arguments["plate_radius"], gap, view=view_known)
    for number, frame in enumerate(frames):
        if isinstance(frame, ValueError):
            yield FrameFit(number, "refused", Reason.FRAME_UNUSABLE(error=str(frame)))
            continue
        with x64(runs_programs=False), one_blas_thread():
            row, track, scale = _next(number, frame, track, scale, arguments)
        yield row


def _next(number: int, frame: np.ndarray, track: Track | None, scale: FrameScale, arguments: dict):
    """The row of a frame; the track with it, or as it was, and the scale."""
    reason = None
    if track is not None:
        try:
            track = follow(track, frame)
            return scale.row(number, track.fit), track, scale
        except np.linalg.LinAlgError as error:
            return FrameFit(number, "refused", Reason.UNDETERMINED(error=str(error))), track, scale
        except LostError as lost:
            if lost.hopeless:
                return FrameFit(number, "refused", lost.reason), track, scale
            reason = lost.reason
    try:
        result = fit(frame, **arguments)
    except ValueError as error:  # a frame that is no image, or of another shape than the mask
        return FrameFit(number, "refused", Reason.FRAME_UNUSABLE(error=str(error))), track, scale
    if result.evidence is None or result.picture is None:
        message = Reason.SEARCHED_IN_VAIN(reason=reason, message=result.message) if reason else result.message
        return FrameFit(number, result.status, message, searched=True), track, scale
    fitted = scale.counted(result.evidence.found, None if track is None else track.fit)
    scale = scale.calibrated(result, fitted)
    row = scale.row(number, fitted, searched=True)
    row = replace(row, message=Reason.SEARCHED_ANEW(reason=reason) if reason else row.message)
    return row, begin(result.picture.photograph, fitted), scale
