"""Which lamp made the rings: how much its lines leave over, next to those of the others and to no lines at all."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from fitting.colour.lamp_fit import LampFit, best_fit, weighed
from fitting.colour.palette import Lines, lines_of_lamp, of_lamp
from fitting.colour.profiles import Profiles
from newtonjax.scene import LAMPS

# Light without lines, in the table of odds.
BANDS_ALONE, ONE_LINE = "bands alone", "one line"
# The rate is free: a line at one place is a line anywhere.
_ANY_LINE = Lines(np.array([555e-9]), np.ones(1))


def odds_of_lamps(fit: LampFit, scale: float) -> dict[str, float]:
    """Natural logarithm of the odds of each named lamp, of one line, and of bands alone, against a fit's light.

    Half the number of independent bins times the logarithm of what is left over: a Gaussian likelihood whose variance
    is free in each channel; less half the logarithm of that number for each component that the light has more
    (G. Schwarz, Ann. Statist. 6, 461 (1978)). `scale`: of the search's rings [turns per px²].
    """
    problem = fit.problem
    halved = replace(problem, profiles=_halved(problem.profiles))
    reference = weighed(halved, fit.optimum.curve)
    turns = scale * float(halved.profiles.squares.max())
    rivals = {BANDS_ALONE: weighed(replace(halved, palette=of_lamp(None, 0.0)), fit.optimum.curve)}
    lights = {name: lines_of_lamp(name) for name in LAMPS} | {ONE_LINE: _ANY_LINE}
    for name, lines in lights.items():
        palette = of_lamp(lines, turns)
        rivals[name] = best_fit(halved.profiles, palette, scale, problem.view, problem.channels)
    independent = (halved.profiles.weight > 0).sum(axis=1) / reference.correlations
    odds = {name: _odds(rival, reference, independent) for name, rival in rivals.items()}
    # A line of any wavelength: that of the single lines' which goes best with bands where they are.
    odds[ONE_LINE] = max(odds[name] for name, rival in rivals.items() if rival.problem.palette.lines == 1)
    return dict(sorted(odds.items(), key=lambda item: -item[1]))


def _odds(rival: LampFit, reference: LampFit, independent: Float[np.ndarray, " channels"]) -> float:
    """Logarithm of the odds of two fits of profiles of so many independent bins."""
    ratio = np.log(rival.unexplained / reference.unexplained)
    further = rival.components - reference.components
    return -0.5 * float(independent @ ratio + further @ np.log(independent))


def _halved(profiles: Profiles) -> Profiles:
    """Bins of twice the width: what tells lamps apart is their beats."""
    bins = len(profiles.squares) // 2 * 2

    def pairs(table: np.ndarray) -> np.ndarray:
        return table[..., :bins].reshape(*table.shape[:-1], -1, 2)

    counts, weights = pairs(profiles.counts), pairs(profiles.weights)
    total = np.maximum(counts.sum(axis=-1), 1e-12)
    share = counts / total[..., None]
    return Profiles(
        pairs(profiles.squares).mean(axis=-1),
        2 * profiles.width,
        (pairs(profiles.values) * share).sum(axis=-1),
        (pairs(profiles.levels) * share).sum(axis=-1),
        counts.sum(axis=-1),
        # A pair of which one is left out is left out.
        np.where((weights > 0).all(axis=-1) | (weights.sum(axis=-1) == 0), weights.sum(axis=-1), 0.0),
    )
