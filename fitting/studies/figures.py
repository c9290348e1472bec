"""Pictures of `Information`, `Sensitivity` and `Spread`: of anything with their attributes."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

# Derivatives of the image that are shown beside the target's own.
_PICTURES = 5


def correlations(result: Any, ax=None) -> Any:
    """Correlations of the bounds, where both are finite and neither is fixed."""
    canvas, axes = _axes(ax, (6.4, 5.4))
    covariance = result.covariance
    sd = np.sqrt(np.diag(covariance))
    is_shown = np.isfinite(sd) & (sd > 0)
    names = [name.replace("_", " ") for name, shown_one in zip(result.names, is_shown, strict=True) if shown_one]
    block = covariance[np.ix_(is_shown, is_shown)] / np.outer(sd[is_shown], sd[is_shown])
    if names:
        axes.imshow(block, cmap="RdBu_r", vmin=-1, vmax=1)
    for row, column in np.ndindex(block.shape):
        axes.annotate(f"{block[row, column]:.2f}", (column, row), ha="center", va="center", fontsize=7)
    axes.set_xticks(range(len(names)), names, rotation=45, ha="right")
    axes.set_yticks(range(len(names)), names)
    axes.set_title("correlation of the bounds" if names else "no parameter is determined", fontsize=10)
    return canvas


def tolerances(result: Any, ax=None) -> Any:
    """How well each number must be known, and the derivatives of the image, each on its own scale."""
    if ax is not None or result.images is None:
        canvas, axes = _axes(ax, (6.4, 5.2))
        _tolerance_bars(result, axes)
        return canvas
    canvas = Figure(figsize=(11, 5.2), layout="constrained")
    grid = canvas.add_gridspec(2, 5)
    _tolerance_bars(result, canvas.add_subplot(grid[:, :2]))
    names = [result.target, *(row.name for row in result.neglected[:_PICTURES])]
    units = {row.name: row.unit for row in result.neglected}
    for place, (name, image) in enumerate(result.images(names).items()):
        axes = canvas.add_subplot(grid[place // 3, 2 + place % 3])
        edge = float(np.abs(image).max()) or 1.0
        axes.imshow(image, cmap="RdBu_r", vmin=-edge, vmax=edge)
        per = f" per {units.get(name, result.unit) or 'unit'}"
        axes.set_title(
            f"photoelectrons{per} of {name.replace('_', ' ')}\nred +{edge:.2g}, blue -{edge:.2g}", fontsize=7
        )
        axes.set(xticks=[], yticks=[])
    return canvas


def _tolerance_bars(result: Any, axes) -> None:
    # A number whose error may be as large as itself need not be known.
    rows = [row for row in result.neglected if row.tolerance < row.size][::-1]
    digits = -np.log10([row.tolerance / row.size for row in rows]) if rows else np.zeros(0)
    axes.barh(range(len(rows)), digits, color="tab:blue", height=0.6)
    axes.set_yticks(range(len(rows)), [row.name.replace("_", " ") for row in rows])
    for k, row in enumerate(rows):
        axes.annotate(f" ± {with_unit(row.tolerance, row.unit)}", (digits[k], k), va="center", fontsize=8)
    axes.set_xlabel("digits to which it must be known\n(of a mrad for tilts of 0, of the wavelength for a gap)")
    axes.set_title(f"to know the {result.target} to {result.relative_accuracy:.2g} of it", fontsize=10)
    axes.set_xlim(0.0, 1.35 * max(digits, default=1.0))


def scatter(result: Any, ax=None) -> Any:
    """The draws beside the normal curve that slopes predict, and each number's fraction of their variance."""
    if ax is not None:
        _draws(result, ax)
        return ax.figure
    canvas = Figure(figsize=(10, 4), layout="constrained")
    draws, shares = canvas.subplots(1, 2)
    _draws(result, draws)
    rows = result.shares[::-1]
    height = 0.35
    for shift, name, label in (
        (height / 2, "first", "first order: by itself"),
        (-height / 2, "total", "total: with what others add"),
    ):
        values = np.array([getattr(share, name) for share in rows])
        low, high = np.array([getattr(share, f"{name}_range") for share in rows]).T
        error = np.maximum([values - low, high - values], 0.0)
        shares.barh(np.arange(len(rows)) + shift, values, height, xerr=error, label=label)
    shares.set_yticks(
        range(len(rows)), [f"{share.name.replace('_', ' ')} ± {with_unit(share.sd, share.unit)}" for share in rows]
    )
    shares.set(title="fraction of the variance (Sobol), bars 95 %", xlabel="fraction")
    shares.legend(fontsize=8)
    return canvas


def _draws(result: Any, axes) -> None:
    unit = f" {result.unit}" if result.unit else ""
    axes.hist(result.targets, bins=30, density=True, color="tab:blue", alpha=0.6, label="fits with errors drawn")
    if result.slope_sd > 0.02 * result.sd:
        low, high = axes.get_xlim()
        at = np.linspace(low, high, 400)
        bell = np.exp(-(((at - result.value) / result.slope_sd) ** 2) / 2) / (result.slope_sd * np.sqrt(2 * np.pi))
        axes.plot(at, bell, color="k", lw=1, label=f"by slopes alone, sd {result.slope_sd:.2g}{unit}")
    axes.axvline(result.value, color="tab:red", lw=1, label="the value in the image")
    axes.set(
        title=f"{len(result.targets)} fits, sd {result.sd:.2g}{unit}",
        xlabel=f"{result.target} [{result.unit or 1}]",
        yticks=[],
    )
    axes.legend(fontsize=8)


def _axes(ax, size: tuple[float, float]) -> tuple[Any, Any]:
    """The figure of axes, and they; new ones where none are given."""
    if ax is not None:
        return ax.figure, ax
    canvas = Figure(figsize=size, layout="constrained")
    return canvas, canvas.subplots()


def with_unit(value: float, unit: str) -> str:
    """A length in nm to m, an angle in mrad, other units as they are."""
    if unit == "m":
        for factor, name in ((1e9, "nm"), (1e6, "um"), (1e3, "mm")):
            if value * factor < 1000:
                return f"{value * factor:.2g} {name}"
    return f"{value * 1e3:.2g} mrad" if unit == "rad" else f"{value:.2g} {unit}".rstrip()
