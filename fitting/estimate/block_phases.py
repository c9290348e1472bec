"""The models of `phase` as the solver takes them: on the nodes of one grid."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace

import jax.numpy as jnp
import numpy as np

from fitting.estimate.elimination import Fields
from fitting.estimate.fringe_sums import PhaseAt, table_of
from fitting.model import EDGES, Frame, GapModel, SceneModel, as_arrays, gap_phase, localize
from fitting.parameters import NUMBERS, Numbers
from fitting.photo import NODES, Grid

_CURVATURE = NUMBERS.index("curvature")
# A tangent of a bench's phase holds to a millionth of a turn within a thousandth of one.
_STRAIGHT = 1e-3


def frame_on(grid: Grid, numbers: np.ndarray | None = None) -> Frame:
    """The nodes of a grid's box; positions are counted from the middle of its frame, in half diagonals.

    `numbers`: of r² fringes whose contrast the grid's blocks lower.
    """
    half_y, half_x = ((n - 1) / 2 for n in grid.shape)
    frame = Frame(*grid.nodes, (half_x, half_y), float(np.hypot(half_x, half_y)), float(grid.block))
    if numbers is None:
        return frame
    by_name = Numbers(*numbers)
    x, y = (
        (at - middle) / frame.unit - offset
        for at, middle, offset in zip(
            (frame.x, frame.y), frame.middle, (by_name.centre_x, by_name.centre_y), strict=True
        )
    )
    frame = frame._replace(reach=float(np.hypot(x, y).max()))
    return frame if grid.block == 1 else frame._replace(contrast=_block_contrast(frame, numbers))


def _block_contrast(frame: Frame, numbers: np.ndarray) -> np.ndarray:
    """What means over blocks leave of the contrast of r² fringes at the nodes: sin(π b f) / (b sin π f) a side.

    f is the fringes' frequency along the side [cycles per pixel].
    """
    by_name = Numbers(*numbers)
    k, contrast = by_name.curvature / frame.unit**2, np.ones(len(frame.x))
    offsets = (by_name.centre_x, by_name.centre_y)
    for at, middle, offset in zip((frame.x, frame.y), frame.middle, offsets, strict=True):
        turn = np.pi * np.clip(2 * k * (at - middle - offset * frame.unit), -0.45 / frame.block, 0.45 / frame.block)
        contrast *= np.sinc(frame.block * turn / np.pi) / np.sinc(turn / np.pi)
    return contrast


class AbstractFringes(ABC):
    """A model of the phase on the grid that it was made for.

    `exact`: the model where a formula gives its phase at any point, not at the grid's nodes alone.
    """

    exact: GapModel | None

    @abstractmethod
    def fields(self, numbers: np.ndarray) -> Fields:
        """Phase, contrast and derivatives at the grid's nodes."""

    @abstractmethod
    def edges(self, numbers: np.ndarray) -> PhaseAt | None:
        """The phase of rows of blocks, where the nodes do not resolve it; None where they do."""

    @abstractmethod
    def slopes_at(self, x: np.ndarray, y: np.ndarray, numbers: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Phase of blocks [turns] and its derivatives by each number at any position [px], where it is `exact`."""


def fringes_of(model: GapModel | SceneModel) -> AbstractFringes:
    """A model for the solver."""
    return _FRINGES[type(model)](model)


def moved_to(model: GapModel | SceneModel, grid: Grid, numbers: np.ndarray | None = None) -> GapModel | SceneModel:
    """The same model on the nodes of another grid; `numbers` as in `frame_on`."""
    return replace(model, frame=frame_on(grid, numbers)._replace(reach=model.frame.reach))


@dataclass(frozen=True)
class GapFringes(AbstractFringes):
    """The gap formula at the nodes of its frame."""

    model: GapModel
    exact: GapModel | None = field(init=False, compare=False, repr=False)
    latest: list[tuple[np.ndarray, Fields]] = field(default_factory=list, compare=False, repr=False)

    def __post_init__(self):
        object.__setattr__(self, "exact", self.model)

    def fields(self, numbers: np.ndarray) -> Fields:
        # Moments are taken where the last step has ended, and the next one begins there.
        if not self.latest or not np.array_equal(self.latest[0][0], numbers):
            frame = self.model.frame
            phase, slopes = self.slopes_at(frame.x, frame.y, numbers)
            table = np.empty((len(NUMBERS), len(phase)))
            for row, name in zip(table, NUMBERS, strict=True):
                row[:] = slopes[name]
            self.latest[:] = [(np.array(numbers), Fields(phase, table.T, frame.contrast))]
        return self.latest[0][1]

    def edges(self, numbers: np.ndarray) -> PhaseAt | None:
        by_name = Numbers(*numbers)
        if not (rough := [name for name in EDGES if getattr(by_name, name) > 0]):
            return None
        # Only what these numbers do has an edge, in r²: the nodes resolve that, and what else the phase is made of.
        frame = self.model.frame
        touching = by_name._replace(**dict.fromkeys(rough, 0.0))
        smooth = gap_phase.phase(self.model, frame.x, frame.y, np.array(touching)) + self._shift * by_name.curvature
        table = table_of(smooth)
        square = table_of(gap_phase.squared_distance(self.model, frame.x, frame.y, numbers))

        def turns(grid: Grid, rows: slice) -> np.ndarray:
            along_y, along_x = grid.along_y[rows, :NODES], grid.along_x[:, :NODES].T
            r2 = along_y @ square @ along_x
            share = gap_phase.flattened(self.model, r2, by_name) - gap_phase.flattened(self.model, r2, touching)
            return along_y @ table @ along_x + share

        return turns

    def slopes_at(self, x: np.ndarray, y: np.ndarray, numbers: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        of_blocks = self._shift
        phase, slopes = gap_phase.phase_and_slopes(self.model, x, y, numbers)
        slopes["curvature"] = slopes["curvature"] + of_blocks
        return phase + of_blocks * numbers[_CURVATURE], slopes

    @property
    def _shift(self) -> float:
        return (self.model.frame.block**2 - 1) / (6 * self.model.frame.unit**2)


@dataclass(frozen=True)
class BenchFringes(AbstractFringes):
    """A traced bench at the nodes of its frame, traced anew where the phase has moved by more than a tangent holds."""

    model: SceneModel
    exact: GapModel | None = field(default=None, init=False, repr=False)
    traced: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = field(default_factory=list, compare=False, repr=False)

    def fields(self, numbers: np.ndarray) -> Fields:
        if not self.traced or np.abs(self.traced[0][2][0] @ (numbers - self.traced[0][0])).max() > _STRAIGHT:
            local = localize(as_arrays(self.model), jnp.asarray(numbers))
            self.traced[:] = [(np.array(numbers), np.asarray(local.value), np.asarray(local.slope))]
        at, value, slope = self.traced[0]
        value = value + slope @ (numbers - at)
        return Fields(value[0], slope[0], value[1], slope[1])

    def edges(self, numbers: np.ndarray) -> PhaseAt | None:  # noqa: ARG002  # a bench has no contact
        return None

    def slopes_at(self, x, y, numbers):
        raise NotImplementedError("a traced bench is known at its nodes")


_FRINGES = {GapModel: GapFringes, SceneModel: BenchFringes}
