"""The log-posterior of a fit as a function, for samplers and optimizers of the user's own."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from fitting.parameters import slots_of
from fitting.photograph import FitResult
from fitting.sampling.density import Posterior, in_blocks, log_density, numbers_at, posterior
from fitting.sampling.distributions import Distribution, checked_distributions
from fitting.sampling.naming import Naming
from newtonjax.numerics import is_concrete, require, require_x64, x64

# For derivatives by differences, in coordinates of a point: all that is named is smooth in them.
_STEP = 1e-3


@dataclass(frozen=True)
class LogPosterior:
    """The logarithm of a fit's posterior density, up to a constant: of named numbers, or of many points at once.

    `log_likelihood`, `log_prior` and `log_density`, their sum, take a mapping of `names` to numbers, in SI units,
    centres in pixels, the phase at the centre in turns (`gap_turns`), and give one number. They are pure functions of
    JAX: jit, grad, hessian and vmap work on them, in float64. All three are densities of the named numbers.

    Called with points [points, `dimensions`], it gives the log-density of each: coordinates are about standard
    deviations from the optimum, which is at 0, of the model's free numbers, then of each given quantity that has a
    standard deviation. `values` has the same points by name. Between both measures lie the derivatives of the named
    numbers by the model's own: a radius is flat in 1/R without a prior, an extent of contact in its square.

    - `optimum`, `sd`: of each name, the fit's value and standard deviation, that by what is given included.
    - `priors`: of the user's own, by name.
    """

    target: Posterior
    naming: Naming
    priors: Mapping[str, Distribution]

    @property
    def names(self) -> tuple[str, ...]:
        """Of the numbers: what is measured first."""
        return self.naming.names

    @property
    def dimensions(self) -> int:
        """Numbers to a point."""
        return self.target.dimensions

    @cached_property
    def optimum(self) -> dict[str, float]:
        """The fit's values, by name."""
        return {name: float(value.item()) for name, value in self.values(np.zeros((1, self.dimensions))).items()}

    @cached_property
    def sd(self) -> dict[str, float]:
        """Standard deviations at the optimum, by name, without the priors of the user's own."""
        ahead, behind = (self.values(step * np.eye(self.dimensions)) for step in (_STEP, -_STEP))
        return {name: float(np.linalg.norm(ahead[name] - behind[name])) / (2 * _STEP) for name in self.names}

    def log_likelihood(self, values: Mapping[str, Any]) -> Float[Array, ""]:
        """Of the image, at named numbers; background and contrast are integrated over.

        -inf where it is not accurate, from 0.4 turns of phase on from the fit. Raises ValueError for other names,
        RuntimeError in a transformation without float64.
        """
        return self._in_float64("likelihood", values)

    def log_prior(self, values: Mapping[str, Any]) -> Float[Array, ""]:
        """Of what is given and of the parts' numbers, and the user's own; as `log_likelihood`."""
        return self._in_float64("prior", values)

    def log_density(self, values: Mapping[str, Any]) -> Float[Array, ""]:
        """Of the posterior, at named numbers: likelihood and priors; as `log_likelihood`."""
        return self._in_float64("density", values)

    def __call__(self, points: Float[np.ndarray, "n dimensions"], *, at_once: int = 1024) -> Float[np.ndarray, " n"]:
        """Log-density at points, `at_once` in one program; -inf where the likelihood is not accurate."""
        points = self._checked(points)
        with x64():
            densities = np.asarray(in_blocks(log_density, self.target, points, at_once))
            return densities + self.log_priors(points, at_once) if self.priors else densities

    def values(self, points: Float[np.ndarray, "n dimensions"]) -> dict[str, Float[np.ndarray, " n"]]:
        """The numbers at points, by name."""
        points = self._checked(points)
        with x64():
            free, factors = in_blocks(numbers_at, self.target, points)
        # Of NumPy's own.
        return {name: np.asarray(value, float) for name, value in self.naming.values(free.T, factors.T).items()}

    def log_priors(self, points: Float[np.ndarray, "n dimensions"], at_once: int = 1024) -> Float[np.ndarray, " n"]:
        """The user's own priors at points, as densities of these."""
        with x64():
            return np.asarray(in_blocks(lambda _, block: self._own_at_points(block), self.target, points, at_once))

    def at_point(self, point: Float[Array, " dimensions"]) -> Float[Array, ""]:
        """Log-density at one point, for JAX."""
        return self.target(point) + self._own_at(point)

    @cached_property
    def _own_at_points(self):
        return jax.jit(jax.vmap(self._own_at))

    def _own_at(self, point: Float[Array, " dimensions"]) -> Float[Array, ""]:
        """The user's own priors at a point: of a named number p(v) |dv/du|, u being the model's own."""
        if not self.priors:
            return jnp.zeros(())
        free, factors = self.target.numbers(point)
        values, slopes = self.naming.values(free, factors), self.naming.slopes(free, factors)
        terms = [prior.log_density(values[name]) for name, prior in self.priors.items()]
        terms += [jnp.log(jnp.abs(slopes[name])) for name in self.priors if name in slopes]
        density = sum(terms)
        return jnp.where(jnp.isnan(density), -jnp.inf, density)

    def _numbers(self, values: Mapping[str, Any]):
        free, factors = self.naming.numbers(values, self.target.optimum)
        return free if "phase" in self.target.moving else self.target.held(free, factors), factors

    def _log_prior(self, values: Mapping[str, Any]) -> Float[Array, ""]:
        free, factors = self._numbers(values)
        slopes = self.naming.slopes(free, factors)
        terms = [prior.log_density(jnp.asarray(values[name])) for name, prior in self.priors.items()]
        terms += [-jnp.log(jnp.abs(slope)) for name, slope in slopes.items() if name not in self.priors]
        return self.target.log_prior(free, factors) + sum(terms)

    @cached_property
    def _programs(self):
        def likelihood(values):
            return self.target.log_likelihood(*self._numbers(values))

        def density(values):
            return likelihood(values) + self._log_prior(values)

        functions = {"likelihood": likelihood, "prior": self._log_prior, "density": density}
        return {name: jax.jit(function) for name, function in functions.items()}

    def _in_float64(self, kind: str, values: Mapping[str, Any]) -> Float[Array, ""]:
        self.naming.check(values)
        if not is_concrete(dict(values)):
            require_x64("a log-density")
            return self._programs[kind](dict(values))
        with x64():
            return self._programs[kind]({name: jnp.asarray(value, float) for name, value in values.items()})

    def _checked(self, points: Any) -> np.ndarray:
        allowed = f"an array of real numbers [points, {self.dimensions}], one point or more"
        require("points", points, allowed, lambda _: True)
        if np.ndim(points) != 2 or np.shape(points)[1] != self.dimensions or not len(points):
            raise ValueError(f"points has shape {np.shape(points)}; allowed: {allowed}")
        return np.asarray(points, float)


def log_posterior(result: FitResult, *, priors: Mapping[str, Any] | None = None) -> LogPosterior:
    """The log-posterior of a fit: the likelihood of every pixel, background and contrast integrated over.

    Free are the numbers that the fit measured, and every given quantity that has a standard deviation, which is its
    normal prior; priors of the others are flat. It is what `sample` draws from.

    Args:
      result: of `fitting.fit`.
      priors: in place of the fit's own, by name, as in `sample`.

    Raises ValueError for a result without a fit, for a fit with a plate radius, and for what is no prior.

    """
    fitted, quantities, variance, covariance, *_ = evidence_of(result)
    with x64():
        target = posterior(fitted, quantities, variance, covariance)
        plain = LogPosterior(target, Naming(fitted, quantities, target.moving, target.given), {})
        if not priors:
            checked_distributions(priors, {}, {})
            return plain
        stated = checked_distributions(priors, plain.optimum, plain.sd)
        slots = [slot for slot, name in plain.naming.by_slot.items() if name in stated]
        counts = np.array([name not in stated for name in target.given], float)
        replaced = target.precision.at[slots_of(slots)].set(0.0), jnp.asarray(counts)
        target = eqx.tree_at(lambda at: (at.precision, at.counts), target, replaced)
    return LogPosterior(target, plain.naming, stated)


def evidence_of(result: FitResult):
    """What a posterior is made of. Raises ValueError for a result that has none."""
    if not isinstance(result, FitResult):
        raise ValueError(f"result is a {type(result).__name__}; allowed: what fitting.fit returned")
    if result.evidence is None:
        raise ValueError(f"the fit has no posterior: it is {result.status}; {result.message}")
    if result.evidence.known.plate is not None:
        raise ValueError("a posterior cannot include plate_radius; fit without it, and correct the radius afterwards")
    return result.evidence
