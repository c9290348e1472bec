"""Chi-squared of fringes on moments with background and contrast eliminated (variable projection).

Golub and Pereyra 1973: for given numbers of the phase the best background and contrast are a linear solution, so that
a step moves four to nine numbers only. The phase is exact: its difference from the moments' reference goes through a
cosine and a sine at the nodes, not through a tangent.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64
from numpy.polynomial.chebyshev import chebvander

from fitting.estimate.fringe_sums import Normal
from fitting.model import BACKGROUND, ENVELOPE, ENVELOPE_NODES, degrees
from newtonjax.numerics import chebyshev

# Degree of the contrast, at most.
CONTRAST = 4
# Directions of the background that hold less than this share of the largest eigenvalue are rounding, not data.
_RANK = 1e-12


class Fields(NamedTuple):
    """A model at the nodes: phase [turns], relative contrast (None: 1), and derivatives by its numbers.

    `slopes` [nodes, free]; `contrast_slopes` the same, None where the contrast has none.
    """

    phase: Float64[np.ndarray, " nodes"]
    slopes: Float64[np.ndarray, "nodes free"]
    contrast: Float64[np.ndarray, " nodes"] | None = None
    contrast_slopes: Float64[np.ndarray, "nodes free"] | None = None


class Eliminated(NamedTuple):
    """Normal equations of the envelope when a background of some degree takes what it can.

    `square`: what is left of Σ w d² without fringes; `low`: number of the background's coefficients.
    """

    normal: Normal
    fringes: Float64[np.ndarray, "envelope envelope"]
    of_fringes: Float64[np.ndarray, " envelope"]
    square: float
    low: int
    inverse: Float64[np.ndarray, "low low"]


@dataclass(frozen=True)
class Point:
    """Chi-squared at given numbers for the best background and contrast, and its derivatives when they are asked for.

    - `contrast`: coefficients by `degrees(CONTRAST)`; `modulus` at the nodes.
    - `columns` [envelope, polynomials]: how the image changes with the contrast; `changed`: normal equations times it.
    - `background`: coefficients by `degrees(BACKGROUND)`, zeros where its degree is lower.
    - `inner` [polynomials, polynomials]: the inverse of the contrast's own normal equations.
    """

    rest: Eliminated
    fields: Fields
    chi2: float
    contrast: Float64[np.ndarray, " polynomials"]
    modulus: Float64[np.ndarray, " nodes"]
    columns: Float64[np.ndarray, "envelope polynomials"]
    changed: Float64[np.ndarray, "envelope polynomials"]
    inner: Float64[np.ndarray, "polynomials polynomials"]
    background: Float64[np.ndarray, " low"]

    @cached_property
    def tails(self) -> Float64[np.ndarray, "envelope free"]:
        """How the image changes with the numbers."""
        fields, ahead = self.fields, self.fields.phase - self.rest.normal.reference
        tails = bent(self.modulus, ahead, fields.slopes)
        if fields.contrast_slopes is not None:
            shape = contrast_at_nodes()[:, : len(self.contrast)] @ self.contrast
            tails = tails + tilted(shape[:, None] * fields.contrast_slopes, ahead)
        return tails

    @cached_property
    def gradient(self) -> Float64[np.ndarray, " free"]:
        """Half of chi-squared's slope downwards, by number."""
        return self.tails.T @ (self.rest.of_fringes - self.changed @ self.contrast)

    @cached_property
    def matrix(self) -> Float64[np.ndarray, "free free"]:
        """Normal matrix of the numbers, background and contrast eliminated."""
        crossed = self.changed.T @ self.tails
        return self.tails.T @ (self.rest.fringes @ self.tails) - crossed.T @ (self.inner @ crossed)


def coefficients_of(degree: int, most: int) -> int:
    """How many polynomials there are up to a total degree; the lowest come first."""
    return int((degrees(most).sum(axis=1) <= degree).sum())


@cache
def contrast_at_nodes() -> np.ndarray:
    """The polynomials of the contrast, lowest degree first, at the envelope's nodes [nodes, polynomials]."""
    x, y = ENVELOPE_NODES
    order = degrees(CONTRAST)
    return chebvander(y, CONTRAST)[:, order[:, 0]] * chebvander(x, CONTRAST)[:, order[:, 1]]


def _to_envelope(fields: np.ndarray) -> np.ndarray:
    """Coefficients up to total degree 16 of fields at the nodes [nodes, n]: [coefficients, n]."""
    nodes, high = ENVELOPE + 1, degrees(ENVELOPE)
    matrix = _analysis()
    # One axis after the other: a single product with both would take five times as many operations.
    half = (matrix @ fields.reshape(nodes, -1)).reshape(nodes, nodes, -1)
    return (matrix @ half)[high[:, 0], high[:, 1]]


@cache
def _analysis() -> np.ndarray:
    return chebyshev.analysis(ENVELOPE + 1)


def eliminate(normal: Normal, degree: int) -> Eliminated:
    """Take a background of a degree out of the normal equations."""
    low = coefficients_of(degree, BACKGROUND)
    inverse = _inverse(normal.smooth[:low, :low])
    crossed, target = normal.crossed[:low], normal.of_smooth[:low]
    share = inverse @ crossed
    return Eliminated(
        normal,
        normal.fringes - crossed.T @ share,
        normal.of_fringes - share.T @ target,
        normal.square - float(target @ inverse @ target),
        low,
        inverse,
    )


def pseudo_inverse(matrix: np.ndarray, rank: float) -> np.ndarray:
    """Inverse of a normal matrix, without directions that hold less than a share `rank` of the largest eigenvalue."""
    size = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    size = np.where(size > 0, size, 1.0)
    scaled = matrix / np.outer(size, size)
    if not np.isfinite(scaled).all():
        return np.full_like(matrix, np.nan)
    value, vector = np.linalg.eigh(scaled)
    good = value > rank * value[-1]
    vector = vector[:, good] / size[:, None]
    return (vector / value[good]) @ vector.T


def _inverse(matrix: np.ndarray) -> np.ndarray:
    """As `pseudo_inverse`, and quicker where the matrix is well determined."""
    try:
        lower = np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError:
        return pseudo_inverse(matrix, _RANK)
    pivots = np.diag(lower) ** 2
    if not pivots.min() > 1e-8 * pivots.max():
        return pseudo_inverse(matrix, _RANK)
    inverse = np.linalg.inv(lower)
    return inverse.T @ inverse


def evaluate(rest: Eliminated, fields: Fields, degree: int) -> Point:
    """Chi-squared at a model's fields, for the best background and contrast (of a degree)."""
    shapes = contrast_at_nodes()[:, : coefficients_of(degree, CONTRAST)]
    if fields.contrast is not None:
        shapes = shapes * fields.contrast[:, None]
    ahead = fields.phase - rest.normal.reference
    columns = tilted(shapes, ahead)
    changed = rest.fringes @ columns
    target = columns.T @ rest.of_fringes
    inner = _inverse(columns.T @ changed)
    best = inner @ target
    background = np.zeros(len(rest.normal.of_smooth))
    of_fringes = rest.normal.crossed[: rest.low] @ (columns @ best)
    background[: rest.low] = rest.inverse @ (rest.normal.of_smooth[: rest.low] - of_fringes)
    chi2 = rest.square - float(best @ target)
    return Point(rest, fields, chi2, best, shapes @ best, columns, changed, inner, background)


def evaluate_model(
    rest: Eliminated, fields_at: Callable[[np.ndarray], Fields], numbers: np.ndarray, degree: int
) -> tuple[Fields, Point]:
    """A model's fields at given numbers, and chi-squared with its derivatives there."""
    # A step may lead anywhere: what is no number there is no better, and the step is not taken.
    with np.errstate(over="ignore", invalid="ignore"):
        fields = fields_at(numbers)
        return fields, evaluate(rest, fields, degree)


def bent(modulus: np.ndarray, ahead: np.ndarray, bends: np.ndarray) -> np.ndarray:
    """How an image's coefficients change with bends of its phase [turns, nodes x any], `ahead` of the reference."""
    swing = 2 * np.pi * modulus[:, None] * bends
    cosine, sine = np.cos(2 * np.pi * ahead), np.sin(2 * np.pi * ahead)
    return _quadratures(-swing * sine[:, None], swing * cosine[:, None])


def tilted(shapes: np.ndarray, ahead: np.ndarray) -> np.ndarray:
    """Coefficients of contrasts [nodes, any] whose phase is `ahead` of the reference [turns]."""
    cosine, sine = np.cos(2 * np.pi * ahead), np.sin(2 * np.pi * ahead)
    return _quadratures(shapes * cosine[:, None], shapes * sine[:, None])


def _quadratures(even: np.ndarray, odd: np.ndarray) -> np.ndarray:
    coefficients = _to_envelope(np.concatenate([even, odd], axis=1))
    return np.concatenate([coefficients[:, : even.shape[1]], coefficients[:, even.shape[1] :]])
