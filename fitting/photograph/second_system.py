"""The rival of a second system of rings: a ghost, another surface, a second colour, or moire with a grid."""

import numpy as np

from fitting.photo import Rings, block_means, polish, search, thin
from fitting.photograph.remainder import Remainder
from fitting.photograph.rival import AbstractRival, Finding
from fitting.reasons import Reason

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
        return Finding(self.name, rings.match, _MATCH, "warning", words)


def _is_first(remainder: Remainder, rings: Rings) -> bool:
    """Whether rings of the blocks are those of the fit, whose own misfit concentrates as well."""
    used = remainder.used[thin(remainder.used, _SOME)]
    step = thin(remainder.used, _SOME)[0].step
    rows, columns = (step * at for at in np.nonzero(used))
    turns = rings.scale * ((columns - rings.centre[0]) ** 2 + (rows - rings.centre[1]) ** 2)
    apart = turns - remainder.fit.phase[rows, columns]
    return bool(np.std(apart) < _SAME)
