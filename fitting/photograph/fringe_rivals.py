"""Rivals in what a fit leaves over: fringes that lie elsewhere, have another waveform, or are a second system's.

Spirals, circles of another law, rings of which part was found; many beams, a camera's curve, clipping; a ghost, another
face, a second colour, moire with a grid.
"""

import numpy as np

from fitting.photo import Rings, block_means, polish, search, thin
from fitting.photograph.remainder import Remainder
from fitting.photograph.rival import AbstractRival, Finding
from fitting.reasons import Reason

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
