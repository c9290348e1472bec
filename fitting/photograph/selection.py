"""The rings' model with all parts that may be there, averaged over sets of them.

No choice is made of warps of the map from image to object: they are averaged (`averaging`). A contact, which a search
finds, stays where a criterion calls for it (`contact_search`).
"""

from typing import NamedTuple

import numpy as np

from fitting.estimate import FEW, Fitted, tukey
from fitting.model import PARTS, SEARCHED, WARPS
from fitting.photo import Photograph
from fitting.photograph.averaging import Parts, sets_of, step_to_parts
from fitting.photograph.contact_search import (
    RunnerUp,
    is_open,
    may_be_seen,
    screened,
    search,
    with_or_without,
    without_promise,
)
from fitting.photograph.priors import Priors
from fitting.photograph.refit import with_parts, with_trial
from fitting.photograph.task import Task
from fitting.photograph.trials import Trial, Trials
from fitting.photograph.verdict import RefusedError
from fitting.reasons import Reason
from newtonjax.numerics import Statement

# Share of the variance that no photograph leaves so little of: the rounding of 8 bits alone leaves ten times as much.
_NOTHING = 1e-6
# Where parts change the phase by less than this [turns], a fit without them is linear in them; up to the second, a fit
# with them needs no other start.
_LINEAR, _NEAR = 0.01, 0.1
# Fewer fringes do not tell warps from another law of rings, cones too: they have them only where these are wished.
_TELLING = 3.0
# What is said of a part that was asked for and that no fit has.
UNFITTED = "asked for, but"


class Complete(NamedTuple):
    """A fit with all parts that may be there.

    - `sets` of warps that may be; `part_words`, `photograph`: as those of a `Choice`.
    - `runner_up`: a fit with a searched part more or less that is not ruled out, and how probable it is.
    """

    fit: Fitted
    sets: list[Parts]
    priors: Priors
    part_words: dict[str, str]
    photograph: Photograph
    runner_up: tuple[Fitted, float] | None = None


def with_needed_parts(
    task: Task, plain: Fitted, priors: Priors, refusal: Statement | None, before: Complete | None = None
) -> Complete:
    """A fit of the gap formula with all parts that may be there; `refusal`: why the plain fit gives no radius.

    A bench has parts of its own: then they are tried only where the rings are not found without them. What a grid says
    of the camera is there for certain. `before` as in `complete`.
    """
    are_too_few = refusal is not None and plain.orders < _TELLING and not any(task.wishes.values())
    if are_too_few or (task.scene is not None and refusal is None):
        return _without_parts(plain, task.photograph, priors)
    return complete(plain, task.photograph, task.wishes, priors, before)


def complete(
    plain: Fitted, photograph: Photograph, wishes: dict[str, bool], priors: Priors, before: Complete | None = None
) -> Complete:
    """The fit with all parts that are wished, or not excluded.

    `plain`: a fit without parts; `before`: the same on the same photograph with another curve. Raises RefusedError for
    fewer than three fringes that call for warps.
    """
    wishes = {part: wish for part, wish in wishes.items() if part in plain.model.parts}
    if 1 - plain.explained < _NOTHING and not any(wishes.values()):
        part_words = dict.fromkeys((*WARPS, *SEARCHED), "not tried: the residual is at rounding level")
        return _without_parts(plain, photograph, priors)._replace(part_words=part_words)
    warps = tuple(part for part in WARPS if part in plain.model.parts and wishes.get(part, True))
    are_few = plain.orders < FEW
    if are_few and warps:
        likelier = _bent_or_lit(plain, with_parts(plain, warps, plain.numbers, priors, is_near=False))
        if plain.orders < _TELLING and not any(wishes.get(part) for part in warps):
            if likelier is not plain:
                raise RefusedError(Reason.UNEVEN_LIGHT(orders=plain.orders, least=FEW), photograph)
            warps = ()
        plain = likelier
    wishes |= {part: False for part in WARPS if part not in warps}
    searched = [part for part in SEARCHED if is_open(part, wishes, plain, photograph)]
    if before is None:
        part_words = screened(plain, wishes)
    else:
        # Those that were not there with the other curve are not looked for again.
        absent = [part for part in SEARCHED if part not in before.fit.parts and not wishes.get(part)]
        part_words = {part: before.part_words[part] for part in absent if part in before.part_words}
    searched = [part for part in searched if part not in part_words]
    sets = sets_of(warps, [part for part in warps if wishes.get(part)])
    step = np.zeros_like(plain.numbers) if are_few else step_to_parts(plain, priors, sets)
    reach = float(np.abs(plain.solution.fields.slopes @ step).max()) if plain.converged else np.inf
    if not searched and reach < _NEAR:
        fit = plain if reach < _LINEAR else with_parts(plain, warps, plain.numbers + step, priors)
        return Complete(fit if fit.converged else plain, sets, priors, part_words, photograph)
    trials = Trials(plain, photograph, wishes, priors, None if before is None else before.fit)
    best = trials.bent() if reach > _LINEAR else trials.first
    searches = {}
    for part in searched:
        if not wishes.get(part):
            if not may_be_seen(part, plain, photograph, best.numbers):
                continue
            if reason := without_promise(part, best):
                part_words[part] = reason
                continue
        searches[part] = search(trials, part, best)
    best, runner_up, of_searches = with_or_without(best, searches, wishes, trials.reduced)
    part_words |= of_searches | _unfitted(wishes, best)
    fit = Complete(with_trial(trials, best, part_words), sets, priors, part_words, photograph)
    return fit if runner_up is None else _with_runner_up(fit, trials, runner_up)


def _bent_or_lit(plain: Fitted, bent: Fitted) -> Fitted:
    """Of few fringes, the fit with all warps where Schwarz's criterion calls for these however the light is counted.

    Warps take the place of uneven light, and light of a high degree that of warps: the warps' numbers have to pay for
    themselves both with the numbers of the light behind each fit and without. Either fit has the slopes of all parts
    that the mean over their sets is made of.
    """
    if not bent.converged or not plain.converged:
        return bent if bent.converged else plain
    weights = np.max([tukey(fit.left.value, fit.reduced) for fit in (plain, bent)], axis=0)
    misfits = [float((weights * fit.left.value**2).sum(dtype=float)) for fit in (plain, bent)]
    drop = (misfits[0] - misfits[1]) / max(misfits[1] / float(weights.sum(dtype=float)), 1e-300)
    warps = np.count_nonzero(bent.solution.problem.moving & ~plain.solution.problem.moving)
    spent = [np.count_nonzero(fit.matrix.active) for fit in (plain, bent)]
    return bent if drop > max(warps, spent[1] - spent[0]) * np.log(plain.reduced.pixels) else plain


def _with_runner_up(complete: Complete, trials: Trials, runner_up: RunnerUp) -> Complete:
    """The same with the robust fit of a trial that is not ruled out."""
    part, beside = runner_up.part, with_trial(trials, runner_up.trial, {})
    if not beside.converged or not complete.fit.converged or (part in beside.parts) == (part in complete.fit.parts):
        return complete
    chance = runner_up.chance if part in beside.parts else 1 - runner_up.chance
    words = f"{complete.part_words[part]}; probability {chance:.0%}"
    return complete._replace(part_words=complete.part_words | {part: words}, runner_up=(beside, runner_up.chance))


def _without_parts(plain: Fitted, photograph: Photograph, priors: Priors) -> Complete:
    """A fit that no part is tried beside."""
    return Complete(plain, sets_of(()), priors, {}, photograph)


def _unfitted(wishes: dict[str, bool], best: Trial) -> dict[str, str]:
    """What is said of the parts that were asked for and that no trial has."""
    absent = [part for part, wish in wishes.items() if wish and part not in best.parts]
    return {part: f"{UNFITTED} {PARTS[part].unfitted}" for part in absent}
