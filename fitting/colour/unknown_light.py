"""Light of which nothing is given: a spectrum of powers of 0 or more in each channel, and as smooth as rings allow."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

# What cameras see, with room for an error of the scale that the spectrum is drawn on [m].
_SHORTEST, _LONGEST = 340e-9, 900e-9
# Fewest waves and most; over the longest path difference neighbours part by so many turns.
_FEWEST, _MOST, _TURNS = 48, 400, 0.35
# Standard deviations of powers and of their second differences, over the light of a channel: lines are allowed.
_POWER, _ROUGHNESS = 1.0, 1 / 30


class UnknownLight(NamedTuple):
    """Waves equidistant in wavenumber, each a Gaussian profile as wide as its distance from the next.

    - `waves`: how many; `roughness`: of the powers that rings leave open, over the usual one.
    """

    waves: int
    roughness: float = 1.0

    @property
    def wavelengths(self) -> Float[np.ndarray, " waves"]:
        """Of the waves [m]."""
        return 1 / self._wavenumbers

    @property
    def widths(self) -> Float[np.ndarray, " waves"]:
        """Full widths at half maximum of the waves [m]."""
        step = self._wavenumbers[1] - self._wavenumbers[0]
        return step / self._wavenumbers**2

    @property
    def held(self) -> Float[np.ndarray, "rows waves"]:
        """The powers and their second differences, in standard deviations of what is expected of them."""
        rough = np.diff(np.eye(self.waves), 2, axis=0) / (self.roughness * _ROUGHNESS)
        return np.concatenate([rough, np.eye(self.waves) / _POWER])

    @property
    def _wavenumbers(self) -> Float[np.ndarray, " waves"]:
        return np.linspace(1 / _LONGEST, 1 / _SHORTEST, self.waves)


def unknown_light(path: float) -> UnknownLight:
    """Waves for path differences up to `path` [m]."""
    turns = path * (1 / _SHORTEST - 1 / _LONGEST)
    return UnknownLight(int(np.clip(np.ceil(turns / _TURNS), _FEWEST, _MOST)))
