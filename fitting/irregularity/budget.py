"""Where the standard deviations of a form come from: rows of one-sigma changes of its terms, in turns."""

from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from fitting.irregularity.disc import Pupil
from fitting.irregularity.moments import powers
from fitting.irregularity.projection import FormFit, nodes
from fitting.irregularity.zernike import ORDERS, at_points, slopes, terms_at

# A change is one of the picture, not of its noise, where its chi-squared exceeds its mean by so many of its sds.
_BEYOND = 3.0
# Steps of Newton's method to a distorted radius: to rounding at a distortion of 0.3.
_DISTORTION_STEPS = 8


class Row(NamedTuple):
    """One source: its name and the vectors [k, terms] of the changes that one standard deviation of it makes."""

    source: str
    changes: np.ndarray

    @property
    def sd(self) -> np.ndarray:
        """Standard deviations of the terms [terms]."""
        return np.sqrt(np.square(self.changes).sum(axis=0))

    def of_answers(self, form: np.ndarray) -> dict[str, float]:
        """What it makes of power, of the length of astigmatism and of the irregularity's rms, in turns."""
        irregular = np.where(np.arange(len(form)) >= 4, form, 0.0)
        astigmatic = np.where(np.isin(np.arange(len(form)), (4, 5)), form, 0.0)
        power = np.where(np.arange(len(form)) == 3, 1.0, 0.0)
        ways = {"power": power, "astigmatism": astigmatic, "irregularity": irregular}
        lengths = {name: max(float(np.linalg.norm(way)), 1e-300) for name, way in ways.items()}
        return {name: float(np.linalg.norm(self.changes @ (way / lengths[name]))) for name, way in ways.items()}


def noise_row(covariance: np.ndarray) -> Row:
    """The noise of the pixels, as neighbours go together."""
    values, vectors = np.linalg.eigh(covariance)
    return Row("noise", np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T)


def pupil_row(form: np.ndarray, pupil: Pupil, sd: float) -> Row:
    """The circle: its radius, its centre and its two stretches, each uncertain by `sd` [px] at the rim.

    The form stands still in the picture: with u = (x - x0) / R it changes by u·grad φ with the radius, by grad φ with
    the centre, and by a stretch as the pupil seen at a slant has it.
    """
    u, v, _ = nodes()
    along, down = (at_points(part[: len(form)], u, v) @ form for part in slopes())
    changes = [u * along + v * down, along, down, u * along - v * down, v * along + u * down]
    return Row("pupil", _projected(np.column_stack(changes) * sd / pupil.radius, len(form)))


def distortion_row(form: np.ndarray, sd: float) -> Row:
    """A radial distortion of the camera: what is seen at r lies at r (1 + κ (r² - 1)), the rim where it is.

    By the forms for κ = ±`sd`. Half their difference is the change of one standard deviation; half their sum goes as
    κ², whose mean square is 3 `sd`⁴ for a normal κ. Beside many fringes of power it is more than the noise.
    """
    u, v, _ = nodes()
    count, radius = len(form), np.hypot(u, v)
    forms = []
    for kappa in (sd, -sd):
        source = radius
        for _ in range(_DISTORTION_STEPS):
            ahead = source * (1 + kappa * (source**2 - 1)) - radius
            source = source - ahead / (1 + kappa * (3 * source**2 - 1))
        forms.append(terms_at(u * source / radius, v * source / radius, count) @ form)
    even = (forms[0] + forms[1]) / 2 - terms_at(u, v, count) @ form
    changes = [(forms[0] - forms[1]) / 2, np.sqrt(3) * even]
    return Row("distortion", _projected(np.column_stack(changes), count))


def edge_row(change: np.ndarray, covariance: np.ndarray) -> Row:
    """How the terms change where the light at the rim is not used, and by how much noise makes them do so."""
    return _change_row("edge", change, covariance)


def terms_row(form: np.ndarray, covariance: np.ndarray, inflation: float) -> Row:
    """How the terms change without those of the highest order: what a further order may do.

    Only where neighbouring residuals go together: white ones say that no order is missing.
    """
    count = len(form)
    before = max([order for order in ORDERS if order < count], default=count)
    high = slice(before, count)
    gain = np.linalg.lstsq(covariance[high, high], covariance[high], rcond=None)[0]
    change = -(form[high] @ gain)
    change[high] = form[high]
    weight = float(form[high] @ np.linalg.lstsq(covariance[high, high], form[high], rcond=None)[0])
    freedom = count - before
    if inflation == 1 or freedom == 0 or weight < freedom + _BEYOND * np.sqrt(2 * freedom):
        change = np.zeros(count)
    # Those of the highest order are themselves seen: of them only what their neighbours lose counts.
    change[high] = np.sqrt(np.mean(np.square(change[:before]))) if before else 0.0
    return Row("number of terms", change[None])


def blur_row(fit: FormFit) -> Row:
    """What a blur does to the phase: s² (grad ln M · grad φ + div grad φ / 2), s² from how contrast falls with slope.

    Lit by one lamp, M / B falls as exp(-2π² s² |grad φ|²); s² is the slope of its logarithm beside a light and a
    visibility of degree 2, so an upper bound where anything else takes contrast.
    """
    u, v, _ = nodes()
    count = len(fit.coefficients)
    inside = np.hypot(u, v) < 0.97
    rises = np.stack([at_points(part[:count], u, v) @ fit.coefficients for part in slopes()])
    contrast = _values(fit.contrast, fit.degrees.contrast, u, v)
    size = np.abs(contrast[0])
    ln_slope = np.stack(contrast[1:]) / np.where(contrast[0] == 0, 1.0, contrast[0])
    steepness = np.square(rises).sum(axis=0)
    logarithm = np.log(np.maximum(size, 1e-3 * size.max()))
    design = np.column_stack([-2 * np.pi**2 * steepness, np.ones_like(u), u, v, np.square(u) + np.square(v)])
    square = max(float(np.linalg.lstsq(design[inside], logarithm[inside], rcond=None)[0][0]), 0.0)
    bend = _laplacian(fit.coefficients, u, v)
    shift = square * ((ln_slope * rises).sum(axis=0) + bend / 2)
    return Row("blur", _projected(np.where(inside, shift, 0.0)[:, None], count))


def _change_row(source: str, change: np.ndarray, covariance: np.ndarray) -> Row:
    """A change where it is beyond what noise makes of it."""
    values, vectors = np.linalg.eigh(covariance)
    # Of a smaller variance is the difference of two matrices no variance: some are negative.
    finite = values > 1e-3 * values.max()
    weight = float((np.square(vectors[:, finite].T @ change) / values[finite]).sum())
    freedom = int(finite.sum())
    beyond = weight > freedom + _BEYOND * np.sqrt(2 * freedom)
    return Row(source, (change if beyond else np.zeros_like(change))[None])


def _projected(fields: np.ndarray, count: int) -> np.ndarray:
    """The terms [k, count] of fields at the nodes [n, k], by least squares over the disc."""
    u, v, _ = nodes()
    return np.linalg.lstsq(terms_at(u, v, count), fields, rcond=None)[0].T


def _values(coefficients: np.ndarray, degree: int, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, ...]:
    """A field of Chebyshev products at points, and its derivatives along u and v."""
    square, pairs = np.zeros((degree + 1, degree + 1)), powers(degree)
    square[pairs[:, 0], pairs[:, 1]] = coefficients
    along, down = chebyshev.chebder(square, axis=1), chebyshev.chebder(square, axis=0)
    return tuple(chebyshev.chebval2d(v, u, part) for part in (square, along, down))


def _laplacian(form: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Div grad of a form at points, turns a square of the radius."""
    along, down = (np.tensordot(form, part[: len(form)], 1) for part in slopes())
    return chebyshev.chebval2d(v, u, chebyshev.chebder(along, axis=1)) + chebyshev.chebval2d(
        v, u, chebyshev.chebder(down, axis=0)
    )
