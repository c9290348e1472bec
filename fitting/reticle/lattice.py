"""The pixel size from a photograph of a ruled grid: its two wave vectors, by demodulation over the whole field."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy import fft, ndimage, optimize

from fitting.parameters import absolute_sd, number, says_its_origin
from fitting.photo import Photograph, flatten, read
from fitting.reticle.grid import Grid, Lines
from fitting.reticle.result import Scale

# Harmonics of thin lines that are added up to find the grid; the lines need so many pixels a division.
_HARMONICS, _FINEST = 3, 0.3
_ROUNDS = 3
# Width of the average of the demodulated lines, in divisions.
_WIDTH = 1.2
# Least mean coherence of the demodulated lines: a clean grid has 0.3 and more, rings below 0.01; and so many times what
# white noise has in that average.
_COHERENT, _NOISE = 0.02, 20.0
# A square grid is seen off its right angle by so much [rad], and stretched by so much, behind a view at 25 degrees; an
# eyepiece distorts it by 0.1.
_SKEW, _STRETCH, _BENT = 0.05, 0.1, 0.3
# The field's parts that are left out in turn, to a side, for the standard deviation (jackknife).
_PARTS = 4


@says_its_origin
def scale(
    image: str | Path | np.ndarray,
    *,
    division: float,
    division_sd: float | str | None = None,
    transfer: str | float | None = None,
    mask: str | Path | np.ndarray | None = None,
    page: int | None = None,
) -> Scale:
    """The pixel size on the object from a photograph of a square grid of lines, at any angle.

    The grid's two lowest wave vectors are found in the Fourier transform, with their harmonics; demodulated by each,
    the image gives the lines' phase everywhere, to which two plane waves behind one radial distortion are fitted. The
    standard deviation is the jackknife's over sixteen parts of the field, with the division's own.

    Args:
      image: a file, or an array as in `fitting.fit`.
      division, division_sd: distance of two lines, and its standard deviation [m], or "0.1%".
      transfer, mask, page: as in `fitting.fit`.

    A photograph without a grid comes back refused. Raises ValueError and FileNotFoundError for input that is none.

    """
    if not 1e-9 < number("division", division) < 1.0:
        raise ValueError(f"division is {division}; allowed: 1e-9 to 1 m")
    sd = absolute_sd("division", division_sd, division) or 0.0
    photograph = read(image, transfer, mask, page)
    return _measured(photograph, float(division), sd)


def _measured(photograph: Photograph, division: float, division_sd: float) -> Scale:
    if photograph.mask.sum() < 1024:
        return Scale("refused", f"{int(photograph.lit.sum())} pixels can be used: the image is dark or masked")
    fringes = flatten(photograph.image, photograph.lit)
    grid = _lattice(fringes)
    if grid is None:
        return Scale("refused", "no grid: no two directions of evenly spaced lines were found", photograph=photograph)
    phases: list[Phases] = []
    for _ in range(_ROUNDS):
        phases = [_demodulated(fringes, photograph.lit, grid, direction) for direction in (0, 1)]
        coherence = min(of_direction.coherence for of_direction in phases)
        longest = 1 / min(lines.frequency for lines in grid.directions)
        least = max(_COHERENT, _NOISE / (4 * np.pi * (_WIDTH * longest) ** 2))
        if coherence < least:
            message = f"no grid found: line coherence is {coherence:.2g}; at least {least:.2g} is required"
            return Scale("refused", message, photograph=photograph)
        grid = _fit(phases, grid, photograph.image.shape)
    return _checked(_answer(grid, phases, photograph, division, division_sd))


def _checked(answer: Scale) -> Scale:
    """The answer, or a refusal where that is no square grid."""
    stretch = abs(np.log((answer.pixel_size_x or 1.0) / (answer.pixel_size_y or 1.0)))
    skew, bent = abs(answer.skew or 0.0), abs(answer.distortion or 0.0)
    reason = ""
    if answer.distortion_sd is None or not np.isfinite(answer.pixel_size_sd or 0.0):
        reason = "its lines cover too little of the picture"
    elif skew > _SKEW or stretch > _STRETCH or bent > _BENT:
        reason = (
            f"what looks like one is {np.degrees(skew):.2g}° off a right angle, {stretch:.1%} longer one way and "
            f"distorted by {bent:.2g}"
        )
    return Scale("refused", f"no square grid: {reason}", photograph=answer.photograph) if reason else answer


def _lattice(fringes: np.ndarray) -> Grid | None:
    """Two directions of similar distances across each other, with the most power in them and their harmonics."""
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


def _demodulated(fringes: np.ndarray, lit: np.ndarray, grid: Grid, direction: int) -> Phases:
    """The lines' phase against a grid, and not against a plane wave: near an edge the average's middle is no pixel."""
    rows, columns = fringes.shape
    width = _WIDTH / grid.directions[direction].frequency
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


def _fit(
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


def _jackknife(grid: Grid, phases: list[Phases], shape: tuple[int, int]) -> list[Grid]:
    """The grid from the field without each of its parts in turn, where that leaves most of the places but not all."""

    def without(part: int) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
        def select(x: np.ndarray, y: np.ndarray) -> np.ndarray:
            return (y * _PARTS // shape[0]).astype(int) * _PARTS + (x * _PARTS // shape[1]).astype(int) != part

        return select

    grids = []
    for part in range(_PARTS**2):
        select = without(part)
        counts = [(int(select(p.x, p.y).sum()), len(p.x)) for p in phases]
        if all(0.5 * total < count < total for count, total in counts):
            grids.append(_fit(phases, grid, shape, select))
    return grids


def _jackknife_sd(estimates: list[float]) -> float:
    """Standard deviation from estimates without one part each (Efron 1982); NaN from fewer than two."""
    values, n = np.array(estimates), len(estimates)
    return float(np.sqrt((n - 1) / n * ((values - values.mean()) ** 2).sum())) if n > 1 else float("nan")


def _answer(grid: Grid, phases: list[Phases], photograph: Photograph, division: float, division_sd: float) -> Scale:
    shape = photograph.image.shape
    partial = _jackknife(grid, phases, shape)
    size = grid.pixel * division
    spread = _jackknife_sd([part.pixel for part in partial]) * division
    lines = tuple(float(np.ptp(grid.turns(k, p.x, p.y, shape))) for k, p in enumerate(phases))
    warnings = list(photograph.warnings)
    if not division_sd:
        warnings.append(
            "no standard deviation is given for division: treated as exact, and the uncertainty does not include it"
        )
    # Columns of the matrix of waves are what one pixel along x, y crosses, in divisions.
    along_x, along_y = (float(np.hypot(*grid.waves[:, k])) * division for k in (0, 1))
    if abs(np.log(along_x / along_y)) > 0.02:
        warnings.append(
            f"pixels are {abs(np.log(along_x / along_y)):.1%} longer one way: their geometric mean is given"
        )
    first, second = grid.waves
    square = float(first @ second / (np.hypot(*first) * np.hypot(*second)))
    distortion_sd = _jackknife_sd([part.distortion for part in partial])
    return Scale(
        "ok",
        pixel_size=size,
        pixel_size_sd=float(np.hypot(spread, size * division_sd / division)),
        pixel_size_x=along_x,
        pixel_size_y=along_y,
        angle=float(np.arctan2(first[1], first[0])) if first[0] >= 0 else float(np.arctan2(-first[1], -first[0])),
        skew=float(np.arcsin(np.clip(square, -1, 1))),
        distortion=grid.distortion,
        distortion_sd=distortion_sd if np.isfinite(distortion_sd) else None,
        lines=(lines[0], lines[1]),
        division=division,
        division_sd=division_sd or None,
        warnings=warnings,
        photograph=photograph,
        grid=grid,
    )
