"""Rivals in what the model says of lens and camera: another form or law, two radii for a view, untrue priors."""

import numpy as np
from scipy import optimize

from fitting.estimate import Fitted
from fitting.model import PRIORS, RADIAL, SEARCHED, STRETCHES, numbers_of
from fitting.parameters import NUMBERS, Numbers, slots_of
from fitting.photograph.choice import form_terms
from fitting.photograph.phase_map import phase_map
from fitting.photograph.remainder import Remainder
from fitting.photograph.rival import AbstractRival, Finding
from fitting.reasons import Reason

# Chi-squared that the terms of a form take, per term, in variances with what neighbours share: of pictures on the model
# one in a hundred exceeds it.
_LIMIT = 4.0
# A phase that terms change by more than this [turns] is not linear in them.
_LINEAR = 1.0
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

# Powers that a search starts from, its evaluations, and places to a side where the phase is taken.
_STARTS, _STEPS, _PLACES = (1.5, 3.0, 4.5), 40, 20
# A power that is nearer to a sphere's is one.
_SPHERE, _ANOTHER = 2.0, 0.2
_TINY = 1e-6


class Form(AbstractRival):
    """Coma, trefoil, astigmatism of the fourth order, fourfold waves, and rings in r or r⁴ (Zernike's terms).

    A score test (Rao 1948) on the fit's normal equations: no fit is made. A lens with a form has no single radius near
    its vertex: coma about a shifted vertex is curvature. So what the scale would move by with the terms, their common
    prior being as wide as they are (empirical Bayes), is a row of the budget.
    """

    name = "form"

    def finding(self, remainder: Remainder) -> Finding | None:
        """What the terms take of chi-squared, and move of the scale."""
        terms = form_terms(remainder.fit, remainder.nodes, remainder.noise)
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


class RingLaw(AbstractRival):
    """Rings in r^p, which a disc of contact or a distortion imitates.

    The phase of the fringes from place to place tells them apart: five numbers (power, scale, centre, phase) miss it by
    less than the fit with all its parts does, where the rings are of that law. Of photographs of rings the power misses
    it by 1.6 times as much and more.
    """

    name = "law"

    def finding(self, remainder: Remainder) -> Finding | None:
        """Whether a power explains the phase better than the fit."""
        fit = remainder.fit
        bending = {*numbers_of(SEARCHED), *RADIAL}
        if not any(name in bending for name in fit.solution.problem.free) or fit.solution.problem.phase.exact is None:
            return None
        x, y, ahead, strength = phase_map(fit.reduced, fit.phase, _PLACES)
        good = strength > 0
        if np.count_nonzero(good) < 2 * _PLACES:
            return None
        root = np.sqrt(strength[good] / strength[good].mean())
        turns = (fit.solution.problem.phase.slopes_at(x, y, fit.numbers)[0] + ahead)[good]
        frame, numbers = fit.model.frame, Numbers(*fit.numbers)
        place = [(at[good] - middle) / frame.unit for at, middle in zip((x, y), frame.middle, strict=True)]
        power, missed = _nearest_power(place, turns, root, (float(numbers.centre_x), float(numbers.centre_y)))
        own = float(np.sqrt(np.mean((root * ahead[good]) ** 2)))
        if missed >= own or abs(power - _SPHERE) < _ANOTHER:
            return None
        words = Reason.RIVAL_RING_LAW(power=power, missed=missed, own=own)
        return Finding(self.name, own / missed, 1.0, "refusal", words)


def _nearest_power(
    place: list[np.ndarray], turns: np.ndarray, root: np.ndarray, centre: tuple[float, float]
) -> tuple[float, float]:
    """The power p of a + b |x - c|^p that is nearest to a phase [turns], and the root mean square by which it misses.

    `root`: of the weights, whose mean is 1.
    """

    def columns(at: np.ndarray) -> np.ndarray:
        r2 = (place[0] - at[0]) ** 2 + (place[1] - at[1]) ** 2 + _TINY
        logarithm = at[2] / 2 * np.log(r2)
        # Over the largest, as a power that runs away would be.
        return np.stack([root, root * np.exp(logarithm - logarithm.max())], axis=1)

    def misses(at: np.ndarray) -> np.ndarray:
        # Phase and scale are linear, and so found at once (Golub and Pereyra 1973).
        design = columns(at)
        return design @ np.linalg.lstsq(design, root * turns, rcond=None)[0] - root * turns

    fits = [optimize.least_squares(misses, (*centre, power), max_nfev=_STEPS) for power in _STARTS]
    best = min(fits, key=lambda fit: fit.cost)
    return float(best.x[2]), float(np.sqrt(2 * best.cost / len(turns)))
