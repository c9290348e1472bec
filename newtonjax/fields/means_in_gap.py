"""What the area of a pixel and a blur leave of fringes of equal thickness: functions of the path difference alone.

Between spheres and planes the path difference bends alike everywhere and in all directions, so that the square of its
slope grows in proportion to it. Over a pixel it is φ + f u + κ u² / 2 [turns]; a Gaussian blur of standard deviation b
then leaves of e^{2πi φ} exactly

    z exp(-2π² b² f² z),    z = 1 / (1 - 2πi κ b²)

times e^{2πi φ}, and the fringes a frequency z f. The square of a pixel takes sin(π a f)/(π a f) along each axis, and a
bend to first order. Its direction counts little: it is taken at 22.5 degrees to the axes, where the terms in f⁴ and f⁶
have their mean over all directions.
"""

from typing import Any, NamedTuple

import numpy as np

from newtonjax.numerics import Scalar, namespace
from newtonjax.scene import Camera, Gap, Lines, gap_slopes

# Shares of the squared slope along the two axes.
_SHARES = (np.cos(np.pi / 8) ** 2, np.sin(np.pi / 8) ** 2)
# The series of sin(√x) / √x, the highest power first, and up to where it is taken: it errs by 1e-15 there.
_SERIES, _SMALL = np.array([-1 / 39916800, 1 / 362880, -1 / 5040, 1 / 120, -1 / 6, 1.0]), 0.1

# Of the path difference, for slopes of a fading [turns].
_STEP = 0.01


class GapMeans(NamedTuple):
    """The means of a camera's pixels in a gap.

    - `turns`, `square`: at one point the path difference [turns of the mean wavenumber], and the square of its slope
      [turns² per pixel²].
    - `bending`: its second derivative [turns per pixel²].
    - `blur`, `side`: squares of the standard deviation of the blur, and of the side of a pixel [pixels²]; or None.
    """

    turns: Scalar
    square: Scalar
    bending: Scalar
    blur: Scalar | None
    side: Scalar | None

    def of(self, ratios, turns, real, imaginary) -> tuple[Any, Any]:
        """The means of real and imaginary parts of waves, of these wavenumbers over the mean one."""
        xp = namespace(self, ratios, turns)
        along, aside, turned, total = 1.0, 0.0, 0.0, 1.0
        if self.blur is not None:
            size, angle, turned, total = self.blurred(ratios, turns)
            along, aside = size * xp.cos(angle), size * xp.sin(angle)
        if self.side is not None:
            square = ratios * ratios * self._square_at(turns) * total
            box, bent = _of_square(xp, self.side, square, ratios * self.bending, turned)
            along, aside = along * box - aside * bent, along * bent + aside * box
        return along * real - aside * imaginary, along * imaginary + aside * real

    def blurred(self, ratios, turns) -> tuple[Any, ...]:
        """Modulus and angle of what the blur leaves; 2π κ b², and the square of the modulus of z."""
        xp, blur = namespace(self, ratios, turns), 0.0 if self.blur is None else self.blur
        turned = 2 * np.pi * ratios * self.bending * blur
        total = 1 / (1 + turned * turned)
        loss = (2 * np.pi**2 * blur * ratios * ratios * total) * self._square_at(turns)
        return xp.sqrt(total) * xp.exp(-loss), xp.arctan(turned) - turned * loss, turned, total

    def loss_as_path(self, ratios, turns) -> Any:
        """By how much the mean falls with the wavenumber, as an imaginary path [turns], to leading order."""
        variance = 0.0 if self.blur is None else self.blur
        if self.side is not None:
            variance = variance + self.side / 12
        return 2 * np.pi * variance * ratios * self._square_at(turns)

    def _square_at(self, turns) -> Any:
        return self.square + 2 * self.bending * (turns - self.turns)


def faded(lines: Lines, means: GapMeans | None, turns, real, imaginary, scale=1.0) -> tuple[Any, Any]:
    """Real and imaginary parts of waves of lines [lines, ...], as their widths fade them, and means over pixels.

    Within a line the mean falls with the wavenumber: the fading is that at a path with an imaginary part, to first
    order in it.

    - `scale`: of path differences and wavenumbers, that of a harmonic at an angle in the gap.
    """
    path = scale * turns
    fading = lines.fading(path)
    if means is None:
        return fading * real, fading * imaginary
    ratios = scale * lines.ratios.reshape(-1, *[1] * np.ndim(turns))
    real, imaginary = means.of(ratios, turns, real, imaginary)
    if lines.are_sharp:
        return real, imaginary
    slope = (lines.fading(path + _STEP) - lines.fading(path - _STEP)) / (2 * _STEP)
    aside = scale * means.loss_as_path(ratios, turns) * slope
    return fading * real - aside * imaginary, fading * imaginary + aside * real


def gap_means(gap: Gap, camera: Camera, wavenumber: Scalar) -> GapMeans | None:
    """What a camera's pixels are means over, in a gap between spheres and planes; None where they are points."""
    if not camera.takes_means:
        return None
    x, y = (ends.mean() for ends in camera.ends())
    scale = 2 * gap.refractive_index * wavenumber * camera.pixel_size
    slope_x, slope_y = gap_slopes(gap, x, y)
    bending = scale * camera.pixel_size * (gap.above.curvature - gap.below.curvature)
    sizes = (camera.blur, camera.aperture)
    squares = (None if size is None else size * size for size in sizes)
    square = scale * scale * (slope_x * slope_x + slope_y * slope_y)
    return GapMeans(gap.opd(x, y) * wavenumber, square, bending, *squares)


def _of_square(xp, side, square, bending, turned):
    """Real and imaginary part of what a square pixel leaves; `turned`: of the squared frequency, half its angle."""
    places = [np.pi**2 * side * share * square for share in _SHARES]
    (x, dx, ddx), (y, dy, ddy) = (_box(xp, place) for place in places)
    first_x, first_y = places[0] * dx * y, places[1] * x * dy
    second_x = (dx + 2 * places[0] * ddx) * y
    second_y = x * (dy + 2 * places[1] * ddy)
    change = 2 * turned * (first_x + first_y)
    return x * y, change - np.pi / 2 * side * bending * (second_x + second_y)


def _box(xp, x):
    """Sin(√x) / √x, and its first and second derivative; of x below 0, beyond the point of no slope, too."""
    is_small = x < _SMALL
    safe = xp.where(is_small, 1.0, x)
    root = xp.sqrt(safe)
    value = xp.where(is_small, _horner(_SERIES, x), xp.sin(root) / root)
    slope = (xp.cos(root) - value) / (2 * safe)
    slope = xp.where(is_small, _horner(np.polyder(_SERIES), x), slope)
    bend = -(value / 2 + 3 * slope) / (2 * safe)
    return value, slope, xp.where(is_small, _horner(np.polyder(_SERIES, 2), x), bend)


def _horner(coefficients, x):
    value = 0.0 * x
    for coefficient in coefficients:
        value = value * x + coefficient
    return value
