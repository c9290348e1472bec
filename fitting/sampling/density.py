"""The posterior of a fit's numbers on fringe moments: the image's exact likelihood, without the image."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from fitting.estimate import CONTRAST, Fitted, Moments, bends, contrast_at_nodes, moments, sums
from fitting.model import (
    BACKGROUND,
    GapModel,
    SceneModel,
    as_arrays,
    degrees,
    free_numbers,
    model_coefficients,
)
from fitting.parameters import (
    NUMBERS,
    Quantities,
    block_of,
    held_turns,
    slots_of,
)
from newtonjax.fields import packed

# A phase further from the moments' reference [turns] is not resolved by their basis: a cubic drift of so much puts
# chi-squared off by 5e-8 of it (6e-4 in 1.1e4, 256 x 256 pixels), of 0.25 by 1e-9.
NEAR = 0.4


class Posterior(eqx.Module):
    """The log-posterior of a fit: of the model's free numbers, and of the given quantities with standard deviations.

    A point holds the free numbers that move, in units of their noise about where the optimum is for the given
    quantities, then each of these, in its own standard deviations from its value. The priors are normal in what is
    given and in the parts' numbers, and flat in the others and in the coefficients of background and contrast, which
    are integrated over. `centre`, `precision`: of the priors of the free numbers, precision 0 without one;
    `counts`: 1 for each given quantity, 0 where a prior of the user's stands for its normal one.
    """

    model: GapModel | SceneModel
    kept: Moments
    optimum: Float[Array, " free"]
    spread: Float[Array, "moving moving"]
    variance: Float[Array, ""]
    relative_sd: Float[Array, " given"]
    lean: Float[Array, "moving given"]
    held_turns: Float[Array, ""]
    centre: Float[Array, " free"]
    precision: Float[Array, " free"]
    counts: Float[Array, " given"]
    moving: tuple[str, ...] = eqx.field(static=True)
    given: tuple[str, ...] = eqx.field(static=True)
    unknown: str | None = eqx.field(static=True)
    shape: tuple[int, int] = eqx.field(static=True)

    def __call__(self, point: Float[Array, " dimensions"]) -> Float[Array, ""]:
        """Log-density up to a constant; -inf where the moments do not hold it."""
        free, factors = self.numbers(point)
        return self.log_likelihood(free, factors) + self.log_prior(free, factors)

    def log_likelihood(self, free: Float[Array, " free"], factors: Float[Array, " given"]) -> Float[Array, ""]:
        """Of the image, background and contrast integrated over; -inf where the moments do not hold it."""
        phase, contrast = self._fields(free, factors)
        chi2, volume = _marginal(self.kept, phase, contrast, self.shape)
        density = -0.5 * (chi2 / self.variance + volume)
        is_held = (self._away(phase) < NEAR) & (factors > 0).all() & jnp.isfinite(density)
        return jnp.where(is_held, density, -jnp.inf)

    def log_prior(self, free: Float[Array, " free"], factors: Float[Array, " given"]) -> Float[Array, ""]:
        """Of the parts' numbers and of what is given."""
        steps = (factors - 1) / self.relative_sd
        return -0.5 * (self.precision @ (free - self.centre) ** 2 + self.counts @ steps**2)

    def excursion(self, point: Float[Array, " dimensions"]) -> Float[Array, ""]:
        """Largest distance of the phase from the moments' reference [turns]."""
        return self._away(self.fields(point)[0])

    def _away(self, phase: Float[Array, " nodes"]) -> Float[Array, ""]:
        return jnp.abs(phase - self.kept.reference).max()

    def fields(self, point: Float[Array, " dimensions"]) -> Float[Array, "2 nodes"]:
        """Phase [turns] and contrast at the nodes."""
        return self._fields(*self.numbers(point))

    def _fields(self, free: Float[Array, " free"], factors: Float[Array, " given"]) -> Float[Array, "2 nodes"]:
        return self.model.traced(self.unknown, dict(zip(self.given, factors, strict=True)))(free)

    def numbers(self, point: Float[Array, " dimensions"]) -> tuple[Float[Array, " free"], Float[Array, " given"]]:
        """The model's free numbers at a point, and the factors of what is given."""
        count = len(self.moving)
        step = self.spread @ point[:count] + self.lean @ point[count:]
        free = self.optimum.at[slots_of(self.moving)].add(step)
        factors = 1 + self.relative_sd * point[count:]
        return self.held(free, factors), factors

    def held(self, free: Float[Array, " free"], factors: Float[Array, " given"]) -> Float[Array, " free"]:
        """Free numbers with the phase of a held gap: so many half wavelengths in its medium as both of these say."""
        by_name = dict(zip(self.given, factors, strict=True))
        longer = by_name.get("gap_index", 1.0) / by_name.get("wavelength", 1.0)
        return free.at[NUMBERS.index("phase")].add(self.held_turns * (longer - 1))

    @property
    def dimensions(self) -> int:
        return len(self.moving) + len(self.given)


# With these options a bench's rays compile in half of the time, and take two thirds of it, with the same numbers.
@partial(jax.jit, compiler_options=packed.OPTIONS)
def log_density(target: Posterior, points: Float[Array, "walkers dimensions"]) -> Float[Array, " walkers"]:
    """The log-posterior of many points at once."""
    return jax.vmap(target)(points)


@partial(jax.jit, compiler_options=packed.OPTIONS)
def excursions(target: Posterior, points: Float[Array, "n dimensions"]) -> Float[Array, " n"]:
    """Of each of many points [turns]."""
    return jax.vmap(target.excursion)(points)


def in_blocks(of_points: Callable, target: Posterior, points: Float[np.ndarray, "n dimensions"], size: int = 1024):
    """What a program makes of points, `size` at a time: one program, however many they are. Arrays of NumPy."""
    count = len(points)
    padded = points[np.minimum(np.arange(-(-count // size) * size), count - 1)].reshape(-1, size, points.shape[1])
    parts = [of_points(target, jnp.asarray(block)) for block in padded]
    return jax.tree.map(lambda *blocks: np.concatenate(blocks)[:count], *parts)


def posterior(found: Fitted, known: Quantities, variance: float, covariance: np.ndarray) -> Posterior:
    """The posterior of a finished fit, for the noise's variance per unit weight and the covariance at the optimum."""
    moving = free_numbers(found.fixed, found.parts)
    given = tuple(name for name, sd in known.sd.items() if sd) if known.unknown else ()
    gap_is_held = "gap" in found.fixed and found.model.holds_turns
    inner = block_of(covariance, moving)
    centre, cost = found.solution.problem.pull
    target = Posterior(
        model=as_arrays(found.model),
        kept=_moments(found),
        optimum=jnp.asarray(found.numbers),
        spread=jnp.asarray(np.linalg.cholesky(inner)),
        variance=jnp.asarray(variance),
        relative_sd=jnp.asarray([known.sd[name] / known.given[name] for name in given]),
        lean=jnp.zeros((len(moving), len(given))),
        held_turns=jnp.asarray(held_turns(found.fixed, known) if gap_is_held else 0.0),
        centre=jnp.asarray(centre),
        precision=jnp.asarray(cost / found.solution.problem.prior.variance),
        counts=jnp.ones(len(given)),
        moving=moving,
        given=given,
        unknown=known.unknown,
        shape=found.shape,
    )
    return eqx.tree_at(lambda t: t.lean, target, _lean(target, found)) if given else target


def _moments(found: Fitted) -> Moments:
    """Moments with the fit's weights about its phase, in double precision: a chain takes differences of them."""
    phase, numbers = found.solution.fields.phase, found.numbers
    light, weights = found.reduced.light.astype(float), found.left.weights.astype(float)
    weighted = replace(found.reduced, light=light, weights=weights)
    return moments(*sums(weighted, phase, found.solution.problem.phase.edges(numbers)))


def _lean(target: Posterior, found: Fitted) -> Float[Array, "moving given"]:
    """How the optimum moves with each given quantity, per standard deviation: the implicit function theorem.

    Else a held gap of many waves, or a bench, would leave a ridge that no ensemble finds its way along.
    """
    changes = np.asarray(_phases_by_given(target))
    steps = found.matrix.shift(bends(found.solution, changes.T)[0])
    return jnp.asarray(steps[slots_of(target.moving)])


@eqx.filter_jit
def _phases_by_given(target: Posterior) -> Float[Array, "given nodes"]:
    """How the phase changes with each given quantity, per standard deviation, at the optimum."""
    origin, unit = jnp.zeros(target.dimensions), jnp.eye(target.dimensions)[len(target.moving) :]
    return jax.vmap(lambda e: jax.jvp(lambda p: target.fields(p)[0], (origin,), (e,))[1])(unit)


def _marginal(kept: Moments, phase, contrast, shape: tuple[int, int]) -> tuple[Float[Array, ""], Float[Array, ""]]:
    """Chi-squared of the best background and contrast (less a constant), and log det of their normal matrix."""
    low = int((degrees(BACKGROUND).sum(axis=1) <= shape[0]).sum())  # lowest degrees come first
    high = int((degrees(CONTRAST).sum(axis=1) <= shape[1]).sum())
    shapes = contrast[:, None] * jnp.asarray(contrast_at_nodes()[:, :high])
    nothing = jnp.zeros(len(degrees(BACKGROUND)))
    fringes = jax.vmap(lambda s: model_coefficients(nothing, s, phase, kept.reference), 1, 1)(shapes)
    columns = jnp.concatenate([kept.root[:, :low], kept.root @ fringes], axis=1)
    lower = jnp.linalg.cholesky(columns.T @ columns)
    best = jax.scipy.linalg.solve_triangular(lower, columns.T @ kept.target, lower=True)
    return -(best @ best), 2 * jnp.log(jnp.diag(lower)).sum()


@eqx.filter_jit
def numbers_at(target: Posterior, points: Float[Array, "n dimensions"]):
    """The model's free numbers at each of many points, and the factors of what is given."""
    return jax.vmap(target.numbers)(points)
