"""Robust fits with parts, from where trials of them have ended."""

import numpy as np

from fitting.estimate import Fitted, robust_fit
from fitting.model import WARPS
from fitting.photograph.averaging import variance_of
from fitting.photograph.priors import Priors
from fitting.photograph.trials import Trial, Trials, without


def with_trial(trials: Trials, best: Trial, part_words: dict[str, str]) -> Fitted:
    """The robust fit with a trial's parts; where it does not converge, without the last of the warps."""
    plain, parts, numbers = trials.fitted, best.parts, best.numbers
    variance = variance_of(plain)[0] * trials.variance_of(best) / trials.variance
    while True:
        fit = with_parts(plain, parts, numbers, trials.priors, variance)
        if not parts:
            # The trials may have met rings that the plain fit has missed.
            better = fit.converged and fit.explained > plain.explained
            return fit if better or not plain.converged else plain
        if fit.converged:
            return fit
        warps = [part for part in WARPS if part in parts]
        last = warps[-1] if warps else parts[-1]
        part_words[last] = "dropped: least squares did not converge with it"
        parts = tuple(part for part in parts if part != last)
        numbers = without(numbers, parts)


def with_parts(
    plain: Fitted,
    parts: tuple[str, ...],
    numbers: np.ndarray,
    priors: Priors,
    variance: float | None = None,
    is_near: bool = True,
) -> Fitted:
    """The robust fit with parts; `variance`: of the light per unit weight, that of the plain fit unless given."""
    variance = variance_of(plain)[0] if variance is None else variance
    prior = priors.of(parts, numbers, variance)
    return robust_fit(plain.model, plain.reduced, [numbers], plain.fixed, parts, prior, is_near)
