"""The models of `models` as the solver takes them: on the nodes of one grid."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from fitting import gap_phase
from fitting.elimination import Fields
from fitting.fringe_sums import PhaseAt
from fitting.models import NUMBERS, Frame, GapModel
from fitting.reduction import Grid

_CONTACT = NUMBERS.index("contact")


def frame_on(grid: Grid) -> Frame:
    """The nodes of a grid's box; positions are counted from the middle of its frame, in half diagonals."""
    half_y, half_x = ((n - 1) / 2 for n in grid.shape)
    return Frame(*grid.nodes, (half_x, half_y), float(np.hypot(half_x, half_y)))


class AbstractFringes(ABC):
    """A model of the phase on the grid that it was made for."""

    @abstractmethod
    def fields(self, numbers: np.ndarray) -> Fields:
        """Phase, contrast and derivatives at the grid's nodes."""

    @abstractmethod
    def edges(self, numbers: np.ndarray) -> PhaseAt | None:
        """The phase at any position, where the nodes do not resolve it; None where they do."""


@dataclass(frozen=True)
class GapFringes(AbstractFringes):
    """The gap formula at the nodes of its frame, as blocks of pixels show it.

    `block` [px]: a mean over it adds the phase's second derivatives times (block² - 1) / 24, for r² fringes 4 k
    together; `contrast` at the nodes: what it leaves of the contrast (`block_contrast`), None for all.
    """

    model: GapModel
    block: int = 1
    contrast: np.ndarray | None = None

    def fields(self, numbers: np.ndarray) -> Fields:
        phase, slopes = gap_phase.phase_and_slopes(self.model, self.model.frame.x, self.model.frame.y, numbers)
        slopes = np.stack(slopes, axis=1)
        slopes[:, 0] += self._shift
        return Fields(phase + self._shift * numbers[0], slopes, self.contrast)

    def edges(self, numbers: np.ndarray) -> PhaseAt | None:
        if not numbers[_CONTACT] > 0:
            return None
        shift = self._shift * numbers[0]
        return lambda x, y: gap_phase.phase(self.model, x, y, numbers) + shift

    @property
    def _shift(self) -> float:
        return (self.block**2 - 1) / 6 / self.model.frame.unit**2


def block_contrast(frame: Frame, block: int, numbers: np.ndarray) -> np.ndarray | None:
    """What means over blocks leave of the contrast of r² fringes at the nodes: sin(π b f) / (b sin π f) a side.

    f is the fringes' frequency along the side [cycles per pixel].
    """
    if block == 1:
        return None
    k, left = numbers[0] / frame.unit**2, np.ones(len(frame.x))
    for at, middle, offset in zip((frame.x, frame.y), frame.middle, numbers[1:3], strict=True):
        turn = np.pi * np.clip(2 * k * (at - middle - offset * frame.unit), -0.45 / block, 0.45 / block)
        left *= np.sinc(block * turn / np.pi) / np.sinc(turn / np.pi)
    return left
