"""The map from a photograph to the object: where pixels lie on it, from the rings' centre, as the parts have it."""

from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np

from fitting.model.parts import DISPLACING, RADIAL, REACHING, STRETCHES
from fitting.parameters import Numbers

# Small enough for derivatives by complex numbers to be exact to rounding.
_STEP = 1e-30


class Frame(NamedTuple):
    """Pixel positions of the nodes [px], and the unit in which a model counts positions [px].

    The image may be means over blocks of `block` pixels a side: `contrast` [nodes] is what these leave of the fringes'
    (`block_contrast`, None for all of it), and they add a phase of (block² - 1) / 24 times its second derivatives, for
    r² fringes k (block² - 1) / 6.
    """

    x: np.ndarray
    y: np.ndarray
    middle: tuple[float, float]
    unit: float
    block: float = 1.0
    contrast: np.ndarray | None = None


def on_object(frame: Frame, x, y, numbers: Numbers):
    """Where pixels [px] lie on the object, from the rings' centre [px]: (x, y), for JAX.

    An offset from the centre is exp([[a, b], [b, -a]] / 2) times as large as without stretches.
    """
    x0, y0 = numbers.centre_x, numbers.centre_y
    ux, uy = (x - frame.middle[0]) / frame.unit, (y - frame.middle[1]) / frame.unit
    at_x, at_y = _displaced(ux, uy, ux * ux + uy * uy, numbers)
    # The centre is a pixel too; beyond the frame nothing is known of the lens.
    from_x, from_y = _displaced(x0, y0, jnp.minimum(x0 * x0 + y0 * y0, 1.0), numbers)
    dx, dy = (at_x - from_x) * frame.unit, (at_y - from_y) * frame.unit
    a, b = _stretch(numbers)
    # cosh and sinh(m)/m of m² = (a² + b²) / 4, as series: they have no root at 0, and 1e-9 is left at m = 0.4.
    m2 = (a * a + b * b) / 4
    even, odd = 1 + m2 / 2 * (1 + m2 / 12 * (1 + m2 / 30)), (1 + m2 / 6 * (1 + m2 / 20 * (1 + m2 / 42))) / 2
    return even * dx + odd * (a * dx + b * dy), even * dy + odd * (b * dx - a * dy)


def _displaced(ux, uy, u2, numbers: Numbers) -> tuple[Any, Any]:
    """The object's point of a pixel, both from the middle in half diagonals, before stretches."""
    *lower, factor = (getattr(numbers, name) for name in RADIAL)
    for coefficient in reversed(lower):
        factor = coefficient + factor * u2
    factor = 1 + u2 * factor
    x, y = ux * factor, uy * factor
    for part in DISPLACING:
        for name, (along_x, along_y) in part.displacements(ux, uy, u2).items():
            x, y = x + getattr(numbers, name) * along_x, y + getattr(numbers, name) * along_y
    return x, y


def _stretch(numbers: Numbers) -> tuple[Any, Any]:
    return sum(getattr(numbers, a) for a, _ in STRETCHES), sum(getattr(numbers, b) for _, b in STRETCHES)


def reach(numbers: Numbers):
    """By how much r² on the object exceeds that of the stretched offset, for all parts."""
    factor = 1.0
    for part in REACHING:
        factor = factor * part.reach(numbers)
    return factor


class Distance:
    """Squared distance `r2` of pixels from the rings' centre on the object [px²], and its derivatives, by NumPy."""

    def __init__(self, frame: Frame, x, y, numbers: Numbers):
        unit, (middle_x, middle_y) = frame.unit, frame.middle
        x0, y0 = numbers.centre_x, numbers.centre_y
        ux, uy = (x - middle_x) / unit, (y - middle_y) / unit
        u2 = ux * ux + uy * uy
        # As in `on_object`.
        m2 = min(x0 * x0 + y0 * y0, 1.0)
        at_x, at_y = _displaced(ux, uy, u2, numbers)
        from_x, from_y = _displaced(x0, y0, m2, numbers)
        self.unit, self.numbers, self.pixel, self.centre = unit, numbers, (ux, uy, u2), (x0, y0, m2)
        dx, dy = (at_x - from_x) * unit, (at_y - from_y) * unit
        self.r2, *self.by_offset_and_stretch = _stretched(dx, dy, *_stretch(numbers))

    def slopes(self, along) -> dict[str, np.ndarray]:
        """Derivatives, by the numbers of this map, of what changes with r² by `along`."""
        by_dx, by_dy, by_a, by_b = (along * slope for slope in self.by_offset_and_stretch)
        (ux, uy, u2), (x0, y0, m2), unit = self.pixel, self.centre, self.unit
        inwards, radial = x0 * by_dx + y0 * by_dy, ux * by_dx + uy * by_dy
        changes, by_pixel, by_centre = {}, u2, m2
        for name in RADIAL:
            changes[name] = unit * (by_pixel * radial - by_centre * inwards)
            by_pixel, by_centre = by_pixel * u2, by_centre * m2
        for pair in STRETCHES:
            changes |= zip(pair, (by_a, by_b), strict=True)
        factor, growth = self._at_centre()
        changes["centre_x"] = -unit * (factor * by_dx + growth * x0 * inwards)
        changes["centre_y"] = -unit * (factor * by_dy + growth * y0 * inwards)
        for part in DISPLACING:
            pixel_ways, centre_ways = part.displacements(ux, uy, u2), part.displacements(x0, y0, m2)
            for name, (way_x, way_y) in pixel_ways.items():
                from_x, from_y = centre_ways[name]
                changes[name] = unit * ((way_x - from_x) * by_dx + (way_y - from_y) * by_dy)
                for centre, (slope_x, slope_y) in self._centre_ways(part, name).items():
                    changes[centre] = changes[centre] - unit * (slope_x * by_dx + slope_y * by_dy)
        return changes

    def _at_centre(self) -> tuple[float, float]:
        """The radial factor at the centre, and its growth with the centre's squared distance; none beyond the frame."""
        m2, factor, growth = self.centre[2], 0.0, 0.0
        coefficients = [getattr(self.numbers, name) for name in RADIAL]
        for power, coefficient in reversed(list(enumerate(coefficients, 1))):
            factor, growth = factor * m2 + coefficient, growth * m2 + power * coefficient
        return 1 + m2 * factor, 2 * growth if m2 < 1 else 0.0

    def _centre_ways(self, part, name: str) -> dict[str, tuple[float, float]]:
        """How a part displaces the centre as the centre moves (complex step: Squire and Trapp 1998)."""
        x0, y0, m2 = self.centre
        value, ways = getattr(self.numbers, name), {}
        for centre, (x, y) in {"centre_x": (complex(x0, _STEP), y0), "centre_y": (x0, complex(y0, _STEP))}.items():
            way_x, way_y = part.displacements(x, y, x * x + y * y if m2 < 1 else m2)[name]
            ways[centre] = value * complex(way_x).imag / _STEP, value * complex(way_y).imag / _STEP
        return ways


def _stretched(dx, dy, a, b):
    """Squared distance on the object of an offset (dx, dy), dᵀ exp([[a, b], [b, -a]]) d, and its derivatives."""
    m2 = a * a + b * b
    # cosh m, sinh(m)/m and (cosh m - sinh(m)/m)/m² as series in m²: no root at 0, 1e-12 left at m = 0.8.
    even = 1 + m2 / 2 * (1 + m2 / 12 * (1 + m2 / 30 * (1 + m2 / 56 * (1 + m2 / 90))))
    odd = 1 + m2 / 6 * (1 + m2 / 20 * (1 + m2 / 42 * (1 + m2 / 72 * (1 + m2 / 110))))
    bend = (1 + m2 / 10 * (1 + m2 / 28 * (1 + m2 / 54 * (1 + m2 / 88)))) / 3
    square, along, across = dx * dx + dy * dy, dx * dx - dy * dy, 2 * dx * dy
    lean = a * along + b * across
    r2 = even * square + odd * lean
    by_dx, by_dy = 2 * (even * dx + odd * (a * dx + b * dy)), 2 * (even * dy + odd * (b * dx - a * dy))
    turn = odd * square + bend * lean
    return r2, by_dx, by_dy, a * turn + odd * along, b * turn + odd * across
