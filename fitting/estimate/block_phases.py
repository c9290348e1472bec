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
    rough: list[tuple[np.ndarray, PhaseAt]] = field(default_factory=list, compare=False, repr=False)

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
        # Moments, residuals and what judges them look at one phase, one after the other.
        if not self.rough or not np.array_equal(self.rough[0][0], numbers):
            self.rough[:] = [(np.array(numbers), _EdgePhase(self, by_name, rough))]
        return self.rough[0][1]

    def slopes_at(self, x: np.ndarray, y: np.ndarray, numbers: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        of_blocks = self.shift
        phase, slopes = gap_phase.phase_and_slopes(self.model, x, y, numbers)
        slopes["curvature"] = slopes["curvature"] + of_blocks
        return phase + of_blocks * numbers[_CURVATURE], slopes

    @property
    def shift(self) -> float:
        """What means over blocks add to the phase, by curvature."""
        return (self.model.frame.block**2 - 1) / (6 * self.model.frame.unit**2)


class _EdgePhase:
    """The phase of rows of blocks, for numbers of which some make an edge; each row is made once.

    Only what these numbers do has an edge, in r²: the nodes resolve that, and what else the phase is made of.
    """

    def __init__(self, fringes: GapFringes, by_name: Numbers, rough: list[str]):
        self.model, self.by_name = fringes.model, by_name
        self.touching = by_name._replace(**dict.fromkeys(rough, 0.0))
        self.of_grid: tuple[Grid, dict[tuple[int, int], np.ndarray]] | None = None
        x, y, smooth = self.model.frame.x, self.model.frame.y, np.array(self.touching)
        phase = gap_phase.phase(self.model, x, y, smooth) + fringes.shift * by_name.curvature
        self.smooth = table_of(phase)
        self.square = table_of(gap_phase.squared_distance(self.model, x, y, np.array(by_name)))

    def __call__(self, grid: Grid, rows: slice) -> np.ndarray:
        if self.of_grid is None or self.of_grid[0] is not grid:
            self.of_grid = grid, {}
        finished, size = self.of_grid[1], len(grid.y)
        place = rows.indices(size)[:2]
        if (0, size) in finished:
            return finished[0, size][rows]
        if place not in finished:
            finished[place] = self._turns(grid, rows)
        return finished[place]

    def _turns(self, grid: Grid, rows: slice) -> np.ndarray:
        along_y, along_x = grid.along_y[rows, :NODES], grid.along_x[:, :NODES].T
        r2 = along_y @ self.square @ along_x
        of_edge = gap_phase.flattened(self.model, r2, self.by_name)
        return along_y @ self.smooth @ along_x + (of_edge - gap_phase.flattened(self.model, r2, self.touching))


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


def at_blocks(grid: Grid, nodes: np.ndarray) -> np.ndarray:
    """A field given at the nodes, at every block [rows, columns]."""
    return grid.along_y[:, :NODES] @ table_of(nodes) @ grid.along_x[:, :NODES].T
