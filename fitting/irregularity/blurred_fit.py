"""The form of a surface in a picture of few fringes, by least squares: one illumination, one visibility, one blur.

d = blur(E (1 + V cos 2πφ)), φ = Σ p_j Z_j, E a polynomial of degree 4, the blur a Gaussian of variance s² [px²]. The
model itself is blurred, so that neither contrast nor phase is biased where fringes are narrow. What a picture of few
fringes hardly determines has a prior: terms of the illumination beyond degree 2, terms of the form beyond those that
are reported, and the blur.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from fitting.irregularity.blurring import blurred
from fitting.irregularity.lamp_light import CHANGE_SD
from fitting.irregularity.lit_disc import LitDisc
from fitting.irregularity.moments import powers, products_at
from fitting.irregularity.residuals import inflation_of
from fitting.irregularity.zernike import on_grid, terms_at

# Terms that are fitted: an order more than are reported, each of them with this standard deviation [turns].
FITTED, REPORTED, _BEYOND_SD = 21, 15, 0.03
# Degree of the illumination; standard deviation of its terms beyond degree 2, as shares of its mean.
_DEGREE, _FREE, _LIGHT_SD = 4, 2, 0.02
# Variance of the blur, mean and standard deviation [px²], and its bounds.
_BLUR, _BLUR_SD, _BLUR_BOUNDS = 1.0, 2.0, (0.0, 25.0)
_VISIBILITY_BOUNDS = (0.03, 1.0)
# Turns that the phase may move in a step; the fit has converged where a step would lower chi-squared by less.
_STEP, _STILL, _STEPS = 0.3, 0.01, 40
# With more damping a step says nothing of what is left to gain.
_LIGHTLY = 1e-2


@dataclass(frozen=True)
class Numbers:
    """Form [terms], turns; visibility; variance of the blur [px²]; terms of the illumination."""

    form: np.ndarray
    visibility: float
    blur: float
    light: np.ndarray

    def moved(self, step: np.ndarray) -> "Numbers":
        """The numbers after a step, within their bounds."""
        terms = len(self.form)
        return Numbers(
            self.form + step[:terms],
            float(np.clip(self.visibility + step[terms], *_VISIBILITY_BOUNDS)),
            float(np.clip(self.blur + step[terms + 1], *_BLUR_BOUNDS)),
            self.light + step[terms + 2 :],
        )


@dataclass(frozen=True)
class BlurredFit:
    """An optimum.

    - `numbers`; `covariance` [terms, terms] of the form, for white noise, with the priors.
    - `with_lamp` [terms, terms]: what that would be, were the light measured.
    - `square`: residual sum of squares and the priors' part, in units of the light; `variance`: of a pixel.
    - `unexplained`: share of the light's variance, illumination and noise taken out, that is no fringe of this form.
    - `inflation`: of the noise's variance; `block`: pixels of the picture along the side of a fitted one.
    """

    numbers: Numbers
    covariance: np.ndarray
    with_lamp: np.ndarray
    square: float
    variance: float
    unexplained: float
    inflation: float
    pixels: int
    block: int
    converged: bool

    @property
    def form(self) -> np.ndarray:
        """All fitted terms, turns."""
        return self.numbers.form


def fit_blurred(
    disc: LitDisc, form: np.ndarray, visibility: float, noise: float, light_sd: float | None = None
) -> BlurredFit:
    """The optimum next to a form [terms] and a visibility; `noise`: the variance of a pixel by its neighbours.

    `light_sd`: how uneven the light is, as a share, where it was measured: its terms from degree 1 on then have this
    prior, else those beyond degree 2 that of a lamp.
    """
    picture = _Picture(disc, noise, light_sd)
    numbers = picture.start(np.pad(form, (0, FITTED - len(form))), visibility)
    square, damping, converged = picture.square(numbers), 1e-3, False
    for _ in range(_STEPS):
        normal, slope = picture.normal(numbers)
        scale = np.sqrt(np.diag(normal))
        damped = normal / np.outer(scale, scale) + damping * np.eye(len(normal))
        step = np.linalg.solve(damped, slope / scale) / scale
        gain = float(step @ slope)
        # Single precision does not show so small a gain in the sum of squares.
        if gain < _STILL * max(square / picture.pixels, picture.noise) and damping < _LIGHTLY:
            converged = True
            break
        largest = float(np.abs(picture.values @ step[:FITTED].astype(np.float32)).max())
        trial = picture.relit(numbers.moved(step * min(1.0, _STEP / max(largest, 1e-9))))
        trial_square = picture.square(trial)
        if trial_square > square * (1 + 1e-9):
            damping *= 6
            if damping > 1e5:
                break
            continue
        numbers, square = trial, trial_square
        damping = max(damping / 5, 1e-9)
    return picture.answer(numbers, square, converged)


class _Picture:
    """The light of a disc with the terms of form and illumination there, and the priors of the latter."""

    def __init__(self, disc: LitDisc, noise: float, light_sd: float | None):
        u, v = disc.points()
        self.disc, self.u = disc, disc.u.astype(np.float32)
        self.light = disc.light[disc.used]
        self.pixels = len(self.light)
        self.values = terms_at(u, v, FITTED).astype(np.float32)
        self.even = products_at(u, v, _DEGREE).astype(np.float32)
        grid_v, grid_u = (np.clip(grid, -1.1, 1.1).ravel() for grid in np.meshgrid(disc.v, disc.u, indexing="ij"))
        self.grid = products_at(grid_u, grid_v, _DEGREE).astype(np.float32).reshape(*disc.light.shape, -1)
        flat = self.light - self._even_part()
        self.spread = float(np.square(flat, dtype=float).sum())
        # A picture without noise is one of codes.
        self.noise = max(noise, 1e-6 * self.spread / self.pixels)
        self.weights = self._priors(light_sd)

    def _even_part(self) -> np.ndarray:
        few = products_at(*self.disc.points(), _FREE)
        return few @ np.linalg.lstsq(few, self.light, rcond=None)[0]

    def _priors(self, light_sd: float | None) -> np.ndarray:
        """Inverse variances of all numbers in units of the noise's [numbers]; those of the illumination by its mean."""
        of_form = np.where(np.arange(FITTED) < REPORTED, 0.0, _BEYOND_SD**-2.0)
        degree = powers(_DEGREE).sum(axis=1)
        free, sd = (_FREE, _LIGHT_SD) if light_sd is None else (0, light_sd)
        of_light = np.where(degree > free, (sd * float(self.light.mean())) ** -2.0, 0.0)
        return self.noise * np.concatenate([of_form, [0.0, _BLUR_SD**-2.0], of_light])

    def _strayed(self, numbers: Numbers) -> np.ndarray:
        """The numbers less the middles of their priors."""
        return np.concatenate([numbers.form, [0.0, numbers.blur - _BLUR], numbers.light])

    def start(self, form: np.ndarray, visibility: float) -> Numbers:
        """The illumination that fits best at a form."""
        fringes = 1 + visibility * np.cos(2 * np.pi * (self.values @ form.astype(np.float32)))
        columns = (fringes[:, None] * self.even).astype(float)
        normal = columns.T @ columns + np.diag(self.weights[FITTED + 2 :])
        return Numbers(form, visibility, _BLUR, np.linalg.solve(normal, columns.T @ self.light))

    def relit(self, numbers: Numbers) -> Numbers:
        """The numbers with the illumination that fits best: along a valley it follows the form."""
        even, cosine, _ = self._fields(numbers)
        fringes = 1 + np.float32(numbers.visibility) * cosine
        residual = self.light - blurred(even * fringes, numbers.blur)[self.disc.used]
        columns = blurred(fringes, numbers.blur)[self.disc.used][:, None] * self.even
        priors = self.weights[FITTED + 2 :]
        normal = (columns.T @ columns).astype(float) + np.diag(priors)
        slope = (columns.T @ residual).astype(float) - priors * numbers.light
        return replace(numbers, light=numbers.light + np.linalg.solve(normal, slope))

    def _fields(self, numbers: Numbers) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Illumination, cosine and sine of the phase, on the grid."""
        angle = np.float32(2 * np.pi) * on_grid(numbers.form, self.u, self.disc.v)
        return self.grid @ numbers.light.astype(np.float32), np.cos(angle), np.sin(angle)

    def square(self, numbers: Numbers) -> float:
        """Residual sum of squares and the priors' part."""
        even, cosine, _ = self._fields(numbers)
        model = blurred(even * (1 + np.float32(numbers.visibility) * cosine), numbers.blur)
        residual = self.light - model[self.disc.used]
        prior = float(self.weights @ np.square(self._strayed(numbers)))
        return float(np.square(residual, dtype=float).sum()) + prior

    def _columns(self, numbers: Numbers) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Residual [n], columns [n, numbers], and the light's rate with the phase [n].

        Terms of form and illumination change little over a blur, so they stand before it: the residual's mean is zero
        at the truth whatever columns it is multiplied with.
        """
        visibility, used = np.float32(numbers.visibility), self.disc.used
        even, cosine, sine = self._fields(numbers)
        model = blurred(even * (1 + visibility * cosine), numbers.blur)
        rate = blurred(np.float32(-2 * np.pi) * visibility * even * sine, numbers.blur)[used]
        contrast = blurred(even * cosine, numbers.blur)[used]
        fringes = blurred(1 + visibility * cosine, numbers.blur)[used]
        # By the heat equation a blur of variance s² changes with s² by half of the Laplacian.
        widening = ndimage.laplace(model)[used] / 2
        parts = [rate[:, None] * self.values, contrast[:, None], widening[:, None], fringes[:, None] * self.even]
        return self.light - model[used], np.concatenate(parts, axis=1), rate

    def normal(self, numbers: Numbers) -> tuple[np.ndarray, np.ndarray]:
        """Normal matrix and slope, with the priors."""
        residual, columns, _ = self._columns(numbers)
        normal = (columns.T @ columns).astype(float) + np.diag(self.weights)
        slope = (columns.T @ residual).astype(float) - self.weights * self._strayed(numbers)
        bounded = (numbers.visibility, _VISIBILITY_BOUNDS), (numbers.blur, _BLUR_BOUNDS)
        for place, (value, (low, high)) in enumerate(bounded, FITTED):
            # A number at its bound that would go beyond stays.
            if (value <= low and slope[place] < 0) or (value >= high and slope[place] > 0):
                normal[place], normal[:, place], slope[place] = 0.0, 0.0, 0.0
                normal[place, place] = 1.0
        return normal, slope

    def _inverse(self, columns: np.ndarray, numbers: Numbers, weights: np.ndarray) -> np.ndarray:
        """The form's part of the inverse of the normal matrix with such priors [terms, terms]."""
        normal = (columns.T @ columns).astype(float) + np.diag(weights)
        # A blur at its bound does not move.
        free = np.ones(len(normal), bool)
        free[FITTED + 1] = _BLUR_BOUNDS[0] < numbers.blur < _BLUR_BOUNDS[1]
        scale = np.sqrt(np.diag(normal))[free]
        inverse = np.linalg.pinv(normal[np.ix_(free, free)] / np.outer(scale, scale), hermitian=True)
        return (inverse / np.outer(scale, scale))[:FITTED, :FITTED]

    def answer(self, numbers: Numbers, square: float, converged: bool) -> BlurredFit:
        """What is reported of an optimum."""
        residual, columns, rate = self._columns(numbers)
        residual_square = float(np.square(residual, dtype=float).sum())
        variance = residual_square / max(self.pixels - columns.shape[1], 1)
        score = np.zeros(self.disc.used.shape, np.float32)
        score[self.disc.used] = residual * rate
        noise_square = self.pixels * self.noise
        unexplained = (residual_square - noise_square) / max(self.spread - noise_square, 1e-30)
        return BlurredFit(
            numbers,
            variance * self._inverse(columns, numbers, self.weights),
            variance * self._inverse(columns, numbers, self._priors(CHANGE_SD)),
            square,
            variance,
            float(unexplained),
            inflation_of(score),
            self.pixels,
            self.disc.block,
            converged,
        )
