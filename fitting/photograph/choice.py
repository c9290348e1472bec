"""The fit with the most probable set of parts, and the mean over all sets of them."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from fitting.estimate import FEW, Fitted, bends, normal_matrix, problem_of, residuals_of, solve, tukey
from fitting.model import AXIS, PARTS, SEARCHED, WARPS
from fitting.parameters import NUMBERS, Numbers, slots_of
from fitting.photo import Photograph, noise_variance
from fitting.photograph.averaging import Average, Averaging, Member, variance_of
from fitting.photograph.priors import CUT
from fitting.photograph.refit import with_parts, with_trial
from fitting.photograph.selection import Complete
from fitting.photograph.trials import Trial, Trials, without

# The axis of a picture that may be cut counts where it may move the phase by so much [turns].
_AXIS_SEEN = 0.02
# Beyond this change of the phase [turns] a fit's linear model does not reach the mean over sets of parts; rounds in
# which the fit is then made anew.
_LINEAR, _MOST_ROUNDS = 0.1, 3
_FORM = "lens_form"
# Residuals that neighbours share less than this hold no form. Share of the structure that the form's terms take, from
# which on they are tried: a form beyond half a turn, of which the terms are not linear, 0.04 and more.
_SHARED, _TAKEN = 10.0, 0.03
# With a wide prior neighbours share so much less, of such rings 25 times less and more, of photographs 5 at most.
_LESS = 8.0
# Standard deviations that the terms' prior may have [turns at the rim], from the data.
_SMALLEST, _LARGEST, _ROUNDS = 1e-3, 0.5, 8
# Terms of which less than this is left beside the model's own numbers are these numbers.
_ALIKE = 1e-6
_CURVATURE = NUMBERS.index("curvature")


class Choice(NamedTuple):
    """A fit with the most probable set of parts, and what the mean over all sets is made of.

    - `part_words`: by part, how probable it is, or why it is not there; `photograph`: on which the fit was made.
    - `undecided`: fits that are not ruled out: what the difference is, and the other fit.
    - `averaging`: None where no part was averaged; `place`: of its member that the fit is of; `shift`: from the fit's
      numbers to the mean over all sets; `ratio`: of the data's variance of the first number, by clusters of residuals,
      to what the correlation of neighbours says.
    """

    found: Fitted
    part_words: dict[str, str]
    photograph: Photograph
    undecided: tuple[tuple[str, Fitted], ...] = ()
    averaging: Averaging | None = None
    place: int = 0
    shift: np.ndarray | None = None
    ratio: float = 1.0


class Terms(NamedTuple):
    """Terms of a form beside the fit: its values [turns at the rim], and what they do.

    - `chi2`: what each takes of chi-squared in the mean, in variances; `share`: of the structure that all take.
    - `shift`: relative change of the fringe scale with them; `shift_sd`: what they leave uncertain of it.
    """

    values: Float[np.ndarray, " terms"]
    chi2: float
    shift: float
    shift_sd: float
    share: float


def averaged(complete: Complete) -> Choice:
    """The fit with the most probable set of parts, and what the mean over all sets is made of.

    Members of that mean are the fit, another one for a picture that may be cut, and a runner-up of a search.
    """
    complete = _with_wide_form(complete)
    fit, photograph = complete.fit, complete.photograph
    members = [Member(fit, complete.priors, complete.sets)]
    if fit.converged and complete.priors.may_be_cut and _axis_counts(fit):
        elsewhere = Trials(fit, photograph, {}, complete.priors.cut(), None)
        wider = with_trial(elsewhere, elsewhere.beside(elsewhere.first), {})
        members.append(Member(wider, elsewhere.priors, complete.sets))
    if complete.runner_up is not None:
        beside, chance = complete.runner_up
        members = [replace(member, chance=1 - chance) for member in members]
        members.append(Member(beside, complete.priors, complete.sets, chance=chance))
    choice = Choice(fit, complete.part_words, photograph)
    return _averaged(choice, [member for member in members if member.fit.converged])


def _with_wide_form(complete: Complete) -> Complete:
    """The same with a lens of any form where that is what is left over, else as it is.

    Half a fringe of coma is 25 standard deviations of the usual prior. Against residuals that err together that prior
    holds the form at zero, and a distortion about an axis off the middle, which has coma too, takes its place.
    """
    fit = complete.fit
    largest = max(complete.sets, key=len)
    if (
        not fit.model.holds_turns
        or _FORM not in largest
        or not fit.converged
        or fit.orders < FEW
        or fit.correlation < _SHARED
    ):
        return complete
    terms = form_terms(
        fit, _from_centre(fit), noise_variance(fit.reduced.inverse_sd * fit.left.value, fit.left.weights > 0)
    )
    if terms is None or terms.share < _TAKEN:
        return complete
    wishes = {part: False for part in WARPS if part not in largest}
    wishes |= dict.fromkeys(min(complete.sets, key=len), True)
    trials = Trials(fit, complete.photograph, wishes, complete.priors.of_any_form(), None)
    wider = with_trial(trials, _trial_with_form(trials), {})
    if _FORM not in wider.parts or not wider.converged or not _explains(wider, fit):
        return complete
    return complete._replace(fit=wider, priors=trials.priors, runner_up=None)


def _trial_with_form(trials: Trials) -> Trial:
    """The best trial with all warps: without searched parts, and with those that the fit has."""
    bent = trials.bent()
    searched = tuple(part for part in trials.fitted.parts if part in SEARCHED)
    if not searched:
        return bent
    beside = trials.fit((*bent.parts, *searched), trials.fitted.numbers)
    return beside if trials.is_sane(beside) and trials.cost(beside) < trials.cost(bent) else bent


def _explains(wider: Fitted, fit: Fitted) -> bool:
    """Whether neighbours share far less of what the wider fit leaves over, which is less on the same pixels."""
    weights = np.maximum(*(tukey(of.left.value, of.reduced) for of in (wider, fit)))
    squares = [float((weights * of.left.value**2).sum(dtype=float)) for of in (wider, fit)]
    return squares[0] < squares[1] and wider.correlation * _LESS < fit.correlation


def _from_centre(fit: Fitted) -> tuple[np.ndarray, np.ndarray]:
    """Places of the grid's nodes from the rings' centre [half diagonals]."""
    frame, numbers = fit.model.frame, Numbers(*fit.numbers)
    x, y = ((at - m) / frame.unit for at, m in zip(fit.reduced.grid.nodes, frame.middle, strict=True))
    return x - float(numbers.centre_x), y - float(numbers.centre_y)


def form_terms(fit: Fitted, nodes: tuple[np.ndarray, ...], noise: float) -> Terms | None:
    """The terms of a form that a fit leaves over; None where the model has them all.

    `nodes`: places (x, y) of the grid's nodes from the rings' centre; `noise`: of a block, white, per unit weight.
    """
    crossed, among, gradient = bends(fit.solution, _phases(nodes))
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
    taken = float(slope @ np.linalg.solve(information + np.eye(len(slope)) / _LARGEST**2, slope))
    structure = fit.chi2 - noise * fit.weight
    of_structure = taken * white / structure if structure > 0 else 0.0
    of_scale = np.zeros((len(matrix.values), len(slope)))
    of_scale[matrix.active] = -share[:, free]
    curvature = float(Numbers(*fit.numbers).curvature)
    by_terms = of_scale[_CURVATURE] / (abs(curvature) if fit.model.holds_turns else 1 + curvature)
    uncertain = float(by_terms @ covariance @ by_terms)
    chi2 = taken / fit.correlation / len(values)
    return Terms(values, chi2, float(by_terms @ values), float(np.sqrt(max(uncertain, 0.0))), of_structure)


def _phases(nodes: tuple[np.ndarray, ...]) -> np.ndarray:
    """The terms at the grid's nodes, each at most one turn at the rim [nodes, terms]."""
    x, y = nodes
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


def _axis_counts(fit: Fitted) -> bool:
    """Whether it matters where the camera's axis is in a picture that may be cut."""
    slopes = fit.solution.fields.slopes[:, slots_of(AXIS)]
    return "distortion" in fit.parts and float(np.abs(slopes).max()) * CUT > _AXIS_SEEN


def _averaged(choice: Choice, members: list[Member], rounds: int = _MOST_ROUNDS) -> Choice:
    """The choice with the best of its members, and the mean over the sets of all of them.

    `members`: fits with all that may be there, made anew in so many rounds where the mean is not linear in them.
    """
    if not members:
        return choice
    weights = np.max([tukey(member.fit.left.value, member.fit.reduced) for member in members], axis=0)
    misfits = [float((weights * member.fit.left.value**2).sum(dtype=float)) for member in members]
    members = [replace(member, misfit=misfit) for member, misfit in zip(members, misfits, strict=True)]
    warps = max(members[0].sets, key=len)
    if not warps and len(members) == 1:
        return choice._replace(found=members[0].fit)
    averaging = Averaging(tuple(members))
    variance = variance_of(members[int(np.argmin(misfits))].fit)[0]
    average = averaging.mean(variance)
    best_set, place, numbers = average.best
    member = members[place]
    change = member.fit.solution.fields.slopes @ (numbers - member.fit.numbers)
    if rounds and np.abs(change).max() > _LINEAR:
        nearer = with_parts(member.fit, member.parts, numbers, member.priors, variance)
        if nearer.converged and nearer.chi2 < member.fit.chi2:
            members[place] = replace(member, fit=nearer)
            return _averaged(choice, members, rounds - 1)
    parts = tuple(part for part in PARTS if part in best_set or (part in member.fit.parts and part not in WARPS))
    fit = member.fit if parts == member.fit.parts else _restricted(member, parts, numbers, variance)
    if not fit.converged:
        fit = with_parts(choice.found, parts, numbers, member.priors)
    certain = min(members[0].sets, key=len)
    part_words = {
        part: member.priors.words(part) if part in certain else f"probability {_share(average, part):.0%}"
        for part in WARPS
        if part in warps
    }
    return choice._replace(found=fit, averaging=averaging, place=place, part_words=part_words | choice.part_words)


def _share(average: Average, part: str) -> float:
    """The weight of all sets with a part."""
    return sum(weight for parts, weight in average.weights.items() if part in parts)


def _restricted(member: Member, parts: tuple[str, ...], numbers: np.ndarray, variance: float) -> Fitted:
    """The fit with a member's weights and fewer parts, from the numbers that its normal matrix says."""
    fit = member.fit
    prior = member.priors.of(parts, numbers, variance)
    problem = problem_of(fit.model, fit.fixed, parts, fit.shape, prior)
    weighted = fit.reduced if fit.scale is None else replace(fit.reduced, weights=fit.left.weights)
    solution = solve(problem, weighted, without(numbers, parts))
    left = residuals_of(solution, fit.reduced, fit.scale)
    return replace(fit, solution=solution, left=left, parts=parts, matrix=normal_matrix(solution))
