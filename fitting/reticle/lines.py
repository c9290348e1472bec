"""Lines of a ruled grid in an image: their two directions, their phases, and the grid that fits these."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy import fft, ndimage, optimize

from fitting.reticle.grid import Grid, Lines

# Harmonics of thin lines that are added up to find the grid; the lines need so many pixels a division.
_HARMONICS, _FINEST = 3, 0.3
# Width of the average of the demodulated lines, in divisions.
WIDTH = 1.2


def _peaks(fringes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Wave vectors of the strongest peaks of the Fourier transform [peak, (x, y)], and their power with harmonics."""
    size = [fft.next_fast_len(2 * n) for n in fringes.shape]
    power = np.abs(np.asarray(fft.fft2(fringes, size, workers=2))) ** 2
    fy, fx = np.meshgrid(fft.fftfreq(size[0]), fft.fftfreq(size[1]), indexing="ij")
    length = np.hypot(fx, fy)
    least = 4 / min(fringes.shape)
    half = (length > least) & (length < _FINEST) & ((fx > 0) | ((fx == 0) & (fy > 0)))
    peaks = half & (power == ndimage.maximum_filter(power, size=7, mode="wrap"))
    rows, columns = np.nonzero(peaks)
    strongest = np.argsort(power[rows, columns])[::-1][:60]
    waves = np.stack([fx[rows, columns], fy[rows, columns]], axis=1)[strongest]

    def strength(wave):
        at = [np.round(k * wave[::-1] * size).astype(int) for k in range(1, _HARMONICS + 1)]
        near = [power[np.ix_(*[(np.arange(-2, 3) + a) % n for a, n in zip(place, size, strict=True)])] for place in at]
        return sum(float(table.max()) for table in near)

    strengths = np.array([strength(wave) for wave in waves])
    return waves, strengths


def strongest_lines(fringes: np.ndarray) -> np.ndarray | None:
    """The wave vector of lines with the most power in it and its harmonics [cycles/px], [2]; None without one."""
    waves, strengths = _peaks(fringes)
    return waves[int(np.argmax(strengths))] if len(waves) else None


def first_grid(fringes: np.ndarray) -> Grid | None:
    """Two directions of similar distances across each other, with the most power in them and their harmonics."""
    waves, strengths = _peaks(fringes)
    best = None
    for i in range(len(waves)):
        for j in range(i + 1, len(waves)):
            long, short = sorted(np.hypot(*waves[[i, j]].T))[::-1]
            if long > 1.25 * short or abs(waves[i] @ waves[j]) > 0.26 * long * short:
                continue
            # Both directions count: a strong one beside noise is no grid.
            score = min(strengths[i], strengths[j])
            if best is None or score > best[0]:
                best = (score, i, j)
    if best is None:
        return None
    first, second = waves[best[1]], waves[best[2]]
    upright = [first, second] if abs(first[0]) >= abs(second[0]) else [second, first]
    along_x, along_y = (Lines(float(wave[0]), float(wave[1]), 0.0) for wave in upright)
    return Grid(along_x, along_y, 0.0)


class Phases(NamedTuple):
    """Lines of one direction: places x, y [px], by how much they are ahead of a grid [turns, modulo 1], coherence."""

    x: np.ndarray
    y: np.ndarray
    ahead: np.ndarray
    coherence: float


def demodulated(fringes: np.ndarray, lit: np.ndarray, grid: Grid, direction: int) -> Phases:
    """The lines' phase against a grid, and not against a plane wave: near an edge the average's middle is no pixel."""
    rows, columns = fringes.shape
    width = WIDTH / grid.directions[direction].frequency
    turns = grid.turns(direction, np.arange(columns), np.arange(rows)[:, None], fringes.shape)
    waves = (np.cos(2 * np.pi * turns), -np.sin(2 * np.pi * turns))
    smooth = [ndimage.gaussian_filter(fringes * wave, width, mode="constant") for wave in waves]
    power = ndimage.gaussian_filter(fringes**2, width, mode="constant")
    step = max(1, round(1.5 * width))
    sample = (slice(step // 2, None, step),) * 2
    phasor, power, covered = (smooth[0] + 1j * smooth[1])[sample], power[sample], lit[sample]
    size = np.abs(phasor) ** 2 / np.maximum(power, 1e-12)
    clear = covered & (size > 0.25 * np.percentile(size[covered], 90)) if covered.any() else covered
    y, x = np.meshgrid(np.arange(rows)[sample[0]], np.arange(columns)[sample[1]], indexing="ij")
    coherence = float(np.mean(size[clear] * 2)) if clear.any() else 0.0
    return Phases(x[clear], y[clear], np.angle(phasor[clear]) / (2 * np.pi), coherence)


def fit_grid(
    phases: list[Phases],
    start: Grid,
    shape: tuple[int, int],
    select: Callable[[np.ndarray, np.ndarray], np.ndarray] | None = None,
) -> Grid:
    """The grid, by robust least squares on what the lines are ahead of `start`; `select`: which places count."""
    middle = np.array([(shape[1] - 1) / 2, (shape[0] - 1) / 2])
    chosen = [np.ones(len(p.x), bool) if select is None else select(p.x, p.y) for p in phases]
    turns = [p.ahead + start.turns(k, p.x, p.y, shape) for k, p in enumerate(phases)]
    distances = [np.hypot(p.x - middle[0], p.y - middle[1]) / np.hypot(*middle) for p in phases]

    def bounded(vector: np.ndarray, bends: bool) -> Grid:
        grid = Grid.unpacked(vector)
        return grid if bends else replace(grid, distortion=start.distortion)

    def residual(vector: np.ndarray, reach: float, bends: bool) -> np.ndarray:
        grid, parts = bounded(vector, bends), []
        for k, p in enumerate(phases):
            used = chosen[k] & (distances[k] <= reach)
            difference = turns[k][used] - grid.turns(k, p.x[used], p.y[used], shape)
            parts.append(difference - np.round(difference))
        return np.concatenate(parts)

    mean_ahead = [float(np.angle(np.exp(2j * np.pi * p.ahead).mean()) / (2 * np.pi)) for p in phases]
    lines = [lines._replace(phase=lines.phase + turn) for lines, turn in zip(start.directions, mean_ahead, strict=True)]
    grid = Grid(lines[0], lines[1], start.distortion)
    # Outwards from the middle: at the rim a distortion may be off by whole lines.
    nearest = float(min(distance.min() for distance in distances))
    reaches = [*sorted({max(reach, nearest + 0.25) for reach in (0.3, 0.5, 0.7)}), np.inf]
    for reach in reaches:
        arguments = (reach, reach > reaches[0])
        if len(residual(grid.packed(), *arguments)) > 20:
            fit = optimize.least_squares(
                residual, grid.packed(), x_scale=np.array(Grid.UNITS), loss="soft_l1", f_scale=0.03, args=arguments
            )
            grid = bounded(fit.x, arguments[1])
    return grid
