"""A photograph and its fit, at every pixel: what pictures of a result are drawn from."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fitting.estimate import Fitted, pictures
from fitting.photo import Photograph


@dataclass(frozen=True)
class Picture:
    """What the pictures are drawn from: the photograph, and of its fit what is asked for, at every pixel.

    `fitted`: the model image; `phase`: of the rings [turns]; `weights`: of the pixels.
    """

    photograph: Photograph
    found: Fitted

    @cached_property
    def fitted(self) -> np.ndarray:
        return pictures.fitted(self.found, self.phase)

    @cached_property
    def phase(self) -> np.ndarray:
        return pictures.phase(self.found)

    @cached_property
    def weights(self) -> np.ndarray:
        return pictures.weights(self.found, self.photograph.mask)


@dataclass(frozen=True)
class DrawnPicture:
    """What the pictures are drawn from, of a fit that has it all at every pixel; the names are those of `Picture`."""

    photograph: Photograph
    fitted: np.ndarray
    phase: np.ndarray
    weights: np.ndarray
