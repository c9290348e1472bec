"""Least squares on one photograph: the illumination that it calls for, its outliers, and the model's tangent."""

from dataclasses import dataclass
from functools import cached_property, partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from fitting import least_squares as ls
from fitting.models import GapModel, Local, SceneModel, as_arrays, held_numbers, localize
from fitting.moments import Moments, at_pixels, moments, synthesize
from fitting.photo import Photograph
from fitting.smoothing import thin

# A reference phase this close to the optimum everywhere [turns] makes the moments exact to rounding.
_NEAR = 0.1
_NEAR_EDGE = 0.003
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
    """A finished least-squares fit and what it was made of.

    `fixed`: what the user held, by name; `parts`: of the model's parts those that are there.
    """

    model: GapModel | SceneModel
    solution: ls.Solution
    kept: Moments
    weights: np.ndarray
    shape: tuple[int, int]
    fixed: dict
    parts: tuple[str, ...] = ()

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
        return np.asarray(synthesize(*self.solution.image, self.weights.shape, self.kept.rough))

    @cached_property
    def phase(self) -> np.ndarray:
        """The rings' phase at every pixel [turns]."""
        smooth = np.asarray(at_pixels(self.solution.image[2], self.weights.shape))
        return smooth if self.kept.rough is None else smooth + np.asarray(self.kept.rough)


def robust_fit(
    model, photograph: Photograph, starts: list[np.ndarray], fixed: dict, parts: tuple[str, ...] = ()
) -> Fitted:
    """Fit, and where pixels lie far off the fit, weight them down (Tukey's biweight) and fit again.

    Weights are always those of the last fit: what a bad one took for outliers comes back. Dark fringes are those of a
    positive contrast: where it came out negative and the phase is free, half a turn puts it right.
    """
    plain = photograph.mask.astype(float)
    found = _illuminated(model, photograph, starts, plain, fixed, parts)
    if float(found.solution.image[1].mean()) < 0 and 3 not in held_numbers(fixed, parts):
        turned = numbers_of(found).copy()
        turned[3] += 0.5
        found = _illuminated(model, photograph, [turned], plain, fixed, parts)
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
        weights = plain if clean else tukey(residual, photograph.mask)
        found = _illuminated(model, photograph, [numbers_of(found)], weights, fixed, parts)
        if clean:
            break
    return found


def tukey(residual: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Tukey's biweights, which end at six standard deviations as the median tells them; 0 outside of the mask."""
    sample = thin(mask)
    spread = 1.4826 * float(np.median(np.abs(residual[sample][mask[sample]])))
    biweight = np.clip(1 - (residual / (6 * spread)) ** 2, 0, None) ** 2 if spread else np.ones(mask.shape)
    return np.where(mask, biweight, 0.0)


def numbers_of(found: Fitted) -> np.ndarray:
    return np.asarray(found.solution.unknowns.model)


def _illuminated(
    model, photograph: Photograph, starts: list[np.ndarray], weights: np.ndarray, fixed: dict, parts: tuple[str, ...]
) -> Fitted:
    """Fit with the illumination that the image calls for.

    Many fringes tell it at once: the degrees are chosen on the optimum of full degree. A few are imitated by a
    background of high degree, and that optimum may be a false one: then every shape up to the second degree is fitted,
    from every start and from the others' optima, and the least Bayesian information criterion of the fits themselves
    decides.
    """
    phase = localize(as_arrays(model), jnp.asarray(starts[0])).value[0]
    if fringes_seen(phase, photograph.mask) >= FEW:
        return converge(model, photograph, starts[0], weights, fixed, parts, (ls.BACKGROUND, ls.CONTRAST))
    tried = [converge(model, photograph, at, weights, fixed, parts, shape) for shape in _SHAPES for at in starts]
    pixels = float(weights.sum())

    def criterion(found: Fitted) -> float:
        variance = max(min(float(one.solution.chi2) for one in tried) / pixels, 1e-300)
        chi2 = float(found.solution.chi2) / variance
        return chi2 + float(np.sum(found.solution.active)) * np.log(pixels) if np.isfinite(chi2) else np.inf

    for best in sorted(tried, key=criterion)[:2]:
        tried += [converge(model, photograph, numbers_of(best), weights, fixed, parts, shape) for shape in _SHAPES]
    return min(tried, key=criterion)


def converge(
    model,
    photograph: Photograph,
    numbers: np.ndarray,
    weights: np.ndarray,
    fixed: dict,
    parts: tuple[str, ...],
    shape: tuple[int, int],
    most: int = _ROUNDS,
) -> Fitted:
    """Fit, following the optimum with the model's tangent and the moments' reference until both are near.

    First with background and contrast of the given degrees, then with those up to them that the image calls for.
    After `most` rounds it ends where it is.
    """
    image, count = photograph.image, len(numbers)
    held, chosen = held_numbers(fixed, parts), False
    # An edge is in the moments as the reference has it.
    near_enough = _NEAR_EDGE if "contact" in parts else _NEAR

    local = localize(as_arrays(model), jnp.asarray(numbers))
    kept = about(model, image, weights, local, parts)
    unknowns = ls.linear_start(local, kept, jnp.asarray(ls.active_mask(count, *shape, held)))
    rounds = 0
    while True:
        solution = ls.solve(local, kept, unknowns, jnp.asarray(ls.active_mask(count, *shape, held)))
        unknowns = solution.unknowns
        moved = localize(as_arrays(model), unknowns.model)
        straight = float(jnp.abs(moved.value[0] - solution.image[2]).max()) < _STRAIGHT
        near = float(solution.excursion) < near_enough
        if near and straight and chosen:
            break
        local = moved
        if not near:
            kept = about(model, image, weights, local, parts)
        elif not chosen:
            shape, chosen = ls.choose_shape(solution, count, float(weights.sum()), held), True
        rounds += 1
        if rounds == most:
            break
    return Fitted(model, solution, kept, weights, shape, fixed, parts)


def about(model, image: np.ndarray, weights: np.ndarray, local: Local, parts: tuple[str, ...]) -> Moments:
    """Moments of an image about the phase of a model with given parts."""
    rough = edges(as_arrays(model), local, image.shape) if "contact" in parts else None
    return moments(jnp.asarray(image), jnp.asarray(weights), local.value[0], rough)


@partial(jax.jit, static_argnames="shape")
def edges(model: GapModel, local: Local, shape: tuple[int, int]) -> Float[Array, "rows columns"]:
    """What the model's phase at the pixels has over the one that its nodes resolve [turns]."""
    rows, columns = shape
    exact = model.phase(jnp.arange(columns, dtype=float), jnp.arange(rows, dtype=float)[:, None], local.free)
    return exact - at_pixels(local.value[0], shape)


def fringes_seen(phase, mask: np.ndarray) -> float:
    """Fringes across the unmasked part of an image, from the phase at the nodes [turns]."""
    grid = np.asarray(at_pixels(jnp.asarray(phase), (_SAMPLES, _SAMPLES)))
    rows, columns = (np.linspace(0, n - 1, _SAMPLES).round().astype(int) for n in mask.shape)
    seen = grid[mask[np.ix_(rows, columns)]]
    return float(np.ptp(seen)) if seen.size else 0.0
