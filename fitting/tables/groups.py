"""The rival "groups": readings in several groups of rings, with rings between them that were counted and not read."""

from dataclasses import dataclass

import numpy as np
from scipy import stats

from fitting.tables.breaks import Break, gaps_of
from fitting.tables.regression import Regression, regression

# Chance that honest groups are taken for miscounted ones.
ALARM = 0.002
# Groups that are told apart at most.
_MOST = 20


@dataclass(frozen=True)
class GroupBreaks:
    """A step of the orders at every gap between groups, all at once.

    `gain`: the fall of chi²; `variance` and `freedom` of what is left of it.
    """

    breaks: list[Break]
    gain: float
    variance: float
    freedom: int

    def explains_beyond(self, gain: float) -> bool:
        """Whether the steps together explain what a rival of one number, which explains so much of chi², does not."""
        more = len(self.breaks) - 1
        return bool(stats.f.sf(max(self.gain - gain, 0.0) / more / self.variance, more, self.freedom) < ALARM)


def group_breaks(line: Regression, floor: float) -> GroupBreaks | None:
    """The steps between three groups or more that no honest table shows by chance; None without.

    Each of them alone may be hidden by the others. Lines of one slope, an intercept for each group, against one line:
    Fisher's F.
    """
    orders = np.unique(line.order)
    gaps = np.flatnonzero(np.isin(orders, gaps_of(line.order)))
    counts = np.diff(np.concatenate([[0], gaps + 1, [len(orders)]]))
    if not 2 <= len(gaps) < _MOST or counts.min() < 2 or line.group.any() or line.slope <= 0:
        return None
    group = np.searchsorted(orders[gaps], line.order, side="left")
    apart = regression(line.order, line.y, line.weight, group)
    if apart.freedom < 1 or apart.slope <= 0:
        return None
    variance = max(apart.chi2 / apart.freedom, floor)
    gain = line.chi2 - apart.chi2
    chance = float(stats.f.sf(gain / len(gaps) / variance, len(gaps), apart.freedom))
    if chance > ALARM:
        return None
    breaks = [_break(apart, orders[gap], orders[gap + 1], k, variance, chance) for k, gap in enumerate(gaps)]
    if not any(step.is_step for step in breaks):
        return None
    return GroupBreaks(breaks, gain, variance, apart.freedom)


def _break(line: Regression, before: float, after: float, group: int, variance: float, chance: float) -> Break:
    """The step between a group and the next one."""
    centres = [float(np.mean(line.order[line.group == k])) for k in (group, group + 1)]
    jump = line.intercept(group + 1) - line.intercept(group)
    weights = line.group_weight[group : group + 2]
    relative = 1 / weights[0] + 1 / weights[1] + (centres[1] - centres[0]) ** 2 / line.spread
    sd = float(np.sqrt(variance * relative)) / line.slope
    first = float(line.y[line.group == group + 1].min())
    return Break(first, float(before), float(after), jump / line.slope, sd, chance, 0.0)
