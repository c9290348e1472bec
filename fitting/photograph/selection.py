"""The rings' model with all parts that may be there, averaged over sets of them.

No choice is made of warps of the map from image to object: they are averaged (`averaging`). A contact, which a search
finds, stays where a criterion calls for it (`contact_search`).
"""

from typing import NamedTuple

import numpy as np

from fitting.estimate import (
    FEW,
    Fitted,
)
from fitting.model import PARTS, SEARCHED, WARPS
from fitting.photo import Photograph
from fitting.photograph.averaging import Parts, sets_of, step_to_parts
from fitting.photograph.contact_search import (
    Rival,
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
from newtonjax.numerics import Statement

# Share of the variance that no photograph leaves so little of: the rounding of 8 bits alone leaves ten times as much.
_NOTHING = 1e-6
# Where parts change the phase by less than this [turns], a fit without them is linear in them; up to the second, a fit
# with them needs no other start.
_LINEAR, _NEAR = 0.01, 0.1
# What is said of a part that was asked for and that no fit has.
UNFITTED = "asked for, but"


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


def with_needed_parts(
    task: Task, plain: Fitted, priors: Priors, refusal: Statement | None, before: Complete | None = None
) -> Complete:
    """A fit of the gap formula with all parts that may be there; `refusal`: why the plain fit gives no radius.

    A bench has parts of its own: then they are tried only where the rings are not found without them. What a grid says
    of the camera is there for certain. `before` as in `complete`.
    """
    photograph, wishes = task.photograph, task.wishes
    are_few = refusal is not None and plain.orders < FEW and not any(wishes.values())
    if are_few or (task.scene is not None and refusal is None):
        return _without_parts(plain, photograph, priors)
    return complete(plain, photograph, wishes, priors, before)


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
        return _without_parts(plain, photograph, priors)._replace(evidence=evidence)
    are_many = plain.orders >= FEW
    warps = tuple(part for part in WARPS if part in plain.model.parts and wishes.get(part, are_many))
    wishes |= {part: False for part in WARPS if part not in warps}
    searched = [part for part in SEARCHED if is_open(part, wishes, plain, photograph)]
    if before is None:
        evidence = screened(plain, wishes)
    else:
        # Those that were not there with the other curve are not looked for again.
        absent = [part for part in SEARCHED if part not in before.fit.parts and not wishes.get(part)]
        evidence = {part: before.evidence[part] for part in absent if part in before.evidence}
    searched = [part for part in searched if part not in evidence]
    sets = sets_of(warps, [part for part in warps if wishes.get(part)])
    step = step_to_parts(plain, priors, sets)
    reach = float(np.abs(plain.solution.fields.slopes @ step).max()) if plain.converged else np.inf
    if not searched and reach < _NEAR:
        fit = plain if reach < _LINEAR else with_parts(plain, warps, plain.numbers + step, priors)
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
    fit = Complete(with_trial(trials, best, evidence), sets, priors, evidence, photograph)
    return fit if rival is None else _with_rival(fit, trials, rival)


def _with_rival(complete: Complete, trials: Trials, rival: Rival) -> Complete:
    """The same with the robust fit of a trial that is not ruled out."""
    part, beside = rival.part, with_trial(trials, rival.trial, {})
    if not beside.converged or not complete.fit.converged or (part in beside.parts) == (part in complete.fit.parts):
        return complete
    chance = rival.chance if part in beside.parts else 1 - rival.chance
    words = f"{complete.evidence[part]}; probability {chance:.0%}"
    return complete._replace(evidence=complete.evidence | {part: words}, rival=(beside, rival.chance))


def _without_parts(plain: Fitted, photograph: Photograph, priors: Priors) -> Complete:
    """A fit that no part is tried beside."""
    return Complete(plain, sets_of(()), priors, {}, photograph)


def _unfitted(wishes: dict[str, bool], best: Trial) -> dict[str, str]:
    """What is said of the parts that were asked for and that no trial has."""
    absent = [part for part, wish in wishes.items() if wish and part not in best.parts]
    return {part: f"{UNFITTED} {PARTS[part].unfitted}" for part in absent}
