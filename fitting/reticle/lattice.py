"""The pixel size from a photograph of a ruled grid: its two wave vectors, by demodulation over the whole field."""

from collections.abc import Callable

import numpy as np

from fitting.parameters import with_sd
from fitting.photo import Photograph, flatten
from fitting.reasons import Reason
from fitting.reticle.grid import Grid
from fitting.reticle.lines import WIDTH, Phases, demodulated, first_grid, fit_grid
from fitting.reticle.result import Scale
from newtonjax.numerics import Statement

_ROUNDS = 3
# Least mean coherence of the demodulated lines: a clean grid has 0.3 and more, rings below 0.01; and so many times what
# white noise has in that average.
_COHERENT, _NOISE = 0.02, 20.0
# A square grid is seen off its right angle by so much [rad], and stretched by so much, behind a view at 25 degrees; an
# eyepiece distorts it by 0.1.
_SKEW, _STRETCH, _BENT = 0.05, 0.1, 0.3
# The field's parts that are left out in turn, to a side, for the standard deviation (jackknife).
_PARTS = 4
# What noise alone makes of the grid's stretch once in 370 pictures: chi-squared with two degrees of freedom.
_APART = 11.8


def of_grid(photograph: Photograph, division: float, division_sd: float, done: Callable[[int, int], object]) -> Scale:
    """The scale of a photograph of a square grid at any angle, or a refusal.

    The grid's two lowest wave vectors are found in the Fourier transform, with their harmonics; demodulated by each,
    the image gives the lines' phase everywhere, to which two plane waves behind one radial distortion are fitted. The
    standard deviation is the jackknife's over sixteen parts of the field, with the division's own and half of the
    stretch beyond its noise, by which pixels are longer one way: a tilted grid or camera makes as much.
    """
    if photograph.mask.sum() < 1024:
        return Scale("refused", Reason.TOO_FEW_PIXELS_OF_GRID(pixels=int(photograph.lit.sum())))
    fringes = flatten(photograph.image, photograph.lit)
    grid = first_grid(fringes)
    if grid is None:
        return Scale("refused", Reason.NO_GRID(), photograph=photograph)
    phases: list[Phases] = []
    for fit_number in range(_ROUNDS):
        done(fit_number, _ROUNDS + _PARTS**2)
        phases = [demodulated(fringes, photograph.lit, grid, direction) for direction in (0, 1)]
        coherence = min(of_direction.coherence for of_direction in phases)
        longest = 1 / min(lines.frequency for lines in grid.directions)
        least = max(_COHERENT, _NOISE / (4 * np.pi * (WIDTH * longest) ** 2))
        if coherence < least:
            reason = Reason.NO_GRID_COHERENCE(coherence=coherence, least=least)
            return Scale("refused", reason, photograph=photograph)
        grid = fit_grid(phases, grid, photograph.image.shape)
    partial = _jackknife(grid, phases, photograph.image.shape, done)
    return _checked(_answer(grid, partial, phases, photograph, division, division_sd))


def _checked(answer: Scale) -> Scale:
    """The answer, or a refusal where that is no square grid."""
    stretch = abs(np.log((answer.pixel_size_x or 1.0) / (answer.pixel_size_y or 1.0)))
    skew, bent = abs(answer.skew or 0.0), abs(answer.distortion or 0.0)
    if answer.distortion_sd is None or not np.isfinite(answer.pixel_size_sd or 0.0):
        return Scale("refused", Reason.GRID_TOO_SMALL(), photograph=answer.photograph)
    if skew > _SKEW or stretch > _STRETCH or bent > _BENT:
        reason = Reason.GRID_NOT_SQUARE(skew=np.degrees(skew), stretch=stretch, distortion=bent)
        return Scale("refused", reason, photograph=answer.photograph)
    return answer


def _jackknife(
    grid: Grid, phases: list[Phases], shape: tuple[int, int], done: Callable[[int, int], object]
) -> list[Grid]:
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
            grids.append(fit_grid(phases, grid, shape, select))
        done(_ROUNDS + part + 1, _ROUNDS + _PARTS**2)
    return grids


def jackknife_sd(estimates: list[float]) -> float:
    """Standard deviation from estimates without one part each (Efron 1982); NaN from fewer than two."""
    values, n = np.array(estimates), len(estimates)
    return float(np.sqrt((n - 1) / n * ((values - values.mean()) ** 2).sum())) if n > 1 else float("nan")


def _answer(
    grid: Grid,
    partial: list[Grid],
    phases: list[Phases],
    photograph: Photograph,
    division: float,
    division_sd: float,
) -> Scale:
    """The scale of a grid; `partial`: the grid from all parts of the field but one."""
    shape = photograph.image.shape
    size = grid.pixel * division
    spread = jackknife_sd([part.pixel for part in partial]) * division
    side_sds = [jackknife_sd([part.sides[axis] for part in partial]) * division for axis in (0, 1)]
    stretch_sds = np.array([jackknife_sd([part.stretches[way] for part in partial]) for way in (0, 1)])
    uneven = unevenness(np.array(grid.stretches), stretch_sds)
    lines = tuple(float(np.ptp(grid.turns(k, p.x, p.y, shape))) for k, p in enumerate(phases))
    first, second = grid.waves
    square = float(first @ second / (np.hypot(*first) * np.hypot(*second)))
    distortion_sd = jackknife_sd([part.distortion for part in partial])
    answer = Scale(
        "ok",
        pixel_size=size,
        pixel_size_sd=float(np.hypot(np.hypot(spread, size * division_sd / division), size * uneven / 2)),
        pixel_size_x=grid.sides[0] * division,
        pixel_size_y=grid.sides[1] * division,
        pixel_size_x_sd=side_sds[0],
        pixel_size_y_sd=side_sds[1],
        stretch=grid.stretches[0],
        shear=grid.stretches[1],
        stretch_sd=float(stretch_sds[0]),
        shear_sd=float(stretch_sds[1]),
        angle=float(np.arctan2(first[1], first[0])) if first[0] >= 0 else float(np.arctan2(-first[1], -first[0])),
        skew=float(np.arcsin(np.clip(square, -1, 1))),
        distortion=grid.distortion,
        distortion_sd=distortion_sd if np.isfinite(distortion_sd) else None,
        half_diagonal=float(np.hypot(shape[0] - 1, shape[1] - 1) / 2),
        lines=(lines[0], lines[1]),
        division=division,
        division_sd=division_sd or None,
        warnings=list(photograph.warnings),
        photograph=photograph,
        grid=grid,
    )
    if not division_sd:
        answer.warnings.append(Reason.DIVISION_TREATED_AS_EXACT())
    if uneven > 0:
        answer.warnings.append(_uneven_words(answer, uneven))
    return answer


def unevenness(stretches: np.ndarray, sds: np.ndarray) -> float:
    """By what share pixels are longer one way than across it, beyond what noise makes of it; 0 where noise may."""
    with np.errstate(divide="ignore", invalid="ignore"):  # a grid that is drawn by a program has no scatter
        apart = np.square(stretches / sds).sum()
    if not apart > _APART:
        return 0.0
    return float(np.sqrt(max(np.square(stretches).sum() - np.square(sds).sum(), 0.0)))


def _uneven_words(answer: Scale, uneven: float) -> Statement:
    along = [
        f"{with_sd(size, sd, 'm')} along {axis}"
        for axis, size, sd in (
            ("x", answer.pixel_size_x, answer.pixel_size_x_sd),
            ("y", answer.pixel_size_y, answer.pixel_size_y_sd),
        )
        if size and sd
    ]
    stretches, sds = (answer.stretch, answer.shear), (answer.stretch_sd, answer.shear_sd)
    ratio = np.sqrt(sum((value or 0.0) ** 2 / (sd or 1.0) ** 2 for value, sd in zip(stretches, sds, strict=True)))
    return Reason.PIXELS_NOT_SQUARE(uneven=uneven, along=", ".join(along), ratio=ratio)
