"""Which parts the rings' model needs: each is tried, and stays where the image calls for it.

The evidence is Schwarz's criterion (1978) on correlated residuals: chi-squared is counted in units of the variance that
blocks of neighbours show, and so many independent pixels are there.
"""

from itertools import chain, combinations
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np

from fitting import least_squares as ls
from fitting.illumination import Fitted, fringes_seen, numbers_of, robust_fit, tukey
from fitting.models import PARTS, GapModel
from fitting.photo import Photograph
from fitting.smoothing import fringe_correlation
from fitting.trials import DISCS, WARPS, bent, nested, rim, touching

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
# What is said of a part that was asked for and that no fit has.
UNFITTED = "asked for, but"


class Choice(NamedTuple):
    """A fit with the parts that it needs, why (by part, what the criterion says), and fits that are not ruled out.

    `rivals`: what the difference is, and the other fit.
    """

    found: Fitted
    evidence: dict[str, str]
    rivals: tuple[tuple[str, Fitted], ...] = ()


def checked_parts(parts) -> dict[str, bool]:
    """The user's wishes by part. Raises ValueError for other names or values."""
    parts = {} if parts is None else parts
    if not isinstance(parts, dict) or set(parts) - set(PARTS) or not all(isinstance(v, bool) for v in parts.values()):
        raise ValueError(f"parts is {parts!r}; allowed: a mapping of {', '.join(PARTS)} to True or False")
    return dict(parts)


def adapt(found: Fitted, photograph: Photograph, wishes: dict[str, bool], pinned: float) -> Choice:
    """The fit with the parts that are wished, or not excluded and called for by the image.

    `found`: a fit without parts; `pinned`: the phase of a contact [turns]. Where a score test sees no use for a part,
    it is not tried.
    """
    evidence, full, pressed = _screened(found, photograph, wishes), found, []
    rivals: list[tuple[str, Fitted]] = []
    warps = [part for part in WARPS if wishes.get(part, True)]
    if any(part not in evidence for part in warps):
        evidence = {part: text for part, text in evidence.items() if part not in warps}
        full = bent(found, photograph, wishes)
    if "contact" not in evidence and wishes.get("contact", _may_touch(full, photograph)):
        pressed = touching(found, full, photograph, pinned, wishes)
    if wishes.get("contact") and not pressed:
        evidence["contact"] = f"{UNFITTED} no disc of contact fits the image: it is left out"
    if full is found and not pressed:
        return Choice(found, evidence)
    judge = _Judge([found, full, *pressed], photograph)
    if pressed:
        best = min(pressed, key=judge.criterion)
        gain = judge.criterion(full) - judge.criterion(best)
        if 0 < gain < _CLEAR and not wishes.get("contact"):
            rivals.append(("contact, not ruled out", best))
        full = best if wishes.get("contact") or gain > _CLEAR else full
        evidence["contact"] = _said("contact" in full.parts, wishes.get("contact"), gain)
        if "contact" in full.parts and len(pressed) > 1:
            gain = judge.criterion(pressed[0]) - judge.criterion(pressed[1])
            evidence["film"] = _said("film" in full.parts, wishes.get("film"), gain)
    parts, numbers = _without_idle_warps(full, wishes, judge, evidence)
    chosen = _settled(found, photograph, parts, numbers, evidence)
    if _too_steep(chosen, photograph) and not wishes.get("distortion"):
        evidence["distortion"] = (
            "dropped: so steep a sphere bends the view of the gap as much; a scene tells them apart"
        )
        left = tuple(part for part in chosen.parts if part not in ("distortion", "fifth order"))
        rivals.append(("view of a steep sphere", chosen))
        chosen = _settled(found, photograph, left, numbers_of(found), evidence)
    few = fringes_seen(chosen.solution.image[2], photograph.mask) < _FEW_FOR_PARTS
    if chosen.parts and few and judge.inflation > _STRUCTURED and bool(found.solution.converged):
        rivals.append(("parts that few rings may feign", found))
    return Choice(chosen, evidence, tuple(rivals))


def _screened(found: Fitted, photograph: Photograph, wishes: dict[str, bool]) -> dict[str, str]:
    """The parts that need no trial, and why: a score test sees no use for them, correlation of residuals or none."""
    if 1 - found.explained < _NOTHING and not any(wishes.values()):
        return dict.fromkeys((*WARPS, "contact"), "not tried: nothing is left over to explain")
    judge = _Judge([found], photograph)
    left, columns = _columns(found)

    def gain(table: np.ndarray, inflation: float) -> float:
        drop = ls.drop_with(found.solution, left, table) / judge.variance * inflation
        return drop - table.shape[1] * judge.penalty

    warps = [part for part in WARPS if wishes.get(part, True)]
    sets = [s for n in range(1, len(warps) + 1) for s in combinations(warps, n)]
    evidence = {}
    if not any(wishes.get(part) for part in warps) and all(
        gain(np.concatenate([columns[part] for part in s], axis=1), judge.inflation) < 0 for s in sets
    ):
        evidence = {part: _said(False, None, gain(columns[part], 1.0)) for part in warps}
    discs = [disc[:, None] for disc in columns["contact"]]
    if not wishes.get("contact") and max((gain(disc, judge.inflation) for disc in discs), default=0.0) < 0:
        evidence["contact"] = _said(False, None, max(gain(disc, 1.0) for disc in discs))
    return evidence


def _settled(
    found: Fitted, photograph: Photograph, parts: tuple[str, ...], numbers: np.ndarray, evidence: dict[str, str]
) -> Fitted:
    """The robust fit with parts; where it does not converge, without the last of the warps."""
    while True:
        fit = robust_fit(found.model, photograph, [numbers], found.fixed, parts)
        warps = [part for part in WARPS if part in parts]
        if not parts:
            # The trials may have found rings that the plain fit has missed.
            better = bool(fit.solution.converged) and fit.explained > found.explained
            return fit if better or not bool(found.solution.converged) else found
        if bool(fit.solution.converged):
            return fit
        last = warps[-1] if warps else parts[-1]
        evidence[last] = "dropped: least squares did not converge with it"
        parts = tuple(part for part in parts if part != last)
        numbers = numbers.copy()
        numbers[list(PARTS[last])] = 0.0


def _too_steep(found: Fitted, photograph: Photograph) -> bool:
    """Whether the distortion is no larger than what the gap formula itself leaves out for a sphere so steep."""
    if "distortion" not in found.parts or not isinstance(found.model, GapModel):
        return False
    numbers, unit, far = numbers_of(found), found.model.frame.unit, rim(photograph.lit)
    factor, power = found.model.sphere
    slope2 = float(factor * abs(numbers[0] / unit**2) ** power) ** 2 * far * unit**2
    return bool(2 * abs(numbers[6]) * far < _STEEP * slope2)


def _columns(found: Fitted) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """The residuals of a fit, and how they change with each part's numbers; a contact's with discs of several sizes."""
    numbers, frame = numbers_of(found), found.model.frame
    bends = [np.zeros(len(frame.x))]
    if isinstance(found.model, GapModel):
        for square in DISCS:
            trial = jnp.asarray(numbers).at[7].set(square)
            bends.append(np.asarray(found.model.phase(frame.x, frame.y, trial)) - np.asarray(found.solution.image[2]))
    left, discs = ls.responses(found.solution, found.kept, jnp.asarray(np.stack(bends)))
    jacobian = np.asarray(found.solution.jacobian)
    by_part = {part: jacobian[:, list(PARTS[part])] for part in WARPS}
    return np.asarray(left), by_part | {"contact": np.asarray(discs)[1:]}


class _Judge:
    """Chi-squared in units of the correlated variance, and the criterion's price of a number.

    Every fit is judged on the same pixels: a pixel counts as much as the fit that explains it best lets it.
    """

    def __init__(self, fits: list[Fitted], photograph: Photograph):
        self.image = photograph.image
        self.weights = np.max([tukey(self.image - fit.fitted, photograph.mask) for fit in fits], axis=0)
        best = min(fits, key=self._square)
        self.inflation = fringe_correlation(self.image - best.fitted, self.weights, best.phase)
        pixels = float(self.weights.sum())
        self.variance = max(self._square(best) / pixels * self.inflation, 1e-300)
        self.penalty = float(np.log(max(pixels / self.inflation, 2.0)))

    def _square(self, fit: Fitted) -> float:
        return float((self.weights * (self.image - fit.fitted) ** 2).sum())

    def criterion(self, fit: Fitted) -> float:
        spent = sum(len(PARTS[part]) for part in fit.parts) + ("film" in fit.parts)
        return self._square(fit) / self.variance + spent * self.penalty


def _without_idle_warps(
    full: Fitted, wishes: dict[str, bool], judge: _Judge, evidence: dict[str, str]
) -> tuple[tuple[str, ...], np.ndarray]:
    """The parts that the criterion keeps, and numbers to start from; why, into `evidence`."""
    here = [part for part in WARPS if part in full.parts]
    forced = {part for part in here if wishes.get(part)}
    sets = [set(s) | forced for s in chain.from_iterable(combinations(here, n) for n in range(len(here) + 1))]
    sets = [s for s in sets if nested(s)]

    def criterion(kept: set[str]) -> float:
        dropped = [k for part in here if part not in kept for k in PARTS[part]]
        mask = np.zeros(len(full.solution.active), bool)
        mask[dropped] = True
        return ls.rise_without(full.solution, mask) / judge.variance - len(dropped) * judge.penalty

    best, numbers = min(sets, key=criterion), numbers_of(full).copy()
    for part in here:
        without = min(criterion(s) for s in sets if part not in s) if part not in forced else criterion(best - {part})
        evidence[part] = _said(part in best, part in forced, without - min(criterion(s) for s in sets if part in s))
        if part not in best:
            numbers[list(PARTS[part])] = 0.0
    return tuple(part for part in full.parts if part in best or part not in WARPS), numbers


def _said(kept: bool, asked: bool | None, gain: float) -> str:
    better = f"criterion {abs(gain):.3g} {'better' if gain > 0 else 'worse'} with it"
    return f"{'asked for' if asked else 'kept' if kept else 'dropped'}: {better}"


def _may_touch(found: Fitted, photograph: Photograph) -> bool:
    """Whether a contact could be seen: the rings' centre is in the field, and the phase is free."""
    if not isinstance(found.model, GapModel) or "gap" in found.fixed:
        return False
    x, y = numbers_of(found)[1:3]
    frame = found.model.frame
    column, row = round(frame.middle[0] + x * frame.unit), round(frame.middle[1] + y * frame.unit)
    rows, columns = photograph.lit.shape
    return 0 <= row < rows and 0 <= column < columns
