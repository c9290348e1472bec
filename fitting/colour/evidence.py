"""Which lamp made the rings: how much its lines leave over, next to those of the others and to no lines at all."""

from dataclasses import replace

import numpy as np

from fitting.colour.lamp_fit import LampFit, best_fit, weighed
from fitting.colour.palette import lines_of_lamp, of_lamp
from fitting.colour.profiles import Profiles
from newtonjax.scene import LAMPS

# Light without lines, in the table of odds.
BANDS_ALONE = "bands alone"


def odds_of_lamps(fit: LampFit, scale: float) -> dict[str, float]:
    """Natural logarithm of the odds of each named lamp, and of bands without lines, against a fit's light.

    Half the number of independent bins times the logarithm of what is left over: a Gaussian likelihood whose variance
    is free in each channel. `scale`: of the search's rings [turns per px²].
    """
    problem = fit.problem
    halved = replace(problem, profiles=_halved(problem.profiles))
    reference = weighed(halved, fit.optimum.curve)
    without = weighed(replace(halved, palette=of_lamp(np.zeros(0))), fit.optimum.curve)
    rivals = {BANDS_ALONE: without}
    for name in LAMPS:
        palette = of_lamp(lines_of_lamp(name))
        rivals[name] = best_fit(halved.profiles, palette, scale, problem.view, problem.channels, most=1)
    # Bins of one channel that stand for one independent one.
    together = reference.correlation
    bins = (halved.profiles.weight > 0).sum(axis=1)
    base = np.log(reference.unexplained)
    odds = {name: -0.5 * float(bins @ (np.log(rival.unexplained) - base)) / together for name, rival in rivals.items()}
    return dict(sorted(odds.items(), key=lambda item: -item[1]))


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
