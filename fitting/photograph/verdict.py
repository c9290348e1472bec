"""Whether a fit of the gap formula found rings of which a radius can be had, and why not."""

import numpy as np

from fitting.estimate import FEW, SHAPES, Fitted, correlation
from fitting.parameters import Numbers, Parameter
from fitting.photo import (
    PLANE,
    Photograph,
    Rings,
    are_straight,
    block_means,
    noise_variance,
    pixels_of,
    plane_wave,
    view_of,
)
from fitting.reasons import Reason
from newtonjax.numerics import Statement

# Fringes that explain less than this are looked at twice; less than that are none.
_POOR, _NONE = 0.3, 0.12
# Structure that makes up more than 45 % of the variance, and errs together in blocks [px] by more than blurred noise
# does, is fringes of another kind (equidistant circles, spirals, ellipses that were not found).
_DOUBTFUL, _TOGETHER, _BLOCKS = 0.55, 3.5, (8, 16)
# Fewer fringes than this do not determine their scale unless a person tells where they are: of made pictures
# (`experiments/truth/few_fringes.py`) with 1 to 1.5 some locked 16 to 30 % off behind uneven light, and left nothing
# over that shows it. A person who gives a start or holds a number needs one.
_FEWEST, _FEWEST_GUIDED = 1.5, 1.0
# Share of the variance that a few fringes may leave over as structure; it grows with their number by this power, up to
# that of many (of a photograph with 7 fringes 14 %, of ellipses with 5 to 6 up to 32 %). And how much less than two may
# err together.
_STRUCTURE, _GROWTH, _ALIKE = 0.02, 3.6, 3.0
# Fringes that are wide, by their number, and blocks to a side that leave enough of their means.
_WIDE, _LARGE = 10.0, 64


class RefusedError(Exception):
    """A photograph of which no radius can be had: why, the photograph as far as it was read, and what was measured."""

    def __init__(self, reason: Statement, photograph: Photograph, parameters: dict[str, Parameter] | None = None):
        super().__init__(reason)
        self.reason, self.photograph, self.parameters = reason, photograph, parameters or {}


def judge(found: Fitted, photograph: Photograph, rings: Rings, guided: bool = False) -> Statement | None:
    """Why no radius can be had from a fit of the gap formula; None where one can.

    `guided`: a person gave a start or held values, and so has seen rings.
    """
    frame = found.model.frame
    numbers = Numbers(*found.numbers)
    scale, offsets = float(numbers.curvature) / frame.unit**2, (float(numbers.centre_x), float(numbers.centre_y))
    x, y = (middle + at * frame.unit for middle, at in zip(frame.middle, offsets, strict=True))
    orders, explained = found.orders, found.explained
    if not (np.isfinite(explained) and np.isfinite(scale)):
        return Reason.NOT_FINITE()
    straight = plane_wave(view_of(photograph)) if explained < _POOR else 0.0
    if straight > PLANE:
        return Reason.STRAIGHT_FIT_WAVE(straight=straight)
    if explained < _NONE:
        return Reason.NO_RINGS_FIT(explained=max(explained, 0.0), least=_NONE)
    for k, c in ((rings.scale, rings.centre), (scale, (x, y))):
        if bend := _straight(photograph.mask, k, c):
            return bend
    if orders < (least := _FEWEST_GUIDED if guided else _FEWEST):
        reason = Reason.TOO_FEW_FRINGES_GUIDED if guided else Reason.TOO_FEW_FRINGES
        return reason(orders=orders, least=least)
    if scale <= 0:
        return Reason.NOT_CURVED()
    if not guided and (bend := _straight(photograph.mask, scale, (x, y), judges_few=True)):
        return bend
    return _locked_badly(found, explained, orders, guided)


def _most_structure(orders: float, guided: bool) -> float:
    """Share of the variance that so many fringes may leave over as structure."""
    growth = np.inf if guided and orders >= FEW else max(orders / FEW, 1.0) ** _GROWTH
    return min(_STRUCTURE * growth, 1 - _DOUBTFUL)


def _locked_badly(found: Fitted, explained: float, orders: float, guided: bool) -> Statement | None:
    """That what the fringes leave over has structure which no radius explains; None where it is as it should be."""
    most = _most_structure(orders, guided)
    if explained >= 1 - most and orders >= FEW:
        return None
    left = found.left
    inflation = correlation(found.reduced.grid, left.value, left.weights, _BLOCKS)
    share = _structure(found, orders) * found.weight / found.variance
    if inflation > _TOGETHER and (share > 1 - _DOUBTFUL or (explained < _POOR and inflation > 3 * _TOGETHER)):
        return Reason.NOT_ONE_SPHERE(explained=explained)
    if orders >= FEW and (share < most or inflation <= _TOGETHER):
        return None
    if not guided and orders < FEW and found.shape == SHAPES[-1]:
        return Reason.UNEVEN_LIGHT(orders=orders, least=FEW)
    if share < most and (orders >= 2 or inflation < _ALIKE):
        return None
    return Reason.STRUCTURE_BESIDE_FEW_FRINGES(orders=orders, share=max(share, 0.0))


def _structure(found: Fitted, orders: float) -> float:
    """Variance of what is left over beyond noise: for a few fringes of means over 2 x 2 blocks.

    These fringes are wide, and so is what may pass for some. What a camera's JPEG makes of noise is no wider than a few
    pixels: of rings saved at quality 50 it was 5 to 7 % of the variance, of the means 0.2 to 0.3 %; of ellipses, cones
    and clouds the means hold nearly all.
    """
    left = found.left
    if orders >= _WIDE or min(left.value.shape) < _LARGE:
        return found.chi2 / found.weight - noise_variance(found.reduced.inverse_sd * left.value, left.weights > 0)
    weights = block_means(left.weights, 2)
    is_used = weights > 0
    means = block_means(left.weights * left.value, 2) / np.where(is_used, weights, 1.0)
    return float(np.mean(means[is_used] ** 2)) - noise_variance(means, is_used)


def _squared_distance(mask: np.ndarray, centre: tuple[float, float]) -> np.ndarray:
    x, y = pixels_of(mask)
    return (x - centre[0]) ** 2 + (y - centre[1]) ** 2


def _straight(
    mask: np.ndarray, scale: float, centre: tuple[float, float], judges_few: bool = False
) -> Statement | None:
    """That fringes cross the field without bending as rings do; few of them only where these are judged, too."""
    x, y = pixels_of(mask)
    orders = abs(scale) * float(np.ptp(_squared_distance(mask, centre)))
    bend = abs(scale) * float(_squared_distance(mask, (float(x.mean()), float(y.mean()))).max())
    return (
        Reason.STRAIGHT_FIT_BEND(orders=orders, bend=bend)
        if are_straight(orders, bend, judges_few=judges_few)
        else None
    )
