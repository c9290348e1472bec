"""Rings of many beams: how sharp they are and how they are spaced, and no radius.

The light is B + A Σ ρ^m exp(-m² g² / 2) cos(2π m φ) over m from 1 on, Airy's sum (Born and Wolf, Principles of Optics,
section 7.6.1) of lines of a width g, with polynomials B and A over the field. The phase φ is k u, u the squared
distance from a centre, with what cameras and etalons add: ellipse, powers of u, coma. One picture does not separate ρ
from g; and the scale k at the centre is only as good as these terms, so its deviation is that between their choices.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from numpy.polynomial.polynomial import polyvander2d
from scipy.optimize import least_squares

from fitting.photo import Photograph, Rings, view_of
from fitting.photograph.sharp_waveform import NAMES, finesse_of, slopes, waveform

# Pixels that are looked at: to find the sharpness, and to measure.
_FEW_PIXELS, _PIXELS = 3000, 12_000
# Ratios of neighbouring harmonics from which the fit starts, one after the other.
_STARTS = (0.35, 0.6, 0.8, 0.9)
# Largest values of numbers that are not negative.
_MOST = {"ratio": 0.995, "variance": 1.0}
# Bright rings or dark ones.
_TURNS = (0.0, 0.5)
# What blunt rings explain, the next sharper ones, and these over those, where the sharpest may explain the light: of 15
# made pictures of a finesse of 10 to 29 at least 0.37, 0.58 and 1.24; of eight photographs of something else three
# pass the first, then with 0.24, 0.44 and 0.65, and 0.74, 1.18 and 1.00.
_BLUNT, _SHARPER, _GROWTH = 0.3, 0.5, 1.1
_ROUND, _ELLIPSE = NAMES[:4], NAMES[:8]
# Choices of phase and light: what is free, and the degree of B and A. The first one is stated.
_CHOICES = (
    (_ELLIPSE, 4),
    (_ELLIPSE, 2),
    ((*_ELLIPSE, "u3"), 4),
    ((*_ELLIPSE, "coma_x", "coma_y"), 4),
    ((*_ELLIPSE, "variance"), 4),
)


class ManyBeams(NamedTuple):
    """Rings of many beams in a photograph.

    - `finesse`: distance of rings over their full width half way between their brightest and darkest, with its sd.
    - `scale`: n s² / (R λ) if they are Newton's rings of one round trip [turns per px²], with its standard deviation.
    - `centre` (x, y) [px]; `explained`: share of the variance about smooth light; `ratio`: of neighbouring harmonics.
    """

    finesse: float
    finesse_sd: float
    scale: float
    scale_sd: float
    centre: tuple[float, float]
    explained: float
    ratio: float


class _Pixels(NamedTuple):
    """Some pixels: light, places in half diagonals from the middle, and the polynomials there."""

    light: Float[np.ndarray, " pixels"]
    x: Float[np.ndarray, " pixels"]
    y: Float[np.ndarray, " pixels"]
    unit: float
    middle: tuple[float, float]

    def first(self, count: int) -> "_Pixels":
        return self._replace(light=self.light[:count], x=self.x[:count], y=self.y[:count])

    def polynomials(self, degree: int) -> Float[np.ndarray, "pixels terms"]:
        pairs = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)]
        every = polyvander2d(self.x, self.y, (degree, degree))
        return every[:, [i * (degree + 1) + j for i, j in pairs]]


class _Optimum(NamedTuple):
    """Where a fit ended: its numbers, their covariance where they are free, and the share of variance explained."""

    numbers: dict[str, float]
    free: tuple[str, ...]
    covariance: Float[np.ndarray, "free free"]
    cost: float
    explained: float

    def variance(self, name: str) -> float:
        at = self.free.index(name)
        return float(self.covariance[at, at])


def explained_by_sharp_rings(photograph: Photograph, rings: Rings) -> float:
    """Share of the variance about smooth light that rings of many beams take, of a few pixels.

    That of blunter ones where sharper ones do not take much more.
    """
    pixels = _pixels_of(photograph).first(_FEW_PIXELS)
    start = _start(pixels, rings)
    tries = [_round_rings(pixels, _turned(start, turn), _STARTS[0]) for turn in _TURNS]
    blunt = max(tries, key=lambda optimum: optimum.explained)
    if blunt.explained < _BLUNT:
        return blunt.explained
    sharper = _round_rings(pixels, blunt.numbers, _STARTS[1])
    if sharper.explained < max(_SHARPER, _GROWTH * blunt.explained):
        return sharper.explained
    return _optimum(pixels, _sharpened(pixels, start), _ELLIPSE, 2).explained


def many_beams(photograph: Photograph, rings: Rings, with_another_curve: Photograph | None = None) -> ManyBeams:
    """The sharpness and the scale of rings of many beams near the rings that a search found.

    `with_another_curve`: the same photograph by another curve of the camera that may be its own: half of what that
    changes is in the deviations.
    """
    pixels = _pixels_of(photograph)
    start = _sharpened(pixels.first(_FEW_PIXELS), _start(pixels, rings))
    stated = _optimum(pixels, start, *_CHOICES[0])
    optima = [stated, *(_optimum(pixels, stated.numbers, *choice) for choice in _CHOICES[1:])]
    scales = np.array([optimum.numbers["log_scale"] for optimum in optima])
    finesses = np.array([_finesse(optimum.numbers) for optimum in optima])
    curves = _other_curve(with_another_curve, stated)
    log_sd = np.sqrt(stated.variance("log_scale") + _spread(scales) ** 2 + curves[0] ** 2)
    step = 1e-4
    slope = (_finesse({**stated.numbers, "ratio": stated.numbers["ratio"] + step}) - finesses[0]) / step
    finesse_sd = np.sqrt(slope**2 * stated.variance("ratio") + _spread(finesses) ** 2 + curves[1] ** 2)
    scale = float(np.exp(scales[0])) / pixels.unit**2
    x, y = (m + pixels.unit * stated.numbers[f"centre_{axis}"] for axis, m in zip("xy", pixels.middle, strict=True))
    return ManyBeams(
        float(finesses[0]),
        float(finesse_sd),
        scale,
        scale * float(log_sd),
        (float(x), float(y)),
        stated.explained,
        stated.numbers["ratio"],
    )


def _other_curve(photograph: Photograph | None, stated: _Optimum) -> tuple[float, float]:
    """Half of what another curve of the camera changes: of the logarithm of the scale, and of the finesse."""
    if photograph is None:
        return 0.0, 0.0
    numbers = _optimum(_pixels_of(photograph), stated.numbers, *_CHOICES[0]).numbers
    change = numbers["log_scale"] - stated.numbers["log_scale"]
    return change / 2, (_finesse(numbers) - _finesse(stated.numbers)) / 2


def _spread(values: np.ndarray) -> float:
    """Of other choices about the stated one, which comes first."""
    return float(np.sqrt(np.mean((values[1:] - values[0]) ** 2)))


def _pixels_of(photograph: Photograph) -> _Pixels:
    """Unsaturated pixels, spread over the field by chance."""
    view = view_of(photograph, 1, photograph.mask)
    rows, columns = np.nonzero(view.mask)
    places = np.random.default_rng(0).permutation(len(rows))[:_PIXELS]
    rows, columns = rows[places], columns[places]
    light = view.means[rows, columns].astype(float)
    x, y = columns + float(view.corner[0]), rows + float(view.corner[1])
    middle = (float(x.mean()), float(y.mean()))
    unit = float(np.hypot(x - middle[0], y - middle[1]).max())
    return _Pixels(light, (x - middle[0]) / unit, (y - middle[1]) / unit, unit, middle)


def _start(pixels: _Pixels, rings: Rings) -> dict[str, float]:
    x, y = ((c - m) / pixels.unit for c, m in zip(rings.centre, pixels.middle, strict=True))
    start = dict.fromkeys(NAMES, 0.0)
    scale = np.log(rings.scale * pixels.unit**2)
    return {**start, "log_scale": float(scale), "centre_x": x, "centre_y": y, "phase": rings.phase}


def _sharpened(pixels: _Pixels, start: dict[str, float]) -> dict[str, float]:
    """Numbers of the sharpest rings that explain the most, on bright rings or on dark ones.

    Blunt rings find the place of sharp ones, which are blind beside it. They are made sharper as long as that helps.
    """
    ends = []
    for turn in _TURNS:
        optimum = _round_rings(pixels, _turned(start, turn), _STARTS[0])
        for ratio in _STARTS[1:]:
            sharper = _round_rings(pixels, optimum.numbers, ratio)
            if sharper.cost > optimum.cost:
                break
            optimum = sharper
        ends.append(optimum)
    return min(ends, key=lambda optimum: optimum.cost).numbers


def _turned(numbers: dict[str, float], turn: float) -> dict[str, float]:
    return {**numbers, "phase": numbers["phase"] + turn}


def _round_rings(pixels: _Pixels, start: dict[str, float], ratio: float) -> _Optimum:
    """Round rings from a start of such a sharpness, in light of degree 2."""
    return _optimum(pixels, {**start, "ratio": ratio}, _ROUND, 2)


def _optimum(pixels: _Pixels, start: dict[str, float], free: tuple[str, ...], degree: int) -> _Optimum:
    """The least squares over the free numbers; of B and A at each of them (Golub and Pereyra 1973)."""
    light = pixels.polynomials(degree)
    bounds = [(0.0, _MOST[name]) if name in _MOST else (-np.inf, np.inf) for name in free]
    curve = _Curve(pixels, light, start, free)
    answer = least_squares(
        curve.residual,
        [start[name] for name in free],
        curve.slopes,  # pyright: ignore[reportArgumentType]  # its stubs know the names of methods alone
        bounds=tuple(zip(*bounds, strict=True)),
        x_scale="jac",
        max_nfev=30,
    )
    variance = 2 * answer.cost / max(len(pixels.light) - len(free) - 2 * light.shape[1], 1)
    covariance = np.linalg.pinv(answer.jac.T @ answer.jac) * variance
    smooth = float(np.sum(_remainder(light, _normal(light), pixels.light) ** 2))
    numbers = curve.numbers_at(answer.x)
    return _Optimum(numbers, free, covariance, float(answer.cost), 1 - 2 * float(answer.cost) / smooth)


class _Curve:
    """What rings leave over of pixels' light, as a function of their free numbers, with B and A at their best."""

    def __init__(self, pixels: _Pixels, light: np.ndarray, start: dict[str, float], free: tuple[str, ...]):
        self.pixels, self.light, self.start, self.free = pixels, light, start, free
        # Slopes are asked for where the remainder was taken last.
        self.at, self.design = np.full(len(free), np.nan), np.concatenate([light, light], axis=1)
        self.normal = np.eye(self.design.shape[1])

    def numbers_at(self, values: np.ndarray) -> dict[str, float]:
        return {**self.start, **dict(zip(self.free, map(float, values), strict=True))}

    def residual(self, values: np.ndarray) -> Float[np.ndarray, " pixels"]:
        self._look_at(values)
        return _remainder(self.design, self.normal, self.pixels.light)

    def slopes(self, values: np.ndarray) -> Float[np.ndarray, "pixels free"]:
        """Without that part which is of second order in the remainder (Kaufman 1975)."""
        self._look_at(values)
        amplitude = np.linalg.solve(self.normal, self.design.T @ self.pixels.light)[self.light.shape[1] :]
        wave_slopes = slopes(self.numbers_at(values), self.pixels.x, self.pixels.y, self.free)
        return -_remainder(self.design, self.normal, (self.light @ amplitude)[:, None] * wave_slopes)

    def _look_at(self, values: np.ndarray) -> None:
        if not np.array_equal(self.at, values):
            wave = waveform(self.numbers_at(values), self.pixels.x, self.pixels.y)
            np.multiply(self.light, wave[:, None], out=self.design[:, self.light.shape[1] :])
            self.at, self.normal = values.copy(), _normal(self.design)


def _normal(design: np.ndarray) -> np.ndarray:
    normal = design.T @ design
    return normal + 1e-12 * np.trace(normal) / len(normal) * np.eye(len(normal))


def _remainder(design: np.ndarray, normal: np.ndarray, values: np.ndarray) -> np.ndarray:
    return values - design @ np.linalg.solve(normal, design.T @ values)


def _finesse(numbers: dict[str, float]) -> float:
    return finesse_of(numbers["ratio"], numbers["variance"])
