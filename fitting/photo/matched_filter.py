"""Rings in a small image by a matched filter for r² fringes over curvature and centre.

A ring pattern cos 2π(k |x - c|² + ψ) times e^{-2πi k |x|²} is a plane wave of frequency -2 k c: for every k on a grid
one Fourier transform looks at all centres at once, inside the frame and outside of it. A candidate is refined on finer
images: the factor e^{-2πi k |x - c|²} is a product of a row and a column, so that the image comes down to a few hundred
phasors by two matrix products, on which the same filter runs again.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy import fft

from fitting.photo.smoothing import block_means

_BLOCKS = 32


# Pixels to a side of the image on which rings are looked for first, and cycles of the finest fringe that it resolves.
_COARSEST, _RESOLVED = 128, 0.2


class Bend(NamedTuple):
    """What makes circles ellipses, and what a camera's distortion makes of them: numbers of the model's parts.

    `stretch`, `shear`, `distortion`: as in `fitting.model`; `middle` (x, y) and `unit` [px]: of the frame, and half of
    its diagonal.
    """

    stretch: float
    shear: float
    distortion: float
    middle: tuple[float, float]
    unit: float

    def squared_distance(self, x: Any, y: Any, centre: tuple[float, float]) -> Any:
        """Squared distance on the object [px²] of pixels from the rings' centre: dᵀ exp([[a, b], [b, -a]]) d."""
        (at_x, at_y), (from_x, from_y) = self._on_object(x, y), self._on_object(*centre, most=1.0)
        dx, dy = at_x - from_x, at_y - from_y
        m = float(np.hypot(self.stretch, self.shear))
        odd = np.sinh(m) / m if m > 1e-12 else 1.0
        lean = self.stretch * (dx * dx - dy * dy) + 2 * self.shear * dx * dy
        return np.cosh(m) * (dx * dx + dy * dy) + odd * lean

    def _on_object(self, x: Any, y: Any, most: float = np.inf) -> tuple[Any, Any]:
        x, y = x - self.middle[0], y - self.middle[1]
        factor = 1 + self.distortion * np.minimum((x * x + y * y) / self.unit**2, most)
        return x * factor, y * factor


@dataclass(frozen=True)
class Rings:
    """Where the rings are: fringe scale k = s²/(R λ) [turns per pixel²], centre (x, y) [px], and phase.

    The phase [turns] is that of the cosine at the centre. `match` is the share of the image's fringe power (background
    and envelope divided out) that the rings explain. `bend`: None of circles.
    """

    scale: float
    centre: tuple[float, float]
    phase: float
    match: float
    bend: Bend | None = None

    def on_blocks(self, factor: float | int, corner: tuple[float | int, float | int] = (0, 0)) -> "Rings":
        """The same rings on blocks of `factor` pixels a side, the first one's first pixel being `corner` (x, y)."""
        return self._moved([zero + (factor - 1) / 2 for zero in corner], float(factor))

    def on_pixels(self, factor: float | int, corner: tuple[float | int, float | int] = (0, 0)) -> "Rings":
        """The rings of such blocks on the pixels."""
        return self._moved([-(zero + (factor - 1) / 2) / factor for zero in corner], 1 / factor)

    def _moved(self, first: list[float], unit: float) -> "Rings":
        """On places that are counted from `first` (x, y) in units."""
        (x, y), bend = ((at - zero) / unit for at, zero in zip(self.centre, first, strict=True)), self.bend
        if bend is not None:
            middle_x, middle_y = ((at - zero) / unit for at, zero in zip(bend.middle, first, strict=True))
            bend = bend._replace(middle=(middle_x, middle_y), unit=bend.unit / unit)
        return Rings(self.scale * unit**2, (float(x), float(y)), self.phase, self.match, bend)

    def finest(self, shape: tuple[int, int]) -> float:
        """Largest frequency of the fringes over a frame [rows, columns], in cycles per pixel."""
        far_x, far_y = (max(abs(c), abs(n - 1 - c)) for c, n in zip(self.centre, shape[::-1], strict=True))
        return 2 * self.scale * float(np.hypot(far_x, far_y))


def search(fringes: np.ndarray, count: int = 4) -> list[Rings]:
    """The best few candidates of the matched filter on an image of at most a few hundred pixels a side."""
    rows, columns = fringes.shape
    x, y = np.arange(columns) - (columns - 1) / 2, np.arange(rows) - (rows - 1) / 2
    size = fft.next_fast_len(int(1.5 * max(rows, columns)))
    frequency = fft.fftfreq(size)
    total = float((fringes**2).sum()) * np.count_nonzero(fringes) + 1e-30
    candidates = []
    for k in _scales(0.5 * np.hypot(rows, columns)):
        chirp_y, chirp_x = (np.exp(-2j * np.pi * k * a * a).astype(np.complex64) for a in (y, x))
        spectrum = np.asarray(fft.fft2(fringes * chirp_y[:, None] * chirp_x[None], (size, size)))
        power = np.real(spectrum) ** 2 + np.imag(spectrum) ** 2
        at = np.unravel_index(int(np.argmax(power)), power.shape)
        match = 2 * float(power[at]) / total
        x0, y0 = float(-frequency[at[1]] / (2 * k)), float(-frequency[at[0]] / (2 * k))
        candidates.append(Rings(float(k), (x0 + (columns - 1) / 2, y0 + (rows - 1) / 2), 0.0, match))
    candidates.sort(key=lambda rings: -rings.match)
    distinct: list[Rings] = []
    for rings in candidates:
        if all(abs(np.log(rings.scale / accepted.scale)) > 0.15 for accepted in distinct):
            distinct.append(rings)
        if len(distinct) == count:
            break
    return distinct


def settle(fringes: np.ndarray, rings: Rings) -> Rings:
    """Rings of a given scale and centre with the phase and match that an image gives them."""
    total = complex(_phasors(fringes, rings)[0].sum())
    power = float((fringes.astype(float) ** 2).sum()) * np.count_nonzero(fringes) + 1e-30
    return Rings(rings.scale, rings.centre, float(np.angle(total)) / (2 * np.pi), float(2 * abs(total) ** 2 / power))


def polish(fringes: np.ndarray, rings: Rings) -> Rings:
    """Rings refined until their match grows no more."""
    best = settle(fringes, rings)
    for _ in range(3):
        trial = _refine(fringes, best)
        if trial.match <= best.match * (1 + 1e-3):
            break
        best = trial
    return best


def _scales(half_diagonal: float, fewest: float = 0.4) -> np.ndarray:
    """Fringe scales to try: spaced by half a turn at the rim of what is resolved (slower than 2 px a half fringe)."""
    scales, k = [], fewest / half_diagonal**2
    while k < 0.05:
        scales.append(k)
        k += 0.4 / min(half_diagonal, 0.25 / k) ** 2
    return np.array(scales)


def _phasors(fringes: np.ndarray, rings: Rings) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The image against the candidate, averaged over blocks: a small complex grid, and its block centres x, y [px]."""
    tables = []
    for n, centre in zip(fringes.shape[::-1], rings.centre, strict=True):
        position, count = np.arange(n), min(_BLOCKS, n)
        block = position * count // n
        table = np.zeros((n, count), np.complex64)
        table[position, block] = np.exp(-2j * np.pi * rings.scale * (position - centre) ** 2)
        tables.append((table, np.bincount(block, position) / np.bincount(block)))
    (along_x, x), (along_y, y) = tables
    # Two real products: a complex one would first copy the whole image to complex numbers.
    half = fringes @ np.concatenate([along_x.real, along_x.imag], axis=1)
    return along_y.T @ (half[:, : len(x)] + 1j * half[:, len(x) :]), x, y


def _refine(fringes: np.ndarray, rings: Rings) -> Rings:
    """Correct a candidate's scale, centre and phase on an image, from the phasors that are left over its blocks."""
    grid, x, y = _phasors(fringes, rings)
    middle = (x.mean(), y.mean())
    dx, dy = x - middle[0], y - middle[1]
    reach2 = dx[-1] ** 2 + dy[-1] ** 2
    size = 3 * _BLOCKS
    frequency = fft.fftfreq(size)
    bends = np.linspace(-2.4, 2.4, 25) / reach2
    chirp_y, chirp_x = (np.exp(-2j * np.pi * np.outer(bends, at**2)).astype(np.complex64) for at in (dy, dx))
    chirped = grid.astype(np.complex64) * chirp_y[:, :, None] * chirp_x[:, None, :]
    power = np.abs(np.asarray(fft.fft2(chirped, (size, size)))).reshape(len(bends), -1)
    peaks = []
    for spectrum in power:
        row, column = np.unravel_index(int(np.argmax(spectrum)), (size, size))
        peaks.append((float(spectrum.max()), frequency[column] / (x[1] - x[0]), frequency[row] / (y[1] - y[0])))
    highest = int(np.argmax([peak[0] for peak in peaks]))
    _, *slope = peaks[highest]
    bend = float(bends[highest] + (bends[1] - bends[0]) * _vertex([peak[0] for peak in peaks], highest))
    # The leftover phase bend |x - m|² + f·(x - m) is added to k |x - c|²: both are quadratics.
    scale = rings.scale + bend
    if scale <= 0:
        return rings
    shifted = zip(rings.centre, middle, slope, strict=True)
    x0, y0 = (float((rings.scale * c + bend * m - f / 2) / scale) for c, m, f in shifted)
    return settle(fringes, Rings(float(scale), (x0, y0), 0.0, 0.0))


def _vertex(values: list[float], at: int) -> float:
    """Where a parabola through the largest value and its neighbours is highest, in steps from it."""
    if not 0 < at < len(values) - 1:
        return 0.0
    before, most, after = values[at - 1 : at + 2]
    bend = before - 2 * most + after
    return 0.5 * (before - after) / bend if bend < 0 else 0.0


def from_coarsest(fringes: np.ndarray) -> Rings:
    """The best candidate of an image's coarsest block means, followed to the ones that resolve it."""
    factor = max(1, -(-max(fringes.shape) // _COARSEST))
    candidates = [rings.on_pixels(factor) for rings in search(block_means(fringes, factor))]
    while True:
        small = block_means(fringes, factor)
        candidates = [polish(small, rings.on_blocks(factor)).on_pixels(factor) for rings in candidates]
        candidates = sorted(candidates, key=lambda rings: -rings.match)
        if factor == 1 or candidates[0].finest(fringes.shape) * factor < _RESOLVED:
            return candidates[0]
        candidates = candidates[: 3 if factor > 3 else 2]
        factor = factor // 2
