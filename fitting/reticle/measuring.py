"""The verb `scale`: the pixel size from one thing of known size: a grid, a ruler, a disc, or two points."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from fitting.parameters import Progress, absolute_sd, number, progress_of, says_its_origin
from fitting.photo import checked_mask, read
from fitting.reasons import Reason
from fitting.reticle.disc import of_disc
from fitting.reticle.lattice import of_grid
from fitting.reticle.result import Scale
from fitting.reticle.ruler import of_ruler
from fitting.sheet_reasons import SheetReason
from newtonjax.numerics import shown

# Curves of cameras, of exponents from 1.8 to 2.6, differ from sRGB by a quarter of what sRGB differs from linear light;
# the edge of a disc is where the blurred light is half, and moves with the curve.
_CURVE, _SPOKEN_OF = 0.25, 1e-3


@says_its_origin
def scale(
    image: str | Path | np.ndarray | None = None,
    *,
    division: float | None = None,
    division_sd: float | str | None = None,
    ruler: float | None = None,
    ruler_sd: float | str | None = None,
    disc_diameter: float | None = None,
    disc_diameter_sd: float | str | None = None,
    points: Sequence[Sequence[float]] | None = None,
    distance: float | None = None,
    distance_sd: float | str | None = None,
    pointing_sd: float = 0.5,
    transfer: str | float | None = None,
    mask: str | Path | np.ndarray | None = None,
    page: int | None = None,
    progress: Progress = None,
) -> Scale:
    """The pixel size on the object, with its standard deviation, from one thing of known size.

    Args:
      image: a photograph of it at any angle: a file, or an array as in `fitting.fit`; two points need none.
      division, division_sd: of a square grid the distance of two lines, and its standard deviation [m], or "0.1%".
      ruler, ruler_sd: of a ruler or a stage micrometer the distance of neighbouring lines. The scale is that along it,
        with pixels taken for square.
      disc_diameter, disc_diameter_sd: of a dark or bright disc, or the outer one of a ring; its edge is
        fitted with its blur and clipping.
      points, distance, distance_sd: two places (x, y) in pixels, as of two lines of a ruler, and their distance on the
        object [m]. Pixels are then taken for square.
      pointing_sd: of each place, along the line between them [px].
      transfer, mask, page: as in `fitting.fit`.
      progress: True for a bar on the terminal, or a function of (fits of the grid made, their number).

    A photograph without such a thing comes back refused. Raises ValueError and FileNotFoundError for wrong input.

    """
    sizes = {"division": division, "ruler": ruler, "disc_diameter": disc_diameter, "distance": distance}
    sds = {
        "division": division_sd,
        "ruler": ruler_sd,
        "disc_diameter": disc_diameter_sd,
        "distance": distance_sd,
    }
    stated = [name for name, value in sizes.items() if value is not None]
    if len(stated) != 1 or (points is None) != (distance is None):
        raise ValueError("give one of division, ruler and disc_diameter, of a photograph, or points with distance")
    (name,) = stated
    idle = [f"{key}_sd" for key, sd in sds.items() if sd is not None and key != name]
    if idle:
        raise ValueError(f"{', '.join(idle)} does not belong to {name}; leave it out, or give {name}_sd")
    size = _length(name, sizes[name])
    sd = absolute_sd(name, sds[name], size) or 0.0
    if points is not None:
        return of_points(points, size, sd, number("pointing_sd", pointing_sd))
    if image is None:
        raise ValueError("no photograph is given; two points and their distance alone need none")
    photograph = read(image, transfer, mask, page)
    if name == "disc_diameter":
        allowed = None if mask is None else checked_mask(mask, photograph.lit.shape)
        measured = of_disc(photograph, size, sd, allowed)
        if transfer is not None or photograph.transfer != "srgb":
            return measured
        return _with_curve(measured, of_disc(read(image, "linear", mask, page), size, sd, allowed))
    if name == "ruler":
        return of_ruler(photograph, size, sd)
    with progress_of(progress, "measuring the grid") as done:
        return of_grid(photograph, size, sd, done)


def _with_curve(measured: Scale, linear: Scale) -> Scale:
    """The scale with what a camera's curve, of which sRGB is a guess, does to it; `linear`: by codes that are light."""
    if measured.pixel_size is None or linear.pixel_size is None:
        return measured
    change = linear.pixel_size / measured.pixel_size - 1
    added = _CURVE * abs(change) * measured.pixel_size
    names = ("pixel_size_sd", "pixel_size_x_sd", "pixel_size_y_sd")
    sds = {name: float(np.hypot(getattr(measured, name), added)) for name in names}
    warnings = list(measured.warnings)
    if abs(change) > _SPOKEN_OF:
        size = "larger" if change > 0 else "smaller"
        warnings.append(SheetReason.DISC_CURVE(change=abs(change), size=size))
    return replace(measured, warnings=warnings, **sds)


def _length(name: str, value: float | None) -> float:
    if not 1e-9 < number(name, value) < 1.0:
        raise ValueError(f"{name} is {value}; allowed: 1e-9 to 1 m")
    return float(value or 0.0)


def of_points(points: Sequence[Sequence[float]], distance: float, distance_sd: float, pointing_sd: float) -> Scale:
    """The scale of two places in a picture. Raises ValueError for places that are none."""
    try:
        places = np.asarray(points, dtype=float)
    except (TypeError, ValueError, OverflowError):
        places = np.empty(0)
    if places.shape != (2, 2) or not np.all(np.isfinite(places)):
        raise ValueError(f"points is {shown(points)}; give two places (x, y) in pixels")
    if not 0 < pointing_sd < 1e6:
        raise ValueError(f"pointing_sd is {pointing_sd}; allowed: above zero, in pixels")
    length = float(np.hypot(*(places[1] - places[0])))
    relative = float(np.hypot(np.sqrt(2) * pointing_sd / length if length else np.inf, distance_sd / distance))
    if not relative < 0.25:
        return Scale("refused", Reason.POINTS_TOO_NEAR(length=length), marks=places[None])
    warnings: list[str] = [Reason.PIXELS_TAKEN_AS_SQUARE()]
    if not distance_sd:
        warnings.append(Reason.DISTANCE_TREATED_AS_EXACT())
    size = distance / length
    return Scale("ok", pixel_size=size, pixel_size_sd=size * relative, pixel_size_x=size, pixel_size_y=size,
                 stretch=0.0, shear=0.0, stretch_sd=1.0, shear_sd=1.0, warnings=warnings,
                 marks=places[None])  # fmt: skip
