"""The map from a photograph to the object: where pixels lie on it, from the rings' centre, as the parts have it."""

from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np

from fitting.model.parts import AXIS, DISPLACING, RADIAL, REACHING, STRETCHES
from fitting.parameters import Numbers

# Small enough for derivatives by complex numbers to be exact to rounding.
_STEP = 1e-30


class Frame(NamedTuple):
    """Pixel positions of the nodes [px], and the unit in which a model counts positions [px].

    The image may be means over blocks of `block` pixels a side: `contrast` [nodes] is what these leave of the fringes'
    (`block_contrast`, None for all of it), and they add a phase of (block² - 1) / 24 times its second derivatives, for
    r² fringes k (block² - 1) / 6. `reach`: of the field from the rings' centre [units].
    """

    x: np.ndarray
    y: np.ndarray
    middle: tuple[float, float]
    unit: float
    block: float = 1.0
    contrast: np.ndarray | None = None
    reach: float = 1.0


def on_object(frame: Frame, x, y, numbers: Numbers):
    """Where pixels [px] lie on the object, from the rings' centre [px]: (x, y), for JAX.

    An offset from the centre is exp([[a, b], [b, -a]] / 2) times as large as without stretches.
    """
    x0, y0 = numbers.centre_x, numbers.centre_y
    axis_x, axis_y = (getattr(numbers, name) for name in AXIS)
    x0, y0 = x0 - axis_x, y0 - axis_y
    ux = (x - frame.middle[0]) / frame.unit - axis_x
    uy = (y - frame.middle[1]) / frame.unit - axis_y
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
    """The object's point of a pixel, both from the axis in half diagonals, before stretches."""
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
        axis_x, axis_y = (getattr(numbers, name) for name in AXIS)
        x0, y0 = numbers.centre_x - axis_x, numbers.centre_y - axis_y
        ux, uy = (x - middle_x) / unit - axis_x, (y - middle_y) / unit - axis_y
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
        factor, growth = self._radial(m2)
        growth = growth if m2 < 1 else 0.0
        changes["centre_x"] = -unit * (factor * by_dx + growth * x0 * inwards)
        changes["centre_y"] = -unit * (factor * by_dy + growth * y0 * inwards)
        # The axis moves pixel and centre alike.
        factor, growth = self._radial(u2)
        changes[AXIS[0]] = -unit * (factor * by_dx + growth * ux * radial) - changes["centre_x"]
        changes[AXIS[1]] = -unit * (factor * by_dy + growth * uy * radial) - changes["centre_y"]
        for part in DISPLACING:
            pixel_ways, centre_ways = part.displacements(ux, uy, u2), part.displacements(x0, y0, m2)
            for name, (way_x, way_y) in pixel_ways.items():
                from_x, from_y = centre_ways[name]
                changes[name] = unit * ((way_x - from_x) * by_dx + (way_y - from_y) * by_dy)
                value = getattr(self.numbers, name)
                at_pixel, at_centre = _ways(part, name, ux, uy), _ways(part, name, x0, y0, m2 if m2 >= 1 else None)
                for axis in (0, 1):
                    pixel, centre = (
                        unit * value * (slope_x * by_dx + slope_y * by_dy)
                        for slope_x, slope_y in (at_pixel[axis], at_centre[axis])
                    )
                    changes[("centre_x", "centre_y")[axis]] -= centre
                    changes[AXIS[axis]] += centre - pixel
        return changes

    def _radial(self, square) -> tuple[Any, Any]:
        """The radial factor at a squared distance from the axis, and twice its growth with that."""
        factor, growth = 0.0, 0.0
        coefficients = [getattr(self.numbers, name) for name in RADIAL]
        for power, coefficient in reversed(list(enumerate(coefficients, 1))):
            factor, growth = factor * square + coefficient, growth * square + power * coefficient
        return 1 + square * factor, 2 * growth


def _ways(part, name: str, x, y, square=None) -> list[tuple[Any, Any]]:
    """How what a part displaces changes with x and with y (complex step: Squire and Trapp 1998).

    `square`: what stands for x² + y², and does not change, beyond the frame.
    """
    ways = []
    for at_x, at_y in ((x + 1j * _STEP, y + 0j), (x + 0j, y + 1j * _STEP)):
        way = part.displacements(at_x, at_y, at_x * at_x + at_y * at_y if square is None else square)[name]
        ways.append(tuple(np.imag(np.asarray(along, complex)) / _STEP for along in way))
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
