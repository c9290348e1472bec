"""Sources of an angular size: discs, squares and maps, and the directions over which light is summed."""

from typing import Any, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Float

from newtonjax.numerics import (
    Scalar,
    as_scalar,
    is_concrete,
    module_of,
    namespace,
    require,
    require_choice,
    require_number,
    shown,
)

_SHAPES = ("disc", "square")
_BELOW_ONE = "0 to below 1, the sine of an angle"
_RADIANCES = "a table of radiances of 0 or more, not all of them 0, or None"
# The largest order of a quadrature; that of traced numbers, which holds 1e-6 while phases differ by up to 8 radians.
_MOST, TRACED = 64, 8


def _table(values) -> Any:
    if not isinstance(values, list | tuple):
        return values
    try:
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"radiances is {shown(values)}; allowed: {_RADIANCES}") from None


class Extent(eqx.Module):
    """How large a source is, as seen from the gap: incoherent points about the light's direction.

    Radiance counts by the projected solid angle, as the pupil of a lens that keeps the sine condition fills (Born and
    Wolf, Principles of Optics, section 10.6.1): a disc is uniform in the square of the sine.

    - `sine`: of the angular radius of a disc, or of half the side of a square, in the first medium. A microscope that
      lights and sees through one objective has its numerical aperture over the refractive index there.
    - `shape`: "disc" or "square". Static.
    - `radiances`: of the cells of a map over the square, [rows, columns], rows along y; None for an even source.

    Raises ValueError for sizes, shapes and maps that no source has.
    """

    sine: Scalar = eqx.field(converter=as_scalar)
    shape: str = eqx.field(static=True, default="disc")
    radiances: Float[Any, "rows columns"] | None = eqx.field(converter=_table, default=None)

    def __check_init__(self):
        require_choice("shape", self.shape, _SHAPES)
        require_number("sine", self.sine, _BELOW_ONE, lambda v: (v >= 0) & (v < 1))
        if self.radiances is None:
            return
        if np.ndim(self.radiances) != 2 or self.shape != "square":
            raise ValueError(f"radiances of a {self.shape}; allowed: {_RADIANCES}, with shape='square'")
        require("radiances", self.radiances, _RADIANCES, lambda v: np.isfinite(v).all() and (v >= 0).all() and v.any())


class Directions(NamedTuple):
    """Directions of light: sines along x and y about its mean direction in the first medium, and weights of sum 1."""

    x: Float[Any, " directions"]
    y: Float[Any, " directions"]
    weights: Float[Any, " directions"]

    def squares(self) -> Float[Any, " directions"]:
        """Of the sines of the angles."""
        return self.x * self.x + self.y * self.y


def directions_of(extent: Extent | None, order: int, azimuths: int = 1) -> Directions:
    """Directions over which an image is summed: of an even source those of a Gaussian quadrature.

    - `order`: of the quadrature, along the squared radius of a disc, or along each half side of a square.
    - `azimuths`: of a disc; 1 where its path depends on the squared sine alone, as in a gap.
    """
    if extent is None:
        return Directions(np.zeros(1), np.zeros(1), np.ones(1))
    if extent.radiances is not None:
        return _of_map(extent)
    nodes, weights = np.polynomial.legendre.leggauss(order)
    nodes, weights = (1 + nodes) / 2, weights / 2
    if extent.shape == "disc":
        angles = 2 * np.pi * (np.arange(azimuths) + 0.5) / azimuths
        radii, along = np.sqrt(nodes)[:, None], np.stack([np.cos(angles), np.sin(angles)])
        x, y = ((radii * part).ravel() * extent.sine for part in along)
        return Directions(x, y, np.repeat(weights / azimuths, azimuths))
    if azimuths > 1:  # all four quarters
        nodes, weights = np.concatenate([-nodes[::-1], nodes]), np.concatenate([weights[::-1], weights]) / 2
    y, x = (part.ravel() * extent.sine for part in np.meshgrid(nodes, nodes, indexing="ij"))
    return Directions(x, y, np.outer(weights, weights).ravel())


def _of_map(extent: Extent) -> Directions:
    table: Any = extent.radiances
    rows, columns = table.shape
    y, x = np.meshgrid(_cells(rows), _cells(columns), indexing="ij")
    weights = namespace(table).asarray(table).ravel()
    return Directions(x.ravel() * extent.sine, y.ravel() * extent.sine, weights / weights.sum())


def _cells(count: int) -> np.ndarray:
    return (2 * np.arange(count) + 1 - count) / count


def order_for(extent: Extent | None, radians: float, tolerance: float) -> int:
    """The order of a quadrature of e^{iφu} over u from 0 to 1, φ in radians, that errs by less than a tolerance.

    Gauss and Legendre's rule of n nodes errs by at most φ^(2n) (n!)⁴ / ((2n+1) (2n)!³) (Abramowitz and Stegun 25.4.30).
    Raises ValueError where it takes too many.
    """
    if extent is None or not is_concrete(extent, radians):
        return TRACED
    error, count = abs(radians) ** 2 / 24, 1
    while error > tolerance:
        count += 1
        if count > _MOST:
            raise ValueError(
                f"light over the source differs by {radians:.3g} rad of phase; allowed: a source over which "
                f"{_MOST} directions are enough: a smaller one, or a thinner gap"
            )
        ratio = count**4 / ((2 * count) * (2 * count - 1)) ** 3
        error *= radians**2 * ratio * (2 * count - 1) / (2 * count + 1)
    return count


def tilt_towards(frame, x: Float[Any, ""], y: Float[Any, ""]) -> Any:
    """The tilt of light [rad] that comes from a direction of these sines; `frame` as of `launch_frame`."""
    across_x, across_y, direction = frame
    xp = module_of(direction)
    up = across_x * x + across_y * y - direction * xp.sqrt(1 - x * x - y * y)
    return xp.stack([-xp.arcsin(up[1]), xp.arctan2(up[0], up[2])])
