"""Rings that are ellipses, or that a camera distorts: where a search for circles finds none.

The wave vectors of small tiles are the phase's slopes, up to their signs. For each distortion of a few, tiles move to
where they would be without it, and their wave vectors with them; then these are linear in the place, q = A p + b, with
a symmetric A. Every three tiles, with any signs, propose A and b; what most tiles agree with goes on to least squares
in all numbers, of the wave vectors first, then of the phases that are left over small blocks.
"""

from collections.abc import Callable
from itertools import product

import numpy as np

from fitting.photo.matched_filter import Bend, Rings
from fitting.photo.tiles import waves_of

# Distortions at half a diagonal that are tried; threes of tiles that propose for each; pixels to a side of a tile.
_DISTORTIONS, _THREES, _TILE = (0.0, -0.05, 0.05, -0.1, 0.1, -0.15, 0.15), 400, 64
# Largest logarithmic stretch: radii of a lens that differ by a factor of two; and largest distortion.
_MOST_STRETCHED, _MOST_DISTORTED = 0.37, 0.2
# A skew part of A over its mean curvature, of three tiles that may belong together; turns that a frame bends at least.
_SKEW, _BENT = 0.3, 1.0
# The centre's largest distance from the middle [half diagonals]: of arcs whose centre is farther away neither ellipse
# nor distortion is determined, and curved fringes of another form pass for them.
_FARTHEST = 1.5
# Tiles that have to agree, and their share of all.
_FEWEST, _SHARE = 10, 0.3
# Rounds of least squares, blocks to a side, and a phase [turns] that is left over beyond which a block does not count.
_ROUNDS, _BLOCKS, _NEAR = 4, 32, 0.3
_STEPS = np.array([1e-4, 1e-4, 1e-4, 1e-5, 1e-5, 1e-5])


def bent(fringes: np.ndarray, middle: tuple[float, float], unit: float) -> Rings | None:
    """Rings in an image of fringes [rows, columns]; None where no three tenths of its tiles agree on any.

    `middle` (x, y) and `unit` [px]: of the camera's frame, about whose middle it distorts, and half of its diagonal.
    """
    size = min(_TILE, *fringes.shape)
    places, waves = waves_of(lambda y, x, side: fringes[y : y + side, x : x + side], fringes.shape, size)
    if len(places) < _FEWEST:
        return None
    ellipse = _proposed((places - middle) / unit, waves * unit, 1.5 * unit / size)
    if ellipse is None:
        return None
    ellipse = _on_waves(ellipse, (places - middle) / unit, waves * unit, 1.5 * unit / size)
    rings = _on_phases(ellipse, fringes, middle, unit)
    far = np.hypot(*np.subtract(rings.centre, middle)) > _FARTHEST * unit
    return rings if rings.match > 0 and np.isfinite(rings.match) and not far else None


def _proposed(places: np.ndarray, waves: np.ndarray, near: float) -> np.ndarray | None:
    """Curvature, centre (x, y), stretch, shear and distortion that most tiles agree with; all in half diagonals."""
    rng = np.random.default_rng(0)
    best, most = None, max(_FEWEST, _SHARE * len(places)) - 1
    for distortion in _DISTORTIONS:
        at, slopes = _undistorted(places, waves, distortion)
        matrices, zeros = _threes(at, slopes, rng)
        if not len(matrices):
            continue
        predicted = at @ np.swapaxes(matrices, 1, 2) + zeros[:, None]
        apart = np.minimum(np.abs(predicted - slopes).max(axis=2), np.abs(predicted + slopes).max(axis=2))
        counts = (apart < near).sum(axis=1)
        place = int(np.argmax(counts))
        if counts[place] > most:
            most, best = int(counts[place]), (matrices[place], zeros[place], distortion)
    if best is None:
        return None
    matrix, zero, distortion = best
    centre = _distorted(-np.linalg.solve(matrix, zero), distortion)
    curvature = float(np.sqrt(np.linalg.det(matrix)))
    stretch = float(np.arccosh(max(0.5 * np.trace(matrix) / curvature, 1.0)))
    axis = np.array([matrix[0, 0] - matrix[1, 1], 2 * matrix[0, 1]])
    a, b = stretch * axis / max(float(np.hypot(*axis)), 1e-300)
    return np.array([curvature / 2, *centre, a, b, distortion])


def _undistorted(places: np.ndarray, waves: np.ndarray, distortion: float) -> tuple[np.ndarray, np.ndarray]:
    """Places on the object of a camera with a distortion, and the wave vectors there."""
    u2 = (places**2).sum(axis=1)
    factor, growth = 1 + distortion * u2, 2 * distortion
    # The inverse of factor + growth u uᵀ.
    along = (places * waves).sum(axis=1) * growth / (factor + growth * u2)
    return places * factor[:, None], (waves - along[:, None] * places) / factor[:, None]


def _distorted(place: np.ndarray, distortion: float) -> np.ndarray:
    """The image's point of the object's, by a few rounds; beyond the frame nothing is known of the lens."""
    at = place
    for _ in range(20):
        at = place / (1 + distortion * min(float(at @ at), 1.0))
    return at


def _threes(places: np.ndarray, waves: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A [n, 2, 2] and b [n, 2] of threes of tiles with any signs that may be rings'."""
    triples = rng.integers(0, len(places), (_THREES, 3))
    apart = places[triples[:, 1:]] - places[triples[:, :1]]
    area = np.abs(apart[:, 0, 0] * apart[:, 1, 1] - apart[:, 0, 1] * apart[:, 1, 0])
    triples = triples[area > 0.01]
    apart = apart[area > 0.01]
    inverse = np.linalg.inv(apart)
    matrices, zeros = [], []
    for signs in product((1.0, -1.0), repeat=2):
        of_three = waves[triples] * np.array([1.0, *signs])[:, None]
        slope = np.swapaxes(inverse @ (of_three[:, 1:] - of_three[:, :1]), 1, 2)
        mean = 0.5 * (slope[:, 0, 0] + slope[:, 1, 1])
        turn = np.where(mean < 0, -1.0, 1.0)
        slope, mean, of_three = slope * turn[:, None, None], mean * turn, of_three * turn[:, None, None]
        skew = np.abs(slope[:, 0, 1] - slope[:, 1, 0])
        lean = np.hypot(0.5 * (slope[:, 0, 0] - slope[:, 1, 1]), 0.5 * (slope[:, 0, 1] + slope[:, 1, 0]))
        is_ring = (skew < _SKEW * mean) & (lean < np.tanh(_MOST_STRETCHED) * mean) & (mean > 2 * _BENT)
        slope = 0.5 * (slope + np.swapaxes(slope, 1, 2))[is_ring]
        matrices.append(slope)
        middles, means = places[triples[is_ring]].mean(axis=1), of_three[is_ring].mean(axis=1)
        zeros.append(means - (slope @ middles[:, :, None])[:, :, 0])
    return np.concatenate(matrices), np.concatenate(zeros)


def _turns(ellipse: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Phase at places in half diagonals."""
    curvature, centre_x, centre_y, stretch, shear, distortion = (float(number) for number in ellipse)
    bend = Bend(stretch, shear, distortion, (0.0, 0.0), 1.0)
    return curvature * bend.squared_distance(x, y, (centre_x, centre_y))


def _slopes(phase: Callable[[np.ndarray], np.ndarray], ellipse: np.ndarray) -> np.ndarray:
    """Derivatives by its numbers, last axis: central differences."""
    steps = np.diag(_STEPS)
    return np.stack([(phase(ellipse + s) - phase(ellipse - s)) / (2 * s.sum()) for s in steps], axis=-1)


def _held(ellipse: np.ndarray, before: np.ndarray) -> np.ndarray:
    """The ellipse where its numbers can be a camera's and a lens's, else the one before."""
    is_sane = np.hypot(*ellipse[3:5]) < _MOST_STRETCHED + 0.02 and abs(ellipse[5]) < _MOST_DISTORTED and ellipse[0] > 0
    return ellipse if is_sane and np.isfinite(ellipse).all() else before


def _on_waves(ellipse: np.ndarray, places: np.ndarray, waves: np.ndarray, near: float) -> np.ndarray:
    """Least squares of the wave vectors of the tiles that agree, ever more of them."""
    (x, y), step = places.T, 1e-3

    def slopes_at(at: np.ndarray) -> np.ndarray:
        ends = ((x + step, y), (x - step, y), (x, y + step), (x, y - step))
        right, left, below, above = (_turns(at, *end) for end in ends)
        return np.stack([right - left, below - above], axis=1) / (2 * step)

    for _ in range(_ROUNDS):
        predicted = slopes_at(ellipse)
        signs = np.where((predicted * waves).sum(axis=1) < 0, -1.0, 1.0)
        residual = signs[:, None] * waves - predicted
        agree = np.abs(residual).max(axis=1) < near
        if agree.sum() < _FEWEST:
            return ellipse
        design = _slopes(slopes_at, ellipse)[agree].reshape(-1, len(ellipse))
        change = np.linalg.lstsq(design, residual[agree].ravel(), rcond=1e-6)[0]
        ellipse = _held(ellipse + change, ellipse)
    return ellipse


def _on_phases(ellipse: np.ndarray, fringes: np.ndarray, middle: tuple[float, float], unit: float) -> Rings:
    """Least squares of what is left of the phase over small blocks: its differences first, then itself.

    The pixels are asked once for either: within a block the phase that rounds change is next to even.
    """
    rows, columns = fringes.shape
    x, y = ((np.arange(n) - m) / unit for n, m in zip((columns, rows), middle, strict=True))
    down, across = (np.linspace(0, n, _BLOCKS + 1).astype(int)[:-1] for n in fringes.shape)
    block_x, block_y = (
        (0.5 * (begin + np.append(begin[1:], n) - 1) - m) / unit
        for begin, n, m in zip((across, down), (columns, rows), middle, strict=True)
    )

    def turns(at: np.ndarray) -> np.ndarray:
        return _turns(at, block_x, block_y[:, None])

    def phasors_of(at: np.ndarray) -> np.ndarray:
        angle = (2 * np.pi * (_turns(at, x, y[:, None]) % 1.0)).astype(np.float32)
        parts = (np.add.reduceat(fringes * wave, across, axis=1) for wave in (np.cos(angle), np.sin(angle)))
        real, imaginary = (np.add.reduceat(part, down, axis=0).astype(float) for part in parts)
        return real - 1j * imaginary

    for change_of in (_by_differences, _by_phases):
        phasors, there = phasors_of(ellipse), turns(ellipse)
        for _ in range(_ROUNDS):
            turned = phasors * np.exp(2j * np.pi * (there - turns(ellipse)))
            ellipse = _held(ellipse + change_of(turned, _slopes(turns, ellipse)), ellipse)
    total = phasors_of(ellipse).sum()
    constant = float(np.angle(total)) / (2 * np.pi)
    power = float((fringes.astype(float) ** 2).sum()) * np.count_nonzero(fringes) + 1e-30
    centre = (float(middle[0] + unit * ellipse[1]), float(middle[1] + unit * ellipse[2]))
    bend = Bend(float(ellipse[3]), float(ellipse[4]), float(ellipse[5]), middle, unit)
    return Rings(float(ellipse[0]) / unit**2, centre, constant, float(2 * abs(total) ** 2 / power), bend)


def _by_differences(phasors: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """Change of the ellipse by the phase's differences between neighbouring blocks."""
    pairs = (phasors[1:] * np.conj(phasors[:-1]), phasors[:, 1:] * np.conj(phasors[:, :-1]))
    rise, weights = (np.concatenate([of(pair).ravel() for pair in pairs]) for of in (np.angle, np.abs))
    terms = [slopes[1:] - slopes[:-1], slopes[:, 1:] - slopes[:, :-1]]
    design = np.concatenate([term.reshape(-1, slopes.shape[-1]) for term in terms])
    return _weighted_least_squares(design, rise / (2 * np.pi), weights)


def _by_phases(phasors: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """Change of the ellipse by the phase of the blocks that are near to the mean's."""
    residual = np.angle(phasors * np.conj(phasors.sum())).ravel() / (2 * np.pi)
    weights = np.where(np.abs(residual) < _NEAR, np.abs(phasors).ravel(), 0.0)
    design = np.concatenate([slopes.reshape(-1, slopes.shape[-1]), np.ones((residual.size, 1))], axis=1)
    return _weighted_least_squares(design, residual, weights)[:-1]


def _weighted_least_squares(design: np.ndarray, residual: np.ndarray, weights: np.ndarray) -> np.ndarray:
    root = np.sqrt(weights / max(float(weights.max()), 1e-300))
    return np.linalg.lstsq(design * root[:, None], residual * root, rcond=1e-6)[0]
