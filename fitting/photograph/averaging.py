"""The answer averaged over sets of parts, from the normal matrices of fits with all of them.

Which parts a photograph calls for is itself uncertain, and so belongs into the answer's deviation. Each set of parts
has a weight, the probability of the image under it (Laplace's approximation: Kass and Raftery 1995), with the parts'
priors; the answer is the mean over all sets (Hoeting and others 1999). On the model linearized at the fit, a set is a
few numbers set to zero, so no set takes a pass over the image.

Residuals that err together hold less evidence than their chi-squared says even in units of the correlated variance: the
correlation is that of the worst direction. The logarithms of all weights are divided by its square root.

A part that a search finds, as a contact, is no number that may be 0: fits with and without it are optima of their own,
each with a probability by Schwarz's criterion. That is not divided: the price of such a part would vanish.
"""

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field
from itertools import combinations
from typing import NamedTuple

import numpy as np

from fitting.estimate import Fitted, Residuals, pseudo_inverse
from fitting.model import PARTS, SEARCHED, WARPS, anchors_of, numbers_of
from fitting.parameters import NUMBERS, slots_of
from fitting.photograph.priors import Priors, optimum_with_priors

# Share of the largest eigenvalue below which one is 0.
_RANK = 1e-13
# What single precision leaves of the sum of squares.
_ROUNDING = 1e-14

Parts = frozenset[str]


@dataclass(frozen=True)
class Average:
    """Mean numbers, covariance of all unknowns, and the weight of each set of parts.

    `best`: the most probable set, the number of its member, and its own numbers.
    """

    numbers: np.ndarray
    covariance: np.ndarray
    weights: dict[Parts, float]
    best: tuple[Parts, int, np.ndarray]


@dataclass(frozen=True)
class Member:
    """A fit with all parts that may be there, what was known of its numbers, and which sets of parts may be.

    `misfit`: its weighted sum of squares, all members on the same weights; `chance`: probability of the parts that a
    search has found, of all members that have the same together.
    """

    fit: Fitted
    priors: Priors
    sets: list[Parts]
    misfit: float = 0.0
    chance: float = 1.0

    @property
    def parts(self) -> tuple[str, ...]:
        """All warps that may be there, and what its fit has beside them."""
        warps = max(self.sets, key=len)
        return tuple(part for part in PARTS if part in warps or (part in self.fit.parts and part not in WARPS))


@dataclass(frozen=True)
class Averaging:
    """Fits at optima of their own, and what the mean over all their sets of parts is."""

    members: tuple[Member, ...]
    computed: dict[tuple, list["_Set"]] = field(default_factory=dict, init=False, compare=False, repr=False)

    def mean(
        self,
        variance: float,
        allows: Callable[[Parts], bool] | None = None,
        fixed_parts: Collection[str] = (),
        ratio: float = 1.0,
        held: Collection[str] = (),
    ) -> Average:
        """Over the sets that are allowed, all of them unless `allows` says which.

        `variance`: of the light per unit weight, errors that neighbours share included; `fixed_parts`: those whose
        numbers stay as they are; `ratio`: of the data's own share of each variance to what `variance` makes it; `held`:
        numbers of the camera's axis that stay as they are.
        """
        sets = self._all_sets(variance, tuple(fixed_parts), ratio, tuple(held))
        sets = sets if allows is None else [fit for fit in sets if allows(fit.parts)]
        likeliest = np.array([fit.member.chance for fit in sets])
        likeliest = likeliest == likeliest.max()
        if any(part in SEARCHED for part in fixed_parts):
            # What a searched part's own numbers are, and whether it is there, is one question.
            sets = [fit for fit, counts in zip(sets, likeliest, strict=True) if counts]
            likeliest = likeliest[likeliest]
        temper = max(1.0, float(np.sqrt(min(member.fit.correlation for member in self.members))))
        evidence = np.array([fit.evidence for fit in sets])
        share = np.zeros(len(sets))
        for chosen in filter(np.any, (likeliest, ~likeliest)):
            share[chosen] = np.exp((evidence[chosen] - evidence[chosen].max()) / temper)
            share[chosen] *= sets[int(np.argmax(chosen))].member.chance / share[chosen].sum()
        share /= share.sum()
        numbers, count = np.stack([fit.numbers for fit in sets]), len(NUMBERS)
        covariances = np.stack([fit.covariance for fit in sets])
        within = np.where(likeliest, share, 0.0) / share[likeliest].sum()
        # Orders and discs of fits with and without a contact are not the same numbers.
        own = slots_of({*numbers_of(SEARCHED), *anchors_of(SEARCHED)})
        numbers[~likeliest[:, None] & np.isin(np.arange(count), own)] = 0.0
        mean = share @ numbers
        mean[own] = within @ numbers[:, own]
        apart = numbers - mean
        apart[np.ix_(~likeliest, own)] = 0.0
        covariance = np.tensordot(share, covariances, 1)
        covariance[:count, :count] += apart.T @ (share[:, None] * apart)
        if not likeliest.all():
            own_rows = np.tensordot(within, covariances, 1)[own]
            spread = np.tensordot(within, apart[:, own, None] * apart[:, None], 1)
            own_rows[:, :count] += spread
            covariance[own], covariance[:, own] = own_rows, own_rows.T
        weights: dict[Parts, float] = {}
        for weight, fit in zip(share, sets, strict=True):
            weights[fit.parts] = weights.get(fit.parts, 0.0) + float(weight)
        best = sets[int(within.argmax())]
        place = next(at for at, member in enumerate(self.members) if member is best.member)
        return Average(mean, covariance, weights, (best.parts, place, best.numbers))

    def _all_sets(
        self, variance: float, fixed_parts: tuple[str, ...], ratio: float, held: tuple[str, ...]
    ) -> list["_Set"]:
        # A budget asks for the mean over some of them, row by row.
        key = variance, fixed_parts, ratio, held
        if key not in self.computed:
            self.computed[key] = [fit for member in self.members for fit in _sets(member, *key)]
        return self.computed[key]


def sets_of(parts: Collection[str], forced: Collection[str] = ()) -> list[Parts]:
    """All sets of parts that hold those that are forced, and with each part those that it needs."""
    candidates = [frozenset(s) | set(forced) for n in range(len(parts) + 1) for s in combinations(parts, n)]
    nested = {s for s in candidates if all(need in s for part in s for need in PARTS[part].needs)}
    return sorted(nested, key=lambda s: (len(s), sorted(s)))


def step_to_parts(plain: Fitted, priors: Priors, sets: list[Parts]) -> np.ndarray:
    """The step to the mean over sets of parts, linearized at the fit without them; correlation of residuals or none."""
    variance, inflation = variance_of(plain)
    return Averaging((Member(plain, priors, sets),)).mean(variance / inflation).numbers - plain.numbers


class _Set(NamedTuple):
    """A set of parts: its numbers, covariance of all unknowns, logarithm of its evidence."""

    member: Member
    parts: Parts
    numbers: np.ndarray
    covariance: np.ndarray
    evidence: float


class Eliminated(NamedTuple):
    """Normal equations of the numbers of all parts that a member's sets may have, whatever else is free taken out.

    - `slots`: where the numbers stand; `core`: of what is taken out, whose own inverse is `inverse`; a step d of the
      numbers moves it by -`slope` d, and without one by `step`. `matrix`, `pull`: of the numbers.
    """

    names: tuple[str, ...]
    slots: np.ndarray
    core: np.ndarray
    inverse: np.ndarray
    slope: np.ndarray
    matrix: np.ndarray
    pull: np.ndarray
    step: np.ndarray


def eliminated(member: Member, variance: float, fixed_parts: Collection[str] = ()) -> Eliminated:
    """A member on the model linearized at its fit; `fixed_parts`: those whose numbers stay as they are.

    `variance`: of the light per unit weight, in units of which the phase of contact is held to its anchor: the fit was
    made before it was known.
    """
    matrix = member.fit.matrix
    names = numbers_of(part for part in PARTS if any(part in s for s in member.sets))
    tested = slots_of(names)
    is_core = matrix.active.copy()
    is_core[[*tested, *slots_of(numbers_of(fixed_parts))]] = False
    core = np.flatnonzero(is_core)
    anchor_weights, anchor_pulls = np.zeros((2, len(matrix.values)))
    for name, sd in anchors_of(member.fit.parts).items():
        slot = NUMBERS.index(name)
        anchor_weights[slot] = variance / sd**2
        anchor_pulls[slot] = anchor_weights[slot] * (member.fit.solution.problem.pull[0][slot] - matrix.values[slot])
    inverse = pseudo_inverse(matrix.matrix[np.ix_(core, core)] + np.diag(anchor_weights[core]), _RANK)
    slope = inverse @ matrix.matrix[np.ix_(core, tested)]
    of_tested = matrix.matrix[np.ix_(tested, tested)] - matrix.matrix[np.ix_(tested, core)] @ slope
    gradient = (matrix.gradient + anchor_pulls)[core]
    pull = matrix.gradient[tested] - slope.T @ gradient
    return Eliminated(names, tested, core, inverse, slope, of_tested, pull, inverse @ gradient)


def _sets(
    member: Member, variance: float, fixed_parts: Collection[str], ratio: float, held: Collection[str]
) -> Iterator[_Set]:
    """The sets of a member on the model linearized at its fit; what else is free there, is so in each of them."""
    matrix, rest = member.fit.matrix, eliminated(member, variance, fixed_parts)
    names, tested, core, inverse, slope, of_tested, pull, of_core = rest
    centre, sd = (np.array([member.priors.numbers[name][k] for name in names]) for k in (0, 1))
    # Without a distortion the camera's axis is anywhere.
    aside = np.isin(names, [name for part in PARTS.values() for name in part.axis])
    values = matrix.values[tested]
    absent = np.where(aside, values, 0.0)
    for parts in member.sets:
        free = np.isin(names, numbers_of(parts)) & ~np.isin(names, list(held))
        step, spread, logarithm = optimum_with_priors(
            of_tested / variance, pull / variance, values, free, centre, 1 / sd**2, absent
        )
        shift = np.zeros(len(matrix.values))
        shift[tested], shift[core] = step, of_core - slope @ step
        spread = spread + (ratio - 1) * spread @ of_tested @ spread / variance
        covariance = np.zeros_like(matrix.matrix)
        covariance[np.ix_(tested, tested)] = spread
        covariance[np.ix_(core, core)] = ratio * variance * inverse + slope @ spread @ slope.T
        covariance[np.ix_(core, tested)] = -slope @ spread
        covariance[np.ix_(tested, core)] = -spread @ slope.T
        numbers = member.fit.numbers + shift[: len(NUMBERS)]
        yield _Set(member, parts, numbers, covariance, logarithm - 0.5 * member.misfit / variance)


def variance_of(fit: Fitted) -> tuple[float, float]:
    """Variance of the light per unit weight, errors that neighbours share included, and their factor in it."""
    # Below the rounding of single precision nothing is known of the residuals.
    above_rounding = fit.chi2 > _ROUNDING * fit.solution.normal.square
    inflation = fit.correlation if above_rounding else 1.0
    chi2 = max(fit.chi2, _ROUNDING * fit.solution.normal.square)
    variance = chi2 / max(fit.weight - float(np.sum(fit.matrix.active)), 1.0) * inflation
    return variance * (_of_biweight(fit.left, fit.reduced.weights) if above_rounding else 1.0), inflation


def _of_biweight(residuals: Residuals, weights: np.ndarray) -> float:
    """By how much Tukey's estimate scatters more than least squares with its weights; 1 without outliers.

    E[ψ²] / E[ψ']² of ψ = w r, with w = (1 - u)² and ψ' = (1 - u)(1 - 5 u) (Huber 1981, Robust Statistics, 7.6).
    `weights`: of the blocks alone.
    """
    used = weights > 0
    block, r = weights[used].astype(float), residuals.value[used]
    share = (residuals.weights[used] / weights[used]).astype(float)
    slope = block * np.sqrt(share) * (5 * np.sqrt(share) - 4)
    scatter, total = (block * (share * r) ** 2).sum(), (block * share).sum()
    return float(scatter / slope.sum() ** 2 * total**2 / max((block * share * r * r).sum(), 1e-300))
