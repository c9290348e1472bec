"""Whether a fit of the gap formula found rings of which a radius can be had, and why not."""

import numpy as np

from fitting.estimate import FEW, SHAPES, Fitted, correlation
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
# The search's scale of so few of them says nothing about their bend; the fit's does.
_FEW_STRAIGHT = 3.6
# Fewer fringes than this do not determine their scale unless a person tells where they are: of made pictures
# (`experiments/truth/few_fringes.py`) with 1 to 1.5 some locked 16 to 30 % off behind uneven light, and left nothing
# over that shows it. A person who gives a start or holds a number needs one.
_FEWEST, _FEWEST_GUIDED = 1.5, 1.0
# Share of the variance that a few fringes may leave over as structure; it grows with their number by this power, up to
# that of many (of a photograph with 7 fringes 14 %, of ellipses with 5 to 6 up to 32 %). And how much less than two may
# err together.
_STRUCTURE, _GROWTH, _ALIKE = 0.02, 3.6, 3.0


class RefusedError(Exception):
    """A photograph of which no radius can be had: why, and the photograph as far as it was read."""

    def __init__(self, reason: str, photograph: Photograph):
        super().__init__(reason)
        self.reason, self.photograph = reason, photograph


def judge(fit: Fitted, photograph: Photograph, rings: Rings, guided: bool = False) -> None:
    """Raise RefusedError where `why_refused` has a reason."""
    if reason := why_refused(fit, photograph, rings, guided):
        raise RefusedError(reason, photograph)


def why_refused(found: Fitted, photograph: Photograph, rings: Rings, guided: bool = False) -> str:
    """Why no radius can be had from a fit of the gap formula; empty where one can.

    `guided`: a person gave a start or held values, and so has seen rings.
    """
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
        return (
            f"no rings found: the best ring pattern explains {max(explained, 0):.1%} of the image variance; "
            f"at least {_NONE:.0%} is required"
        )
    for k, c in ((rings.scale, rings.centre), (scale, (x, y))):
        if bend := _straight(photograph.mask, k, c, _FEW_STRAIGHT):
            return bend
    if orders < (least := _FEWEST_GUIDED if guided else _FEWEST):
        way_out = "" if guided else ", or give start or fixed values"
        return (
            f"the image shows {orders:.3g} fringes, which do not determine a scale; at least {least:g} are required: "
            f"include more rings, or a larger field{way_out}"
        )
    if scale <= 0:
        return "the rings' curvature is not determined"
    if not guided and (bend := _straight(photograph.mask, scale, (x, y), 0.0)):
        return bend
    return _locked_badly(found, explained, orders, guided)


def _most_structure(orders: float, guided: bool) -> float:
    """Share of the variance that so many fringes may leave over as structure."""
    growth = np.inf if guided and orders >= FEW else max(orders / FEW, 1.0) ** _GROWTH
    return min(_STRUCTURE * growth, 1 - _DOUBTFUL)


def _locked_badly(found: Fitted, explained: float, orders: float, guided: bool) -> str:
    """That what the fringes leave over has structure which no radius explains; empty where it is as it should be."""
    most = _most_structure(orders, guided)
    if explained >= 1 - most and orders >= FEW:
        return ""
    left = found.left
    inflation = correlation(found.reduced.grid, left.value, left.weights, _BLOCKS)
    structure = found.chi2 / found.weight - noise_variance(left.value, left.weights > 0)
    share = structure * found.weight / found.variance
    if inflation > _TOGETHER and (share > 1 - _DOUBTFUL or (explained < _POOR and inflation > 3 * _TOGETHER)):
        return (
            f"a ring pattern explains {explained:.0%} of the image variance, but the residual is not random: "
            "the fringes are not the rings of one sphere"
        )
    if orders >= FEW and (share < most or inflation <= _TOGETHER):
        return ""
    if not guided and orders < FEW and found.shape == SHAPES[-1]:
        return (
            f"{orders:.1f} fringes lie in light so uneven that it may pass for some: at least {FEW:g} are needed; take "
            "more rings into the picture, light it more evenly, or give start or fixed values"
        )
    if share < most and (orders >= 2 or inflation < _ALIKE):
        return ""
    return (
        f"the image shows only {orders:.1f} fringes, and {max(share, 0):.1%} of its variance is structure that the "
        "model does not explain; curvature cannot be separated from it: include more rings, or a larger field"
    )


def _squared_distance(mask: np.ndarray, centre: tuple[float, float]) -> np.ndarray:
    x, y = pixels_of(mask)
    return (x - centre[0]) ** 2 + (y - centre[1]) ** 2


def _straight(mask: np.ndarray, scale: float, centre: tuple[float, float], fewest: float) -> str:
    """That more fringes than the fewest cross the field without bending as rings do: they may be straight."""
    x, y = pixels_of(mask)
    orders = abs(scale) * float(np.ptp(_squared_distance(mask, centre)))
    bend = abs(scale) * float(_squared_distance(mask, (float(x.mean()), float(y.mean()))).max())
    if bend >= min(1.0, _BEND + _WARPED * orders) or orders <= fewest:
        return ""
    return (
        f"the fringes are straight: across {orders:.2g} fringes they bend by {bend:.2g} fringe spacings; "
        "a radius needs curved fringes"
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
        f"wavelength and pixel size imply a lens radius of {values['radius']:.3g} m, but the rings extend to "
        f"{reach:.3g} m; check the units"
    )
