"""What a fit leaves over at every block, and where the fringes lie against it from tile to tile."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Complex, Float

from fitting.estimate import Fitted, at_blocks
from fitting.parameters import Numbers
from fitting.photo import Photograph, block_means, noise_variance

# Tiles to a side of the field, blocks to a side of the smallest, and the share of a tile that has to be lit.
_TILES, _SMALLEST, _LIT = 12, 5, 0.4
# A tile in which cosine and sine, the background taken out, are more alike than this tells nothing.
_ALIKE = 1e-3


class Tiles(NamedTuple):
    """The light of tiles [rows, columns] against the fit's fringes.

    - `amplitude`: of the tile's fringes over the fit's, its argument the phase by which they are ahead [radians].
    - `share`: of the tile's variance, white noise taken off, that its own fringes explain.
    - `lit`: tiles that tell it; the others hold zeros.
    """

    amplitude: Complex[np.ndarray, "rows columns"]
    share: Float[np.ndarray, "rows columns"]
    lit: Bool[np.ndarray, "rows columns"]


class Remainder:
    """A finished fit and its photograph, with the fringes at every block [rows, columns], made once for all rivals.

    - `used`: blocks that Tukey's weights do not leave out; `swing`: half of the fringes' swing, as the fit has it;
      `cosine`, `sine`: of their phase.
    - `noise`: variance of a block's white noise per unit weight; `structure`: root mean square of what is left over
      beyond it, over that of the half swing.
    - `first`: what the fit's first number is, or is a relative change of, in its units.
    - `scale`: of the fringes [turns/px²], whatever the model; `nodes`: places (x, y) of the grid's nodes from the
      rings' centre [half diagonals].
    - `tiles`: least squares of background, cosine and sine in every tile, where all blocks count alike.
    """

    def __init__(self, fit: Fitted, photograph: Photograph):
        grid, residuals = fit.reduced.grid, fit.left
        self.fit, self.photograph, self.used = fit, photograph, residuals.weights > 0
        angle = (2 * np.pi * (fit.phase % 1.0)).astype(np.float32)
        self.swing = at_blocks(grid, fit.solution.point.modulus).astype(np.float32)
        self.cosine, self.sine = np.cos(angle), np.sin(angle)
        self.noise = noise_variance(fit.reduced.inverse_sd * residuals.value, self.used)
        excess = max(residuals.square / max(fit.weight, 1e-300) - self.noise, 0.0)
        self.structure = float(np.sqrt(excess / max(float(np.mean(self.swing**2, where=self.used)), 1e-300)))
        curvature = float(Numbers(*fit.numbers).curvature)
        self.first = abs(curvature) if fit.model.holds_turns else 1 + curvature
        self.scale, centre = paraboloid(fit)
        self.nodes = tuple((at - c) / fit.model.frame.unit for at, c in zip(grid.nodes, centre, strict=True))
        self.tiles = self._tiles()

    def _tiles(self) -> Tiles:
        fit, weights = self.fit, self.fit.reduced.weights.astype(np.float32)
        even, odd = self.swing * self.cosine, self.swing * self.sine
        light = fit.left.value + even
        size = max(_SMALLEST, int(np.sqrt(weights.size)) // _TILES)
        weighted_even, weighted_odd = weights * even, weights * odd
        columns = (weights, weighted_even, weighted_odd, weighted_even * even, weighted_even * odd, weighted_odd * odd)
        products = (weights * light, weighted_even * light, weighted_odd * light, weights * light**2)
        total, c, s, cc, cs, ss, d, dc, ds, dd = (
            block_means(table, size).astype(float) for table in (*columns, *products)
        )
        lit = total > _LIT * max(float(total.max()), 1e-300)
        # Background taken out, the two fringes' normal equations are left.
        share = np.where(lit, total, 1.0)
        cc, cs, ss = cc - c * c / share, cs - c * s / share, ss - s * s / share
        dc, ds, dd = dc - c * d / share, ds - s * d / share, dd - d * d / share
        determinant = cc * ss - cs * cs
        lit &= determinant > _ALIKE * np.maximum(cc, ss) ** 2
        determinant = np.where(lit, determinant, np.inf)
        c, s = (ss * dc - cs * ds) / determinant, (cc * ds - cs * dc) / determinant
        fringes, noise = c * dc + s * ds, total * self.noise
        explained = fringes / np.maximum(np.maximum(dd - noise, fringes), 1e-300)
        return Tiles(c - 1j * s, np.where(lit, explained, 0.0), lit)


def paraboloid(fit: Fitted) -> tuple[float, tuple[float, float]]:
    """Scale and centre (x, y) [px] of the r² fringes that are nearest to the fit's phase at the grid's nodes."""
    x, y = fit.reduced.grid.nodes
    middle, unit = (float(x.mean()), float(y.mean())), float(np.ptp(x))
    u, v = (x - middle[0]) / unit, (y - middle[1]) / unit
    design = np.stack([np.ones_like(u), u, v, u * u + v * v], axis=1)
    _, along_x, along_y, bend = np.linalg.lstsq(design, fit.solution.fields.phase, rcond=None)[0]
    bend = bend or 1e-300
    centre = (middle[0] - unit * along_x / (2 * bend), middle[1] - unit * along_y / (2 * bend))
    return float(bend / unit**2), (float(centre[0]), float(centre[1]))
