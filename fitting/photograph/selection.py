"""Which parts the rings' model needs: each is tried, and stays where the image calls for it.

The evidence is Schwarz's criterion (1978) on correlated residuals: chi-squared is counted in units of the variance that
blocks of neighbours show, and so many independent pixels are there.
"""

from collections.abc import Sequence
from itertools import chain, combinations
from typing import NamedTuple

import numpy as np

from fitting.estimate import (
    Fitted,
    NormalMatrix,
    bends,
    fringe_correlation,
    normal_matrix,
    robust_fit,
    score_drop,
    tukey,
)
from fitting.model import PARTS, PRICES, SEARCHED, WARPS, numbers_of
from fitting.parameters import NUMBERS, Numbers
from fitting.photo import Photograph, Reduced
from fitting.photograph.trials import Trial, Trials, is_nested

# With fewer fringes than this, parts may be structure of another kind where residuals are correlated more than this.
_FEW_FOR_PARTS, _STRUCTURED = 12.0, 3.0
# Share of the variance that no photograph leaves so little of: the rounding of 8 bits alone leaves ten times as much.
_NOTHING = 1e-6
# Parts that lower chi-squared by more, and are not needed in the end, have led to rings that the plain fit has missed.
_ELSEWHERE = 0.8
# What is said of a part that was asked for and that no fit has.
UNFITTED = "asked for, but"


class Choice(NamedTuple):
    """A fit with the parts that it needs, why (by part, what the criterion says), and fits that are not ruled out.

    `photograph`: on which it was made; `rivals`: what the difference is, and the other fit.
    """

    found: Fitted
    evidence: dict[str, str]
    photograph: Photograph
    rivals: tuple[tuple[str, Fitted], ...] = ()


def adapt(
    plain: Fitted, photograph: Photograph, wishes: dict[str, bool], pinned: float, before: Fitted | None = None
) -> Choice:
    """The fit with the parts that are wished, or not excluded and called for by the image.

    `plain`: a fit without parts; `pinned`: the phase of a contact [turns]; `before`: an earlier choice to start from.
    Where a score test sees no use for a part, it is not tried.
    """
    wishes = {part: wish for part, wish in wishes.items() if part in plain.model.parts}
    evidence = _screened(plain, wishes)
    warps = [part for part in WARPS if wishes.get(part, True)]
    is_warped = any(part not in evidence for part in warps)
    searched = [part for part in SEARCHED if part not in evidence and _is_open(part, wishes, plain, photograph)]
    if not (is_warped or searched):
        return Choice(plain, evidence, photograph)
    trials = Trials(plain, photograph, wishes, before)
    best = trials.plain
    if is_warped:
        evidence = {part: text for part, text in evidence.items() if part not in warps}
        best = trials.bent()
    searches = {
        part: trials.searched(part, best, pinned)
        for part in searched
        if wishes.get(part) or _may_be_seen(part, plain, photograph, best.numbers)
    }
    evidence |= _unfitted(wishes, best, searches)
    if best is trials.plain and not any(searches.values()):
        return Choice(plain, evidence, photograph)
    judge = _Judge([trials.plain, best, *chain(*searches.values())], trials.reduced)
    rivals: list[tuple[str, Fitted]] = []
    for part, fits in searches.items():
        if fits:
            best, rival = _with_or_without(part, fits, best, wishes, judge, evidence)
            if rival is not None:
                rivals.append((f"{part}, not ruled out", _with_parts(plain, rival.parts, rival.numbers)))
    parts, numbers = _without_idle_warps(best, wishes, judge, evidence)
    if not parts and plain.converged and best.solution.chi2 > _ELSEWHERE * trials.plain.solution.chi2:
        return Choice(plain, evidence, photograph, tuple(rivals))
    chosen = _settled(plain, parts, numbers, evidence)
    if chosen.parts and chosen.orders < _FEW_FOR_PARTS and judge.inflation > _STRUCTURED and plain.converged:
        rivals.append(("parts not determined by few rings", plain))
    return Choice(chosen, evidence, photograph, tuple(rivals))


def _unfitted(wishes: dict[str, bool], bent: Trial, searches: dict[str, list[Trial]]) -> dict[str, str]:
    """What is said of the parts that were asked for and that no trial has."""
    absent = [part for part in WARPS if wishes.get(part) and part not in bent.parts]
    for part in (part for part in SEARCHED if not searches.get(part)):
        absent += [name for name in (part, SEARCHED[part].name) if wishes.get(name)]
    return {part: f"{UNFITTED} {PARTS[part].unfitted}" for part in absent}


def _with_or_without(
    part: str, fits: list[Trial], without: Trial, wishes: dict[str, bool], judge: "_Judge", evidence: dict[str, str]
) -> tuple[Trial, Trial | None]:
    """The best of the fits with a searched part, or the one without it; and a fit with it that is not ruled out."""
    best, is_wished = min(fits, key=judge.criterion), wishes.get(part)
    gain = judge.criterion(without) - judge.criterion(best)
    rival = best if 0 < gain < PARTS[part].clear and not is_wished else None
    chosen = best if is_wished or gain > PARTS[part].clear else without
    evidence[part] = _words(part in chosen.parts, is_wished, gain)
    freed = SEARCHED[part].name
    if part in chosen.parts and wishes.get(freed):
        evidence[freed] = f"asked for: with {part}"
    elif part in chosen.parts and len(fits) > 1:
        gain = judge.criterion(fits[0]) - judge.criterion(fits[1])
        evidence[freed] = _words(freed in chosen.parts, None, gain)
    return chosen, rival


def _nested(parts: tuple[str, ...], dropped: str) -> tuple[str, ...]:
    """Parts without one of them, and without those that need it."""
    return tuple(part for part in parts if part != dropped and dropped not in PARTS[part].needs)


def _screened(plain: Fitted, wishes: dict[str, bool]) -> dict[str, str]:
    """The parts that need no trial, and why: a score test sees no use for them, correlation of residuals or none."""
    if 1 - plain.explained < _NOTHING and not any(wishes.values()):
        return dict.fromkeys((*WARPS, *SEARCHED), "not tried: the residual is at rounding level")
    searched = [part for part in SEARCHED if part in plain.model.parts and not wishes.get(part)]
    probed = {part: max(_drops(plain, part)) for part in searched}
    warps = [part for part in WARPS if wishes.get(part, True)]
    sets = [s for n in range(1, len(warps) + 1) for s in combinations(warps, n)]
    drops = {parts: plain.matrix.drop_with(numbers_of(parts)) for parts in sets}
    judge = _Judge([plain], plain.reduced)

    def gain(drop: float, spent: int, inflation: float) -> float:
        return drop / judge.variance * inflation - spent * judge.penalty

    def of_warps(parts: tuple[str, ...], inflation: float) -> float:
        return gain(drops[parts], len(numbers_of(parts)), inflation)

    evidence = {}
    if not any(wishes.get(part) for part in warps) and all(of_warps(s, judge.inflation) < 0 for s in sets):
        evidence = {part: _words(False, None, of_warps((part,), 1.0)) for part in warps}
    for part in probed:
        if gain(probed[part], PRICES[part], judge.inflation) < 0:
            evidence[part] = _words(False, None, gain(probed[part], PRICES[part], 1.0))
    return evidence


def _with_parts(plain: Fitted, parts: tuple[str, ...], numbers: np.ndarray) -> Fitted:
    return robust_fit(plain.model, plain.reduced, [numbers], plain.fixed, parts)


def _settled(plain: Fitted, parts: tuple[str, ...], numbers: np.ndarray, evidence: dict[str, str]) -> Fitted:
    """The robust fit with parts; where it does not converge, without the last of the warps."""
    while True:
        fit = _with_parts(plain, parts, numbers)
        warps = [part for part in WARPS if part in parts]
        if not parts:
            # The trials may have found rings that the plain fit has missed.
            better = fit.converged and fit.explained > plain.explained
            return fit if better or not plain.converged else plain
        if fit.converged:
            return fit
        last = warps[-1] if warps else parts[-1]
        evidence[last] = "dropped: least squares did not converge with it"
        parts = tuple(part for part in parts if part != last)
        numbers = np.array(Numbers(*numbers)._replace(**dict.fromkeys(PARTS[last].parameters, 0.0)))


def _drops(plain: Fitted, part: str) -> list[float]:
    """By how much chi-squared would drop with a part, for each of its probes."""
    fringes, columns = plain.solution.problem.phase, []
    for probe in PARTS[part].probes:
        numbers = np.array(Numbers(*plain.numbers)._replace(**probe))
        columns.append(fringes.fields(numbers).phase - plain.solution.fields.phase)
    crossed, among, gradient = bends(plain.solution, np.stack(columns, axis=1))
    return [score_drop(plain.matrix, crossed[:, [k]], among[[k]][:, [k]], gradient[[k]]) for k in range(len(columns))]


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
        return self._square(fit) / self.variance + sum(PRICES[part] for part in fit.parts) * self.penalty


def _without_idle_warps(
    best: Trial, wishes: dict[str, bool], judge: _Judge, evidence: dict[str, str]
) -> tuple[tuple[str, ...], np.ndarray]:
    """The parts that the criterion keeps, and numbers to start from; why, into `evidence`."""
    warps = [part for part in WARPS if part in best.parts]
    forced = {part for part in warps if wishes.get(part)}
    sets = [set(s) | forced for s in chain.from_iterable(combinations(warps, n) for n in range(len(warps) + 1))]
    sets = [s for s in sets if is_nested(s)]

    matrix: NormalMatrix = normal_matrix(best.solution)

    def criterion(present: set[str]) -> float:
        dropped = numbers_of(part for part in warps if part not in present)
        mask = np.isin(np.arange(len(matrix.values)), [NUMBERS.index(name) for name in dropped])
        return matrix.rise_without(mask) / judge.variance - len(dropped) * judge.penalty

    chosen, numbers = min(sets, key=criterion), best.numbers
    for part in warps:
        # Without a part that is forced, those that need it go too.
        remaining = [set(_nested(tuple(chosen), part))] if part in forced else [s for s in sets if part not in s]
        without = min(criterion(s) for s in remaining)
        gain = without - min(criterion(s) for s in sets if part in s)
        evidence[part] = _words(part in chosen, part in forced, gain)
        if part not in chosen:
            numbers = np.array(Numbers(*numbers)._replace(**dict.fromkeys(PARTS[part].parameters, 0.0)))
    return tuple(part for part in best.parts if part in chosen or part not in WARPS), numbers


def _words(is_there: bool, is_wished: bool | None, gain: float) -> str:
    change = f"BIC {'lower' if gain > 0 else 'higher'} by {abs(gain):.3g} with this part"
    return f"{'asked for' if is_wished else 'kept' if is_there else 'dropped'}: {change}"


def _is_open(part: str, wishes: dict[str, bool], plain: Fitted, photograph: Photograph) -> bool:
    """Whether a searched part is wished, or neither excluded nor out of sight."""
    return part in plain.model.parts and wishes.get(part, _may_be_seen(part, plain, photograph, plain.numbers))


def _may_be_seen(part: str, plain: Fitted, photograph: Photograph, numbers: np.ndarray) -> bool:
    """Whether what it pins is not held, and the rings' centre is in the field where it is seen there only."""
    if not set(PARTS[part].pins) <= set(plain.solution.problem.free):
        return False
    by_name, frame = Numbers(*numbers), plain.model.frame
    offsets = (by_name.centre_x, by_name.centre_y)
    column, row = (round(middle + at * frame.unit) for middle, at in zip(frame.middle, offsets, strict=True))
    rows, columns = photograph.lit.shape
    return not PARTS[part].at_centre or (0 <= row < rows and 0 <= column < columns)
