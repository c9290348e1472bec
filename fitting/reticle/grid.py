"""A square grid of lines as a camera shows it: two plane waves behind one radial distortion."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np


class Lines(NamedTuple):
    """One direction of lines: wave vector (x, y) [cycles/px], and phase in the middle of the image [turns]."""

    along_x: float
    along_y: float
    phase: float

    @property
    def frequency(self) -> float:
        """Lines in a pixel across them [cycles/px]."""
        return float(np.hypot(self.along_x, self.along_y))


@dataclass(frozen=True)
class Grid:
    """The lines of both directions, and κ of the distortion r (1 + κ r²), r in half diagonals from the middle."""

    first: Lines
    second: Lines
    distortion: float

    # Units of least squares' numbers, in the order of `packed`.
    UNITS = (1e-4, 1e-4, 0.1, 1e-4, 1e-4, 0.1, 1e-2)

    @property
    def directions(self) -> tuple[Lines, Lines]:
        """Both directions' lines."""
        return self.first, self.second

    @property
    def waves(self) -> np.ndarray:
        """Wave vectors of both directions [direction, (x, y)] in cycles/px."""
        return np.array([[lines.along_x, lines.along_y] for lines in self.directions])

    @property
    def pixel(self) -> float:
        """Geometric mean of a pixel's sides in the middle of the image [divisions]."""
        first, second = self.directions
        return float(np.sqrt(abs(first.along_x * second.along_y - first.along_y * second.along_x)))

    @property
    def sides(self) -> tuple[float, float]:
        """What one pixel along x and along y crosses, in the middle of the image [divisions]."""
        along_x, along_y = np.hypot(*self.waves)
        return float(along_x), float(along_y)

    @property
    def stretches(self) -> tuple[float, float]:
        """A and b: offsets on the object are exp([[a, b], [b, -a]] / 2) times those of square pixels, as in the fit.

        Squared lengths are dᵀ WᵀW d of an offset d, and WᵀW = s² exp([[a, b], [b, -a]]).
        """
        (along, across), (_, down) = self.waves.T @ self.waves / self.pixel**2
        half_trace = max((along + down) / 2, 1.0)
        m = np.arccosh(half_trace)
        factor = m / np.sinh(m) if m > 0 else 1.0
        return float(factor * (along - down) / 2), float(factor * across)

    def packed(self) -> np.ndarray:
        """The grid's seven numbers [7], as least squares takes them."""
        return np.array([*self.first, *self.second, self.distortion])

    @classmethod
    def unpacked(cls, vector: np.ndarray) -> "Grid":
        """The grid of such numbers [7]."""
        first_x, first_y, first_phase, second_x, second_y, second_phase, distortion = map(float, vector)
        return cls(Lines(first_x, first_y, first_phase), Lines(second_x, second_y, second_phase), distortion)

    def turns(self, direction: int, x: np.ndarray, y: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
        """Turns of one direction's lines (0 or 1) at pixels of an image [rows, columns]: whole on a line."""
        middle_y, middle_x = ((n - 1) / 2 for n in shape)
        from_x, from_y = x - middle_x, y - middle_y
        stretch = 1 + self.distortion * (from_x**2 + from_y**2) / (middle_y**2 + middle_x**2)
        along_x, along_y, phase = self.directions[direction]
        return (along_x * from_x + along_y * from_y) * stretch + phase
