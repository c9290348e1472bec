"""A control chart: a measured quantity against time, and which photographs do not belong to the others."""

from collections.abc import Sequence
from datetime import datetime
from typing import Any, NamedTuple

import numpy as np

# Fewer values give no limits.
FEWEST = 5
# Three standard deviations on each side (Shewhart 1931), and the median of the distance of two normal deviates of
# standard deviation 1.
_LIMIT, _MEDIAN_RANGE = 3.0, 0.9539


class Control(NamedTuple):
    """Centre line, limits, and whether each value lies outside of its own limits."""

    centre: float
    low: float
    high: float
    outliers: tuple[bool, ...]


def control(values: Sequence[float], sds: Sequence[float]) -> Control | None:
    """Limits for individual values in the order of time; None for fewer than five.

    Centre: the median. Standard deviation: the median of the moving ranges over 0.954 (Montgomery, Introduction to
    Statistical Quality Control, section 6.4, with the median in place of the mean, which outliers do not move); a slow
    drift does not widen it. A value whose own `sds` is larger has wider limits.
    """
    if len(values) < FEWEST:
        return None
    x = np.asarray(values, float)
    centre = float(np.median(x))
    sd = float(np.median(np.abs(np.diff(x)))) / _MEDIAN_RANGE
    outliers = np.abs(x - centre) > _LIMIT * np.maximum(sd, np.asarray(sds, float))
    return Control(centre, centre - _LIMIT * sd, centre + _LIMIT * sd, tuple(map(bool, outliers)))


def draw(
    ax: Any, times: Sequence[str], values: Sequence[float], sds: Sequence[float], limits: Control | None, label: str
) -> None:
    """Draw values with error bars against time, the centre line, the limits, and outliers in red.

    Copied photographs often share one time: where most share theirs, each has a place in their order instead.
    """
    from matplotlib.dates import ConciseDateFormatter
    from matplotlib.ticker import MaxNLocator

    moments: list[Any] = [datetime.fromisoformat(time) for time in times]
    have_times = len({moment.replace(microsecond=0) for moment in moments}) > len(moments) / 2
    if not have_times:
        moments = list(range(1, len(times) + 1))
    ax.errorbar(moments, values, sds, fmt="o", markersize=3, linewidth=1, color="tab:blue", label="photographs")
    if limits is not None:
        ax.axhline(limits.centre, color="0.3", linewidth=1, label="median")
        for limit in (limits.low, limits.high):
            ax.axhline(limit, color="0.3", linewidth=1, linestyle="--")
        outside = [place for place, is_outlier in enumerate(limits.outliers) if is_outlier]
        if outside:
            x, y = [moments[place] for place in outside], [values[place] for place in outside]
            ax.plot(x, y, "o", color="tab:red", markersize=6, label=f"outliers ({len(outside)})")
    if have_times:
        ax.xaxis.set_major_formatter(ConciseDateFormatter(ax.xaxis.get_major_locator()))
    else:
        ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.set_xlabel("time" if have_times else "photograph, in the order of the table")
    ax.set_ylabel(label)
    ax.legend(loc="best")
