"""The verb `wedge_photo`: the angle of an air wedge from a photograph of its straight fringes; or a refusal."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fitting.irregularity.disc import Pupil, disc_of
from fitting.irregularity.pupil import pupil_of, usable_pixels
from fitting.irregularity.straight import StraightFit, straight_fit
from fitting.irregularity.wedge_answer import Request, answer_of
from fitting.irregularity.wedge_model import Wedge, wedge_of
from fitting.irregularity.wedge_photo_result import WedgePhoto
from fitting.parameters import (
    absolute_sd,
    camera_scale,
    check_quantity,
    number,
    one_blas_thread,
    says_its_origin,
)
from fitting.photo import Photograph, read
from fitting.reasons import Reason
from fitting.sheet_reasons import SheetReason
from newtonjax.numerics import Statement

# A camera's distortion at the corners unless a scale says it: that of an eyepiece.
_DISTORTION_SD = 0.1
# Fewer fringes leave the spacing to the illumination; curved by more, they are those of no wedge: photographs of
# wedges had 0.12 and less, parts of circles and spirals 0.39 and more.
_FEWEST, _MOST_CHANGE = 4.0, 0.3
# Of a picture's variance straight fringes must explain so much where the residual is no white noise: photographs of
# wedges had 0.68 and more, two crossing waves 0.5, lines of text 0.47.
_LEAST_EXPLAINED, _STRUCTURE = 0.55, 3.0
_LEAST_PIXELS, _LEAST_RADIUS = 1500, 24.0


@says_its_origin
def wedge_photo(
    image: str | Path | np.ndarray,
    *,
    wavelength: float | None = None,
    wavelength_sd: float | str | None = None,
    pixel_size: float | None = None,
    pixel_size_sd: float | str | None = None,
    scale: Any = None,
    length: float | None = None,
    length_sd: float | str | None = None,
    gap_index: float = 1.0,
    gap_index_sd: float | str | None = None,
    transfer: str | float | None = None,
    mask: str | Path | np.ndarray | None = None,
    page: int | None = None,
) -> WedgePhoto:
    """The angle of a wedge, tan α = λ / (2 n s), from a photograph of its fringes of spacing s, seen along the normal.

    The picture is B + M cos 2πφ with smooth B and M, as for `fitting.form`; φ is straight fringes behind a radial
    distortion, and a quadratic beside them that a bent plate or a view at a slant makes. The thickness at the end,
    such as that of a hair between two plates, is L tan α (Born and Wolf, Principles of Optics, section 7.5.3).

    Args:
      image: a file, or an array as in `fitting.fit`.
      wavelength, wavelength_sd: in vacuum, or in air with air as the index 1 [m]; without it there is no angle.
      pixel_size, pixel_size_sd: on the wedge [m]; without it the spacing in pixels is the answer.
      scale: in place of the pixel size a result of `fitting.scale`, or the path of its JSON.
      length, length_sd: from the line of contact to where the thickness is wanted [m].
      gap_index, gap_index_sd: of what fills the wedge.
      transfer, mask, page: as in `fitting.fit`.

    Standard deviations in the same units or as "0.1%". What is no picture of straight fringes comes back refused.
    Raises ValueError and FileNotFoundError for input that is none.

    """
    saved_scale = None if scale is None else camera_scale(scale)
    if saved_scale is not None:
        if pixel_size is not None or pixel_size_sd is not None:
            raise ValueError("scale and pixel_size both give the pixel size; leave one out")
        pixel_size, pixel_size_sd = saved_scale.pixel_size, saved_scale.pixel_size_sd
    values = {"wavelength": wavelength, "pixel_size": pixel_size, "gap_index": gap_index}
    for name, value in values.items():
        check_quantity(name, value)
    if length is not None and not 1e-6 < number("length", length) < 100:
        raise ValueError(f"length is {length}; allowed: 1e-6 to 100 m")
    values |= {"length": length}
    sds = {"wavelength": wavelength_sd, "pixel_size": pixel_size_sd, "gap_index": gap_index_sd, "length": length_sd}
    relative = {name: (absolute_sd(name, sds[name], value) or 0.0) / (value or 1.0) for name, value in values.items()}
    photograph = read(image, transfer, mask, page)
    with one_blas_thread():
        return _measured(
            photograph, usable_pixels(photograph, mask is not None), Request(values, relative, saved_scale)
        )


def _measured(photograph: Photograph, usable: np.ndarray, request: Request) -> WedgePhoto:
    refused = WedgePhoto("refused", warnings=list(photograph.warnings), photograph=photograph)
    if photograph.is_uniform:
        return replace(refused, message=Reason.UNIFORM())
    pupil = _pupil(photograph)
    pixels = int(disc_of(photograph.image, usable, pupil).pixels)
    if pixels < _LEAST_PIXELS:
        return replace(refused, message=Reason.TOO_FEW_PIXELS(usable=pixels, total=usable.size))
    straight = straight_fit(photograph.image, usable, pupil)
    if straight is None:
        return replace(refused, message=SheetReason.NO_STRAIGHT_FRINGES())
    shape, scale = photograph.image.shape, request.scale
    distortion = None if scale is None else scale.prior_distortion(shape)
    wedge = wedge_of(straight.fit, straight.inflation, pupil, shape, distortion or (0.0, _DISTORTION_SD))
    refusal = _refusal(wedge, straight, pupil)
    if refusal is not None:
        status = "not-converged" if refusal.code == SheetReason.WEDGE_NOT_CONVERGED.name else "refused"
        return replace(refused, status=status, message=refusal)
    return answer_of(replace(refused, pupil=pupil), straight, wedge, request)


def _pupil(photograph: Photograph) -> Pupil:
    """The circle in which fringes are measured: that of the light, or the largest in the frame."""
    pupil, _ = pupil_of(photograph)
    if pupil.radius >= _LEAST_RADIUS:
        return pupil
    rows, columns = photograph.image.shape
    return Pupil((columns - 1) / 2, (rows - 1) / 2, (min(rows, columns) - 1) / 2)


def _refusal(wedge: Wedge, straight: StraightFit, pupil: Pupil) -> Statement | None:
    """Why these are no fringes of a wedge; None where they are."""
    explained = straight.fit.explained
    # Of other structure, such as a ruled grid, it need not converge.
    if explained < _LEAST_EXPLAINED and straight.inflation > _STRUCTURE:
        return SheetReason.OTHER_STRUCTURE(explained=explained, least=_LEAST_EXPLAINED)
    if not straight.fit.converged:
        return SheetReason.WEDGE_NOT_CONVERGED()
    if wedge.relative_change > _MOST_CHANGE:
        return SheetReason.FRINGES_CURVED(change=wedge.relative_change, most=_MOST_CHANGE)
    fringes = 2 * pupil.radius * wedge.frequency
    if fringes < _FEWEST:
        return SheetReason.FEW_STRAIGHT_FRINGES(fringes=fringes, least=_FEWEST)
    return None
