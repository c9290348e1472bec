"""The lens of a camera: at which point of the screen a pixel looks, in each colour, and how much light it passes."""

from dataclasses import replace
from typing import Any

import equinox as eqx
import numpy as np
from jaxtyping import Float

from newtonjax.numerics import (
    Scalar,
    Vector2,
    as_scalar,
    as_vector,
    finite,
    namespace,
    positive,
    require,
    require_one,
    require_size,
)
from newtonjax.scene.limits import TILT
from newtonjax.scene.vectors import frame


def _vector(values) -> Any:
    return None if values is None else as_vector(values)


_SHARE = "0 to below 1, the share of the light that is lost there"


class CameraLens(eqx.Module):
    """What a lens makes of an even grid of pixels. The camera's `pixel_size` is that on its axis.

    A pixel at u from the axis looks at the point u (1 + κ |u|² / h² + κ₅ |u|⁴ / h⁴), as the distortion of a fit is
    counted (Brown 1966); h is half a diagonal of the image, from its middle to the centre of a pixel in its corner.

    - `distortion`, `fifth_order`: κ and κ₅, above 0 for a barrel, below 0 for a pincushion; None for none.
    - `axis_px`: where the lens's axis meets the image, (x, y) in pixels; None for its middle.
    - `tilt`: of the screen about the image's x and y, as the camera sees it [rad]; None for one that it looks straight
      at. It turns about the point on the axis.
    - `principal_distance_px`: of the lens from the image, in pixels: with a tilt, what is farther is smaller. None for
      a telecentric lens, which shows it as large.
    - `magnifications`: of the image in each channel over the mean one, lateral colour; None for one size.
    - `vignette`: share of the light that is lost half a diagonal from the axis, by the law cos⁴; None for none.

    Raises ValueError for numbers that no lens has.
    """

    distortion: Scalar | None = eqx.field(converter=as_scalar, default=None)
    fifth_order: Scalar | None = eqx.field(converter=as_scalar, default=None)
    axis_px: Vector2 | None = eqx.field(converter=_vector, default=None)
    tilt: Vector2 | None = eqx.field(converter=_vector, default=None)
    principal_distance_px: Scalar | None = eqx.field(converter=as_scalar, default=None)
    magnifications: Float[Any, " channels"] | None = eqx.field(converter=_vector, default=None)
    vignette: Scalar | None = eqx.field(converter=as_scalar, default=None)

    def __check_init__(self):
        for name, most in (("distortion", 0.3), ("fifth_order", 0.1)):
            if (value := getattr(self, name)) is not None:
                allowed = f"-{most} to {most} half a diagonal from the axis, or None"
                require_one(f"lens.{name}", value, allowed, lambda v, most=most: np.all(abs(v) <= most))
        for name in ("axis_px", "tilt"):
            if (value := getattr(self, name)) is not None:
                require(f"lens.{name}", value, "two finite numbers, or None", finite)
                require_size(f"lens.{name}", value, 2, "two numbers, along x and y, or None")
        if self.tilt is not None:
            require("lens.tilt", self.tilt, f"two angles {TILT.words}", TILT.holds)
        if self.principal_distance_px is not None:
            allowed = "a positive number of pixels, or None"
            require_one("lens.principal_distance_px", self.principal_distance_px, allowed, positive)
        if self.magnifications is not None:
            allowed = "a number from 0.9 to 1.1 for each channel, or None"
            require("lens.magnifications", self.magnifications, allowed, lambda v: (v >= 0.9) & (v <= 1.1))
            if np.ndim(self.magnifications) != 1:
                shape = np.shape(self.magnifications)
                raise ValueError(f"lens.magnifications has shape {shape}; allowed: (channels,)")
        if self.vignette is not None:
            require_one("lens.vignette", self.vignette, _SHARE, lambda v: np.all((v >= 0) & (v < 1)))


def seen_from(lens: CameraLens, half_diagonal: float, x: Any, y: Any) -> tuple[Any, Any]:
    """The points of the screen at which pixels look, in pixels; all coordinates from the lens's axis.

    Of several channels those of the mean size.
    """
    square = (x * x + y * y) * (1 / half_diagonal**2)
    sizes = lens.magnifications
    factor: Any = 1 / sizes[0] if sizes is not None and len(sizes) == 1 else 1.0
    warp: Any = 1.0
    if lens.distortion is not None:
        warp = warp + lens.distortion * square
    if lens.fifth_order is not None:
        warp = warp + lens.fifth_order * (square * square)
    x, y = x * (factor * warp), y * (factor * warp)
    if lens.tilt is None:
        return x, y
    across_x, across_y, normal = frame(lens.tilt)
    slope = (x * normal[0] + y * normal[1]) * (1 / normal[2])
    # The line of sight through (x, y) meets the plane through the axis's point at depth -slope / (1 + q slope).
    nearness = 0.0 if lens.principal_distance_px is None else 1 / lens.principal_distance_px
    scale = 1 / (1 + nearness * slope)
    x, y, depth = x * scale, y * scale, -slope * scale
    return tuple(x * axis[0] + y * axis[1] + depth * axis[2] for axis in (across_x, across_y))


def passed_by(lens: CameraLens, half_diagonal: float, x: Any, y: Any) -> Any:
    """The share of the light that a lens passes: cos⁴ of the angle whose tangent goes with the distance from the axis.

    `vignette` v is 1 - cos⁴ half a diagonal away, so that tan² = (1 - v)^(-1/2) - 1 there.
    """
    if lens.vignette is None:
        return 1.0
    square = (x * x + y * y) * (1 / half_diagonal**2)
    tangent = (1 - lens.vignette) ** -0.5 - 1
    return (1 + tangent * square) ** -2


def in_window(lens: CameraLens, shape: tuple[int, int], first_row: int, rows: int) -> CameraLens:
    """The lens of an image, for some rows of it by themselves: lengths count in half diagonals of these."""
    axis = np.array([(shape[1] - 1) / 2, (shape[0] - 1) / 2]) if lens.axis_px is None else lens.axis_px
    ratio = np.hypot(rows - 1, shape[1] - 1) / (np.hypot(shape[0] - 1, shape[1] - 1) or 1.0)
    square = None if lens.vignette is None else ratio**2 * ((1 - lens.vignette) ** -0.5 - 1)
    return replace(
        lens,
        axis_px=namespace(axis).stack([axis[0], axis[1] - first_row]),
        distortion=None if lens.distortion is None else lens.distortion * ratio**2,
        fifth_order=None if lens.fifth_order is None else lens.fifth_order * ratio**4,
        vignette=None if square is None else 1 - (1 + square) ** -2,
    )
