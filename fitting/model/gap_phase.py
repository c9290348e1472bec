"""The gap formula's phase and its derivatives in NumPy: what every step of a fit evaluates, without a compilation.

The formula is that of `model.GapModel`, which is its form for JAX; tests hold the two together.
"""

import numpy as np
from jaxtyping import Float

from fitting.model.phase import GapModel
from fitting.parameters import Numbers

_FLOOR = 1e-6


class _Offset:
    """Offset from the rings' centre on the object [px], and its derivatives; `phase.on_object` without view."""

    def __init__(self, model: GapModel, x, y, numbers: Numbers):
        x0, y0, kappa, fifth = numbers.centre_x, numbers.centre_y, numbers.distortion, numbers.distortion_fifth_order
        unit, (middle_x, middle_y) = model.frame.unit, model.frame.middle
        ux, uy = (x - middle_x) / unit, (y - middle_y) / unit
        u2 = ux * ux + uy * uy
        m2 = min(x0 * x0 + y0 * y0, 1.0)
        by_pixel, by_centre = 1 + u2 * (kappa + fifth * u2), 1 + m2 * (kappa + fifth * m2)
        self.unit, self.centre, self.u2, self.m2, self.ux, self.uy = unit, (x0, y0), u2, m2, ux, uy
        self.by_centre = by_centre
        # How the centre's own factor grows with its squared distance; beyond the frame it does not.
        self.growth = 2 * (kappa + 2 * fifth * m2) if m2 < 1 else 0.0
        self.dx, self.dy = (ux * by_pixel - x0 * by_centre) * unit, (uy * by_pixel - y0 * by_centre) * unit

    def slopes(self, along_x, along_y):
        """Derivatives of a function of the offset by centre x, centre y, distortion and fifth order."""
        x0, y0 = self.centre
        inwards = x0 * along_x + y0 * along_y
        by_x0 = -self.unit * (self.by_centre * along_x + self.growth * x0 * inwards)
        by_y0 = -self.unit * (self.by_centre * along_y + self.growth * y0 * inwards)
        radial = self.ux * along_x + self.uy * along_y
        by_kappa = self.unit * (self.u2 * radial - self.m2 * inwards)
        by_fifth = self.unit * (self.u2 * self.u2 * radial - self.m2 * self.m2 * inwards)
        return by_x0, by_y0, by_kappa, by_fifth


def phase(model: GapModel, x, y, numbers: Float[np.ndarray, " free"]) -> np.ndarray:
    """Phase [turns] at pixel positions [px] that broadcast against each other."""
    by_name = Numbers(*numbers)
    stretch, shear, contact = by_name.stretch, by_name.shear, by_name.contact
    offset, unit2 = _Offset(model, x, y, by_name), model.frame.unit**2
    r2, k = _stretched(offset.dx, offset.dy, stretch, shear)[0], by_name.curvature / unit2
    spheres = _spheres(model, r2, k, stretch, shear)[0]
    flat = 0.0 if contact == 0 else flattened(r2, contact * unit2)
    return k * (r2 * spheres + flat) + by_name.phase


def flattened(r2, a2: float) -> np.ndarray:
    """By how much a contact of squared radius a2 lowers the gap of touching spheres, over half their curvature."""
    return _hertz(r2, a2)[0] - r2


def squared_distance(model: GapModel, x, y, numbers: Float[np.ndarray, " free"]) -> np.ndarray:
    """Squared distance of pixels from the rings' centre on the object [px²]."""
    by_name = Numbers(*numbers)
    offset = _Offset(model, x, y, by_name)
    return _stretched(offset.dx, offset.dy, by_name.stretch, by_name.shear)[0]


def phase_and_slopes(
    model: GapModel, x, y, numbers: Float[np.ndarray, " free"]
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Phase [turns] at pixel positions [px], and its derivatives by each of `parameters.NUMBERS`."""
    by_name = Numbers(*numbers)
    stretch, shear = by_name.stretch, by_name.shear
    offset, unit2 = _Offset(model, x, y, by_name), model.frame.unit**2
    r2, r2_dx, r2_dy, r2_a, r2_b = _stretched(offset.dx, offset.dy, stretch, shear)
    k = by_name.curvature / unit2
    spheres, spheres_r2, spheres_k, spheres_l = _spheres(model, r2, k, stretch, shear)
    hertz, outwards, pressing = _hertz(r2, by_name.contact * unit2)
    reach = r2 * spheres + hertz - r2
    along = k * (spheres + r2 * spheres_r2 + outwards - 1)
    # The view's own factor L = exp(sqrt(a² + b² + 1e-12) - 1e-6): dL = L (a da + b db) / sqrt(a² + b² + 1e-12).
    tilt = np.sqrt(stretch**2 + shear**2 + 1e-12)
    longer = k * r2 * spheres_l * np.exp(tilt - 1e-6) / tilt
    by_x0, by_y0, by_kappa, by_fifth = offset.slopes(along * r2_dx, along * r2_dy)
    return k * reach + by_name.phase, {
        "curvature": (reach + k * r2 * spheres_k) / unit2,
        "centre_x": by_x0,
        "centre_y": by_y0,
        "phase": np.ones_like(r2),
        "stretch": along * r2_a + longer * stretch,
        "shear": along * r2_b + longer * shear,
        "distortion": by_kappa,
        "contact": k * unit2 * pressing,
        "distortion_fifth_order": by_fifth,
    }


def _stretched(dx, dy, a, b):
    """Squared distance on the object of an offset (dx, dy), dᵀ exp([[a, b], [b, -a]]) d, and its derivatives."""
    m2 = a * a + b * b
    # cosh m, sinh(m)/m and (cosh m - sinh(m)/m)/m² as series in m²: no root at 0, 1e-12 left at m = 0.8.
    even = 1 + m2 / 2 * (1 + m2 / 12 * (1 + m2 / 30 * (1 + m2 / 56 * (1 + m2 / 90))))
    odd = 1 + m2 / 6 * (1 + m2 / 20 * (1 + m2 / 42 * (1 + m2 / 72 * (1 + m2 / 110))))
    bend = (1 + m2 / 10 * (1 + m2 / 28 * (1 + m2 / 54 * (1 + m2 / 88)))) / 3
    whole, along, across = dx * dx + dy * dy, dx * dx - dy * dy, 2 * dx * dy
    lean = a * along + b * across
    r2 = even * whole + odd * lean
    by_dx, by_dy = 2 * (even * dx + odd * (a * dx + b * dy)), 2 * (even * dy + odd * (b * dx - a * dy))
    turn = odd * whole + bend * lean
    return r2, by_dx, by_dy, a * turn + odd * along, b * turn + odd * across


def _spheres(model: GapModel, r2, k, a, b):
    """2 / (1 + sqrt(1 - c² r² L)) of both faces, weighted by their curvatures, and its derivatives by r², k and L."""
    factor, power = (float(value) for value in model.sphere)
    plate = float(model.plate)
    if factor == 0 and plate == 0:
        return 1.0, 0.0, 0.0, 0.0
    longer = np.exp(np.sqrt(a * a + b * b + 1e-12) - 1e-6)
    both = factor * abs(k) ** power
    share = plate / both if both else 0.0
    by_both = power * both / k if k else 0.0
    lens, lens_c2 = _steepened((both - plate) ** 2 * longer, r2)
    if plate == 0:
        c2 = both * both
        return lens, lens_c2 * c2 * longer / _safe(r2), lens_c2 * 2 * both * longer * by_both, lens_c2 * c2
    other, other_c2 = _steepened(plate**2 * longer, r2)
    first, second = (1 - share) * lens_c2 * (both - plate) ** 2, share * other_c2 * plate**2
    by_k = (share / both * (lens - other) + (1 - share) * lens_c2 * 2 * (both - plate) * longer) * by_both
    return (1 - share) * lens + share * other, (first + second) * longer / _safe(r2), by_k, first + second


def _safe(r2):
    # The derivative by c² L carries one r² more than that by r²; both vanish at the centre.
    return np.maximum(r2, 1e-300)


def _steepened(square, r2):
    """2 / (1 + w), w = sqrt(1 - square r²), and its derivative by `square`: r² / (w (1 + w)²); held where w² < 1e-6."""
    inside = 1 - square * r2
    w = np.sqrt(np.maximum(inside, _FLOOR))
    value = 2 / (1 + w)
    return value, np.where(inside > _FLOOR, r2 * value * value / (4 * w), 0.0)


def _hertz(r2, a2):
    """`newtonjax.scene.hertz_gap` and its derivatives by r² and a².

    With t = sqrt(r²/a² - 1), and 0 inside the disc, arcsin(a/r) is π/2 - arctan t: Johnson's (1985) eq. 3.42a becomes
    a² (2/π) (t + (t² - 1) arctan t), a third of the work.
    """
    if a2 <= 0:
        return r2 - 2 * a2, np.ones_like(r2), np.full_like(r2, -2.0)
    t2 = np.maximum(r2 / a2 - 1, 0)
    t = np.sqrt(t2)
    angle = np.arctan(t)
    gap = (2 / np.pi) * a2 * (t + (t2 - 1) * angle)
    return gap, (2 / np.pi) * (angle + t / (1 + t2)), (-4 / np.pi) * angle
