"""Draws from the posterior of a fit: emcee's ensemble sampler on the moments, all walkers in one call."""

from dataclasses import dataclass

import emcee
import jax.numpy as jnp
import numpy as np

from fitting.posterior import NEAR, Posterior, draws, largest_excursion, log_density, posterior
from fitting.result import FitResult
from newtonjax.precision import x64

# A chain shorter than this many autocorrelation times tells no quantile (emcee's documentation; Sokal 1997).
_LONG = 50


@dataclass(frozen=True)
class Chain:
    """What was drawn after burn-in, and how far it may be trusted.

    - `names`; `values` [steps, walkers, names] in SI units (centre in pixels, gap's phase in turns); `log_prob`
      [steps, walkers], up to a constant.
    - `autocorrelation_time` [names] in steps (Goodman and Weare 2010); `effective` draws, the fewest of any name.
    - `acceptance`: mean share of accepted moves; `split_rhat` [names]: half-chains against each other.
    - `message`: why no quantile is quoted; empty where one is.
    """

    names: tuple[str, ...]
    values: np.ndarray
    log_prob: np.ndarray
    autocorrelation_time: np.ndarray
    effective: float
    acceptance: float
    split_rhat: np.ndarray
    message: str

    def of(self, name: str) -> np.ndarray:
        """All draws of one number. Raises ValueError for an unknown name."""
        if name not in self.names:
            raise ValueError(f"the chain has no {name!r}; it has {', '.join(self.names)}")
        return self.values[:, :, self.names.index(name)].ravel()

    def interval(self, name: str, coverage: float = 0.95) -> tuple[float, float]:
        """Quantiles with equal tails. Raises ValueError where the chain is too short to tell them."""
        if self.message:
            raise ValueError(self.message)
        low, high = np.quantile(self.of(name), [(1 - coverage) / 2, (1 + coverage) / 2])
        return float(low), float(high)


def sample(result: FitResult, *, walkers: int = 32, steps: int = 2000, seed: int = 0) -> Chain:
    """Draw from the posterior of a fit.

    Free are the numbers that the fit measured, and every given quantity that has a standard deviation, which is its
    normal prior; priors of the rest are flat. Background and contrast are integrated over. The noise's variance is the
    fit's, correlation included. The first quarter of the steps is burn-in and dropped.

    Raises ValueError for a result without a fit, and for too few walkers or steps.
    """
    if result.evidence is None:
        raise ValueError(f"the fit has no posterior: it is {result.status}; {result.message}")
    found, known, variance, covariance = result.evidence
    with x64():
        target = posterior(found, known, variance, covariance)
        if walkers < 2 * target.dimensions + 2:
            raise ValueError(f"walkers is {walkers}; allowed: at least {2 * target.dimensions + 2} here")
        if steps < 8:
            raise ValueError(f"steps is {steps}; allowed: at least 8")
        sampler = emcee.EnsembleSampler(
            walkers,
            target.dimensions,
            lambda points: np.asarray(log_density(target, jnp.asarray(points))),
            # A third of the stretch move's autocorrelation time in six dimensions (measured: 21 steps against 63).
            moves=[(emcee.moves.DEMove(), 0.8), (emcee.moves.DESnookerMove(), 0.2)],
            vectorize=True,
        )
        generator = np.random.RandomState(seed)
        sampler.random_state = generator.get_state()
        sampler.run_mcmc(_inside(target, generator.normal(size=(walkers, target.dimensions))), steps)
        burned = steps // 4
        points, log_prob = (np.asarray(get(discard=burned)) for get in (sampler.get_chain, sampler.get_log_prob))
        excursion = float(largest_excursion(target, jnp.asarray(points.reshape(-1, target.dimensions))))
        drawn = draws(target, found, known, points.reshape(-1, target.dimensions))
    values = drawn.values.reshape(*points.shape[:2], -1)
    time = np.atleast_1d(emcee.autocorr.integrated_time(values, quiet=True, tol=0))
    length, slowest = len(values), float(np.max(time))
    message = ""
    if not np.isfinite(slowest) or length < _LONG * slowest:
        message = (
            f"the chain of {length} steps is shorter than {_LONG} autocorrelation times of {slowest:.0f} steps: "
            f"take at least {int(_LONG * slowest * 4 / 3) + 1 if np.isfinite(slowest) else 4 * steps} steps"
        )
    if excursion > 0.9 * NEAR:
        message = (
            f"the posterior reaches {excursion:.2g} turns from the fit, where the image's moments end ({NEAR:g}): the "
            "draws are cut off there; take more rings into the picture"
        )
    return Chain(
        drawn.names,
        values,
        log_prob,
        time,
        values[:, :, 0].size / slowest,
        float(np.mean(sampler.acceptance_fraction)),
        split_rhat(values),
        message,
    )


def _inside(target: Posterior, points: np.ndarray) -> np.ndarray:
    """Points drawn together about the optimum until each has a density: a wide posterior ends where the moments do."""
    while not np.isfinite(np.asarray(log_density(target, jnp.asarray(points)))).all():
        points = points / 2
    return points


def split_rhat(values: np.ndarray) -> np.ndarray:
    """Potential scale reduction of half-chains (Gelman et al., Bayesian Data Analysis, 3rd ed., section 11.4)."""
    half = len(values) // 2
    chains = np.concatenate([values[:half], values[half : 2 * half]], axis=1)
    within = chains.var(axis=0, ddof=1).mean(axis=0)
    between = half * chains.mean(axis=0).var(axis=0, ddof=1)
    return np.sqrt((half - 1) / half + between / (half * within))
