"""The pixel size from a ruler or stage micrometer: the places of its lines, and the straight line through them."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy import ndimage, stats

from fitting.photo import Photograph, flatten
from fitting.reasons import Reason
from fitting.reticle.lines import strongest_lines
from fitting.reticle.result import Scale
from fitting.sheet_reasons import SheetReason

# Fewer lines leave no freedom for a scatter; lines scatter by less of their distance.
_FEWEST, _SCATTER = 6, 0.08
# A line counts where it is so strong beside the median one; the strip of lines ends at this share of their power.
_STRONG, _STRIP = 0.35, 0.4
# Harmonics among which the lines' own distance is looked for: every tenth line is longer. A harmonic of so many times
# the power is the distance; a subharmonic of this share of it.
_HARMONICS, _MORE, _LESS = 10, 4.0, 0.7
# Samples of the strip's profile in a pixel; rounds of placing a line, and of leaving out those off the others.
_SAMPLES, _ROUNDS, _OFF = 2, 3, 4.0
# Standard deviations of what a camera and a slant do at the corners of the picture, as shares of the scale.
_DISTORTION_SD, _SLANT_SD = 0.05, 0.05


class Strip(NamedTuple):
    """The ruler's lines as a profile along its length.

    - `place` [n]: px from the picture's middle along the ruler; `light` [n]: lines positive; NaN off the picture.
    - `normal` [2]: the unit vector along the ruler; `across`: ends of the strip on either side of the middle [px].
    """

    place: np.ndarray
    light: np.ndarray
    normal: np.ndarray
    across: tuple[float, float]


class Ticks(NamedTuple):
    """Lines: their `number` and `place` [px], [n]."""

    number: np.ndarray
    place: np.ndarray


class Line(NamedTuple):
    """Number against place: lines a pixel in the middle of the picture, their deviation, κ, its deviation, the scatter.

    `used` [n]: the lines that lie on it.
    """

    frequency: float
    frequency_sd: float
    distortion: float
    distortion_sd: float
    scatter: float
    used: np.ndarray


def of_ruler(photograph: Photograph, division: float, division_sd: float) -> Scale:
    """The scale across one family of lines, or a refusal. Pixels are taken for square: the lines say nothing of it.

    Each line is placed by the phase of its light over one distance; the numbers are a line of the places, with the
    cubic of a radial distortion and the square of a view at a slant, both expected to be small.
    """
    refused = Scale("refused", photograph=photograph)
    if photograph.mask.sum() < 1024:
        return replace(refused, message=Reason.TOO_FEW_PIXELS_OF_GRID(pixels=int(photograph.lit.sum())))
    fringes = flatten(photograph.image, photograph.lit)
    wave = strongest_lines(fringes)
    if wave is None:
        return replace(refused, message=SheetReason.NO_LINES())
    # A window over the picture's rim, which a spectrum needs, would move the lines there.
    ends = tuple(np.ones(count) for count in fringes.shape)
    level = flatten(photograph.image, photograph.lit, (ends[0], ends[1]))
    strip = _strip(level, photograph.lit, _refined(fringes, wave))
    ticks = _ticks(strip, _distance(strip, 1 / float(np.hypot(*wave))))
    if len(ticks.number) < _FEWEST:
        return replace(refused, message=SheetReason.FEW_LINES(lines=len(ticks.number), least=_FEWEST))
    line = _line(ticks, strip, photograph.image.shape)
    if line.used.sum() < _FEWEST or line.scatter * line.frequency > _SCATTER:
        return replace(refused, message=SheetReason.LINES_UNEVEN(scatter=line.scatter * line.frequency, most=_SCATTER))
    return _answer(photograph, strip, ticks, line, division, division_sd)


def _refined(fringes: np.ndarray, wave: np.ndarray) -> np.ndarray:
    """The wave vector by the mean turn between neighbouring pixels of what it demodulates."""
    y, x = np.mgrid[: fringes.shape[0], : fringes.shape[1]]
    for _ in range(_ROUNDS):
        turns = wave[0] * x + wave[1] * y
        width = 1.2 / float(np.hypot(*wave))
        parts = [ndimage.gaussian_filter(fringes * part(2 * np.pi * turns), width) for part in (np.cos, np.sin)]
        phasor = parts[0] - 1j * parts[1]
        steps = [(phasor[:, 1:] * phasor[:, :-1].conj()).sum(), (phasor[1:] * phasor[:-1].conj()).sum()]
        wave = wave + np.angle(steps) / (2 * np.pi)
    return wave


def _strip(fringes: np.ndarray, lit: np.ndarray, wave: np.ndarray) -> Strip:
    """The profile over the part across the ruler where its lines are strong, squared to them."""
    normal, distance = wave / np.hypot(*wave), 1 / float(np.hypot(*wave))
    across = _strong_part(fringes, wave)
    sides = np.arange(across[0], across[1] + 1)
    for _ in range(_ROUNDS):
        place, light, weights = _rectified(fringes, lit, normal, sides)
        normal = _squared(normal, place, light, distance, sides)
    place, light, weights = _rectified(fringes, lit, normal, sides)
    total = weights.sum(axis=0)
    profile = np.where(total > 0.5 * len(sides), (light * weights).sum(axis=0) / np.maximum(total, 1e-9), np.nan)
    # Lines are thin: what stands out is they, dark or bright.
    centred = profile - np.nanmean(profile)
    return Strip(place, centred * (np.sign(np.nanmean(centred**3)) or 1.0), normal, across)


def _strong_part(fringes: np.ndarray, wave: np.ndarray) -> tuple[float, float]:
    """Where across the ruler its lines are strong, from the picture's middle [px]."""
    rows, columns = fringes.shape
    normal, reach = wave / np.hypot(*wave), int(np.hypot(rows, columns) / 2)
    y, x = np.mgrid[:rows, :columns]
    turns, width = wave[0] * x + wave[1] * y, 0.6 / float(np.hypot(*wave))
    parts = [ndimage.gaussian_filter(fringes * part(2 * np.pi * turns), width) for part in (np.cos, np.sin)]
    side = normal[0] * (y - (rows - 1) / 2) - normal[1] * (x - (columns - 1) / 2)
    bins = (side + reach).astype(int).ravel()
    sums = np.bincount(bins, (np.square(parts[0]) + np.square(parts[1])).ravel(), 2 * reach + 2)
    labels = np.empty(sums.shape, np.int32)
    ndimage.label(sums > _STRIP * sums.max(), output=labels)
    members = np.flatnonzero(labels == labels[np.argmax(sums)])
    return float(members[0] - reach), float(members[-1] + 1 - reach)


def _rectified(
    fringes: np.ndarray, lit: np.ndarray, normal: np.ndarray, sides: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places along the ruler [n], light and weights [sides, n]."""
    rows, columns = fringes.shape
    reach = int(np.hypot(rows, columns) / 2)
    place = np.arange(-reach * _SAMPLES, reach * _SAMPLES + 1) / _SAMPLES
    at_x = (columns - 1) / 2 + normal[0] * place - normal[1] * sides[:, None]
    at_y = (rows - 1) / 2 + normal[1] * place + normal[0] * sides[:, None]
    light = ndimage.map_coordinates(fringes, [at_y, at_x], order=1, cval=0.0)
    weights = ndimage.map_coordinates(lit.astype(float), [at_y, at_x], order=1, cval=0.0)
    return place, light, weights


def _squared(
    normal: np.ndarray, place: np.ndarray, light: np.ndarray, distance: float, sides: np.ndarray
) -> np.ndarray:
    """The direction across the lines, by how far their two halves are shifted against each other."""
    half = len(sides) // 2
    if half < 2:
        return normal
    wave = np.exp(-2j * np.pi * place / distance)
    first, second = (
        _smoothed(part.mean(axis=0) * wave, 1.2 * distance * _SAMPLES) for part in (light[:half], light[-half:])
    )
    shift = -float(np.angle(np.vdot(first, second))) / (2 * np.pi) * distance
    slope = shift / (len(sides) - half)
    turned = normal - slope * np.array([-normal[1], normal[0]])
    return turned / np.hypot(*turned)


def _smoothed(values: np.ndarray, width: float) -> np.ndarray:
    real, imaginary = (ndimage.gaussian_filter1d(part, width) for part in (np.real(values), np.imag(values)))
    return real + 1j * imaginary


def _distance(strip: Strip, distance: float) -> float:
    """The distance of neighbouring lines: the one of which a wave's is a harmonic or a subharmonic [px]."""
    ends = np.isfinite(strip.light)
    place, light = strip.place[ends], strip.light[ends] * np.hanning(ends.sum())

    def power(frequency: float) -> float:
        near = frequency + np.linspace(-0.5, 0.5, 5) / max(np.ptp(place), 1.0)
        return float((np.abs(np.exp(-2j * np.pi * np.outer(near, place)) @ light) ** 2).max())

    first = power(1 / distance)
    for harmonic in range(_HARMONICS, 1, -1):
        if harmonic / distance < 0.4 and power(harmonic / distance) > _MORE * first:
            return distance / harmonic
        if power(1 / (harmonic * distance)) > _LESS * first:
            return harmonic * distance
    return distance


def _ticks(strip: Strip, distance: float) -> Ticks:
    """Lines from the strongest one outwards, each looked for where the last ones have it."""
    starts = strip.place[np.isfinite(strip.light)]
    middle = starts[np.argmin(np.abs(starts - np.median(starts)))]
    at, _ = _placed(strip, middle, distance)
    at, strength = _placed(strip, at, distance)
    rows = [(0, at, strength)]
    for way in (1, -1):
        number, place, step = 0, at, distance
        while True:
            number, expected = number + way, place + way * step
            line, strength = _placed(strip, expected, step)
            if not np.isfinite(line):
                break
            rows.append((number, line, strength))
            is_strong = strength > _STRONG * float(np.median([row[2] for row in rows]))
            place = line if is_strong else expected
            step = 0.7 * step + 0.3 * abs(line - (expected - way * step)) if is_strong else step
    number, place, strength = (np.array(column) for column in zip(*rows, strict=True))
    if not strength.max() > 0:
        return Ticks(number[:0], place[:0])
    strong = strength > _STRONG * np.median(strength[strength > 0.5 * np.median(strength)])
    return Ticks(number[strong], place[strong])


def _placed(strip: Strip, expected: float, distance: float) -> tuple[float, float]:
    """The place of the line near an expected one, and its strength; NaN where its light is not all seen.

    The phase of one distance of light, less the line between its ends; a neighbour's strength does not move it.
    """
    place, phasor = expected, 0j
    for _ in range(_ROUNDS):
        near = np.abs(strip.place - place) <= distance / 2
        offset, light = strip.place[near] - place, strip.light[near]
        if len(offset) < 0.9 * distance * _SAMPLES or not np.all(np.isfinite(light)):
            return np.nan, 0.0
        ends = max(int(0.1 * len(light)), 1)
        low, high = light[:ends].mean(), light[-ends:].mean()
        raised = light - low - (high - low) * (offset / distance + 0.5)
        weight = np.square(np.cos(np.pi * offset / distance))
        phasor = (weight * raised) @ np.exp(2j * np.pi * offset / distance)
        place = place + float(np.clip(np.angle(phasor) / (2 * np.pi), -0.25, 0.25)) * distance
    return place, float(np.abs(phasor))


def _line(ticks: Ticks, strip: Strip, shape: tuple[int, ...]) -> Line:
    """Least squares of number against place, with lines off the others left out."""
    half_diagonal = float(np.hypot(shape[0] - 1, shape[1] - 1) / 2)
    s, sides = ticks.place, np.linspace(*strip.across, 9)
    squares = (np.square(s) + np.mean(np.square(sides))) / half_diagonal**2
    design = np.column_stack([np.ones(len(s)), s, s * squares, np.square(s) / half_diagonal])
    frequency = 1 / float(np.median(np.diff(np.sort(s))))
    expected = np.array([np.inf, np.inf, frequency * _DISTORTION_SD, frequency * _SLANT_SD])
    used, variance, freedom = np.ones(len(s), bool), 0.02**2, 1.0
    values, covariance = np.zeros(4), np.eye(4)
    for _ in range(_ROUNDS * 2):
        matrix = design[used].T @ design[used] / variance + np.diag(expected**-2.0)
        covariance = np.linalg.inv(matrix)
        values = covariance @ (design[used].T @ ticks.number[used]) / variance
        residual = ticks.number - design @ values
        # What the expectations hold is no freedom that the lines have lost.
        lost = len(values) - float(np.trace(covariance @ np.diag(expected**-2.0)))
        freedom = max(used.sum() - lost, 1.0)
        variance = max(float(np.square(residual[used]).sum()) / freedom, 1e-10)
        scatter = 1.4826 * float(np.median(np.abs(residual[used])))
        used = np.abs(residual) < _OFF * max(scatter, 1e-4)
    spread = float(stats.t.ppf(0.975, freedom) / stats.norm.ppf(0.975))
    sds = spread * np.sqrt(np.diag(covariance))
    _, frequency, bend, _ = values
    return Line(
        abs(float(frequency)),
        float(sds[1]),
        float(bend / frequency),
        float(sds[2] / abs(frequency)),
        float(np.sqrt(variance) / abs(frequency)),
        used,
    )


def _answer(photograph: Photograph, strip: Strip, ticks: Ticks, line: Line, division: float, sd: float) -> Scale:
    size, shape = line.frequency * division, photograph.image.shape
    warnings = [*photograph.warnings, SheetReason.ONE_WAY_ONLY(what="a ruler")]
    if not sd:
        warnings.append(Reason.TREATED_AS_EXACT(names="ruler"))
    middle = (np.array(shape[::-1]) - 1) / 2
    sideways = np.array([-strip.normal[1], strip.normal[0]])
    marks = [
        [middle + place * strip.normal + side * sideways for side in strip.across] for place in ticks.place[line.used]
    ]
    angle = float(np.arctan2(strip.normal[1], strip.normal[0]))
    return Scale(
        "ok",
        pixel_size=size,
        pixel_size_sd=float(np.hypot(line.frequency_sd * division, size * sd / division)),
        pixel_size_x=size,
        pixel_size_y=size,
        stretch=0.0,
        shear=0.0,
        stretch_sd=1.0,
        shear_sd=1.0,
        angle=angle,
        distortion=line.distortion,
        distortion_sd=line.distortion_sd,
        half_diagonal=float(np.hypot(shape[0] - 1, shape[1] - 1) / 2),
        lines=(float(np.ptp(ticks.number)), 0.0),
        division=division,
        division_sd=sd or None,
        warnings=warnings,
        photograph=photograph,
        marks=np.array(marks),
    )
