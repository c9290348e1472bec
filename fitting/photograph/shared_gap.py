"""The gap at the centre from the phases of rings in several wavelengths: the method of exact fractions.

The phase of one wavelength repeats with half of it. Gaps at which several phases come together lie farther apart: by
half of the synthetic wavelength, 1 over the difference of two wavenumbers (M. Born and E. Wolf, Principles of Optics,
7th ed., section 7.6.7; C. R. Tilford, Appl. Opt. 16, 1857 (1977)).
"""

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from fitting.model import GapModel
from fitting.parameters import Numbers, between, block_of, with_sd
from fitting.photograph.result import FitResult
from fitting.reasons import Reason
from newtonjax.numerics import Statement

# An order is told from this probability on.
_CERTAIN = 0.99
# Degrees of freedom of Student's distribution of the phases about one gap: their deviations are themselves estimates.
_FREEDOM = 4.0
# Phases farther from any gap, in standard deviations, are not of one lens in one place.
_MOST_APART = 5.0
# Most orders that are listed, and the least probability of one that is.
_LISTED, _LEAST = 10, 1e-4
# The square of a camera's blur [px²] that all pictures have in common, and that each has of its own by its focus.
_BLUR, _OWN_BLUR = 2.25, 0.8
# Wavelengths that are equal, relatively, and rounding [turns].
_EQUAL, _ROUNDING = 1e-6, 1e-9
# How far a lens that touches may be dented, in wavelengths: 16 nm were seen of one of 154.5 mm that lay by its weight.
_DENT = 0.1


class Fraction(NamedTuple):
    """What one picture says: twice the gap, in wavelengths in the gap, less a whole number.

    - `turns`, `sd`: that remainder; `wavelength`: in the gap [m]; `relative_sd` of the wavelength.
    """

    turns: float
    sd: float
    wavelength: float
    relative_sd: float = 0.0


class GapOrder(NamedTuple):
    """A gap that may be: the whole wavelengths in twice the gap, of each picture, and its probability."""

    gap: float
    orders: tuple[int, ...]
    probability: float


class SharedGap(NamedTuple):
    """The gap at the centre of one lens in several wavelengths [m].

    - `status`: "ok", or "undetermined" where `message` says why: no order holds 99 %, or the phases contradict.
    - `value`, `sd`: None unless ok; `budget`: (source, standard deviation).
    - `orders`: the most probable first. `window`: gaps between which it is sought.
    """

    status: str
    message: str
    value: float | None
    sd: float | None
    budget: list[tuple[str, float]]
    orders: list[GapOrder]
    window: tuple[float, float]

    @property
    def interval(self) -> tuple[float, float] | None:
        """95 % of the gap, None where its order is open."""
        if self.value is None or self.sd is None:
            return None
        return self.value - 1.96 * self.sd, self.value + 1.96 * self.sd

    def to_dict(self) -> dict[str, Any]:
        """The JSON object of the shell."""
        return {
            "status": self.status,
            "message": str(self.message),
            "gap_m": self.value,
            "gap_sd_m": self.sd,
            "gap_interval_m": self.interval and list(self.interval),
            "reason": getattr(self.message, "code", None),
            "budget": [{"source": source, "sd_m": sd} for source, sd in self.budget],
            "orders": [
                {"gap_m": gap, "orders": list(orders), "probability": share} for gap, orders, share in self.orders
            ],
            "window_m": list(self.window),
        }

    @classmethod
    def from_dict(cls, saved: Mapping[str, Any]) -> "SharedGap":
        """The gap that `to_dict` was called of."""
        text, reason = saved["message"], saved["reason"]
        message = Statement(text, reason) if reason else text
        budget = [(row["source"], row["sd_m"]) for row in saved["budget"]]
        orders = [GapOrder(row["gap_m"], tuple(row["orders"]), row["probability"]) for row in saved["orders"]]
        low, high = saved["window_m"]
        return cls(saved["status"], message, saved["gap_m"], saved["gap_sd_m"], budget, orders, (low, high))

    def report_lines(self) -> list[str]:
        """Its lines of a report."""
        answer = str(self.message) if self.value is None else with_sd(self.value, self.sd, "m")
        sought = between(self.window, 1e-3 * self.window[1], "m")
        lines = [f"[[Gap]]  at the centre, sought from {sought}", f"    gap = {answer}"]
        for gap, orders, probability in self.orders[:3]:
            lines.append(
                f"    order {', '.join(map(str, orders))}: {with_sd(gap, None, 'm')}, probability {probability:.2%}"
            )
        return lines


def fraction_of(fit: FitResult) -> Fraction | None:
    """What a fit says of the gap, None of one without rings or of a bench."""
    evidence = fit.evidence
    if evidence is None or not isinstance(evidence.found.model, GapModel):
        return None
    quantities, numbers = evidence.known, evidence.found.numbers
    if evidence.averaging is not None:
        numbers = evidence.averaging.mean(evidence.variance, ratio=evidence.ratio).numbers
    sd = float(np.sqrt(max(block_of(evidence.covariance, ["phase"]).item(), 0.0)))
    wavelength, index = quantities.given["wavelength"], quantities.given["gap_index"]
    relative_sd = quantities.sd.get("wavelength", 0.0) / wavelength
    turns = float(Numbers(*numbers).phase) - float(evidence.found.model.microscope.touching)
    return Fraction(turns - round(turns), sd, wavelength / index, relative_sd)


def window_of(wavelengths: Sequence[float]) -> tuple[float, float]:
    """Gaps [m], half of the synthetic wavelength of these wavelengths in the gap [m]: no phases come twice in it.

    It begins before contact, since a lens that dents the plate is nearer by the rings around the dent.
    Raises ValueError for equal wavelengths.
    """
    apart = [abs(1 / one - 1 / other) for one, other in combinations(wavelengths, 2)]
    apart = [difference for difference in apart if difference * max(wavelengths) > _EQUAL]
    if not apart:
        raise ValueError("shared holds gap, which takes pictures in different wavelengths; give wavelength as a list")
    low = -_DENT * min(wavelengths)
    return low, low + 0.5 / min(apart)


def shared_gap(
    fractions: Sequence[Fraction],
    window: tuple[float, float],
    blur_shift: float = 0.0,
    index_sd: float = 0.0,
) -> SharedGap:
    """The gap of phases of one lens in several wavelengths, sought in a window [m].

    Of every order of the shortest wavelength in the window the others have the nearest ones; the gap is that of least
    squares, and its probability by Student's distribution of what they leave over. `blur_shift`: change of the gap by a
    pixel² of blur [m]; `index_sd` of the gap's index, relative.
    """
    wavelengths = np.array([fraction.wavelength for fraction in fractions])
    turns, sds, relative = (np.array([getattr(f, name) for f in fractions]) for name in ("turns", "sd", "relative_sd"))
    first = int(np.argmin(wavelengths))
    low, high = (2 * end / wavelengths[first] - turns[first] for end in window)
    own = np.arange(np.floor(low) - 1, np.ceil(high) + 2)
    paths = wavelengths[first] * (own + turns[first])
    orders = np.round(paths[:, None] / wavelengths - turns)
    paths = wavelengths * (orders + turns)
    of_image = (wavelengths * sds) ** 2 + (2 * blur_shift * _OWN_BLUR) ** 2 + (_ROUNDING * wavelengths) ** 2
    weights = 1 / (of_image + (paths * relative) ** 2)
    gaps = 0.5 * (weights * paths).sum(axis=1) / weights.sum(axis=1)
    square = (weights * (paths - 2 * gaps[:, None]) ** 2).sum(axis=1)
    # Beyond the window by its own deviation a gap is as likely as one that phases miss by theirs.
    beyond = np.maximum(np.maximum(window[0] - gaps, gaps - window[1]), 0.0)
    square += beyond**2 / (0.25 / weights.sum(axis=1) + (blur_shift * _BLUR) ** 2)
    dimension = len(fractions) - 1
    logarithm = -0.5 * (_FREEDOM + dimension) * np.log1p(square / _FREEDOM)
    share = np.exp(logarithm - logarithm.max())
    share /= share.sum()
    ranked = np.argsort(-share, kind="stable")
    best = ranked[0]
    listed = [
        GapOrder(float(gaps[k]), tuple(int(order) for order in orders[k]), float(share[k]))
        for k in ranked[:_LISTED]
        if share[k] >= _LEAST
    ]
    distance = float(np.sqrt(square[best] / dimension))
    if distance > _MOST_APART:
        return SharedGap("undetermined", Reason.PHASES_CONTRADICT(size=distance), None, None, [], listed, window)
    if share[best] < _CERTAIN:
        message = Reason.GAP_ORDER_UNDECIDED(probability=float(share[best]), gap=float(gaps[best]))
        return SharedGap("undetermined", message, None, None, [], listed, window)
    gap, scatter = float(gaps[best]), max(1.0, distance)
    rows = [
        ("phases and wavelengths", scatter * 0.5 / float(np.sqrt(weights[best].sum()))),
        ("blur", blur_shift * _BLUR),
        ("gap_index", abs(gap) * index_sd),
    ]
    sd = float(np.linalg.norm([row for _, row in rows]))
    return SharedGap("ok", "", gap, sd, [row for row in rows if row[1]], listed, window)
