"""What is known of a fit's numbers before the image is seen: by default, by a grid, or by the user."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from fitting.estimate import Prior
from fitting.model import AXIS, PARTS, PRIORS, RADIAL, anchors_of, numbers_of
from fitting.parameters import TABLE, Numbers, normal_pair, number, positive_sd
from newtonjax.numerics import shown

# Where the axis of a picture may lie that has been cut, in half diagonals from its middle.
CUT = 0.25
_OF_A_CUT = "the picture has no camera's shape and may have been cut"
# Of each term of a lens that is far from a sphere, at the rim [turns].
ANY_FORM = 0.5
_NO_SPHERE = "the residual is a form's, which 0.02 of a fringe does not hold"
# The part of each number that has a prior.
_PART_OF = {name: part for part in PARTS for name in PARTS[part].priors}


class StatedPrior(NamedTuple):
    """A prior that replaces the default of its number; `source`: "grid", "user" or "default"; `reason`: in words."""

    value: float
    sd: float
    source: str
    reason: str


@dataclass(frozen=True)
class Priors:
    """Priors of the parts' numbers, by name, and the phase where faces touch [turns].

    `stated`: those that are not the default; `may_be_cut`: whether the picture has not the shape of a camera's: then
    its axis may lie anywhere.
    """

    contact_phase: float
    stated: Mapping[str, StatedPrior]
    may_be_cut: bool = False

    @cached_property
    def numbers(self) -> dict[str, tuple[float, float]]:
        """Value and standard deviation by number: what is stated, else what its part says."""
        return {**PRIORS, **{name: (prior.value, prior.sd) for name, prior in self.stated.items()}}

    def table(self, parts: Iterable[str]) -> dict[str, dict[str, Any]]:
        """By number of parts: value, standard deviation, source and reason, for a report."""
        parts, rows = tuple(parts), {}
        for name in (name for part in parts for name in PARTS[part].priors):
            default = StatedPrior(*PRIORS[name], "default", PARTS[_PART_OF[name]].prior_words)
            rows[name] = self.stated.get(name, default)._asdict()
        for name, sd in anchors_of(parts).items():
            reason = "the phase of touching faces, in turns"
            rows[name] = StatedPrior(self.contact_phase, sd, "default", reason)._asdict()
        return rows

    def words(self, part: str) -> str:
        """Why a part is there for certain."""
        sources = {self.stated[name].source for name in parameters_beside_axis(part) if name in self.stated}
        if "user" in sources:
            return "its prior is given"
        return "measured on the grid" if sources else "asked for"

    def cut(self) -> "Priors":
        """The same for a picture that has been cut out of a larger one."""
        anywhere = StatedPrior(0.0, CUT, "default", _OF_A_CUT)
        return replace(self, stated={**dict.fromkeys(AXIS, anywhere), **self.stated})

    def of_any_form(self) -> "Priors":
        """The same for a lens that may have any form."""
        any_form = StatedPrior(0.0, ANY_FORM, "default", _NO_SPHERE)
        return replace(self, stated={**dict.fromkeys(PARTS["lens_form"].parameters, any_form), **self.stated})

    def of(self, parts: Iterable[str], numbers: np.ndarray, variance: float) -> Prior:
        """For a fit with parts; the phase of contact is meant up to whole turns: the nearest to the numbers' own.

        `variance`: of the light per unit weight, errors that neighbours share included.
        """
        parts, start = tuple(parts), Numbers(*numbers)
        centres = {name: self.numbers[name] for name in numbers_of(parts) if name in self.numbers}
        for name, sd in anchors_of(parts).items():
            offset = getattr(start, name) - self.contact_phase
            centres[name] = (self.contact_phase + float(np.round(offset)), sd)
        return Prior(centres, variance)


def parameters_beside_axis(part: str) -> tuple[str, ...]:
    """Numbers of a part but for the camera's axis, which means nothing without the part."""
    return tuple(name for name in PARTS[part].parameters if name not in AXIS)


def checked_priors(priors: Any, wishes: Mapping[str, bool]) -> dict[str, StatedPrior]:
    """What the user says of numbers of parts: (value, standard deviation) by name.

    Raises ValueError for other names or values, and for numbers of parts that are excluded by `wishes`.
    """
    if not isinstance(priors, Mapping):
        example = '{"distortion": (0.0, 0.02)}'
        raise ValueError(f"priors is {shown(priors)}; allowed: a mapping of names to (value, sd), such as {example}")
    return {name: _checked_prior(name, pair, wishes) for name, pair in priors.items()}


def _checked_prior(name: Any, pair: Any, wishes: Mapping[str, bool]) -> StatedPrior:
    if name not in _PART_OF:
        near = get_close_matches(str(name), _PART_OF, 1)
        meant = f", perhaps {near[0]}" if near else "; sample takes priors of all that is drawn" * (name in TABLE)
        raise ValueError(f"priors: {shown(name)} has no prior; allowed: {', '.join(_PART_OF)}{meant}")
    part = _PART_OF[name]
    if wishes.get(part) is False:
        raise ValueError(f"priors: {name} is a number of {part}, which is left out; leave out its prior, or let it be")
    pair = normal_pair(pair)
    if callable(pair) or hasattr(pair, "logpdf") or hasattr(pair, "log_prob"):
        raise ValueError(
            f"priors: {name} is {shown(pair)}; a fit takes normal ones, (value, sd); "
            "sample(result, priors=...) takes any distribution"
        )
    if not isinstance(pair, tuple | list) or len(pair) != 2:
        raise ValueError(f"priors: {name} is {shown(pair)}; allowed: (value, sd)")
    value = number(f"priors: {name}", pair[0])
    sd = positive_sd(f"priors: {name}", pair[1], value)
    # Bounds are those at the rim of the lit field, which may be well within half a diagonal.
    low, high = (bound * (2 if name in RADIAL else 1) for bound in TABLE[name].bounds)
    if not low < value < high:
        raise ValueError(f"priors: {name} is {value:g}; allowed: between {low:g} and {high:g}")
    return StatedPrior(value, sd, "user", "given")


def checked_axis(place: Any, sd: Any, priors: Mapping[str, StatedPrior]) -> tuple[float, float, float | None]:
    """Where the camera's axis is in the picture, x and y [px], and the standard deviation of each, None where unsaid.

    Raises ValueError for what is no place, and where `priors` say it otherwise.
    """
    if place is None:
        raise ValueError("axis_px_sd is given without axis_px; give both, or neither")
    if not isinstance(place, tuple | list | np.ndarray) or np.size(np.asarray(place, dtype=object)) != 2:
        raise ValueError(f"axis_px is {shown(place)}; allowed: two numbers, (x, y) in pixels")
    if both := [name for name in AXIS if name in priors]:
        raise ValueError(f"axis_px and a prior of {both[0]} both say where the axis is; leave one out")
    x, y = (number("axis_px", at) for at in place)
    if sd is not None and not 0 < number("axis_px_sd", sd) < np.inf:
        raise ValueError(f"axis_px_sd is {shown(sd)}; allowed: a number of pixels above zero")
    return x, y, None if sd is None else float(sd)


def axis_priors(axis: tuple[float, float, float | None], shape: tuple[int, ...]) -> dict[str, StatedPrior]:
    """Priors of an axis [px] in a picture [rows, columns], whose deviation is the default's unless it is said.

    Raises ValueError for one that is further than half a diagonal from the middle, along x or y.
    """
    x, y, sd_px = axis
    middle_y, middle_x = ((count - 1) / 2 for count in shape[:2])
    unit = float(np.hypot(middle_x, middle_y))
    priors = {}
    for name, letter, at, centre in zip(AXIS, "xy", (x, y), (middle_x, middle_y), strict=True):
        low, high = (centre + bound * unit for bound in TABLE[name].bounds)
        if not low < at < high:
            raise ValueError(f"axis_px has {letter} = {at:g}; allowed here: between {low:.0f} and {high:.0f}")
        sd = PRIORS[name][1] if sd_px is None else sd_px / unit
        priors[name] = StatedPrior((at - centre) / unit, sd, "user", "given")
    return priors


def forced_parts(stated: Mapping[str, StatedPrior]) -> dict[str, bool]:
    """Parts that are there for certain, with those that they need: something is stated of their numbers."""
    forced: dict[str, bool] = {}
    for part in reversed(PARTS):
        if part in forced or any(name in stated for name in parameters_beside_axis(part)):
            forced |= dict.fromkeys((part, *PARTS[part].needs), True)
    return forced


def optimum_with_priors(
    matrix: np.ndarray,
    pull: np.ndarray,
    values: np.ndarray,
    free: np.ndarray,
    centre: np.ndarray,
    precision: np.ndarray,
    absent: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, float]:
    """The step to a set's optimum, the covariance there, and the logarithm of its evidence, one constant left out.

    The numbers that are not free go to `absent`. Of q(d) = -2 pull·d + dᵀ M d and the prior's (v + d - centre)²/sd².
    """
    step, spread = np.where(free, 0.0, absent - values), np.zeros_like(matrix)
    inner = matrix[np.ix_(free, free)]
    precise = inner + np.diag(precision[free])
    target = pull[free] - matrix[np.ix_(free, ~free)] @ step[~free] + precision[free] * (centre - values)[free]
    if free.any():
        spread[np.ix_(free, free)] = inverse = np.linalg.inv(precise)
        step[free] = inverse @ target
    cost = step @ matrix @ step - 2 * pull @ step + float(precision[free] @ (values + step - centre)[free] ** 2)
    determinant = float(np.linalg.slogdet(np.eye(free.sum()) + inner / precision[free])[1]) if free.any() else 0.0
    return step, spread, -0.5 * (float(cost) + determinant)
