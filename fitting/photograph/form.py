"""The rival of another form: what the fringes' phase has that no sphere gives, and by how much it moves the scale."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from fitting.estimate import bends
from fitting.parameters import NUMBERS
from fitting.photograph.remainder import Remainder
from fitting.photograph.rival import AbstractRival, Finding
from fitting.reasons import Reason

# Chi-squared that the terms of a form take, per term, in variances with what neighbours share: of pictures on the model
# one in a hundred exceeds it.
_LIMIT = 4.0
# Standard deviations that the terms' prior may have [turns at the rim], from the data.
_SMALLEST, _LARGEST, _ROUNDS = 1e-3, 0.5, 8
# A phase that terms change by more than this [turns] is not linear in them.
_LINEAR = 1.0
# Terms of which less than this is left beside the model's own numbers are these numbers.
_ALIKE = 1e-6
_CURVATURE = NUMBERS.index("curvature")


class Terms(NamedTuple):
    """Terms of a form beside the fit: its values [turns at the rim], and what they do.

    - `chi2`: what each takes of chi-squared in the mean, in variances.
    - `shift`: relative change of the fringe scale with them; `shift_sd`: what they leave uncertain of it.
    """

    values: Float[np.ndarray, " terms"]
    chi2: float
    shift: float
    shift_sd: float


class Form(AbstractRival):
    """Coma, trefoil, astigmatism of the fourth order, fourfold waves, and rings in r or r⁴ (Zernike's terms).

    A score test (Rao 1948) on the fit's normal equations: no fit is made. A lens with a form has no single radius near
    its vertex: coma about a shifted vertex is curvature. So what the scale would move by with the terms, their common
    prior being as wide as they are (empirical Bayes), is a row of the budget.
    """

    name = "form"

    def finding(self, remainder: Remainder) -> Finding | None:
        """What the terms take of chi-squared, and move of the scale."""
        terms = form_terms(remainder)
        if terms is None or terms.chi2 < _LIMIT:
            return None
        # Their shift counts as far as they determine one, and where the phase is linear in them.
        square, doubt = terms.shift**2, terms.shift_sd**2
        largest = float(np.abs(terms.values).max())
        words = Reason.RIVAL_FORM(size=largest, shift=terms.shift)
        deviation = abs(terms.shift) * square / max(square + doubt, 1e-300) if largest < _LINEAR else 0.0
        return Finding(self.name, terms.chi2, _LIMIT, "budget", words, deviation)


def form_terms(remainder: Remainder) -> Terms | None:
    """The terms of a form that a fit leaves over; None where the model has them all."""
    fit = remainder.fit
    crossed, among, gradient = bends(fit.solution, _phases(remainder))
    matrix, white = fit.matrix, fit.chi2 / max(fit.weight, 1.0)
    if not white > 0:
        return None
    share = matrix.inverse @ crossed[matrix.active]
    remaining = among - crossed[matrix.active].T @ share
    slope = gradient - share.T @ matrix.gradient[matrix.active]
    free = np.diag(remaining) > _ALIKE * np.diag(among)
    if not free.any():
        return None
    # What neighbours share is mostly the form itself: it decides whether there is one, and does not pull it to zero.
    information, slope = remaining[np.ix_(free, free)] / white, slope[free] / white
    values, covariance = _shrunk(information, slope)
    chi2 = float(slope @ np.linalg.solve(information + np.eye(len(slope)) / _LARGEST**2, slope)) / fit.correlation
    of_scale = np.zeros((len(matrix.values), len(slope)))
    of_scale[matrix.active] = -share[:, free]
    by_terms = of_scale[_CURVATURE] / remainder.first
    uncertain = float(by_terms @ covariance @ by_terms)
    return Terms(values, chi2 / len(values), float(by_terms @ values), float(np.sqrt(max(uncertain, 0.0))))


def _phases(remainder: Remainder) -> np.ndarray:
    """The terms at the grid's nodes, each at most one turn at the rim [nodes, terms]."""
    x, y = remainder.nodes
    z = x + 1j * y
    z = z / np.abs(z).max()
    r2 = np.abs(z) ** 2
    waves = (z * r2, z**3, z**2 * r2, z**4)
    return np.stack([np.sqrt(r2 + 1e-4), r2 * r2, *(part for wave in waves for part in (wave.real, wave.imag))], axis=1)


def _shrunk(information: np.ndarray, slope: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values and covariance under a normal prior about 0, as wide as the values themselves say (MacKay 1992)."""
    variance, values, posterior = _LARGEST**2, np.zeros(len(slope)), np.eye(len(slope))
    for _ in range(_ROUNDS):
        posterior = np.linalg.inv(information + np.eye(len(slope)) / variance)
        values = posterior @ slope
        effective = len(slope) - float(np.trace(posterior)) / variance
        variance = float(np.clip(values @ values / max(effective, 1e-3), _SMALLEST**2, _LARGEST**2))
    return values, posterior
