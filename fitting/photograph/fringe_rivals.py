"""Rivals in what a fit leaves over or out: fringes elsewhere, of another waveform, or of a second system.

Spirals, circles of another law, rings of which part was found; many beams, a camera's curve, clipping; a ghost, another
face, a second colour, moire with a grid.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from numpy.polynomial.chebyshev import chebvander
from scipy import fft

from fitting.photo import Rings, block_means, noise_variance, polish, search, thin
from fitting.photograph.remainder import Remainder
from fitting.photograph.rival import AbstractRival, Finding
from fitting.reasons import Reason
from newtonjax.numerics import chebyshev

# A tile is astray whose fringes, as a complex amplitude over the fit's, are so far from 1, and so many turns from it,
# and explain so much of its light.
_ASTRAY, _TURNS, _CLEAR = 1.1, 0.05, 0.8
# Share of the tiles that may be: as much as this of the structure in what is left over, between the ends. Of 60 spirals
# 0.042 or more are, 1.3 times the limit at least; of photographs, whose structure is 0.07 to 0.4, 0.018 at most.
_OF_STRUCTURE, _LEAST, _MOST = 0.25, 0.02, 0.045
# A third harmonic over the first less half the square of the second: power laws of a camera leave -0.04 to 0.015 of
# two beams' fringes; more where their exponent is below 1, which makes the second negative.
_CUT, _SOFT, _SHARP = -0.04, 0.015, 0.02
# Harmonics are told where a fringe is so many blocks wide at least, in cycles of the harmonic per block.
_RESOLVED = 0.45
# Harmonics by chance exceed so many of their standard deviations next to never.
_SIGNIFICANT = 5.0
# Share of what is left over that a second system explains, and its scale over the first's. Harmonics of the fringes
# concentrate as well, at the first's centre and 2, 3, ... times its scale.
_MATCH, _SCALES = 0.1, (0.4, 1.9)
# Structure below this share of the fringes' half swing is not looked at: it moves no radius by more than its budget.
_FAINT = 0.02
# Rings whose phase differs from the first's by less than this (standard deviation) [turns] are the first's own misfit;
# it is looked at in so many blocks.
_SAME, _SOME = 0.5, 4000
# Blocks to a side of the image that is searched.
_COARSE = 96

# The weakly lit part is asked from this share of the used pixels on, in tiles: so many to a side of the field, of so
# many blocks to a side at least, in which this share is lit weakly.
_ASKED, _TILES, _SMALLEST, _LIT = 0.05, 12, 8, 0.6
# Nodes to a side of a tile at which the fit's phase is taken.
_NODES = 4
# Places to a side of a tile's spectrum, over its blocks; frequencies off the fit's that are looked at, over its own:
# beyond lie the background and the fringes' mirror image.
_FINER, _NEXT = 2, 0.6
# A tile tells where its fringes lie, if they explain so much of its light beyond noise, and are so many.
_SHOWN, _FRINGES = 0.5, 1.5
# Fringes contradict the fit that lie so many turns off it in a tile's middle, or drift by so many across it.
_OFF, _DRIFT = 0.25, 0.4
# Share of the tiles, used ones and clear ones, that may contradict.
_MOST_WEAK = 0.1
# Spacings that differ by more than this are not of one radius, whatever its deviation: there is no answer.
_APART = 0.15


class Astray(AbstractRival):
    """Share of the field where the fringes lie elsewhere than the fit's.

    Outliers are weighted down, so that a fit may explain nearly all of what it uses and pass over what remains: all of
    the light counts here. Dust and print have no fringes of the fit's period that would explain their light.
    """

    name = "astray"

    def finding(self, remainder: Remainder) -> Finding | None:
        """Which share of the tiles is astray."""
        share, limit = astray(remainder), float(np.clip(_OF_STRUCTURE * remainder.structure, _LEAST, _MOST))
        if share < limit:
            return None
        return Finding(self.name, share, limit, "refusal", Reason.RIVAL_ASTRAY(share=share))


def astray(remainder: Remainder) -> float:
    """Share of the tiles whose fringes are clear, and elsewhere than the fit's."""
    tiles = remainder.tiles
    is_elsewhere = (np.abs(tiles.amplitude - 1) > _ASTRAY) & (np.abs(np.angle(tiles.amplitude)) > 2 * np.pi * _TURNS)
    return float((tiles.lit & is_elsewhere & (tiles.share > _CLEAR)).sum() / max(tiles.lit.sum(), 1))


class Waveform(AbstractRival):
    """Harmonics of the fringes: the waveform of N beams is Airy's, with harmonics q, q² over the first.

    A power g of 1 + m cos x has a second harmonic s = m (g - 1) / 4 and a third (2/3) (g - 2) / (g - 1) s² to lowest
    order in m: at most 0.67 s² where s is positive, where Airy's is s².
    """

    name = "waveform"

    def finding(self, remainder: Remainder) -> Finding | None:
        """What the second and third harmonic in phase say."""
        second, third, deviation = harmonics(remainder)
        value = third - second**2 / 2
        limit = _SOFT if value > 0 else _CUT
        if abs(value) < abs(limit) + _SIGNIFICANT * deviation or (value > 0 and second < _SHARP):
            return None
        sentence = Reason.RIVAL_SHARP_FRINGES if value > 0 else Reason.RIVAL_CUT_FRINGES
        return Finding(self.name, float(value), limit, "warning", sentence(second=second, third=third))


def harmonics(remainder: Remainder) -> tuple[float, float, float]:
    """Second and third harmonic in phase over the first, and the third's standard deviation."""
    fit, used, cosine = remainder.fit, remainder.used, remainder.cosine
    slope_y, slope_x = np.gradient(fit.phase.astype(np.float32)) if min(used.shape) > 1 else (0.0, 0.0)
    finest = np.hypot(slope_y, slope_x)
    columns = []
    for order, wave in ((2, 2 * cosine**2 - 1), (3, (4 * cosine**2 - 3) * cosine)):
        columns.append(np.where(used & (order * finest < _RESOLVED), remainder.swing * wave, 0.0)[used])
    design = np.stack(columns, axis=1).astype(float)
    weighted = design * fit.left.weights[used][:, None]
    matrix = weighted.T @ design
    if not np.linalg.cond(matrix) < 1e6:
        return 0.0, 0.0, np.inf
    second, third = np.linalg.solve(matrix, weighted.T @ fit.left.value[used])
    variance = fit.chi2 / max(fit.weight, 1.0)
    return float(second), float(third), float(np.sqrt(variance * np.linalg.inv(matrix)[1, 1]))


class SecondSystem(AbstractRival):
    """Rings that what is left over holds: a search with the matched filter on it."""

    name = "second system"

    def finding(self, remainder: Remainder) -> Finding | None:
        """What the best rings of the remainder say."""
        if remainder.structure < _FAINT:
            return None
        fit, used = remainder.fit, remainder.used
        swing = np.abs(remainder.swing)
        light = np.where(used, fit.left.value * np.sqrt(fit.left.weights) / np.maximum(swing, 0.1 * swing.max()), 0.0)
        factor = max(1, -(-max(used.shape) // _COARSE))
        coarse = block_means(light, factor).astype(np.float32)
        rings = polish(coarse, search(coarse, 1)[0])
        ratio = rings.scale / (factor * fit.reduced.grid.block) ** 2 / abs(remainder.scale)
        if rings.match < _MATCH or not _SCALES[0] < ratio < _SCALES[1]:
            return None
        if _is_first(remainder, rings.on_pixels(factor)):
            return None
        contrast = float(np.sqrt(2 * rings.match * np.mean(coarse**2)))
        words = Reason.RIVAL_SECOND_SYSTEM(ratio=ratio, contrast=contrast)
        # What is stronger than the rings themselves is no ghost of them: they are not what the image shows.
        return Finding(self.name, rings.match, _MATCH, "warning" if contrast < 1 else "refusal", words)


def _is_first(remainder: Remainder, rings: Rings) -> bool:
    """Whether rings of the blocks are those of the fit, whose own misfit concentrates as well."""
    used = remainder.used[thin(remainder.used, _SOME)]
    step = thin(remainder.used, _SOME)[0].step
    rows, columns = (step * at for at in np.nonzero(used))
    turns = rings.scale * ((columns - rings.centre[0]) ** 2 + (rows - rings.centre[1]) ** 2)
    apart = turns - remainder.fit.phase[rows, columns]
    return bool(np.std(apart) < _SAME)


class WeakTiles(NamedTuple):
    """Tiles of the weakly lit part that show fringes [tiles]: how these differ from the fit's.

    `turns`: in a tile's middle, -0.5 to 0.5; `drift` [turns]: across a tile; `spacing`: their number per length over
    the fit's, less 1.
    """

    turns: Float[np.ndarray, " tiles"]
    drift: Float[np.ndarray, " tiles"]
    spacing: Float[np.ndarray, " tiles"]


class WeakLight(AbstractRival):
    """Rings of the weakly lit part of the field, of which the fit knows nothing, against those that it predicts there.

    A plane, and the one cosine with the largest share of the light, next to the fit's own frequency, are what a tile
    shows: the peak of its light's spectrum, demodulated by the fit's phase.
    """

    name = "weak light"

    def finding(self, remainder: Remainder) -> Finding | None:
        """In which share of the field rings lie elsewhere, and by how much their spacing differs."""
        size = _tile_side(remainder)
        tiles = weak_tiles(remainder, size)
        if tiles is None:
            return None
        is_elsewhere = (np.abs(tiles.turns) > _OFF) | (tiles.drift > _DRIFT)
        used = np.count_nonzero(remainder.used) / size**2
        share = float(np.count_nonzero(is_elsewhere) / max(used + len(is_elsewhere), 1))
        if share < _MOST_WEAK:
            return None
        spacing = float(np.sqrt(np.mean(tiles.spacing**2)))
        if spacing > _APART:
            words = Reason.RIVAL_WEAK_LIGHT_APART(share=share, spacing=spacing)
            return Finding(self.name, share, _MOST_WEAK, "refusal", words)
        words = Reason.RIVAL_WEAK_LIGHT(share=share, spacing=spacing)
        return Finding(self.name, share, _MOST_WEAK, "warning", words, spacing)


def _tile_side(remainder: Remainder) -> int:
    """Blocks to a side of a tile."""
    photograph = remainder.photograph
    lit = np.count_nonzero(photograph.lit) + (0 if photograph.dim is None else np.count_nonzero(photograph.dim))
    return max(_SMALLEST, int(np.sqrt(lit)) // remainder.fit.reduced.grid.block // _TILES)


def weak_tiles(remainder: Remainder, size: int) -> WeakTiles | None:
    """Tiles of so many blocks to a side; None where next to nothing is lit weakly, or the fit's phase ends there."""
    fit, photograph, dim = remainder.fit, remainder.photograph, remainder.photograph.dim
    block = fit.reduced.grid.block
    if (
        dim is None
        or fit.solution.problem.phase.exact is None
        or np.count_nonzero(dim) < _ASKED * np.count_nonzero(photograph.mask)
    ):
        return None
    ends = [np.flatnonzero(dim.any(axis=axis)) for axis in (1, 0)]
    box = (slice(int(ends[0][0]), int(ends[0][-1]) + 1), slice(int(ends[1][0]), int(ends[1][-1]) + 1))
    means, share = photograph.codes.means(block, box, dim)
    rows, columns = (n // size for n in means.shape)

    def cut(table: np.ndarray) -> np.ndarray:
        return table[: rows * size, : columns * size].reshape(rows, size, columns, size).swapaxes(1, 2)

    used = cut((share >= 0.5).astype(float))
    lit = used.mean(axis=(2, 3)) > _LIT
    used, light = used[lit], cut(means)[lit]
    corners = [part.start + block * size * at for part, at in zip(box, np.nonzero(lit), strict=True)]
    phase = _phase_of(remainder, corners, size)
    slopes = np.stack([np.diff(phase, axis=2).mean(axis=(1, 2)), np.diff(phase, axis=1).mean(axis=(1, 2))], axis=1)
    # Tiles with fewer fringes tell nothing.
    many = np.hypot(*slopes.T) * size > _FRINGES
    if not many.any():
        return None
    used, light, phase, slopes = used[many], light[many], phase[many], slopes[many]
    fringes = _without_plane(light, used)
    power = np.square(fringes).sum(axis=(1, 2))
    peak, at = _peaks(fringes * np.exp(-2j * np.pi * phase), np.hypot(*slopes.T))
    weight = used.sum(axis=(1, 2))
    noise = np.minimum(noise_variance(means, share >= 0.5) * weight, 0.9 * power)
    clear = 2 * np.abs(peak) ** 2 > _SHOWN * weight * (power - noise)
    spacing = (at * slopes).sum(axis=1) / np.square(slopes).sum(axis=1)
    # Fringes of negative contrast are half a turn off their phase.
    peak *= np.sign(remainder.swing.mean()) or 1.0
    return WeakTiles(np.angle(peak[clear]) / (2 * np.pi), size * np.hypot(*at[clear].T), spacing[clear])


def _phase_of(remainder: Remainder, corners: list[np.ndarray], size: int) -> np.ndarray:
    """The fit's phase [turns] at the blocks of tiles with these first rows and columns [px], [tiles, rows, columns].

    Within a tile it is a cubic in each direction: fringes are told where it is next to straight.
    """
    fit = remainder.fit
    nodes, block, half = chebyshev.nodes(_NODES), fit.reduced.grid.block, (size - 1) / 2
    y, x = (first[:, None] + block * (half * (nodes + 1) + 0.5) - 0.5 for first in corners)
    shape = (len(x), _NODES, _NODES)
    x, y = np.broadcast_to(x[:, None, :], shape), np.broadcast_to(y[:, :, None], shape)
    turns = fit.solution.problem.phase.slopes_at(x.ravel(), y.ravel(), fit.numbers)[0].reshape(shape)
    along = chebvander(np.arange(size) / half - 1, _NODES - 1) @ np.linalg.inv(chebvander(nodes, _NODES - 1))
    return along @ turns @ along.T


def _without_plane(light: np.ndarray, used: np.ndarray) -> np.ndarray:
    """Light of tiles [tiles, rows, columns] less the plane that is nearest to it where it is used; zero elsewhere."""
    size = light.shape[1]
    place = (np.arange(size) - (size - 1) / 2) / size
    plane = np.stack([np.ones((size, size)), *np.meshgrid(place, place)], axis=-1)
    plane = plane.reshape(-1, 3)
    products = (plane[:, :, None] * plane[:, None, :]).reshape(-1, 9)
    flat, weights = light.reshape(len(light), -1), used.reshape(len(used), -1)
    normal, right = (weights @ products).reshape(-1, 3, 3), (weights * flat) @ plane
    numbers = np.linalg.solve(normal, right[..., None])[..., 0]
    return (weights * (flat - numbers @ plane.T)).reshape(light.shape)


def _peaks(waves: np.ndarray, frequency: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The largest amplitude of tiles' spectra within a share of a frequency [cycles a block], as in their middle.

    Also its frequency (x, y) [cycles a block, tiles].
    """
    size, count = waves.shape[1], _FINER * waves.shape[1]
    at, tiles = np.fft.fftfreq(count), np.arange(len(waves))
    spectra = np.asarray(fft.fft2(waves.astype(np.complex64), (count, count)))
    heights = np.abs(spectra)
    near = np.hypot(at, at[:, None]) < _NEXT * frequency[:, None, None]
    row, column = np.divmod(np.where(near, heights, -1.0).reshape(len(waves), -1).argmax(axis=1), count)
    peak, frequencies = spectra[tiles, row, column], np.stack([at[column], at[row]], axis=1)
    # The phase in the middle is that at the bin, which the tile's fringes share; the frequency lies between bins.
    peak = peak * np.exp(2j * np.pi * frequencies.sum(axis=1) * (size - 1) / 2)
    for axis, (down, across) in enumerate(((0, 1), (1, 0))):
        before, after = (heights[tiles, (row + k * down) % count, (column + k * across) % count] for k in (-1, 1))
        bend = 2 * heights[tiles, row, column] - before - after
        frequencies[:, axis] += np.clip((after - before) / (2 * np.maximum(bend, 1e-30)), -0.5, 0.5) / count
    return peak, frequencies
