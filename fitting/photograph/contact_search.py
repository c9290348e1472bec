"""Parts that a search finds, as a contact: whether one is there, by Schwarz's criterion (1978).

Chi-squared is counted in units of the variance that blocks of neighbours show, and so many independent pixels are
there.
"""

from collections.abc import Mapping, Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np

from fitting.estimate import Fitted, bends, fringe_correlation, normal_matrix, score_drop, tukey
from fitting.model import PARTS, PRICES, SEARCHED, anchors_of
from fitting.parameters import Numbers
from fitting.photo import Photograph, Reduced
from fitting.photograph.trials import Trial, Trials

# Steps of each disc's fit before the best ones go on, and how many these are: false optima are near. One that then has
# so many times the least chi-squared is on none of the best.
_FIRST_STEPS, _FURTHER, _FALSE = 3, 4, 2.0
# What a score test says that a part takes of chi-squared, at least, of one that is looked for: discs take up to twice
# as much as their tangent says (of made pictures with weak ones 15 for 11, 56 for 31), and all that photographs have
# are far above (49 and more). Where the warps have bent to hide a disc, the residuals that neighbours share tell: in
# units of a variance without them it takes 147 and more (a red channel, pieces of a photograph), and 67 at most of
# photographs without a disc, but for one.
_SEEN, _SEEN_ALONE = 10.0, 100.0
# Odds of exp(this / 2) rule a fit out.
_NEAR = 10.0


def screened(plain: Fitted, wishes: Mapping[str, bool]) -> dict[str, str]:
    """The searched parts that need no search, and why: a score test sees no use for them."""
    judge, part_words = _Judge([plain], plain.reduced), {}
    for part in (part for part in SEARCHED if part in plain.model.parts and not wishes.get(part)):
        drop = max(_drops(plain, part)) / judge.variance
        # Whether residuals are correlated or not.
        if drop * judge.inflation < PRICES[part] * judge.penalty:
            part_words[part] = _words(False, None, drop - PRICES[part] * judge.penalty)
    return part_words


def without_promise(part: str, trial: Trial) -> str | None:
    """Why a search of a part beside a trial with all warps can come to nothing, from its moments; None where it may."""
    judge = _Judge([trial], trial.reduced)
    drop = max(_drops(trial, part)) / judge.variance
    may_be_there = drop > _SEEN or drop * judge.inflation > _SEEN_ALONE
    return None if may_be_there else _words(False, None, drop - PRICES[part] * judge.penalty)


def is_open(part: str, wishes: Mapping[str, bool], plain: Fitted, photograph: Photograph) -> bool:
    """Whether a searched part is wished, or neither excluded nor out of sight."""
    return part in plain.model.parts and wishes.get(part, may_be_seen(part, plain, photograph, plain.numbers))


def may_be_seen(part: str, plain: Fitted, photograph: Photograph, numbers: np.ndarray) -> bool:
    """Whether what it anchors is not held, and the rings' centre is in the field where it is seen there only."""
    if not set(PARTS[part].anchors) <= set(plain.solution.problem.free):
        return False
    by_name, frame = Numbers(*numbers), plain.model.frame
    offsets = (by_name.centre_x, by_name.centre_y)
    column, row = (round(middle + at * frame.unit) for middle, at in zip(frame.middle, offsets, strict=True))
    rows, columns = photograph.lit.shape
    return not PARTS[part].at_centre or (0 <= row < rows and 0 <= column < columns)


def search(trials: Trials, part: str, without: Trial) -> list[Trial]:
    """Fits with a part beside another fit's, at its anchor, or one where it is wished with what lifts that.

    An anchor makes a ladder of optima. Without it that ladder is gone, so the search goes there first, from several
    starts, and in the end from there and from the nearest rung.
    """
    freed = SEARCHED[part].name
    parts = (*without.parts, part, freed)
    starts = [np.array(start) for start in PARTS[part].starts(Numbers(*trials.fitted.numbers))]
    if trials.before is not None and part in trials.before.parts:
        starts = [trials.before.numbers]
    first = sorted((trials.fit(parts, at, _FIRST_STEPS) for at in starts), key=lambda fit: fit.solution.chi2)
    near = [fit for fit in first[:_FURTHER] if fit.solution.chi2 < _FALSE * first[0].solution.chi2]
    finished: list[Trial] = []
    for at in near:
        numbers = Numbers(*at.numbers)
        if not any(PARTS[part].is_beside(numbers, Numbers(*fit.numbers)) for fit in finished):
            finished.append(trials.fit(parts, at.numbers))
    finished = [fit for fit in finished if trials.is_sane(fit)]
    if not finished:
        return []
    loose = min(finished, key=lambda fit: fit.solution.chi2)
    turn = 0.5 if float(loose.solution.point.modulus.mean()) < 0 else 0.0
    if trials.wishes.get(freed):
        return [loose]
    rung = np.array(PARTS[part].anchored(Numbers(*loose.numbers), trials.priors.contact_phase, turn))
    # A fit without a disc leaves so much over that an anchor weighed against it would hold the phase off the data's.
    variance = trials.variance_of(loose)
    tight = [trials.fit((*without.parts, part), start, variance=variance) for start in (rung, loose.numbers)]
    return [fit for fit in tight if trials.is_sane(fit)]


class RunnerUp(NamedTuple):
    """The trial that was not accepted, with a part or without it, and how probable it is."""

    trial: Trial
    part: str
    chance: float


def with_or_without(
    without: Trial, searches: Mapping[str, list[Trial]], wishes: Mapping[str, bool], reduced: Reduced
) -> tuple[Trial, RunnerUp | None, dict[str, str]]:
    """The best of the fits with searched parts, or the one without; which of them is not ruled out; and why, by part.

    The criterion's margin in which a part is accepted is the price of its search: half of what it is better by beyond
    that is the logarithm of the odds.
    """
    judge = _Judge([without, *chain(*searches.values())], reduced)
    accepted, runner_up, part_words = without, None, {}
    for part, fits in searches.items():
        if not fits:
            continue
        best, is_wished = min(fits, key=judge.criterion), wishes.get(part)
        gain = judge.criterion(accepted) - judge.criterion(best)
        margin = gain - PARTS[part].clear
        if abs(margin) < _NEAR and not is_wished:
            runner_up = RunnerUp(accepted if margin > 0 else best, part, 1 / (1 + float(np.exp(abs(margin) / 2))))
        if is_wished or margin > 0:
            accepted = best
        part_words[part] = _words(part in accepted.parts, is_wished, gain)
        if part in accepted.parts and wishes.get(lifting := SEARCHED[part].name):
            part_words[lifting] = f"asked for: with {part}"
    return accepted, runner_up, part_words


def _drops(fit: Fitted | Trial, part: str) -> list[float]:
    """By how much chi-squared would drop with a part, for each of its probes."""
    solution, columns = fit.solution, []
    for probe in PARTS[part].probes:
        numbers = np.array(Numbers(*fit.numbers)._replace(**probe))
        columns.append(solution.problem.phase.fields(numbers).phase - solution.fields.phase)
    crossed, among, gradient = bends(solution, np.stack(columns, axis=1))
    matrix = normal_matrix(solution)
    return [score_drop(matrix, crossed[:, [k]], among[[k]][:, [k]], gradient[[k]]) for k in range(len(columns))]


class _Judge:
    """Chi-squared in units of the correlated variance, and the criterion's price of a number.

    Every fit is judged on the same pixels: a pixel counts as much as the fit that explains it best lets it.
    """

    def __init__(self, fits: Sequence[Fitted | Trial], reduced: Reduced):
        self.weights = np.max([tukey(fit.left.value, reduced) for fit in fits], axis=0)
        best = min(fits, key=self._square)
        self.inflation = fringe_correlation(reduced.grid, best.left._replace(weights=self.weights))
        pixels = float(self.weights.sum(dtype=float))
        self.variance = max(self._square(best) / pixels * self.inflation, 1e-300)
        self.penalty = float(np.log(max(pixels / self.inflation, 2.0)))

    def _square(self, fit: Fitted | Trial) -> float:
        return float((self.weights * fit.left.value**2).sum(dtype=float))

    def criterion(self, fit: Fitted | Trial) -> float:
        numbers = sum(PRICES[part] for part in fit.parts) * self.penalty
        return self._square(fit) / self.variance + numbers + _anchored(fit)


def _anchored(fit: Fitted | Trial) -> float:
    """What the anchors of a fit cost: squares of deviations."""
    centre = Numbers(*fit.solution.problem.pull[0])
    offsets = (
        (getattr(Numbers(*fit.numbers), name) - getattr(centre, name), sd) for name, sd in anchors_of(fit.parts).items()
    )
    return float(sum((offset / sd) ** 2 for offset, sd in offsets))


def _words(is_there: bool, is_wished: bool | None, gain: float) -> str:
    change = f"BIC {'lower' if gain > 0 else 'higher'} by {abs(gain):.3g} with this part"
    return f"{'asked for' if is_wished else 'kept' if is_there else 'dropped'}: {change}"
