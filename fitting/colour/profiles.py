"""Rings as means over sectors and bins of equal squared distance, over the light behind them."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float

from fitting.colour.blocks import Blocks
from fitting.colour.geometry import Placed, bins_of
from fitting.photo import Rings

# Sectors whose scatter gives the standard deviation, and fewest blocks to a bin of all of them.
SECTORS = 24
_FEWEST = 8
# Variance of fourth differences of white noise of variance 1, and median of the square of a normal number.
_FOURTH, _MEDIAN = 70.0, 0.455


@dataclass(frozen=True)
class Profiles:
    """Light over squared distance in sectors, over the light behind the rings.

    - `squares`: mean squared distance of each bin's blocks [px²], [bins]; `width` of a bin [px²].
    - `values` and `levels` (light itself, over the brightest) [channels, sectors, bins].
    - `counts`: blocks [sectors, bins]; `weights`: these where a channel is used, else 0 [channels, sectors, bins].
    """

    squares: Float[np.ndarray, " bins"]
    width: float
    values: Float[np.ndarray, "channels sectors bins"]
    levels: Float[np.ndarray, "channels sectors bins"]
    counts: Float[np.ndarray, "sectors bins"]
    weights: Float[np.ndarray, "channels sectors bins"]

    @cached_property
    def weight(self) -> Float[np.ndarray, "channels bins"]:
        """Of the rings' means."""
        return self.weights.sum(axis=1)

    @cached_property
    def means(self) -> Float[np.ndarray, "channels bins"]:
        """Over all sectors; 0 where nothing is used."""
        return (self.values * self.weights).sum(axis=1) / np.maximum(self.weight, 1e-12)

    @property
    def noise(self) -> Float[np.ndarray, " channels"]:
        """Variance of a block of weight 1 by fourth differences of the means, of which rings leave little."""
        return self.noise_of(self.means)

    def noise_of(self, means: Float[np.ndarray, "channels bins"]) -> Float[np.ndarray, " channels"]:
        """Variance of a block of weight 1 by fourth differences of other means."""
        squares = self.weight[:, 2:-2] * np.diff(means, 4, axis=1) ** 2
        return np.maximum(np.median(squares, axis=1), 1e-12) / (_FOURTH * _MEDIAN)

    def within(self, low: float, high: float) -> "Profiles":
        """Bins between two squared distances [px²] alone."""
        bins = (self.squares >= low) & (self.squares <= high)
        parts = {name: getattr(self, name)[..., bins] for name in ("values", "levels", "counts", "weights", "squares")}
        return replace(self, **parts)

    def below(self, level: Float[np.ndarray, " channels"]) -> "Profiles":
        """Without the bins of a channel that are brighter than a level."""
        dim = self.levels < np.asarray(level)[:, None, None]
        return replace(self, weights=np.where(dim, self.weights, 0.0))

    def channel(self, number: int) -> "Profiles":
        """One channel alone."""
        part = slice(number, number + 1)
        return replace(self, values=self.values[part], levels=self.levels[part], weights=self.weights[part])


def profiles_of(blocks: Blocks, placed: Placed, rings: Rings) -> Profiles:
    """The profiles of rings in their place."""
    used, figure = placed.is_used, placed.figure
    squares = figure.squares(blocks.x, blocks.y)
    bins = bins_of(squares, used, rings.scale)
    width = float(squares[used].max()) / bins
    ring = np.minimum((squares[used] / width).astype(int), bins - 1)
    angle = np.arctan2(blocks.y[used] - figure.y, blocks.x[used] - figure.x)
    sector = (angle / (2 * np.pi) * SECTORS).astype(int) % SECTORS
    cell, cells = sector * bins + ring, SECTORS * bins

    def sums(values: np.ndarray | None = None) -> np.ndarray:
        return np.bincount(cell, values, cells).reshape(SECTORS, bins)

    counts = sums().astype(float)
    share = np.maximum(counts, 1.0)
    values = np.stack(
        [sums((light / dark)[used]) / share for light, dark in zip(blocks.light, placed.behind, strict=True)]
    )
    levels = np.stack([sums(light[used]) / top / share for light, top in zip(blocks.light, blocks.top, strict=True)])
    total = counts.sum(axis=0)
    filled = total >= _FEWEST
    centres = sums(squares[used]).sum(axis=0) / np.maximum(total, 1.0)
    weights = np.broadcast_to(counts, values.shape)[..., filled]
    profiles = Profiles(centres[filled], width, values[..., filled], levels[..., filled], counts[:, filled], weights)
    if not blocks.is_saturated.any():
        return profiles
    return _without_saturated(profiles, blocks, figure, filled, bins)


def _without_saturated(profiles: Profiles, blocks: Blocks, figure, filled: np.ndarray, bins: int) -> Profiles:
    """Without bins a tenth of whose blocks is saturated: those that are not would be its darkest."""
    squares = figure.squares(blocks.x[blocks.is_saturated], blocks.y[blocks.is_saturated])
    ring = np.minimum((squares / profiles.width).astype(int), bins - 1)
    saturated = np.bincount(ring, minlength=bins)[filled]
    is_clear = saturated < 0.1 * profiles.counts.sum(axis=0)
    return replace(profiles, weights=np.where(is_clear, profiles.weights, 0.0))
