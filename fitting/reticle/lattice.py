"""The pixel size from a photograph of a ruled grid: its two wave vectors, by demodulation over the whole field."""

from pathlib import Path

import numpy as np
from scipy import fft, ndimage, optimize

from fitting.parameters import check_deviation, number
from fitting.photo import Photograph, flatten, read
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


def scale(
    image: str | Path | np.ndarray,
    *,
    division: float,
    division_sd: float | None = None,
    transfer: str | float | None = None,
    mask: np.ndarray | None = None,
) -> Scale:
    """The pixel size on the object from a photograph of a square grid of lines, at any angle.

    The grid's two lowest wave vectors are found in the Fourier transform, with their harmonics; demodulated by each,
    the image gives the lines' phase everywhere, to which two plane waves behind one radial distortion are fitted. The
    standard deviation is the jackknife's over sixteen parts of the field, with the division's own.

    Args:
      image: a file, or an array as in `fitting.fit`.
      division, division_sd: distance of two lines, and its standard deviation [m].
      transfer, mask: as in `fitting.fit`.

    A photograph without a grid comes back refused. Raises ValueError and FileNotFoundError for input that is none.

    """
    if not 1e-9 < number("division", division) < 1.0:
        raise ValueError(f"division is {division}; allowed: 1e-9 to 1 m")
    check_deviation("division", division_sd, division)
    photograph = read(image, transfer, mask)
    if photograph.mask.sum() < 1024:
        return Scale("refused", f"{int(photograph.lit.sum())} pixels can be used: the image is dark or masked")
    fringes = flatten(photograph.image, photograph.lit)
    waves = _lattice(fringes)
    if waves is None:
        return Scale("refused", "no grid: no two directions of evenly spaced lines were found", photograph=photograph)
    found = np.array([*waves[0], 0.0, *waves[1], 0.0, 0.0])
    places = []
    for _ in range(_ROUNDS):
        places = [_phases(fringes, photograph.lit, found, which) for which in (0, 1)]
        coherence = min(place[3] for place in places)
        longest = 1 / min(float(np.hypot(*found[k : k + 2])) for k in (0, 3))
        least = max(_COHERENT, _NOISE / (4 * np.pi * (_WIDTH * longest) ** 2))
        if coherence < least:
            message = f"no grid: what looks like one is coherent to {coherence:.2g} only ({least:.2g} is the least)"
            return Scale("refused", message, photograph=photograph)
        found = _fit(places, found, photograph.image.shape)
    return _checked(_answer(found, places, photograph, float(division), float(division_sd or 0.0)))


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


def _lattice(fringes: np.ndarray) -> np.ndarray | None:
    """Two wave vectors [cycles/px] of similar length across each other, with the most power in them and harmonics."""
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
    return np.stack([first, second] if abs(first[0]) >= abs(second[0]) else [second, first])


def _phases(fringes: np.ndarray, lit: np.ndarray, numbers: np.ndarray, which: int):
    """Places x, y [px], by how much the lines are ahead of a fit [turns, modulo 1], and their mean coherence.

    Against the fit, and not against a plane wave: near an edge the average's middle is not the pixel.
    """
    rows, columns = fringes.shape
    width = _WIDTH / float(np.hypot(*numbers[3 * which : 3 * which + 2]))
    turns = _model(numbers, np.arange(columns), np.arange(rows)[:, None], which, fringes.shape)
    waves = (np.cos(2 * np.pi * turns), -np.sin(2 * np.pi * turns))
    smooth = [ndimage.gaussian_filter(fringes * wave, width, mode="constant") for wave in waves]
    power = ndimage.gaussian_filter(fringes**2, width, mode="constant")
    step = max(1, round(1.5 * width))
    sample = (slice(step // 2, None, step),) * 2
    phasor, power, covered = (smooth[0] + 1j * smooth[1])[sample], power[sample], lit[sample]
    size = np.abs(phasor) ** 2 / np.maximum(power, 1e-12)
    good = covered & (size > 0.25 * np.percentile(size[covered], 90)) if covered.any() else covered
    y, x = np.meshgrid(np.arange(rows)[sample[0]], np.arange(columns)[sample[1]], indexing="ij")
    return x[good], y[good], np.angle(phasor[good]) / (2 * np.pi), float(np.mean(size[good] * 2)) if good.any() else 0.0


def _model(numbers: np.ndarray, x: np.ndarray, y: np.ndarray, which: int, shape: tuple[int, int]) -> np.ndarray:
    """Turns of the lines of a direction at pixels: a plane wave on the undistorted image."""
    middle = [(n - 1) / 2 for n in shape]
    ux, uy = x - middle[1], y - middle[0]
    out = 1 + numbers[6] * (ux**2 + uy**2) / (middle[0] ** 2 + middle[1] ** 2)
    fx, fy, zero = numbers[3 * which : 3 * which + 3]
    return (fx * ux + fy * uy) * out + zero


def _fit(places, start: np.ndarray, shape: tuple[int, int], keep=None) -> np.ndarray:
    """Both waves, their phases and the distortion, by robust least squares on what the lines are ahead of `start`."""
    middle = np.array([(shape[1] - 1) / 2, (shape[0] - 1) / 2])
    chosen = [np.ones(len(place[0]), bool) if keep is None else keep(place[0], place[1]) for place in places]
    ahead = [place[2] + _model(start, place[0], place[1], k, shape) for k, place in enumerate(places)]
    far = [np.hypot(x - middle[0], y - middle[1]) / np.hypot(*middle) for x, y, *_ in places]

    def left(numbers, reach, free):
        parts = []
        for k, (x, y, *_) in enumerate(places):
            seen = chosen[k] & (far[k] <= reach)
            away = ahead[k][seen] - _model(np.where(free, numbers, start), x[seen], y[seen], k, shape)
            parts.append(away - np.round(away))
        return np.concatenate(parts)

    unit, found = np.array([1e-4, 1e-4, 0.1, 1e-4, 1e-4, 0.1, 1e-2]), start.copy()
    for k, place in enumerate(places):
        found[3 * k + 2] += np.angle(np.exp(2j * np.pi * place[2]).mean()) / (2 * np.pi)
    # Outwards from the middle: at the rim a distortion may be off by whole lines.
    nearest = float(min(f.min() for f in far))
    reaches = [*sorted({max(reach, nearest + 0.25) for reach in (0.3, 0.5, 0.7)}), np.inf]
    for reach in reaches:
        free = np.array([True] * 6 + [reach > reaches[0]])
        if len(left(found, reach, free)) > 20:
            arguments = (reach, free)
            fit = optimize.least_squares(left, found, x_scale=unit, loss="soft_l1", f_scale=0.03, args=arguments)
            found = np.where(free, fit.x, start)
    return found


def _answer(found: np.ndarray, places, photograph: Photograph, division: float, division_sd: float) -> Scale:
    shape = photograph.image.shape
    waves = np.stack([found[0:2], found[3:5]])

    def without(part):
        def keep(x, y):
            return (y * _PARTS // shape[0]).astype(int) * _PARTS + (x * _PARTS // shape[1]).astype(int) != part

        return keep

    left_out = []
    for part in range(_PARTS**2):
        keep = without(part)
        counts = [(int(keep(p[0], p[1]).sum()), len(p[0])) for p in places]
        if all(0.5 * total < count < total for count, total in counts):
            left_out.append(_fit(places, found, shape, keep))
    sizes = np.array([_size(numbers) for numbers in left_out])
    n = max(len(left_out), 2)
    spread = np.sqrt((n - 1) / n * ((sizes - sizes.mean()) ** 2).sum()) if len(sizes) > 1 else np.nan
    bends = np.array([numbers[6] for numbers in left_out])
    size = _size(found) * division
    sd = float(np.hypot(spread * division, size * division_sd / division))
    lines = tuple(float(np.ptp(_model(found, p[0], p[1], k, shape))) for k, p in enumerate(places))
    first, second = waves
    warnings = list(photograph.warnings)
    if not division_sd:
        warnings.append("no standard deviation given for the division: taken as exact, the error bar lacks it")
    # Columns of the matrix of waves are what one pixel along x, y crosses, in divisions.
    along_x, along_y = (float(np.hypot(*waves[:, k])) * division for k in (0, 1))
    if abs(np.log(along_x / along_y)) > 0.02:
        warnings.append(
            f"pixels are {abs(np.log(along_x / along_y)):.1%} longer one way: their geometric mean is given"
        )
    square = float(first @ second / (np.hypot(*first) * np.hypot(*second)))
    return Scale(
        "ok",
        pixel_size=size,
        pixel_size_sd=sd,
        pixel_size_x=along_x,
        pixel_size_y=along_y,
        angle=float(np.arctan2(first[1], first[0])) if first[0] >= 0 else float(np.arctan2(-first[1], -first[0])),
        skew=float(np.arcsin(np.clip(square, -1, 1))),
        distortion=float(found[6]),
        distortion_sd=float(np.sqrt((n - 1) / n * ((bends - bends.mean()) ** 2).sum())) if len(bends) > 1 else None,
        lines=(lines[0], lines[1]),
        division=division,
        division_sd=division_sd or None,
        warnings=warnings,
        photograph=photograph,
        numbers=found,
    )


def _size(numbers: np.ndarray) -> float:
    """Geometric mean of a pixel's sides in divisions, in the middle of the image."""
    return float(np.sqrt(abs(numbers[0] * numbers[4] - numbers[1] * numbers[3])))


def lines_at(result: Scale) -> list[np.ndarray]:
    """Turns of both directions' lines at every pixel: a line is where they are whole. Empty without a grid."""
    if result.photograph is None or result.numbers is None:
        return []
    rows, columns = result.photograph.image.shape
    x, y = np.arange(columns, dtype=float), np.arange(rows, dtype=float)[:, None]
    return [_model(result.numbers, x, y, which, (rows, columns)) for which in (0, 1)]
