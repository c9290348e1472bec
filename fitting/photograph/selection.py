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
from fitting.model import PARTS, WARPS, GapModel, gap_phase, numbers_of
from fitting.parameters import NUMBERS, Numbers
from fitting.photo import Photograph, Reduced
from fitting.photograph.trials import DISCS, Trial, Trials, nested, rim

# By how much the criterion has to be better with a contact, of which many are tried ("strong" evidence: Kass and
# Raftery 1995).
_CLEAR = 6.0
# With fewer fringes than this, parts may be structure of another kind where residuals are correlated more than this.
_FEW_FOR_PARTS, _STRUCTURED = 12.0, 3.0
# Share of the variance that no photograph leaves so little of: the rounding of 8 bits alone leaves ten times as much.
_NOTHING = 1e-6
# A microscope on the gap of a steep sphere sees 2 t only to some 3.3 (r/R)², which a distortion imitates; twice that,
# since the share depends on the glass above.
_STEEP = 6.6
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
    found: Fitted, photograph: Photograph, wishes: dict[str, bool], pinned: float, before: Fitted | None = None
) -> Choice:
    """The fit with the parts that are wished, or not excluded and called for by the image.

    `found`: a fit without parts; `pinned`: the phase of a contact [turns]; `before`: an earlier choice to start from.
    Where a score test sees no use for a part,
    it is not tried.
    """
    evidence = _screened(found, wishes)
    warps = [part for part in WARPS if wishes.get(part, True)]
    warped = any(part not in evidence for part in warps)
    touches = "contact" not in evidence and wishes.get("contact", _may_touch(found, photograph))
    if not (warped or touches):
        return Choice(found, evidence, photograph)
    trials = Trials(found, photograph, wishes, before)
    full, pressed = trials.plain, []
    rivals: list[tuple[str, Fitted]] = []
    if warped:
        evidence = {part: text for part, text in evidence.items() if part not in warps}
        full = trials.bent()
    if touches and (wishes.get("contact") or _may_touch(found, photograph, full.numbers)):
        pressed = trials.touching(full, pinned)
    if wishes.get("contact") and not pressed:
        evidence["contact"] = f"{UNFITTED} no disc of contact fits the image: it is left out"
    if full is trials.plain and not pressed:
        return Choice(found, evidence, photograph)
    judge = _Judge([trials.plain, full, *pressed], trials.reduced)
    if pressed:
        best = min(pressed, key=judge.criterion)
        gain = judge.criterion(full) - judge.criterion(best)
        if 0 < gain < _CLEAR and not wishes.get("contact"):
            rivals.append(("contact, not ruled out", _with_parts(found, best.parts, best.numbers)))
        full = best if wishes.get("contact") or gain > _CLEAR else full
        evidence["contact"] = _said("contact" in full.parts, wishes.get("contact"), gain)
        if "contact" in full.parts and len(pressed) > 1:
            gain = judge.criterion(pressed[0]) - judge.criterion(pressed[1])
            evidence["film"] = _said("film" in full.parts, wishes.get("film"), gain)
    parts, numbers = _without_idle_warps(full, wishes, judge, evidence)
    if not parts and found.converged and full.solution.chi2 > _ELSEWHERE * trials.plain.solution.chi2:
        return Choice(found, evidence, photograph, tuple(rivals))
    chosen = _settled(found, parts, numbers, evidence)
    if _too_steep(chosen, photograph) and not wishes.get("distortion"):
        evidence["distortion"] = (
            "dropped: so steep a sphere bends the view of the gap as much; a scene tells them apart"
        )
        left = tuple(part for part in chosen.parts if part not in ("distortion", "fifth_order"))
        rivals.append(("view of a steep sphere", chosen))
        chosen = _settled(found, left, found.numbers, evidence)
    if chosen.parts and chosen.orders < _FEW_FOR_PARTS and judge.inflation > _STRUCTURED and found.converged:
        rivals.append(("parts that few rings may feign", found))
    return Choice(chosen, evidence, photograph, tuple(rivals))


def _screened(found: Fitted, wishes: dict[str, bool]) -> dict[str, str]:
    """The parts that need no trial, and why: a score test sees no use for them, correlation of residuals or none."""
    if 1 - found.explained < _NOTHING and not any(wishes.values()):
        return dict.fromkeys((*WARPS, "contact"), "not tried: nothing is left over to explain")
    judge, matrix = _Judge([found], found.reduced), found.matrix
    discs = _discs(found)

    def gain(drop: float, spent: int, inflation: float) -> float:
        return drop / judge.variance * inflation - spent * judge.penalty

    def of_warps(parts: tuple[str, ...], inflation: float) -> float:
        return gain(drops[parts], len(numbers_of(parts)), inflation)

    warps = [part for part in WARPS if wishes.get(part, True)]
    sets = [s for n in range(1, len(warps) + 1) for s in combinations(warps, n)]
    drops = {parts: matrix.drop_with(numbers_of(parts)) for parts in sets}
    evidence = {}
    if not any(wishes.get(part) for part in warps) and all(of_warps(s, judge.inflation) < 0 for s in sets):
        evidence = {part: _said(False, None, of_warps((part,), 1.0)) for part in warps}
    if not wishes.get("contact") and max((gain(disc, 1, judge.inflation) for disc in discs), default=0.0) < 0:
        evidence["contact"] = _said(False, None, max(gain(disc, 1, 1.0) for disc in discs))
    return evidence


def _with_parts(found: Fitted, parts: tuple[str, ...], numbers: np.ndarray) -> Fitted:
    return robust_fit(found.model, found.reduced, [numbers], found.fixed, parts)


def _settled(found: Fitted, parts: tuple[str, ...], numbers: np.ndarray, evidence: dict[str, str]) -> Fitted:
    """The robust fit with parts; where it does not converge, without the last of the warps."""
    while True:
        fit = _with_parts(found, parts, numbers)
        warps = [part for part in WARPS if part in parts]
        if not parts:
            # The trials may have found rings that the plain fit has missed.
            better = fit.converged and fit.explained > found.explained
            return fit if better or not found.converged else found
        if fit.converged:
            return fit
        last = warps[-1] if warps else parts[-1]
        evidence[last] = "dropped: least squares did not converge with it"
        parts = tuple(part for part in parts if part != last)
        numbers = np.array(Numbers(*numbers)._replace(**dict.fromkeys(PARTS[last].parameters, 0.0)))


def _too_steep(found: Fitted, photograph: Photograph) -> bool:
    """Whether the distortion is no larger than what the gap formula itself leaves out for a sphere so steep."""
    if "distortion" not in found.parts or not isinstance(found.model, GapModel):
        return False
    numbers, unit, edge = Numbers(*found.numbers), found.model.frame.unit, rim(photograph.lit)
    factor, power = found.model.sphere
    slope2 = float(factor * abs(numbers.curvature / unit**2) ** power) ** 2 * edge * unit**2
    return bool(2 * abs(numbers.distortion) * edge < _STEEP * slope2)


def _discs(found: Fitted) -> list[float]:
    """By how much chi-squared would drop with a contact, for discs of several sizes."""
    model = found.model
    if not isinstance(model, GapModel):
        return []
    here, columns = gap_phase.phase(model, model.frame.x, model.frame.y, found.numbers), []
    for square in DISCS:
        trial = np.array(Numbers(*found.numbers)._replace(contact=square))
        columns.append(gap_phase.phase(model, model.frame.x, model.frame.y, trial) - here)
    crossed, own, gradient = bends(found.solution, np.stack(columns, axis=1))
    return [score_drop(found.matrix, crossed[:, [k]], own[[k]][:, [k]], gradient[[k]]) for k in range(len(columns))]


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
        spent = sum(len(PARTS[part].parameters) for part in fit.parts) + ("film" in fit.parts)
        return self._square(fit) / self.variance + spent * self.penalty


def _without_idle_warps(
    full: Trial, wishes: dict[str, bool], judge: _Judge, evidence: dict[str, str]
) -> tuple[tuple[str, ...], np.ndarray]:
    """The parts that the criterion keeps, and numbers to start from; why, into `evidence`."""
    here = [part for part in WARPS if part in full.parts]
    forced = {part for part in here if wishes.get(part)}
    sets = [set(s) | forced for s in chain.from_iterable(combinations(here, n) for n in range(len(here) + 1))]
    sets = [s for s in sets if nested(s)]

    matrix: NormalMatrix = normal_matrix(full.solution)

    def criterion(kept: set[str]) -> float:
        dropped = numbers_of(part for part in here if part not in kept)
        mask = np.isin(np.arange(len(matrix.values)), [NUMBERS.index(name) for name in dropped])
        return matrix.rise_without(mask) / judge.variance - len(dropped) * judge.penalty

    best, numbers = min(sets, key=criterion), full.numbers
    for part in here:
        without = min(criterion(s) for s in sets if part not in s) if part not in forced else criterion(best - {part})
        evidence[part] = _said(part in best, part in forced, without - min(criterion(s) for s in sets if part in s))
        if part not in best:
            numbers = np.array(Numbers(*numbers)._replace(**dict.fromkeys(PARTS[part].parameters, 0.0)))
    return tuple(part for part in full.parts if part in best or part not in WARPS), numbers


def _said(kept: bool, asked: bool | None, gain: float) -> str:
    better = f"criterion {abs(gain):.3g} {'better' if gain > 0 else 'worse'} with it"
    return f"{'asked for' if asked else 'kept' if kept else 'dropped'}: {better}"


def _may_touch(found: Fitted, photograph: Photograph, numbers: np.ndarray | None = None) -> bool:
    """Whether a contact could be seen: the rings' centre is in the field, and the phase is free."""
    if not isinstance(found.model, GapModel) or "gap" in found.fixed:
        return False
    by_name, frame = Numbers(*found.numbers if numbers is None else numbers), found.model.frame
    offsets = (by_name.centre_x, by_name.centre_y)
    column, row = (round(middle + at * frame.unit) for middle, at in zip(frame.middle, offsets, strict=True))
    rows, columns = photograph.lit.shape
    return 0 <= row < rows and 0 <= column < columns
