"""Rivals in what the model says of lens and camera: another form, two radii for a view, priors that do not hold."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from fitting.estimate import Fitted, bends
from fitting.model import PRIORS, STRETCHES
from fitting.parameters import NUMBERS, Numbers, slots_of
from fitting.photograph.remainder import Remainder
from fitting.photograph.rival import AbstractRival, Finding
from fitting.reasons import Reason

# Chi-squared that the terms of a form take, per term, in variances with what neighbours share: of pictures on the model
# one in a hundred exceeds it.
_LIMIT = 4.0
# Standard deviations that the terms' prior may have [turns at the rim], from the data.
_SMALLEST, _LARGEST, _ROUNDS = 1e-3, 0.5, 8
# A phase that terms change by more than this [turns] is not linear in them.
_LINEAR = 1.0
# Terms of which less than this is left beside the model's own numbers are these numbers.
_ALIKE = 1e-6
_CURVATURE = NUMBERS.index("curvature")

# The row of the budget.
VIEW_OR_FORM = "view or form"
# Stretches below this change nothing: 1 - 1/cosh of it is a millionth of the radius.
LEAST = 1.5e-3
# A view at more than this angle [degrees] is taken for less likely than a lens with two radii.
_LIKELY = 16.5
# Standard deviations of a prior. Of numbers that are drawn from their priors one of 14 is beyond in 0.1 % of pictures.
_TENSION = 4.0
# A relative change of the scale by such a prior from which on it is spoken of.
_PULLED = 1e-4
# No camera distorts by more at half a diagonal, unless a prior says so: of photographs through eyepieces 0.29 at most,
# of rings in r⁴ that were answered 0.88.
_MOST_DISTORTED = 0.6


class Terms(NamedTuple):
    """Terms of a form beside the fit: its values [turns at the rim], and what they do.

    - `chi2`: what each takes of chi-squared in the mean, in variances.
    - `shift`: relative change of the fringe scale with them; `shift_sd`: what they leave uncertain of it.
    """

    values: Float[np.ndarray, " terms"]
    chi2: float
    shift: float
    shift_sd: float


class Form(AbstractRival):
    """Coma, trefoil, astigmatism of the fourth order, fourfold waves, and rings in r or r⁴ (Zernike's terms).

    A score test (Rao 1948) on the fit's normal equations: no fit is made. A lens with a form has no single radius near
    its vertex: coma about a shifted vertex is curvature. So what the scale would move by with the terms, their common
    prior being as wide as they are (empirical Bayes), is a row of the budget.
    """

    name = "form"

    def finding(self, remainder: Remainder) -> Finding | None:
        """What the terms take of chi-squared, and move of the scale."""
        terms = form_terms(remainder)
        if terms is None or terms.chi2 < _LIMIT:
            return None
        largest = float(np.abs(terms.values).max())
        if largest > _LINEAR:
            # What they do to the scale is then no row, and no number is said.
            return Finding(self.name, terms.chi2, _LIMIT, "warning", Reason.RIVAL_LARGE_FORM(size=largest))
        # Their shift counts as far as they determine one.
        square, doubt = terms.shift**2, terms.shift_sd**2
        shift = terms.shift * square / max(square + doubt, 1e-300)
        return Finding(
            self.name, terms.chi2, _LIMIT, "budget", Reason.RIVAL_FORM(size=largest, shift=shift), abs(shift)
        )


def form_terms(remainder: Remainder) -> Terms | None:
    """The terms of a form that a fit leaves over; None where the model has them all."""
    fit = remainder.fit
    crossed, among, gradient = bends(fit.solution, _phases(remainder))
    matrix, white = fit.matrix, fit.chi2 / max(fit.weight, 1.0)
    if not white > 0:
        return None
    share = matrix.inverse @ crossed[matrix.active]
    remaining = among - crossed[matrix.active].T @ share
    slope = gradient - share.T @ matrix.gradient[matrix.active]
    free = np.diag(remaining) > _ALIKE * np.diag(among)
    if not free.any():
        return None
    # What neighbours share is mostly the form itself: it decides whether there is one, and does not pull it to zero.
    information, slope = remaining[np.ix_(free, free)] / white, slope[free] / white
    values, covariance = _shrunk(information, slope)
    chi2 = float(slope @ np.linalg.solve(information + np.eye(len(slope)) / _LARGEST**2, slope)) / fit.correlation
    of_scale = np.zeros((len(matrix.values), len(slope)))
    of_scale[matrix.active] = -share[:, free]
    by_terms = of_scale[_CURVATURE] / remainder.first
    uncertain = float(by_terms @ covariance @ by_terms)
    return Terms(values, chi2 / len(values), float(by_terms @ values), float(np.sqrt(max(uncertain, 0.0))))


def _phases(remainder: Remainder) -> np.ndarray:
    """The terms at the grid's nodes, each at most one turn at the rim [nodes, terms]."""
    x, y = remainder.nodes
    z = x + 1j * y
    z = z / np.abs(z).max()
    r2 = np.abs(z) ** 2
    waves = (z * r2, z**3, z**2 * r2, z**4)
    return np.stack([np.sqrt(r2 + 1e-4), r2 * r2, *(part for wave in waves for part in (wave.real, wave.imag))], axis=1)


def _shrunk(information: np.ndarray, slope: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values and covariance under a normal prior about 0, as wide as the values themselves say (MacKay 1992)."""
    variance, values, posterior = _LARGEST**2, np.zeros(len(slope)), np.eye(len(slope))
    for _ in range(_ROUNDS):
        posterior = np.linalg.inv(information + np.eye(len(slope)) / variance)
        values = posterior @ slope
        effective = len(slope) - float(np.trace(posterior)) / variance
        variance = float(np.clip(values @ values / max(effective, 1e-3), _SMALLEST**2, _LARGEST**2))
    return values, posterior


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
        if not distances or max(distances.values()) < _TENSION:
            return None
        distortion = float(Numbers(*fit.numbers).distortion)
        if (distance := distances.get("distortion", 0.0)) > _TENSION and abs(distortion) > _MOST_DISTORTED:
            return Finding(self.name, distance, _TENSION, "refusal", Reason.RIVAL_ANOTHER_LAW(value=distortion))
        furthest = max(distances, key=distances.__getitem__)
        centre, sd = expected[furthest]
        value = float(getattr(Numbers(*fit.numbers), furthest))
        deviation = _pull(fit, [name for name, size in distances.items() if size > _TENSION]) / remainder.first
        if deviation < _PULLED:
            return None
        words = Reason.RIVAL_PRIOR_TENSION(
            name=furthest, value=value, ratio=distances[furthest], centre=centre, sd=sd, share=deviation
        )
        return Finding(self.name, distances[furthest], _TENSION, "warning", words, deviation)


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
