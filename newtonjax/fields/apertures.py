"""What the area of a pixel and a blur of the picture leave of the fringes: a factor on their envelopes.

Over a pixel a phase is φ + f u + u H u / 2 [turns], u in pixels. The mean of e^{2πi phase} with a weight k(u) is
e^{2πi φ} (S(f) - i/4π Σ H_ij ∂²S/∂f_i ∂f_j), S the Fourier transform of k, to first order in H: `bending_error` bounds
what is left out, by the second.
"""

from itertools import product
from typing import Any

import numpy as np
from jaxtyping import Complex, Float
from numpy.polynomial.chebyshev import chebder, chebvander

from newtonjax.fields.means_in_gap import GapMeans
from newtonjax.numerics import as_complex, chebyshev, module_of, namespace
from newtonjax.scene import Camera

# Below it the series of sin z / z and of its derivatives are used: they err by z⁶/5040 and less.
_SMALL = 0.05
# Nodes to a side of a quadrature over the square of a pixel.
_SQUARE = 5
# Path differences that spread by less [turns] have one slope.
_LEVEL = 1e-6


def pixel_factors(
    turns: Float[Any, "pairs n"], camera: Camera, ratios: Float[Any, " waves"]
) -> Complex[Any, "waves pairs n"]:
    """Of path differences [turns] at a square grid of nodes, row by row: the factors on waves of these wavenumbers.

    - `ratios`: wavenumbers over that of the turns.
    """
    numbers = _slopes_and_bends(turns, camera)
    return _factor(camera, *(ratios[:, None, None] * number for number in numbers))


def means_along(turns: Float[np.ndarray, " n"], camera: Camera) -> GapMeans:
    """The nearest `GapMeans` to what pixels leave of path differences [turns] at a square grid of nodes, row by row.

    By least squares of the squared slope over the path difference.
    """
    f_x, f_y, h_xx, h_yy, _ = _slopes_and_bends(turns, camera)
    square, offset = f_x * f_x + f_y * f_y, turns - turns.mean()
    bending = (h_xx + h_yy).mean() / 2
    if np.ptp(turns) > _LEVEL:
        bending = offset @ square / (2 * offset @ offset)
    sizes = (camera.blur, camera.aperture)
    squares = (None if size is None else float(size) ** 2 for size in sizes)
    return GapMeans(turns.mean(), square.mean(), bending, *squares)


def _slopes_and_bends(turns: Float[Any, "*pairs n"], camera: Camera) -> tuple[Any, ...]:
    """First derivatives along x and y [per pixel], and second ones along x, along y and mixed."""
    count, xp = round(turns.shape[-1] ** 0.5), module_of(turns)
    grid = turns.reshape(-1, count, count)
    derivative = xp.asarray(_derivative(count))
    step_y, step_x = (2 / max(pixels - 1, 1) for pixels in camera.shape)

    def along_x(values):
        return values @ derivative.T * step_x

    def along_y(values):
        return derivative @ values * step_y

    f_x, f_y = along_x(grid), along_y(grid)
    numbers = (f_x, f_y, along_x(f_x), along_y(f_y), along_x(f_y))
    return tuple(number.reshape(turns.shape) for number in numbers)


def bent_factors(
    turns: Float[np.ndarray, "pairs n"], camera: Camera, ratios: Float[np.ndarray, " waves"]
) -> Complex[np.ndarray, "waves pairs n"]:
    """As `pixel_factors`, for a bend of any size: means of e^{2πi (f u + u H u / 2)}.

    Over the blur, of variance b², it is exp(-2π² b² f M⁻¹ f) / √det M, M = 1 - 2πi b² H (a Gaussian integral); over the
    square of a pixel f changes by H u, and the mean is taken by a quadrature.
    """
    numbers = _slopes_and_bends(turns, camera)
    f_x, f_y, h_xx, h_yy, h_xy = (ratios[:, None, None] * number for number in numbers)
    variance = float(camera.blur or 0.0) ** 2
    m_xx, m_yy, m_xy = (unit - 2j * np.pi * variance * h for unit, h in ((1, h_xx), (1, h_yy), (0, h_xy)))
    determinant = m_xx * m_yy - m_xy * m_xy
    at, weights = np.polynomial.legendre.leggauss(_SQUARE if camera.aperture else 1)
    places = at * float(camera.aperture or 0.0) / 2
    total = np.zeros(f_x.shape, complex)
    for (x, of_x), (y, of_y) in product(zip(places, weights, strict=True), repeat=2):
        g_x, g_y = f_x + h_xx * x + h_xy * y, f_y + h_xy * x + h_yy * y
        loss = (m_yy * g_x * g_x - 2 * m_xy * g_x * g_y + m_xx * g_y * g_y) / determinant
        phase = (f_x + g_x) * x / 2 + (f_y + g_y) * y / 2
        total += of_x * of_y / 4 * np.exp(2j * np.pi * phase - 2 * np.pi**2 * variance * loss)
    return total / np.sqrt(determinant)


def bending_error(turns: Float[np.ndarray, "pairs count count"], camera: Camera) -> float:
    """Of the factors, from Chebyshev coefficients of path differences: (2π H s²)² / 2, s² the variance of k."""
    return (2 * np.pi * _largest_derivative(turns, camera, 2) * _variance(camera)) ** 2 / 2


def twisting_error(turns: Float[np.ndarray, "pairs count count"], camera: Camera) -> float:
    """Of `bent_factors`: the third derivative T adds at most 2π T (|u| + |v|)³ / 6 to a phase; 13 s³ in the mean."""
    return 2 * np.pi * _largest_derivative(turns, camera, 3) * 13 * _variance(camera) ** 1.5 / 6


def _largest_derivative(turns: Float[np.ndarray, "pairs count count"], camera: Camera, order: int) -> float:
    """Along x or y, per pixel."""
    ends = [2 / max(pixels - 1, 1) for pixels in camera.shape]
    return max(
        float(abs(chebder(turns, order, axis=axis)).sum(axis=(-2, -1)).max() * step**order)
        for axis, step in zip((-2, -1), ends, strict=True)
    )


def _variance(camera: Camera) -> float:
    return float(camera.blur or 0.0) ** 2 + float(camera.aperture or 0.0) ** 2 / 12


def _factor(camera: Camera, f_x, f_y, h_xx, h_yy, h_xy):
    (s_x, d_x, dd_x), (s_y, d_y, dd_y) = _transform(camera, f_x), _transform(camera, f_y)
    bent = h_xx * dd_x * s_y + h_yy * s_x * dd_y + 2 * h_xy * d_x * d_y
    return as_complex(s_x * s_y) - 1j * as_complex(bent / (4 * np.pi))


def _transform(camera: Camera, f):
    """Of the weights along one axis at a frequency [per pixel], with its first and second derivative."""
    side = 0.0 if camera.aperture is None else camera.aperture
    blur = 0.0 if camera.blur is None else camera.blur
    xp = namespace(f, side, blur)
    box, box_slope, box_bend = _sinc(xp, np.pi * side * f)
    steepness = (2 * np.pi * blur) ** 2
    bell = xp.exp(-steepness * f * f / 2)
    bell_slope, bell_bend = -steepness * f * bell, steepness * (steepness * f * f - 1) * bell
    scale = np.pi * side
    return (
        box * bell,
        scale * box_slope * bell + box * bell_slope,
        scale * scale * box_bend * bell + 2 * scale * box_slope * bell_slope + box * bell_bend,
    )


def _sinc(xp, z):
    """Sin z / z, and its first and second derivative."""
    is_small = abs(z) < _SMALL
    safe, square = xp.where(is_small, 1.0, z), z * z
    value = xp.where(is_small, 1 - square / 6 + square * square / 120, xp.sin(safe) / safe)
    slope = xp.where(is_small, z * (-1 / 3 + square / 30), (xp.cos(safe) - xp.sin(safe) / safe) / safe)
    bend = xp.where(is_small, -1 / 3 + square / 10, -value - 2 * slope / safe)
    return value, slope, bend


def _derivative(count: int) -> np.ndarray:
    """From values at nodes in [-1, 1] to those of the derivative there."""
    degrees = chebvander(chebyshev.nodes(count), max(count - 2, 0))
    return degrees @ chebder(np.eye(count)) @ chebyshev.analysis(count)
