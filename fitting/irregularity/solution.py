"""From a picture and its pupil to the form, its number of terms, and its budget."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fitting.irregularity.budget import Row, blur_row, distortion_row, edge_row, noise_row, pupil_row, terms_row
from fitting.irregularity.curvatures import QUADRATIC
from fitting.irregularity.disc import EDGE, Disc, Pupil
from fitting.irregularity.projection import FormFit, fit_form
from fitting.irregularity.residuals import residual_of
from fitting.irregularity.search import Search
from fitting.irregularity.zernike import ORDERS, REPORTED

# The share of the radius within which light is used for the row of the edge.
_NARROWER = 0.9


@dataclass(frozen=True)
class Solution:
    """A form with all that is not certain of it.

    - `fit`: with two orders more than the `terms` that are reported, or that the picture bears evidence of, up to 36.
    - `rows`: the budget, of the reported terms; `inflation`: of the noise's variance.
    - `dust`: the share of pixels that was left out.
    """

    fit: FormFit
    terms: int
    rows: list[Row]
    inflation: float
    dust: float
    relative_pupil_sd: float

    @property
    def form(self) -> np.ndarray:
        """The reported terms, turns."""
        return self.fit.coefficients[: self.terms]

    @property
    def quadratic_covariance(self) -> np.ndarray:
        """Of power and astigmatism over the square of the radius, so that a pupil found too large changes no curvature.

        Of a larger circle the terms grow as its square: what is left of the radius's row is what higher terms bring.
        """
        changes = [row.changes.copy() for row in self.rows]
        changes[0][0] -= 2 * self.form * self.relative_pupil_sd
        stacked = np.vstack(changes)[:, QUADRATIC]
        return stacked.T @ stacked

    @property
    def covariance(self) -> np.ndarray:
        """Of the reported terms, all rows of the budget together."""
        stacked = np.vstack([row.changes for row in self.rows])
        return stacked.T @ stacked


class Uncertain(NamedTuple):
    """Standard deviations of what the picture does not say: of the pupil's rim [px], of the distortion there."""

    pupil: float = 0.0
    distortion: float = 0.0


def solved(disc: Disc, pupil: Pupil, search: Search, terms: int | None, uncertain: Uncertain) -> Solution:
    """The form on all pixels of a disc, from the best candidate; `terms`: how many are reported, None by evidence."""
    start = search.candidates[0].fit.coefficients
    fit = fit_form(disc, start)
    residual = residual_of(disc, fit)
    dust = 0.0
    if residual.dust is not None:
        disc = disc._replace(weights=np.where(residual.dust, np.float32(0), disc.weights))
        disc = disc._replace(light=disc.light * disc.weights)
        dust = float(residual.dust.sum()) / max(disc.pixels, 1.0)
        fit = fit_form(disc, fit.coefficients)
        residual = residual_of(disc, fit)
    evident = by_evidence(fit.coefficients, residual.inflation * fit.covariance, disc.pixels / residual.inflation)
    reported = terms or evident
    fitted = [order for order in ORDERS if order >= max(reported, evident)][:3][-1]
    if fitted < len(fit.coefficients):
        fit = fit_form(disc, fit.coefficients[:fitted])
    narrower = fit_form(_within(disc, _NARROWER), fit.coefficients, fit.degrees)
    rows = [
        pupil_row(fit.coefficients, pupil, uncertain.pupil),
        edge_row(narrower.coefficients - fit.coefficients, narrower.covariance - fit.covariance),
        terms_row(fit.coefficients, residual.inflation * fit.covariance, residual.inflation),
        blur_row(fit),
        distortion_row(fit.coefficients, uncertain.distortion),
        noise_row(residual.inflation * fit.covariance),
    ]
    rows = [Row(row.source, row.changes[:, :reported]) for row in rows]
    return Solution(fit, reported, rows, residual.inflation, dust, uncertain.pupil / pupil.radius)


def by_evidence(p: np.ndarray, covariance: np.ndarray, count: float) -> int:
    """How many terms the picture bears evidence of, by whole orders from all of them downwards.

    W - k ln n is least, W the chi-squared of the k terms that are dropped, n independent pixels (Schwarz 1978). Upwards
    would not do: a form cut short is more than half a turn off, and its fit is lost.
    """
    penalty = np.log(max(count, 2.0))
    best, least = len(p), 0.0
    for order in (order for order in REPORTED if order < len(p)):
        dropped = p[order:]
        weight = float(dropped @ np.linalg.lstsq(covariance[order:, order:], dropped, rcond=None)[0])
        criterion = weight - len(dropped) * penalty
        if criterion < least:
            best, least = order, criterion
    return best


def _within(disc: Disc, edge: float) -> Disc:
    """The same disc, its light used within a smaller share of the radius."""
    inside = np.square(disc.v)[:, None] + np.square(disc.u) <= min(edge, EDGE) ** 2
    weights = np.where(inside, disc.weights, np.float32(0))
    return disc._replace(weights=weights, light=disc.light * weights)
