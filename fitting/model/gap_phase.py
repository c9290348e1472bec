"""The gap formula's phase and its derivatives in NumPy: what every step of a fit evaluates, without a compilation.

The formula is that of `model.GapModel`, which is its form for JAX; tests hold the two together.
"""

import numpy as np
from jaxtyping import Float

from fitting.model.forming import form_slopes
from fitting.model.parts import FLATTENING, REACHING
from fitting.model.phase import GapModel, SceneModel
from fitting.model.warp import Distance, reach
from fitting.parameters import Numbers

_FLOOR = 1e-6


def phase(model: GapModel, x, y, numbers: Float[np.ndarray, " free"]) -> np.ndarray:
    """Phase [turns] at pixel positions [px] that broadcast against each other."""
    by_name, unit2 = Numbers(*numbers), model.frame.unit**2
    r2, k = squared_distance(model, x, y, numbers), by_name.curvature / unit2
    longer = reach(by_name)
    w, spheres = _steepness(model, k)[0] * r2 * longer, _spheres(model, r2, k, longer)[0]
    per_order, per_turn = (w * _polynomial(table, w) for table in _tables(model, k))
    smooth = k * r2 * (spheres + per_order) + by_name.phase + _apex(model, by_name.phase) * per_turn
    return smooth + flattened(model, r2, by_name) + form_slopes(model.frame, x, y, by_name)[0]


def squared_distance(model: GapModel | SceneModel, x, y, numbers: Float[np.ndarray, " free"]) -> np.ndarray:
    """Squared distance of pixels from the rings' centre on the object [px²]."""
    return Distance(model.frame, x, y, Numbers(*numbers)).r2


def flattened(model: GapModel, r2, numbers: Numbers):
    """Turns that the parts add where the gap is proportional to r² [px²], as they are seen."""
    parts = [part for part in FLATTENING if any(getattr(numbers, name) for name in part.parameters)]
    if not parts:
        return 0.0
    share, unit2 = r2, model.frame.unit**2
    for part in parts:
        share = part.flattening(share, unit2, numbers).value
    k = numbers.curvature / unit2
    w = _steepness(model, k)[0] * r2 * reach(numbers)
    return k * (share - r2) * (1 + w * _polynomial(model.microscope.gap, w))


def phase_and_slopes(
    model: GapModel, x, y, numbers: Float[np.ndarray, " free"]
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Phase [turns] at pixel positions [px], and its derivatives by each of `parameters.NUMBERS`."""
    by_name, unit2 = Numbers(*numbers), model.frame.unit**2
    distance, k = Distance(model.frame, x, y, by_name), by_name.curvature / unit2
    r2, longer = distance.r2, reach(by_name)
    spheres, spheres_r2, spheres_k, by_reach = _spheres(model, r2, k, longer)
    (c2, c2_k), apex, tables = _steepness(model, k), _apex(model, by_name.phase), _tables(model, k)
    k_r2, w = k * r2, c2 * longer * r2
    (per_order, order_w), (per_turn, turn_w) = (_rising(table, w) for table in tables)
    seen_k = k_r2 / model.microscope.scale * w * _polynomial(model.microscope.change, w)
    share, share_r2, flat_slopes = r2, 1.0, {}
    for part in FLATTENING:
        change = part.flattening(share, unit2, by_name)
        flat_slopes = {name: slope * change.by_r2 for name, slope in flat_slopes.items()} | dict(change.by_number)
        share, share_r2 = change.value, share_r2 * change.by_r2
    flat = share - r2
    height = k * flat + apex
    seen_w = k_r2 * order_w + height * turn_w
    by_r2_k = spheres + k * spheres_k + per_order + longer * c2_k * seen_w
    slopes = {
        "curvature": (r2 * by_r2_k + flat * (1 + per_turn) + seen_k) / unit2,
        "phase": 1 + per_turn,
        **distance.slopes(
            k * (spheres + r2 * spheres_r2 + per_order + (share_r2 - 1) * (1 + per_turn)) + c2 * longer * seen_w
        ),
        **{name: k * unit2 * slope * (1 + per_turn) for name, slope in flat_slopes.items()},
    }
    for part in REACHING:
        for name, slope in part.reach_slopes(by_name, r2 * (k * by_reach + c2 * seen_w)).items():
            slopes[name] = slopes.get(name, 0.0) + slope
    turns, forming = form_slopes(model.frame, x, y, by_name)
    for name, slope in forming.items():
        slopes[name] = slopes.get(name, 0.0) + slope
    return k_r2 * (spheres + per_order) + k * flat + by_name.phase + height * per_turn + turns, slopes


def _steepness(model: GapModel, k: float) -> tuple[float, float]:
    """C² of both faces together [1/px²], and its derivative by k."""
    factor, power = (float(value) for value in model.sphere)
    c2 = (factor * abs(k) ** power) ** 2
    return c2, 2 * power * c2 / k if k else 0.0


def _apex(model: GapModel, phase: float) -> float:
    """What a phase [turns] says of the gap at the apex: where whole turns are not counted, -1/4 to 3/4 of one.

    Faces stop each other; and a half turn, as of the wrong view, is not at the edge.
    """
    turns = phase - float(model.microscope.touching)
    return turns - float(model.microscope.modulo) * np.floor(turns + 0.25)


def _tables(model: GapModel, k: float) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients of what a microscope adds, over w: per order of a touching sphere, and per turn of the gap."""
    table = model.microscope
    return np.asarray(table.sphere + (k / table.scale - 1) * table.change), np.asarray(table.gap)


def _polynomial(table, w):
    value = np.full_like(w, table[-1], dtype=float)
    for coefficient in table[-2::-1]:
        value *= w
        value += coefficient
    return value


def _rising(table: np.ndarray, w) -> tuple[np.ndarray, np.ndarray]:
    """W times a polynomial in w, and its derivative."""
    return w * _polynomial(table, w), _polynomial(table * np.arange(1, len(table) + 1), w)


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
