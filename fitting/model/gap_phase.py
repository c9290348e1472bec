"""The gap formula's phase and its derivatives in NumPy: what every step of a fit evaluates, without a compilation.

The formula is that of `model.GapModel`, which is its form for JAX; tests hold the two together.
"""

import numpy as np
from jaxtyping import Float

from fitting.model.parts import FLATTENING, REACHING
from fitting.model.phase import GapModel
from fitting.model.warp import Distance, reach
from fitting.parameters import Numbers

_FLOOR = 1e-6


def phase(model: GapModel, x, y, numbers: Float[np.ndarray, " free"]) -> np.ndarray:
    """Phase [turns] at pixel positions [px] that broadcast against each other."""
    by_name, unit2 = Numbers(*numbers), model.frame.unit**2
    r2, k = squared_distance(model, x, y, numbers), by_name.curvature / unit2
    spheres = _spheres(model, r2, k, reach(by_name))[0]
    return k * (r2 * spheres + flattened(r2, unit2, by_name)) + by_name.phase


def squared_distance(model: GapModel, x, y, numbers: Float[np.ndarray, " free"]) -> np.ndarray:
    """Squared distance of pixels from the rings' centre on the object [px²]."""
    return Distance(model.frame, x, y, Numbers(*numbers)).r2


def flattened(r2, unit2, numbers: Numbers):
    """What the parts add to r² where the gap is proportional to it [px²]."""
    share = r2
    for part in FLATTENING:
        if any(getattr(numbers, name) for name in part.parameters):
            share = part.flattening(share, unit2, numbers).value
    return share - r2


def phase_and_slopes(
    model: GapModel, x, y, numbers: Float[np.ndarray, " free"]
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Phase [turns] at pixel positions [px], and its derivatives by each of `parameters.NUMBERS`."""
    by_name, unit2 = Numbers(*numbers), model.frame.unit**2
    distance, k = Distance(model.frame, x, y, by_name), by_name.curvature / unit2
    r2 = distance.r2
    spheres, spheres_r2, spheres_k, by_reach = _spheres(model, r2, k, reach(by_name))
    share, share_r2, flat_slopes = r2, 1.0, {}
    for part in FLATTENING:
        change = part.flattening(share, unit2, by_name)
        flat_slopes = {name: slope * change.by_r2 for name, slope in flat_slopes.items()} | dict(change.by_number)
        share, share_r2 = change.value, share_r2 * change.by_r2
    height = r2 * spheres + share - r2
    slopes = {
        "curvature": (height + k * r2 * spheres_k) / unit2,
        "phase": np.ones_like(r2),
        **distance.slopes(k * (spheres + r2 * spheres_r2 + share_r2 - 1)),
        **{name: k * unit2 * slope for name, slope in flat_slopes.items()},
    }
    for part in REACHING:
        for name, slope in part.reach_slopes(by_name, k * r2 * by_reach).items():
            slopes[name] = slopes.get(name, 0.0) + slope
    return k * height + by_name.phase, slopes


def _spheres(model: GapModel, r2, k, longer):
    """2 / (1 + sqrt(1 - c² r² L)) of both faces, weighted by their curvatures, and its derivatives by r², k and L."""
    factor, power = (float(value) for value in model.sphere)
    plate = float(model.plate)
    if factor == 0 and plate == 0:
        return 1.0, 0.0, 0.0, 0.0
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
