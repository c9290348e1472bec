"""Priors of the user's own that the image contradicts."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from fitting.reasons import Reason
from fitting.sampling.distributions import Distribution
from fitting.sampling.posterior_function import LogPosterior
from newtonjax.numerics import Statement

# Standard deviations, as of the prior tension of a fit.
_TENSION = 4.0
# Distances from where a mode is looked for, in the fit's standard deviations.
_STEPS = 2.0 ** np.arange(-20, 21)


def tensions(density: LogPosterior, columns: Mapping[str, np.ndarray]) -> list[Statement]:
    """What is said of each prior that the image contradicts; `columns`: all draws, by name.

    Prior and image are as far apart as the best value of both together is below the prior's own mode: of two normal
    distributions that is their distance over the root of the sum of their variances. Of a quantity that is given the
    image says nothing.
    """
    sentences = []
    for name, prior in density.priors.items():
        value, sd = density.optimum[name], density.sd[name]
        if name in density.target.given or not sd > 0:
            continue
        draws = np.unique(columns[name])
        both = prior.at(draws) - 0.5 * ((draws - value) / sd) ** 2
        drop = _highest(prior, float(np.median(draws)), sd) - float(both.max())
        ratio = float(np.sqrt(2 * max(drop, 0.0)))
        if ratio > _TENSION:
            sentences.append(Reason.CHAIN_PRIOR_TENSION(name=name, value=value, sd=sd, ratio=ratio, prior=prior.words))
    return sentences


def _highest(prior: Distribution, place: float, sd: float) -> float:
    """The log-density at a prior's mode."""
    middle = place if prior.place is None else prior.place
    points = np.unique(np.concatenate([[place], middle - sd * _STEPS, [middle], middle + sd * _STEPS]))
    densities = prior.at(points)
    best = int(np.nanargmax(densities))
    low, high = points[max(best - 1, 0)], points[min(best + 1, len(points) - 1)]
    floor = float(densities[best]) - 1e6  # beyond a prior's support, where a search takes no infinity

    def depth(at):
        return -max(float(prior.at(np.array([at])).item()), floor)

    search: Any = minimize_scalar(depth, bounds=(low, high), method="bounded")
    return max(float(densities[best]), -float(search.fun))
