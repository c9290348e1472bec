"""How far a rate moves among models of the rings that are as good: what no scatter of one model's fit shows."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from fitting.colour.lamp_fit import LampFit, variances_of
from fitting.colour.solver import Problem, optimum

# Degrees of the background besides the usual one.
_DEGREES = (2, 5)
# Gap from which on rings are taken [m], where so many bins remain; and share of the rings that are taken.
_INNER, _FEWEST, _OUTER = 0.8e-6, 150, 0.7
# A model that leaves so many times as much is none.
_ADMISSIBLE = 2.0


class Variant(NamedTuple):
    """A model as good as the best one.

    `shift`: logarithm of its rate over the best one's; `noise`: standard deviation of a shift of noise alone.
    """

    name: str
    shift: float
    noise: float

    @property
    def excess(self) -> float:
        """The square of the shift that noise does not explain."""
        return max(self.shift**2 - self.noise**2, 0.0)


def variants_of(fit: LampFit, deviation: float) -> list[Variant]:
    """The admissible models besides the best one; `deviation` of its log rate by the sectors.

    Of fewer rings, or with more numbers, an estimate scatters about an efficient one by the difference of their
    variances (J. A. Hausman, Econometrica 46, 1251 (1978), lemma 2.1).
    """
    before, white = fit.optimum.curve, fit.optimum.deviation()
    inflation = deviation / max(white, 1e-30)
    variants = []
    for name, problem in _problems(fit).items():
        # Of the same bins.
        reference = replace(fit.problem, profiles=problem.profiles)
        best = optimum(problem, before)
        unexplained = variances_of(problem, best.curve) / variances_of(reference, before)
        if np.mean(unexplained) < _ADMISSIBLE:
            noise = inflation * float(np.sqrt(max(best.deviation() ** 2 - white**2, 0.0)))
            variants.append(Variant(name, best.curve.log_rate - before.log_rate, noise))
    return variants


def spread_among(variants: list[Variant], deviation: float) -> float:
    """Standard deviation of the log rate among admissible models; `deviation` of the best one by noise.

    A model that noise moves far says little of an error of the best one: it counts by one over its variance.
    """
    if not variants:
        return 0.0
    weights = [1 / (variant.noise**2 + deviation**2) for variant in variants]
    return float(np.sqrt(np.average([variant.excess for variant in variants], weights=weights)))


def _problems(fit: LampFit) -> dict[str, Problem]:
    base = fit.problem
    rate, squares = np.exp(fit.optimum.curve.log_rate), base.profiles.squares
    problems = {name: replace(base, palette=light) for name, light in base.palette.variants().items()}
    problems |= {f"background of degree {degree}": replace(base, degree=degree) for degree in _DEGREES}
    inner = base.profiles.within(_INNER / rate, np.inf)
    if len(inner.squares) > _FEWEST:
        problems["without the innermost rings"] = replace(base, profiles=inner)
    outer = base.profiles.within(0.0, _OUTER * float(squares.max()))
    if len(outer.squares) > _FEWEST:
        problems["without the outermost rings"] = replace(base, profiles=outer)
    if len(base.channels) > 1:
        colours = {0: "red", 2: "blue"}
        lateral = tuple(colours[channel] for channel in base.channels if channel in colours)
        problems["lateral colour"] = replace(base, free=(*base.free, *lateral))
    return problems
