"""Pictures of a chain: every pair of numbers, and every number along the chain."""

import corner
import numpy as np
from matplotlib.figure import Figure

from fitting.parameters import with_sd


def corner_figure(names: tuple[str, ...], values: np.ndarray) -> Figure:
    """Histograms of all numbers and of all pairs, with median and 68 %; values [steps, walkers, names]."""
    table = values.reshape(-1, len(names))
    middle, spread = table.mean(axis=0), table.std(axis=0)
    # About their means and in their deviations: the digits that numbers share would fill the axes.
    labels = [f"{name}\n{with_sd(m, s)}" for name, m, s in zip(names, middle, spread, strict=True)]
    figure = Figure(figsize=(1.9 * len(names) + 1, 1.9 * len(names) + 1))
    scaled = (table - middle) / np.where(spread > 0, spread, 1.0)
    corner.corner(scaled, labels=labels, quantiles=[0.16, 0.5, 0.84], fig=figure, label_kwargs={"fontsize": 8})
    return figure


def trace_figure(names: tuple[str, ...], values: np.ndarray) -> Figure:
    """Every walker of every number against the step, burn-in left out; values [steps, walkers, names]."""
    figure = Figure(figsize=(9, 1.4 * len(names) + 0.6), layout="constrained")
    rows = figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
    for k, (axes, name) in enumerate(zip(rows, names, strict=True)):
        axes.plot(values[:, :, k], color="0.2", alpha=0.25, lw=0.4)
        axes.set_ylabel(name, fontsize=8)
        axes.tick_params(labelsize=7)
    rows[-1].set_xlabel("step")
    return figure
