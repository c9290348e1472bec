"""The fit with the most probable set of parts, and the mean over all sets of them."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from fitting.estimate import Fitted, normal_matrix, problem_of, residuals_of, solve, tukey
from fitting.model import AXIS, PARTS, WARPS
from fitting.parameters import slots_of
from fitting.photo import Photograph
from fitting.photograph.averaging import Average, Averaging, Member, variance_of
from fitting.photograph.priors import CUT
from fitting.photograph.refit import with_parts, with_trial
from fitting.photograph.selection import Complete
from fitting.photograph.trials import Trials, without

# The axis of a picture that may be cut counts where it may move the phase by so much [turns].
_AXIS_SEEN = 0.02
# Beyond this change of the phase [turns] a fit's linear model does not reach the mean over sets of parts; rounds in
# which the fit is then made anew.
_LINEAR, _MOST_ROUNDS = 0.1, 3


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


def averaged(complete: Complete) -> Choice:
    """The fit with the most probable set of parts, and what the mean over all sets is made of.

    Members of that mean are the fit, another one for a picture that may be cut, and a runner-up of a search.
    """
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
