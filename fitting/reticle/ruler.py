"""The pixel size from a ruler or stage micrometer: the places of its lines, and the straight line through them."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from fitting.photo import Photograph, flatten, smooth
from fitting.reasons import Reason
from fitting.reticle.lines import strongest_lines
from fitting.reticle.result import Scale
from fitting.reticle.ruler_line import Line, Ticks, through
from fitting.sheet_reasons import SheetReason

# Fewer lines leave no freedom for a scatter; lines scatter by less of their distance.
_FEWEST, _SCATTER = 6, 0.08
# A line counts where it is so strong beside the median one; the strip of lines ends at this share of their power.
_STRONG, _STRIP = 0.35, 0.4
# Lags up to this share of the strip are looked at; the first that rises by this share of the highest is the distance.
_LAGS, _RISE = 0.4, 0.5
# Width of the blur whose difference leaves the lines alone [px].
_COARSE = 6.0
# A ruler's second overtone is 0.25 of its lines and more, that of fringes 0.04 and less; fringes fill the picture.
_OVERTONES, _FILLED = 0.12, 0.35
# Samples of the strip's profile in a pixel; rounds of placing a line.
_SAMPLES, _ROUNDS = 2, 3


class Strip(NamedTuple):
    """The ruler's lines as a profile along its length.

    - `place` [n]: px from the picture's middle along the ruler; `light` [n]: lines positive; NaN off the picture.
    - `halves` [2, n]: the same of the halves of the strip across it.
    - `normal` [2]: the unit vector along the ruler; `across`: ends of the strip on either side of the middle [px].
    """

    place: np.ndarray
    light: np.ndarray
    halves: np.ndarray
    normal: np.ndarray
    across: tuple[float, float]


def of_ruler(photograph: Photograph, division: float, division_sd: float) -> Scale:
    """The scale across one family of lines, or a refusal. Pixels are taken for square: the lines say nothing of it.

    Each line is placed by the phase of its light over one distance; the numbers are a line of the places, with the
    cubic of a radial distortion and the square of a view at a slant, both expected to be small.
    """
    refused = Scale("refused", photograph=photograph)
    if photograph.mask.sum() < 1024:
        return replace(refused, message=Reason.TOO_FEW_PIXELS_OF_GRID(pixels=int(photograph.lit.sum())))
    fringes = flatten(photograph.image, photograph.lit)
    answer = _measured(photograph, fringes, division, division_sd)
    if answer.status == "refused" and answer.reason != SheetReason.LINES_OF_FRINGES.name:
        # Long lines and numerals may be stronger than the lines.
        fine = fringes - ndimage.gaussian_filter(fringes, _COARSE)
        answer = _measured(photograph, fine, division, division_sd)
    return answer


def _measured(photograph: Photograph, fringes: np.ndarray, division: float, division_sd: float) -> Scale:
    """The scale by the strongest family of lines in `fringes`."""
    refused = Scale("refused", photograph=photograph)
    wave = strongest_lines(fringes)
    if wave is None:
        return replace(refused, message=SheetReason.NO_LINES())
    strip = _strip(_level(photograph), photograph.lit, _refined(fringes, wave))
    ticks = _ticks(strip, _distance(strip))
    if len(ticks.number) < _FEWEST:
        return replace(refused, message=SheetReason.FEW_LINES(lines=len(ticks.number), least=_FEWEST))
    half_diagonal = float(np.hypot(*(count - 1 for count in photograph.image.shape)) / 2)
    line = through(ticks, _turns(strip, ticks), strip.across, half_diagonal)
    if line.used.sum() < _FEWEST or line.scatter * line.frequency > _SCATTER:
        return replace(refused, message=SheetReason.LINES_UNEVEN(scatter=line.scatter * line.frequency, most=_SCATTER))
    overtones = _overtones(strip, ticks)
    if overtones > _OVERTONES:
        return _answer(photograph, strip, ticks, line, division, division_sd)
    if _filled(strip, photograph.image.shape) > _FILLED:
        return replace(refused, message=SheetReason.LINES_OF_FRINGES(overtones=overtones))
    answer = _answer(photograph, strip, ticks, line, division, division_sd)
    return replace(answer, warnings=[*answer.warnings, SheetReason.SMOOTH_LINES(overtones=overtones)])


def _overtones(strip: Strip, ticks: Ticks) -> float:
    """The strength of twice the lines' frequency over that of the lines themselves."""
    place, number = (column[np.argsort(ticks.place)] for column in (ticks.place, ticks.number))
    between = (strip.place >= place[0]) & (strip.place <= place[-1]) & np.isfinite(strip.light)
    turns = np.interp(strip.place[between], place, number)
    lines, twice = (np.abs(np.mean(strip.light[between] * np.exp(2j * np.pi * k * turns))) for k in (1, 2))
    return float(twice / max(lines, 1e-12))


def _filled(strip: Strip, shape: tuple[int, ...]) -> float:
    """The share of the picture across the lines that they fill."""
    along_x, along_y = np.abs(strip.normal)
    return (strip.across[1] - strip.across[0]) / (along_x * shape[0] + along_y * shape[1])


def _level(photograph: Photograph) -> np.ndarray:
    """The light less what changes slowly. Its strength is left: to divide by what changes would move the lines."""
    lit, width = photograph.lit.astype(float), min(photograph.image.shape) / 8
    slow = smooth(photograph.image * lit, width) / (smooth(lit, width) + 1e-6)
    return lit * (photograph.image - slow)


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
    half = len(sides) // 2
    parts = slice(None), slice(None, half), slice(-half, None)
    profiles = np.array([_profile(light[part], weights[part]) for part in parts])
    # Lines are thin: what stands out is they, dark or bright.
    sign = np.sign(np.nanmean(profiles[0] ** 3)) or 1.0
    return Strip(place, sign * profiles[0], sign * profiles[1:], normal, across)


def _profile(light: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """The mean across the strip, less its own mean; NaN where less than half of it is seen."""
    total = weights.sum(axis=0)
    mean = (light * weights).sum(axis=0) / np.maximum(total, 1e-9)
    profile = np.where(total > 0.5 * len(light), mean, np.nan)
    return profile - np.nanmean(profile)


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
    light = ndimage.map_coordinates(fringes, [at_y, at_x], order=3, mode="nearest")
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


def _distance(strip: Strip) -> float:
    """The distance of neighbouring lines: the first lag at which the profile resembles itself as at any [px]."""
    light = strip.light[np.isfinite(strip.light)]
    count = len(light)
    sums = np.correlate(light, light, "full")[count - 1 :]
    likeness = sums[: int(_LAGS * count)] / (count - np.arange(int(_LAGS * count)))
    inner = likeness[1:-1]
    peaks = 1 + np.flatnonzero((inner > likeness[:-2]) & (inner >= likeness[2:]))
    if not len(peaks):
        return np.nan
    # A slow change of the light lifts all; a peak counts by what it stands above the valleys beside it.
    valleys = np.minimum.reduceat(likeness, np.concatenate([[0], peaks]))
    rises = likeness[peaks] - np.maximum(valleys[:-1], valleys[1:])
    lag = int(peaks[np.argmax(rises > _RISE * rises.max())])
    before, at, after = likeness[lag - 1 : lag + 2]
    return (lag + 0.5 * (before - after) / (before - 2 * at + after)) / _SAMPLES


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


def _turns(strip: Strip, ticks: Ticks) -> np.ndarray:
    """How much each line is turned against the strip: between its halves, place over distance across [n]."""
    distance = float(np.median(np.abs(np.diff(np.sort(ticks.place)))))
    halves = [strip._replace(light=light) for light in strip.halves]
    places = [[_placed(half, place, distance)[0] for place in ticks.place] for half in halves]
    return np.diff(places, axis=0)[0] / (0.5 * (strip.across[1] - strip.across[0]))


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
