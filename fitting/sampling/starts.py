"""Where chains begin: about the fit's optimum, and where the user's own priors allow it."""

import numpy as np

from fitting.sampling.density import in_blocks, log_density
from fitting.sampling.posterior_function import LogPosterior

# Draws about the optimum, of which those are taken that the user's own priors favour.
_POOL = 8192
# So many times more than chains are looked at: not each has a likelihood.
_SPARE = 4


def starting_points(
    density: LogPosterior, count: int, seed: int, *, spread: float = 1.0, at_once: int | None = None
) -> np.ndarray:
    """Points [count, dimensions] about the optimum, each with a density; `spread` in standard deviations.

    `at_once`: points to one run of a program, all unless given: as many as later compile nothing anew.

    Raises ValueError where the fit has no density at its optimum, and where the priors allow nothing near it.
    """
    generator, dimensions, at_once = np.random.RandomState(seed), density.dimensions, at_once or count
    if not np.isfinite(in_blocks(log_density, density.target, np.zeros((1, dimensions)), at_once)).all():
        raise ValueError(
            "the posterior density is zero at the fitted optimum: the fit has not converged; "
            "mask what is not rings, or give start"
        )
    if density.priors:
        return _favoured(density, count, generator, at_once)
    points = spread * generator.normal(size=(count, dimensions))
    # A wide posterior ends where the moments do.
    while not np.isfinite(density(points, at_once=at_once)).all():
        points = points / 2
    return points


def _favoured(density: LogPosterior, count: int, generator: np.random.RandomState, at_once: int) -> np.ndarray:
    """Draws by the weight of the user's priors, none of them twice (Gumbel's trick: Vieira 2014)."""
    pool = generator.normal(size=(_POOL, density.dimensions))
    weights = density.log_priors(pool, at_once)
    scores = np.where(np.isfinite(weights), weights + generator.gumbel(size=_POOL), -np.inf)
    points = pool[np.argsort(-scores)[: _SPARE * count]]
    points = points[np.isfinite(density(points, at_once=at_once))][:count]
    if len(points) < count:
        raise ValueError(f"the priors and the image contradict each other: {_least_allowed(density, pool)}")
    return points


def _least_allowed(density: LogPosterior, pool: np.ndarray) -> str:
    """The prior that allows the fewest draws, and what the fit says of its number."""
    values = density.values(pool)
    shares = {name: float(np.isfinite(prior.at(values[name])).mean()) for name, prior in density.priors.items()}
    name = min(shares, key=shares.__getitem__)
    fit = f"{density.optimum[name]:.8g} ± {density.sd[name]:.2g}"
    return f"the fit has {name} = {fit}, its prior is {density.priors[name].words}; widen it, or look for what is wrong"
