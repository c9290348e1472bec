"""The rival of fringes that leave the fit's: spirals, circles of another law, rings of which part was found."""

import numpy as np

from fitting.photograph.remainder import Remainder
from fitting.photograph.rival import AbstractRival, Finding
from fitting.reasons import Reason

# A tile is astray whose fringes, as a complex amplitude over the fit's, are so far from 1, and so many turns from it,
# and explain so much of its light. So many tiles may be: of spirals 0.053 or more are, of photographs 0.018 at most.
_ASTRAY, _TURNS, _CLEAR, _SHARE = 1.1, 0.05, 0.8, 0.033


class Astray(AbstractRival):
    """Share of the field where the fringes lie elsewhere than the fit's.

    Outliers are weighted down, so that a fit may explain nearly all of what it uses and pass over what remains: all of
    the light counts here. Dust and print have no fringes of the fit's period that would explain their light.
    """

    name = "astray"

    def finding(self, remainder: Remainder) -> Finding | None:
        """Which share of the tiles is astray."""
        share = astray(remainder)
        if share < _SHARE:
            return None
        return Finding(self.name, share, _SHARE, "refusal", Reason.RIVAL_ASTRAY(share=share))


def astray(remainder: Remainder) -> float:
    """Share of the tiles whose fringes are clear, and elsewhere than the fit's."""
    tiles = remainder.tiles
    is_elsewhere = (np.abs(tiles.amplitude - 1) > _ASTRAY) & (np.abs(np.angle(tiles.amplitude)) > 2 * np.pi * _TURNS)
    return float((tiles.lit & is_elsewhere & (tiles.share > _CLEAR)).sum() / max(tiles.lit.sum(), 1))
