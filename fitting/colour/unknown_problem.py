"""Pictures of one set-up under one unknown light: each with a rate and a gap of its own, all with one spectrum.

Variable projection as in `solver.py`; slopes are those at fixed amplitudes, of which the components that are present
are projected out (L. Kaufman, BIT 15, 49 (1975)).
"""

from dataclasses import (
    dataclass,
    field,
    replace,
)
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.linalg import block_diag

from fitting.colour.amplitudes import (
    Channel,
    background,
    solve,
)
from fitting.colour.profiles import Profiles
from fitting.colour.solver import (
    ITERATIONS,
    least_squares,
)
from fitting.colour.unknown_light import UnknownLight
from fitting.colour.waveform import (
    COLOURS,
    PRIORS,
    STEPS,
    Curve,
    View,
    fringes,
)

# Tables of fringes that are remembered: of all numbers of a few pictures.
_REMEMBERED = 40


class Number(NamedTuple):
    """A number of the curves that is fitted: one value for all of these pictures."""

    name: str
    pictures: tuple[int, ...]


@dataclass(frozen=True)
class SharedProblem:
    """Profiles of pictures, and what they are fitted with.

    - `channels`: numbers of the channels that all pictures have; `variances`: of a block of weight 1
      [pictures, channels]; `degree` of the background over r² of each picture.
    - `free`: what is fitted; the first picture's rate is never free, for the light's scale is its.
    """

    profiles: tuple[Profiles, ...]
    views: tuple[View, ...]
    light: UnknownLight
    channels: tuple[int, ...]
    variances: Float[np.ndarray, "pictures channels"]
    free: tuple[Number, ...]
    degree: int = 3
    _fringes: dict[tuple, Float[np.ndarray, "bins waves"]] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )
    _last: dict[tuple[Curve, ...], list[Channel]] = field(default_factory=dict, init=False, repr=False, compare=False)

    def with_numbers(
        self,
        curves: tuple[Curve, ...],
        numbers: Float[np.ndarray, " free"],
    ) -> tuple[Curve, ...]:
        """The curves with other values of what is free."""
        changed = list(curves)
        for number, value in zip(self.free, numbers, strict=True):
            for picture in number.pictures:
                changed[picture] = changed[picture]._replace(**{number.name: float(value)})
        return tuple(changed)

    def numbers(
        self,
        curves: tuple[Curve, ...],
    ) -> Float[np.ndarray, " free"]:
        """The values of what is free."""
        return np.array([getattr(curves[number.pictures[0]], number.name) for number in self.free])

    @property
    def steps(self) -> Float[np.ndarray, " free"]:
        """Of difference quotients."""
        return np.array([STEPS[number.name] for number in self.free])

    @property
    def widths(self) -> Float[np.ndarray, " free"]:
        """Standard deviations of what is known of the numbers before; infinite for nothing."""
        return np.array([PRIORS[number.name] or np.inf for number in self.free])

    def waves(
        self,
        curves: tuple[Curve, ...],
        channel: int,
    ) -> Float[np.ndarray, "bins waves"]:
        """The fringes of each wave in a channel, in all pictures one after the other."""
        tables = []
        for picture, curve in enumerate(curves):
            tables.append(self._table(picture, curve, channel) * getattr(curve, f"gain_{COLOURS[channel]}"))
        return np.concatenate(tables)

    def _table(
        self,
        picture: int,
        curve: Curve,
        channel: int,
    ) -> Float[np.ndarray, "bins waves"]:
        """Of one picture, without its gain: channels of one size and blur have it in common."""
        key = (picture, *curve.geometry(channel))
        if key not in self._fringes:
            if len(self._fringes) >= _REMEMBERED:
                self._fringes.pop(next(iter(self._fringes)))
            profiles, view = self.profiles[picture], self.views[picture]
            self._fringes[key] = fringes(
                self.light,
                curve,
                profiles.squares,
                profiles.width,
                channel,
                view,
            )
        return self._fringes[key]

    @property
    def smooth(self) -> Float[np.ndarray, "bins terms"]:
        """The background's terms, of each picture its own."""
        return np.asarray(block_diag(*(background(profiles.squares, self.degree) for profiles in self.profiles)))

    def weights(
        self,
        number: int,
    ) -> Float[np.ndarray, " bins"]:
        """Of the bins of a channel in all pictures: one over their variance."""
        pairs = zip(self.profiles, self.variances[:, number], strict=True)
        return np.concatenate([profiles.weight[number] / variance for profiles, variance in pairs])

    def solved(
        self,
        curves: tuple[Curve, ...],
    ) -> list[Channel]:
        """Amplitudes of each channel, with models and residuals of its bins in all pictures."""
        if curves in self._last:
            return self._last[curves]
        smooth, answers = self.smooth, []
        for k, channel in enumerate(self.channels):
            values = np.concatenate([profiles.means[k] for profiles in self.profiles])
            answers.append(solve(self.waves(curves, channel), smooth, values, self.weights(k), self.light.held))
        self._last.clear()
        self._last[curves] = answers
        return answers

    def residual(
        self,
        curves: tuple[Curve, ...],
    ) -> Float[np.ndarray, " rows"]:
        """Of all bins, of what is known of the light and of priors, in standard deviations."""
        parts = []
        for answer in self.solved(curves):
            parts += [answer.residual, -self.light.held @ answer.amplitudes]
        return np.concatenate([*parts, self.numbers(curves) / self.widths])

    def changes(
        self,
        curves: tuple[Curve, ...],
        amplitudes: np.ndarray,
        number: int,
    ) -> Float[np.ndarray, "bins free"]:
        """How a channel's fringes of given amplitudes change with what is free."""
        numbers, columns = self.numbers(curves), []
        for step in np.diag(self.steps):
            sides = [self.with_numbers(curves, numbers + side * step) for side in (1, -1)]
            above, below = (self.waves(side, self.channels[number]) @ amplitudes for side in sides)
            columns.append((above - below) / (2 * step.max()))
        return np.stack(columns, axis=1)

    def slopes(
        self,
        curves: tuple[Curve, ...],
    ) -> Float[np.ndarray, "rows free"]:
        """Of the residual in what is free."""
        parts, smooth = [], self.smooth
        for k, answer in enumerate(self.solved(curves)):
            root = np.sqrt(self.weights(k))[:, None]
            present = answer.amplitudes > 0
            held = self.light.held[:, present]
            waves = self.waves(curves, self.channels[k])[:, present]
            rows = np.zeros((len(held), smooth.shape[1]))
            basis = np.linalg.qr(np.block([[waves * root, smooth * root], [held, rows]]))[0]
            change = np.concatenate(
                [self.changes(curves, answer.amplitudes, k) * root, np.zeros((len(held), len(self.free)))]
            )
            parts.append(basis @ (basis.T @ change) - change)
        return np.concatenate([*parts, np.diag(1 / self.widths)])


class SharedOptimum(NamedTuple):
    """The best curves of a problem, and its sum of squares."""

    curves: tuple[Curve, ...]
    chi2: float


def shared_optimum(
    problem: SharedProblem,
    start: tuple[Curve, ...],
    steps: int = ITERATIONS,
) -> SharedOptimum:
    """The curves of least squares next to a start: at most so many steps of Levenberg and Marquardt."""
    numbers, square, _ = least_squares(
        lambda numbers: problem.residual(problem.with_numbers(start, numbers)),
        lambda numbers, _: problem.slopes(problem.with_numbers(start, numbers)),
        problem.numbers(start),
        steps,
    )
    return SharedOptimum(problem.with_numbers(start, numbers), square)


def variances_of(
    problem: SharedProblem,
    curves: tuple[Curve, ...],
) -> Float[np.ndarray, "pictures channels"]:
    """Of a block of weight 1 in each picture and channel: the mean square of its weighted residuals."""
    ends = np.cumsum([len(single.squares) for single in problem.profiles])[:-1]
    parts = [np.split(answer.residual, ends) for answer in problem.solved(curves)]
    squares = np.array([[float(np.mean(part**2)) for part in channel] for channel in parts]).T
    return problem.variances * np.maximum(squares, 1e-12 * squares.max())


def weighed(
    problem: SharedProblem,
    curves: tuple[Curve, ...],
) -> tuple[SharedProblem, SharedOptimum]:
    """Pictures and channels weighed by the variances that they leave over, and the optimum next to these curves."""
    problem = replace(
        problem,
        variances=variances_of(
            problem,
            curves,
        ),
    )
    return problem, shared_optimum(
        problem,
        curves,
    )
