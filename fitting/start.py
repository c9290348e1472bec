"""Finding rings without help: a matched filter for r² fringes over curvature and centre, from coarse to fine.

A ring pattern cos 2π(k |x - c|² + ψ) times e^{-2πi k |x|²} is a plane wave of frequency -2 k c: for every k on a grid
one Fourier transform looks at all centres at once, inside the frame and outside of it. What the coarse image finds is
refined on finer ones: the factor e^{-2πi k |x - c|²} is a product of a row and a column, so that the image comes down
to a few hundred phasors by two matrix products, on which the same filter runs again.
"""

from dataclasses import dataclass

import numpy as np
from scipy import fft

from fitting.smoothing import flatten, reduce

_COARSEST = 128
_BLOCKS = 32
_TILE = 64
# Rings that explain as much of the fringes' power need no second opinion.
_GOOD = 0.3


@dataclass(frozen=True)
class Rings:
    """Where the rings are: fringe scale k = s²/(R λ) [turns per pixel²], centre (x, y) [px], and phase.

    The phase [turns] is that of the cosine at the centre. `match` is the share of the image's fringe power (background
    and envelope divided out) that the rings explain.
    """

    scale: float
    centre: tuple[float, float]
    phase: float
    match: float


def _scales(half_diagonal: float, fewest: float = 0.4) -> np.ndarray:
    """Fringe scales to try: spaced by half a turn at the rim of what is resolved (slower than 2 px a half fringe)."""
    scales, k = [], fewest / half_diagonal**2
    while k < 0.05:
        scales.append(k)
        k += 0.4 / min(half_diagonal, 0.25 / k) ** 2
    return np.array(scales)


def search(fringes: np.ndarray, count: int = 4) -> list[Rings]:
    """The best few candidates of the matched filter on an image of at most a few hundred pixels a side."""
    rows, columns = fringes.shape
    x, y = np.arange(columns) - (columns - 1) / 2, np.arange(rows) - (rows - 1) / 2
    size = fft.next_fast_len(int(1.5 * max(rows, columns)))
    frequency = fft.fftfreq(size)
    total = float((fringes**2).sum()) * np.count_nonzero(fringes) + 1e-30
    found = []
    for k in _scales(0.5 * np.hypot(rows, columns)):
        chirp_y, chirp_x = (np.exp(-2j * np.pi * k * a * a).astype(np.complex64) for a in (y, x))
        spectrum = np.asarray(fft.fft2(fringes * chirp_y[:, None] * chirp_x[None], (size, size), workers=2))
        power = np.real(spectrum) ** 2 + np.imag(spectrum) ** 2
        at = np.unravel_index(int(np.argmax(power)), power.shape)
        match = 2 * float(power[at]) / total
        x0, y0 = float(-frequency[at[1]] / (2 * k)), float(-frequency[at[0]] / (2 * k))
        centre = (x0 + (columns - 1) / 2, y0 + (rows - 1) / 2)
        found.append(Rings(float(k), centre, 0.0, match))
    found.sort(key=lambda rings: -rings.match)
    distinct: list[Rings] = []
    for rings in found:
        if all(abs(np.log(rings.scale / other.scale)) > 0.15 for other in distinct):
            distinct.append(rings)
        if len(distinct) == count:
            break
    return distinct


def from_tiles(fringes: np.ndarray) -> Rings | None:
    """A candidate from the wave vectors of small tiles: these are 2 k (x - c), linear in the place, up to their signs.

    Every two tiles, with either sign, propose scale and centre; the proposal that most tiles agree with is refined by
    least squares over these. None where no three agree.
    """
    size = min(_TILE, *fringes.shape)
    corners = [np.unique(np.linspace(0, n - size, 10).round().astype(int)) for n in fringes.shape]
    places = np.array([(x + (size - 1) / 2, y + (size - 1) / 2) for y in corners[0] for x in corners[1]])
    tiles = np.stack([fringes[y : y + size, x : x + size] for y in corners[0] for x in corners[1]])
    window = np.hanning(size + 2)[1:-1]
    power = np.abs(np.asarray(fft.fft2(tiles * np.outer(window, window), (2 * size,) * 2, workers=2))) ** 2
    frequency = fft.fftfreq(2 * size)
    slow = np.hypot(*np.meshgrid(frequency, frequency)) < 1.5 / size
    at = np.where(slow, 0, power).reshape(len(tiles), -1).argmax(axis=1)
    waves = np.stack([frequency[at % (2 * size)], frequency[at // (2 * size)]], axis=1)
    near = 1.5 / size

    def agree(slope, zero):
        """Wave vectors of the tiles by the nearer sign, and which agree, for a proposal slope x + zero."""
        wanted = slope * places + zero
        sign = np.where((waves * wanted).sum(axis=1) < 0, -1.0, 1.0)[:, None] * waves
        return sign, np.abs(sign - wanted).max(axis=1) < near

    best, kept = 2, None
    first, second = np.triu_indices(len(places), 1)
    apart = places[second] - places[first]
    for sign in (1.0, -1.0):
        slopes = ((sign * waves[second] - waves[first]) * apart).sum(axis=1) / (apart**2).sum(axis=1)
        for pair in np.flatnonzero(np.abs(slopes) > 0.2 / (np.hypot(*fringes.shape) / 2) ** 2):
            one, slope = first[pair], slopes[pair]
            signed, good = agree(slope, waves[one] - slope * places[one])
            if good.sum() > best:
                best, kept = int(good.sum()), (signed, good)
    if kept is None:
        return None
    signed, good = kept
    middle, mean = places[good].mean(axis=0), signed[good].mean(axis=0)
    away = places[good] - middle
    slope = float((away * (signed[good] - mean)).sum() / (away**2).sum())
    if slope == 0:
        return None
    x, y = (float(value) for value in middle - mean / slope)
    return Rings(abs(slope) / 2, (x, y), 0.0, 0.0)


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


def refine(fringes: np.ndarray, rings: Rings) -> Rings:
    """Correct a candidate's scale, centre and phase on an image, from the phasors that are left over its blocks."""
    grid, x, y = _phasors(fringes, rings)
    middle = (x.mean(), y.mean())
    dx, dy = x - middle[0], y - middle[1]
    reach2 = dx[-1] ** 2 + dy[-1] ** 2
    size = 3 * _BLOCKS
    best = (-1.0, 0.0, 0.0, 0.0)
    for bend in np.linspace(-2.4, 2.4, 25) / reach2:
        chirped = grid * np.exp(-2j * np.pi * bend * dy**2)[:, None] * np.exp(-2j * np.pi * bend * dx**2)[None]
        power = np.abs(np.asarray(fft.fft2(chirped, (size, size))))
        at = np.unravel_index(int(np.argmax(power)), power.shape)
        if power[at] > best[0]:
            frequency = fft.fftfreq(size)
            best = (float(power[at]), float(bend), frequency[at[1]] / (x[1] - x[0]), frequency[at[0]] / (y[1] - y[0]))
    _, bend, *slope = best
    # The leftover phase bend |x - m|² + f·(x - m) is added to k |x - c|²: both are quadratics.
    scale = rings.scale + bend
    if scale <= 0:
        return rings
    shifted = zip(rings.centre, middle, slope, strict=True)
    x0, y0 = (float((rings.scale * c + bend * m - f / 2) / scale) for c, m, f in shifted)
    return _settle(fringes, Rings(float(scale), (x0, y0), 0.0, 0.0))


def _settle(fringes: np.ndarray, rings: Rings) -> Rings:
    grid, _, _ = _phasors(fringes, rings)
    total = complex(grid.sum())
    power = float((fringes.astype(float) ** 2).sum()) * np.count_nonzero(fringes) + 1e-30
    return Rings(rings.scale, rings.centre, float(np.angle(total)) / (2 * np.pi), float(2 * abs(total) ** 2 / power))


def find_rings(image: np.ndarray, mask: np.ndarray) -> Rings:
    """Rings in an image, without a start value: centre inside or outside of the frame, any phase and contrast.

    Candidates are found on the coarsest image and followed to the one that resolves them. Where these explain little of
    the whole image, the fringes may be too fine for it everywhere: then the tiles' wave vectors give another candidate,
    and the better match wins.
    """
    fringes = flatten(image, mask)
    best = _settle(fringes, _from_coarsest(fringes))
    if best.match > _GOOD:
        return best
    fine = from_tiles(fringes)
    return best if fine is None else max(best, _polish(fringes, fine), key=lambda rings: rings.match)


def _from_coarsest(fringes: np.ndarray) -> Rings:
    factor = max(1, -(-max(fringes.shape) // _COARSEST))
    found = [_scaled(rings, factor) for rings in search(reduce(fringes, factor))]
    while True:
        small = reduce(fringes, factor)
        found = [_scaled(_polish(small, _scaled(rings, 1 / factor)), factor) for rings in found]
        found = sorted(found, key=lambda rings: -rings.match)
        if factor == 1 or _is_resolved(found[0], fringes.shape, factor):
            return found[0]
        found = found[: 3 if factor > 3 else 2]
        factor = factor // 2


def plane_wave(image: np.ndarray, mask: np.ndarray) -> float:
    """Share of the fringe power that straight, evenly spaced fringes explain."""
    fringes = flatten(image, mask)
    small = reduce(fringes, max(1, max(image.shape) // (2 * _COARSEST)))
    power = np.abs(np.asarray(fft.fft2(small, tuple(2 * n for n in small.shape), workers=2))) ** 2
    return float(2 * power.max() / ((small**2).sum() * np.count_nonzero(small) + 1e-30))


def follow(image: np.ndarray, mask: np.ndarray, rings: Rings) -> Rings:
    """The rings next to a given scale and centre."""
    factor = max(1, -(-max(image.shape) // _COARSEST))
    while factor > 1 and not _is_resolved(rings, image.shape, factor):
        factor //= 2
    # A block counts where all of its pixels do.
    fringes = flatten(reduce(image, factor), reduce(mask.astype(float), factor) > 1 - 1e-9)
    return _scaled(_polish(fringes, _scaled(rings, 1 / factor)), factor)


def settle(image: np.ndarray, mask: np.ndarray, rings: Rings) -> Rings:
    """Rings of a given scale and centre with the phase and match that the image gives them."""
    return _settle(flatten(image, mask), rings)


def _is_resolved(rings: Rings, shape: tuple[int, int], factor: int) -> bool:
    """Whether the finest fringe of the frame is at least five coarse pixels wide."""
    far_x, far_y = (max(abs(c), abs(n - 1 - c)) for c, n in zip(rings.centre, shape[::-1], strict=True))
    return 2 * rings.scale * float(np.hypot(far_x, far_y)) * factor < 0.2


def _scaled(rings: Rings, factor: float | int) -> Rings:
    """The same rings on pixels `factor` times smaller."""
    offset = (factor - 1) / 2
    x, y = (float(factor * c + offset) for c in rings.centre)
    return Rings(rings.scale / factor**2, (x, y), rings.phase, rings.match)


def _polish(fringes: np.ndarray, rings: Rings) -> Rings:
    best = _settle(fringes, rings)
    for _ in range(3):
        trial = refine(fringes, best)
        if trial.match <= best.match * (1 + 1e-3):
            break
        best = trial
    return best
