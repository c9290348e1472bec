"""The rings' model with all parts that may be there, averaged over sets of them.

No choice is made of warps of the map from image to object: they are averaged (`averaging`). A contact, which a search
finds, stays where a criterion calls for it (`contact_search`).
"""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from fitting.estimate import (
    FEW,
    Fitted,
    normal_matrix,
    problem_of,
    residuals_of,
    robust_fit,
    solve,
    stay,
    tukey,
)
from fitting.model import AXIS, PARTS, SEARCHED, WARPS
from fitting.parameters import slots_of
from fitting.photo import Photograph, reduce
from fitting.photograph.averaging import Averaging, Member, Parts, sets_of, step_to_parts
from fitting.photograph.clusters import data_variance, scatter
from fitting.photograph.contact_search import (
    Rival,
    is_open,
    may_be_seen,
    screened,
    search,
    with_or_without,
    without_promise,
)
from fitting.photograph.priors import CUT, Priors
from fitting.photograph.trials import Trial, Trials, without
from fitting.photograph.variance import variance_of

# Share of the variance that no photograph leaves so little of: the rounding of 8 bits alone leaves ten times as much.
_NOTHING = 1e-6
# Where parts change the phase by less than this [turns], a fit without them is linear in them; up to the second, a fit
# with them needs no other start.
_LINEAR, _NEAR = 0.01, 0.1
# The axis of a picture that may be cut counts where it may move the phase by so much [turns].
_AXIS_SEEN = 0.02
# What is said of a part that was asked for and that no fit has.
UNFITTED = "asked for, but"


class Choice(NamedTuple):
    """A fit with the most probable set of parts, and what the mean over all sets is made of.

    - `evidence`: by part, how probable it is, or why it is not there; `photograph`: on which the fit was made.
    - `rivals`: fits that are not ruled out: what the difference is, and the other fit.
    - `averaging`: None where no part was averaged; `place`: of its member that the fit is of; `shift`: from the fit's
      numbers to the mean over all sets; `ratio`: of the data's variance of the first number, by clusters of residuals,
      to what the correlation of neighbours says.
    """

    found: Fitted
    evidence: dict[str, str]
    photograph: Photograph
    rivals: tuple[tuple[str, Fitted], ...] = ()
    averaging: Averaging | None = None
    place: int = 0
    shift: np.ndarray | None = None
    ratio: float = 1.0

    @property
    def priors(self) -> dict[str, dict[str, Any]]:
        """What was known of the parts that may be there, for a report."""
        if self.averaging is None:
            return {}
        member = self.averaging.members[self.place]
        parts = {*max(member.sets, key=len), *self.found.parts}
        return member.priors.table(part for part in PARTS if part in parts)

    @property
    def answer(self) -> Fitted:
        """The fit moved to the mean over all sets, for its numbers alone: that is no optimum."""
        if self.shift is None:
            return self.found
        solution = self.found.solution
        numbers = solution.numbers + self.shift
        return replace(self.found, solution=stay(solution.problem, solution.normal, numbers, solution.converged))


class Complete(NamedTuple):
    """A fit with all parts that may be there.

    - `sets` of warps that may be; `evidence`, `photograph`: as those of a `Choice`.
    - `rival`: a fit with a searched part more or less that is not ruled out, and how probable it is.
    """

    fit: Fitted
    sets: list[Parts]
    priors: Priors
    evidence: dict[str, str]
    photograph: Photograph
    rival: tuple[Fitted, float] | None = None


def complete(
    plain: Fitted, photograph: Photograph, wishes: dict[str, bool], priors: Priors, before: Complete | None = None
) -> Complete:
    """The fit with all parts that are wished, or not excluded.

    `plain`: a fit without parts; `before`: the same on the same photograph with another curve. A few fringes have
    warps only where these are wished: they would imitate whatever so few leave over.
    """
    wishes = {part: wish for part, wish in wishes.items() if part in plain.model.parts}
    if 1 - plain.explained < _NOTHING and not any(wishes.values()):
        evidence = dict.fromkeys((*WARPS, *SEARCHED), "not tried: the residual is at rounding level")
        return without_parts(plain, photograph, priors)._replace(evidence=evidence)
    are_many = plain.orders >= FEW
    warps = tuple(part for part in WARPS if part in plain.model.parts and wishes.get(part, are_many))
    wishes |= {part: False for part in WARPS if part not in warps}
    searched = [part for part in SEARCHED if is_open(part, wishes, plain, photograph)]
    evidence = screened(plain, wishes) if before is None else _searched_before(before, wishes)
    searched = [part for part in searched if part not in evidence]
    sets = sets_of(warps, [part for part in warps if wishes.get(part)])
    step = step_to_parts(plain, priors, sets)
    reach = float(np.abs(plain.solution.fields.slopes @ step).max()) if plain.converged else np.inf
    if not searched and reach < _NEAR:
        fit = plain if reach < _LINEAR else _with_parts(plain, warps, plain.numbers + step, priors)
        return Complete(fit if fit.converged else plain, sets, priors, evidence, photograph)
    trials = Trials(plain, photograph, wishes, priors, None if before is None else before.fit)
    best = trials.bent() if reach > _LINEAR else trials.first
    searches = {}
    for part in searched:
        if not wishes.get(part):
            if not may_be_seen(part, plain, photograph, best.numbers):
                continue
            if reason := without_promise(part, best):
                evidence[part] = reason
                continue
        searches[part] = search(trials, part, best)
    best, rival, of_searches = with_or_without(best, searches, wishes, trials.reduced)
    evidence |= of_searches | _unfitted(wishes, best)
    fit = Complete(_with_trial(trials, best, evidence), sets, priors, evidence, photograph)
    return fit if rival is None else _with_rival(fit, trials, rival)


def _with_rival(complete: Complete, trials: Trials, rival: Rival) -> Complete:
    """The same with the robust fit of a trial that is not ruled out."""
    part, beside = rival.part, _with_trial(trials, rival.trial, {})
    if not beside.converged or not complete.fit.converged or (part in beside.parts) == (part in complete.fit.parts):
        return complete
    chance = rival.chance if part in beside.parts else 1 - rival.chance
    words = f"{complete.evidence[part]}; probability {chance:.0%}"
    return complete._replace(evidence=complete.evidence | {part: words}, rival=(beside, rival.chance))


def with_another_curve(before: Complete, photograph: Photograph) -> Complete | None:
    """The same on a photograph whose codes follow the light by another curve; None where it needs a new search.

    A contact may have come with the curve.
    """
    fit = before.fit
    if not fit.converged or set(SEARCHED) & set(fit.parts) or before.rival is not None:
        return None
    reduced = reduce(photograph, fit.reduced.grid.block, dtype=fit.reduced.light.dtype.type)
    used = reduced.used & fit.reduced.used
    # Priors weigh against the image by its noise over its fringes, which the curve leaves as they are.
    growth = float(reduced.light[used].var() / fit.reduced.light[used].var())
    curved = replace(fit, reduced=reduced)
    fit = _with_parts(curved, fit.parts, fit.numbers, before.priors, variance_of(fit)[0] * growth)
    return before._replace(fit=fit, photograph=photograph) if fit.converged else None


def without_parts(plain: Fitted, photograph: Photograph, priors: Priors) -> Complete:
    """A fit that no part is tried beside."""
    return Complete(plain, sets_of(()), priors, {}, photograph)


def averaged(complete: Complete) -> Choice:
    """The fit with the most probable set of parts, and what the mean over all sets is made of."""
    fit, photograph = complete.fit, complete.photograph
    members = [Member(fit, complete.priors, complete.sets)]
    if fit.converged and complete.priors.may_be_cut and _axis_counts(fit):
        elsewhere = Trials(fit, photograph, {}, complete.priors.cut(), None)
        wider = _with_trial(elsewhere, elsewhere.beside(elsewhere.first), {})
        members.append(Member(wider, elsewhere.priors, complete.sets))
    if complete.rival is not None:
        beside, chance = complete.rival
        members = [replace(member, chance=1 - chance) for member in members]
        members.append(Member(beside, complete.priors, complete.sets, chance=chance))
    choice = Choice(fit, complete.evidence, photograph)
    return _averaged(choice, [member for member in members if member.fit.converged])


def _searched_before(before: Complete, wishes: dict[str, bool]) -> dict[str, str]:
    """What another curve has said of the parts that a search finds: those that were not there are not looked for."""
    absent = [part for part in SEARCHED if part not in before.fit.parts and not wishes.get(part)]
    return {part: before.evidence[part] for part in absent if part in before.evidence}


def _axis_counts(fit: Fitted) -> bool:
    """Whether it matters where the camera's axis is in a picture that may be cut."""
    slopes = fit.solution.fields.slopes[:, slots_of(AXIS)]
    return "distortion" in fit.parts and float(np.abs(slopes).max()) * CUT > _AXIS_SEEN


def _averaged(choice: Choice, members: list[Member]) -> Choice:
    """The fit with the most probable set of warps, and what the mean over all sets is made of.

    `members`: fits with all that may be there.
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
    parts = tuple(part for part in PARTS if part in best_set or (part in member.fit.parts and part not in WARPS))
    fit = member.fit if parts == member.fit.parts else _restricted(member, parts, numbers, variance)
    if not fit.converged:
        fit = _with_parts(choice.found, parts, numbers, member.priors)
    certain = min(members[0].sets, key=len)
    evidence = {
        part: member.priors.words(part) if part in certain else f"probability {average.share(part):.0%}"
        for part in WARPS
        if part in warps
    }
    return choice._replace(found=fit, averaging=averaging, place=place, evidence=evidence | choice.evidence)


def _restricted(member: Member, parts: tuple[str, ...], numbers: np.ndarray, variance: float) -> Fitted:
    """The fit with a member's weights and fewer parts, from the numbers that its normal matrix says."""
    fit = member.fit
    prior = member.priors.of(parts, numbers, variance)
    problem = problem_of(fit.model, fit.fixed, parts, fit.shape, prior)
    weighted = fit.reduced if fit.scale is None else replace(fit.reduced, weights=fit.left.weights)
    solution = solve(problem, weighted, without(numbers, parts))
    left = residuals_of(solution, fit.reduced, fit.scale)
    return replace(fit, solution=solution, left=left, parts=parts, matrix=normal_matrix(solution))


def at_the_mean(choice: Choice) -> Choice:
    """The choice with the mean over all sets of parts, at its fit as it has become since."""
    fit, averaging = choice.found, choice.averaging
    if averaging is None or not fit.converged:
        return choice
    variance = variance_of(fit)[0]
    of_data = max(data_variance(fit, variance), 1e-300)
    warps = frozenset(part for part in fit.parts if part in WARPS)
    average = averaging.mean(variance)
    of_warps = averaging.mean(variance, lambda parts: parts == warps).best[2]
    shift = np.where(fit.solution.problem.moving, average.numbers - of_warps, 0.0)
    return choice._replace(shift=shift, ratio=scatter(fit, of_data) / of_data)


def _with_trial(trials: Trials, best: Trial, evidence: dict[str, str]) -> Fitted:
    """The robust fit with a trial's parts; where it does not converge, without the last of the warps."""
    plain, parts, numbers = trials.fitted, best.parts, best.numbers
    variance = variance_of(plain)[0] * trials.variance_of(best) / trials.variance
    while True:
        fit = _with_parts(plain, parts, numbers, trials.priors, variance)
        if not parts:
            # The trials may have met rings that the plain fit has missed.
            better = fit.converged and fit.explained > plain.explained
            return fit if better or not plain.converged else plain
        if fit.converged:
            return fit
        warps = [part for part in WARPS if part in parts]
        last = warps[-1] if warps else parts[-1]
        evidence[last] = "dropped: least squares did not converge with it"
        parts = tuple(part for part in parts if part != last)
        numbers = without(numbers, parts)


def _with_parts(
    plain: Fitted, parts: tuple[str, ...], numbers: np.ndarray, priors: Priors, variance: float | None = None
) -> Fitted:
    """The robust fit with parts; `variance`: of the light per unit weight, that of the plain fit unless given."""
    variance = variance_of(plain)[0] if variance is None else variance
    prior = priors.of(parts, numbers, variance)
    return robust_fit(plain.model, plain.reduced, [numbers], plain.fixed, parts, prior, is_near=True)


def _unfitted(wishes: dict[str, bool], best: Trial) -> dict[str, str]:
    """What is said of the parts that were asked for and that no trial has."""
    absent = [part for part, wish in wishes.items() if wish and part not in best.parts]
    return {part: f"{UNFITTED} {PARTS[part].unfitted}" for part in absent}
