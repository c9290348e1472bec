"""The rival of fringes that leave the fit's: spirals, circles of another law, rings of which part was found."""

import numpy as np

from fitting.photograph.remainder import Remainder
from fitting.photograph.rival import AbstractRival, Finding
from fitting.reasons import Reason

# A tile is astray whose fringes, as a complex amplitude over the fit's, are so far from 1, and so many turns from it,
# and explain so much of its light.
_ASTRAY, _TURNS, _CLEAR = 1.1, 0.05, 0.8
# Share of the tiles that may be: as much as this of the structure in what is left over, between the ends. Of 60 spirals
# 0.042 or more are, 1.3 times the limit at least; of photographs, whose structure is 0.07 to 0.4, 0.018 at most.
_OF_STRUCTURE, _LEAST, _MOST = 0.25, 0.02, 0.045


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
