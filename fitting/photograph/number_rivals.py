"""Rivals that speak by the fit's own numbers: a lens with two radii for a view, and priors that do not hold."""

import numpy as np

from fitting.estimate import Fitted
from fitting.model import PRIORS, STRETCHES
from fitting.parameters import NUMBERS, Numbers, slots_of
from fitting.photograph.remainder import Remainder
from fitting.photograph.rival import AbstractRival, Finding
from fitting.reasons import Reason

# The row of the budget.
VIEW_OR_FORM = "view or form"
# Stretches below this change nothing: 1 - 1/cosh of it is a millionth of the radius.
LEAST = 1.5e-3
# A view at more than this angle [degrees] is taken for less likely than a lens with two radii.
_LIKELY = 16.5
# Standard deviations of a prior. Of numbers that are drawn from their priors one of 14 is beyond in 0.1 % of pictures.
_LIMIT = 4.0
# A relative change of the scale by such a prior from which on it is spoken of.
_PULLED = 1e-4
# No camera distorts by more at half a diagonal, unless a prior says so: of photographs through eyepieces 0.29 at most,
# of rings in r⁴ that were answered 0.88.
_MOST_DISTORTED = 0.6
_CURVATURE = NUMBERS.index("curvature")


class ViewOrForm(AbstractRival):
    """That a view's stretch m is the lens's own: one image does not tell.

    Principal radii then are R exp(-m) and R exp(m), with R their geometric mean, which the view does not change; the
    radius of the mean curvature is R / cosh m. The difference is a row.
    """

    name = VIEW_OR_FORM

    def finding(self, remainder: Remainder) -> Finding | None:
        """By how much the geometric mean exceeds the radius of the mean curvature."""
        numbers = Numbers(*remainder.fit.numbers)
        stretch = float(np.hypot(numbers.stretch, numbers.shear))
        if stretch < LEAST:
            return None
        angle = float(np.degrees(np.arccos(np.exp(-stretch))))
        deviation = 1 - 1 / float(np.cosh(stretch))
        words = Reason.RIVAL_VIEW_OR_FORM(
            stretch=np.expm1(2 * stretch), angle=angle, apart=2 * np.sinh(stretch), share=deviation
        )
        return Finding(self.name, angle, _LIKELY, "warning" if angle > _LIKELY else "budget", words, deviation)


class PriorTension(AbstractRival):
    """The number that is furthest from its prior's middle, in the prior's standard deviations.

    Such a prior pulls the answer without right. What the scale moves by when each of them is made as wide as its number
    is far, one step on the fit's normal equations, is a row; a pull that moves nothing is not spoken of: the image has
    told the number. Stretches are the matter of view or form. With a
    distortion that no camera has there is no answer.
    """

    name = "prior tension"

    def finding(self, remainder: Remainder) -> Finding | None:
        """Which number is furthest, and what its prior does to the scale."""
        fit = remainder.fit
        expected = fit.solution.problem.prior.numbers
        distances = {name: _distance(fit, name) for name in fit.solution.problem.free if _counts(name, expected)}
        if not distances or max(distances.values()) < _LIMIT:
            return None
        distortion = float(Numbers(*fit.numbers).distortion)
        if (distance := distances.get("distortion", 0.0)) > _LIMIT and abs(distortion) > _MOST_DISTORTED:
            return Finding(self.name, distance, _LIMIT, "refusal", Reason.RIVAL_ANOTHER_LAW(value=distortion))
        furthest = max(distances, key=distances.__getitem__)
        centre, sd = expected[furthest]
        value = float(getattr(Numbers(*fit.numbers), furthest))
        deviation = _pull(fit, [name for name, size in distances.items() if size > _LIMIT]) / remainder.first
        if deviation < _PULLED:
            return None
        words = Reason.RIVAL_PRIOR_TENSION(
            name=furthest, value=value, ratio=distances[furthest], centre=centre, sd=sd, share=deviation
        )
        return Finding(self.name, distances[furthest], _LIMIT, "warning", words, deviation)


def _counts(name: str, expected) -> bool:
    return name in PRIORS and name in expected and not any(name in pair for pair in STRETCHES)


def _distance(fit: Fitted, name: str) -> float:
    """Of a number from its prior's middle, in its standard deviations."""
    centre, sd = fit.solution.problem.prior.numbers[name]
    return abs(float(getattr(Numbers(*fit.numbers), name)) - centre) / sd


def _pull(fit: Fitted, names: list[str]) -> float:
    """By how much priors hold the curvature: its change when each is as wide as its number is far from the middle."""
    matrix, slots = fit.matrix, slots_of(names)
    centre, cost = fit.solution.problem.pull
    wider, ahead = cost.copy(), fit.numbers - centre
    wider[slots] /= np.square([_distance(fit, name) for name in names])
    change, prior = np.zeros(len(matrix.values)), np.zeros(len(matrix.values))
    change[: len(NUMBERS)], prior[: len(NUMBERS)] = (cost - wider) * ahead, wider
    active = matrix.active
    block = (matrix.matrix + np.diag(prior))[np.ix_(active, active)]
    step = np.zeros(len(matrix.values))
    step[active] = np.linalg.lstsq(block, change[active], rcond=1e-13)[0]
    return abs(float(step[_CURVATURE]))
