"""Whether a fit of the gap formula found rings of which a radius can be had, and why not."""

import numpy as np

from fitting.estimate import FEW, Fitted, correlation
from fitting.finding import Rings, plane_wave, view_of
from fitting.parameters import Numbers, Quantities, lensless
from fitting.photo import Photograph, noise_variance, pixels_of

# Fringes that explain less than this are looked at twice; less than that are none.
_POOR, _NONE = 0.3, 0.12
# Structure that makes up more than 45 % of the variance, and errs together in blocks [px] by more than blurred noise
# does, is fringes of another kind (equidistant circles, spirals, ellipses that were not found).
_DOUBTFUL, _TOGETHER, _BLOCKS = 0.55, 3.5, (8, 16)
# Straight fringes behind a camera's distortion of a few percent bend by so many turns, and so many more a fringe.
_BEND, _WARPED = 0.15, 0.03
# So few of them are judged by whether their curvature is determined.
_FEW_STRAIGHT = 3.6
# Share of the variance that a few fringes may leave over as structure, and how much less than two may err together.
_STRUCTURE, _ALIKE = 0.02, 3.0


def why_refused(found: Fitted, photograph: Photograph, rings: Rings) -> str:
    """Why no radius can be had from a fit of the gap formula; empty where one can."""
    frame = found.model.frame
    numbers = Numbers(*found.numbers)
    scale, offsets = float(numbers.curvature) / frame.unit**2, (float(numbers.centre_x), float(numbers.centre_y))
    x, y = (middle + at * frame.unit for middle, at in zip(frame.middle, offsets, strict=True))
    orders, explained = found.orders, found.explained
    if not (np.isfinite(explained) and np.isfinite(scale)):
        return "the fit has no finite optimum: no rings were recognized"
    straight = plane_wave(view_of(photograph)) if explained < _POOR else 0.0
    if straight > 0.3:
        return f"the fringes are straight (they explain {straight:.0%} of the power); a radius needs rings or arcs"
    if explained < _NONE:
        return f"no rings: fringes of any radius and centre explain {max(explained, 0):.1%} of the variance at best"
    for k, c in ((rings.scale, rings.centre), (scale, (x, y))):
        if bend := _straight(photograph.mask, k, c):
            return bend
    if orders < 1:
        return f"the image holds {orders:.2g} of a fringe; a radius needs at least one"
    if scale <= 0:
        return "the rings' curvature is not determined"
    return _locked_badly(found, explained, orders)


def _locked_badly(found: Fitted, explained: float, orders: float) -> str:
    """That what the fringes leave over has structure which no radius explains; empty where it is as it should be."""
    if explained >= _DOUBTFUL and orders >= FEW:
        return ""
    left = found.left
    inflation = correlation(found.reduced.grid, left.value, left.weights, _BLOCKS)
    structure = found.chi2 / found.weight - noise_variance(left.value, left.weights > 0)
    share = structure * found.weight / found.variance
    if inflation > _TOGETHER and (share > 1 - _DOUBTFUL or (explained < _POOR and inflation > 3 * _TOGETHER)):
        return (
            f"the fringes of a sphere explain {explained:.0%} of the variance and what is left has structure: "
            "these are not the rings of one sphere"
        )
    if orders >= FEW:
        return ""
    if share < _STRUCTURE and (orders >= 2 or inflation < _ALIKE):
        return ""
    return (
        f"{orders:.1f} fringes leave {max(share, 0):.1%} of the variance over as structure: with so few of them that "
        "may be curvature, or no rings at all; take more rings into the picture"
    )


def _squared_distance(mask: np.ndarray, centre: tuple[float, float]) -> np.ndarray:
    x, y = pixels_of(mask)
    return (x - centre[0]) ** 2 + (y - centre[1]) ** 2


def _straight(mask: np.ndarray, scale: float, centre: tuple[float, float]) -> str:
    """That many fringes cross the field without bending as rings do: then their curvature may be none. Else empty."""
    x, y = pixels_of(mask)
    orders = abs(scale) * float(np.ptp(_squared_distance(mask, centre)))
    bend = abs(scale) * float(_squared_distance(mask, (float(x.mean()), float(y.mean()))).max())
    if bend >= min(1.0, _BEND + _WARPED * orders) or orders <= _FEW_STRAIGHT:
        return ""
    return (
        f"the fringes are straight: over {orders:.0f} of them the curvature bends one by {bend:.2g} of their distance; "
        "a radius needs rings or arcs"
    )


def too_steep(photograph: Photograph, rings: Rings, known: Quantities) -> str:
    """That the given quantities make the lens smaller than the field it fills; empty where they do not."""
    if known.unknown is None or rings.match < 0.05:
        return ""
    values = known.values(rings.scale)
    x, y = pixels_of(photograph.mask)
    reach = values["pixel_size"] * float(np.hypot(x - rings.centre[0], y - rings.centre[1]).max())
    if reach < values["radius"]:
        return lensless(known.plate[0], values["radius"], reach) if known.plate else ""
    return (
        f"with these quantities the rings' lens has a radius of {values['radius']:.3g} m, but the rings reach out to "
        f"{reach:.3g} m; check the units of what was given"
    )
