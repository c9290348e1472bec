"""Least squares on one photograph: the illumination that it calls for, its outliers, and the model's tangent."""

from dataclasses import dataclass
from functools import cached_property

import jax.numpy as jnp
import numpy as np

from fitting import least_squares as ls
from fitting.models import GapModel, SceneModel, as_arrays, held_numbers, localize
from fitting.moments import Moments, at_pixels, moments, synthesize
from fitting.photo import Photograph
from fitting.smoothing import thin

# A reference phase this close to the optimum everywhere [turns] makes the moments exact to rounding.
_NEAR = 0.1
# A tangent that misses the model by less [turns] moves no radius: a thousandth of what noise does to a phase.
_STRAIGHT = 1e-7
_ROUNDS = 8
# Share of pixels beyond four standard deviations from which on they are outliers (a normal distribution: 6e-5), and
# how many times the variance that their median tells residuals may have without any.
_OUTLIERS, _HEAVY = 1e-3, 2.0
# With fewer fringes than this a background of high degree imitates them; then these degrees of background and contrast.
FEW = 4.0
_SHAPES = ((0, 0), (1, 1), (2, 2))
# Points to a side at which a phase is looked at to count fringes.
_SAMPLES = 65


@dataclass(frozen=True)
class Fitted:
    """A finished least-squares fit and what it was made of; `fixed`: what the user held, by name."""

    model: GapModel | SceneModel
    solution: ls.Solution
    kept: Moments
    weights: np.ndarray
    shape: tuple[int, int]
    fixed: dict

    @cached_property
    def variance(self) -> float:
        """Weighted sum of squares about the best background without fringes, of a degree that does not imitate them."""
        few = fringes_seen(self.solution.image[2], self.weights > 0) < FEW
        return float(ls.background_only(self.kept, _SHAPES[-1][0] if few else ls.BACKGROUND))

    @property
    def explained(self) -> float:
        """Share of that variance that the fringes explain."""
        return 1 - float(self.solution.chi2) / self.variance

    @cached_property
    def fitted(self) -> np.ndarray:
        """The model at every pixel [rows, columns]."""
        return np.asarray(synthesize(*self.solution.image, self.weights.shape))


def robust_fit(model, photograph: Photograph, starts: list[np.ndarray], fixed: dict) -> Fitted:
    """Fit, and where pixels lie far off the fit, weight them down (Tukey's biweight) and fit again.

    Weights are always those of the last fit: what a bad one took for outliers comes back. Dark fringes are those of a
    positive contrast: where it came out negative and the phase is free, half a turn puts it right.
    """
    plain = photograph.mask.astype(float)
    found = _illuminated(model, photograph, starts, plain, fixed)
    if float(found.solution.image[1].mean()) < 0 and "gap" not in fixed:
        found = _illuminated(model, photograph, [numbers_of(found) + np.array([0, 0, 0, 0.5])], plain, fixed)
    sample = thin(photograph.mask)
    for _ in range(3):
        residual = photograph.image - found.fitted
        away = np.abs(residual[sample][photograph.mask[sample]])
        spread = 1.4826 * float(np.median(away))
        whole = found.weights is plain
        square = float(found.solution.chi2) / plain.sum() if whole else float(np.mean(away**2))
        clean = np.mean(away > 4 * spread) < _OUTLIERS and square < _HEAVY * spread**2
        if clean and whole:
            break
        biweight = np.clip(1 - (residual / (6 * spread)) ** 2 if spread else 1.0, 0, None) ** 2
        found = _illuminated(
            model, photograph, [numbers_of(found)], plain if clean else np.where(photograph.mask, biweight, 0.0), fixed
        )
        if clean:
            break
    return found


def numbers_of(found: Fitted) -> np.ndarray:
    return np.asarray(found.solution.unknowns.model)


def _illuminated(model, photograph: Photograph, starts: list[np.ndarray], weights: np.ndarray, fixed: dict) -> Fitted:
    """Fit with the illumination that the image calls for.

    Many fringes tell it at once: the degrees are chosen on the optimum of full degree. A few are imitated by a
    background of high degree, and that optimum may be a false one: then every shape up to the second degree is fitted,
    from every start and from the others' optima, and the least Bayesian information criterion of the fits themselves
    decides.
    """
    phase = localize(as_arrays(model), jnp.asarray(starts[0])).value[0]
    if fringes_seen(phase, photograph.mask) >= FEW:
        return _converge(model, photograph, starts[0], weights, fixed, (ls.BACKGROUND, ls.CONTRAST))
    tried = [_converge(model, photograph, at, weights, fixed, shape) for shape in _SHAPES for at in starts]
    pixels = float(weights.sum())

    def criterion(found: Fitted) -> float:
        variance = max(min(float(one.solution.chi2) for one in tried) / pixels, 1e-300)
        chi2 = float(found.solution.chi2) / variance
        return chi2 + float(np.sum(found.solution.active)) * np.log(pixels) if np.isfinite(chi2) else np.inf

    for best in sorted(tried, key=criterion)[:2]:
        tried += [_converge(model, photograph, numbers_of(best), weights, fixed, shape) for shape in _SHAPES]
    return min(tried, key=criterion)


def _converge(
    model, photograph: Photograph, numbers: np.ndarray, weights: np.ndarray, fixed: dict, shape: tuple[int, int]
) -> Fitted:
    """Fit, following the optimum with the model's tangent and the moments' reference until both are near.

    First with background and contrast of the given degrees, then with those up to them that the image calls for.
    """
    image, weight, count = jnp.asarray(photograph.image), jnp.asarray(weights), len(numbers)
    held, chosen = held_numbers(fixed), False
    local = localize(as_arrays(model), jnp.asarray(numbers))
    kept = moments(image, weight, local.value[0])
    unknowns = ls.linear_start(local, kept, jnp.asarray(ls.active_mask(count, *shape, held)))
    rounds = 0
    while True:
        solution = ls.solve(local, kept, unknowns, jnp.asarray(ls.active_mask(count, *shape, held)))
        unknowns = solution.unknowns
        moved = localize(as_arrays(model), unknowns.model)
        straight = float(jnp.abs(moved.value[0] - solution.image[2]).max()) < _STRAIGHT
        near = float(solution.excursion) < _NEAR
        if near and straight and chosen:
            break
        local = moved
        if not near:
            kept = moments(image, weight, local.value[0])
        elif not chosen:
            shape, chosen = ls.choose_shape(solution, count, float(weights.sum()), held), True
        rounds += 1
        if rounds == _ROUNDS:
            break
    return Fitted(model, solution, kept, weights, shape, fixed)


def fringes_seen(phase, mask: np.ndarray) -> float:
    """Fringes across the unmasked part of an image, from the phase at the nodes [turns]."""
    grid = np.asarray(at_pixels(jnp.asarray(phase), (_SAMPLES, _SAMPLES)))
    rows, columns = (np.linspace(0, n - 1, _SAMPLES).round().astype(int) for n in mask.shape)
    seen = grid[mask[np.ix_(rows, columns)]]
    return float(np.ptp(seen)) if seen.size else 0.0
