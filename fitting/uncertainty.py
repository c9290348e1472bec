"""What an image leaves uncertain of its first number, row by row: noise, parts of the model, and what it left out."""

from itertools import chain

import jax.numpy as jnp
import numpy as np
from numpy.polynomial.chebyshev import chebvander

from fitting import least_squares as ls
from fitting.illumination import Fitted, numbers_of
from fitting.models import PARTS, as_arrays, localize
from fitting.moments import BACKGROUND, degrees, moments
from fitting.photo import Photograph

# A difference between two halves of the field beyond so many standard deviations is the model's, not the noise's.
_APART = 3.0
# Relative differences below this are rounding and unfinished steps.
_ROUNDING = 1e-7
# Middle of sodium's D lines in air, and their distance [m]: a wavelength between them may be either line or both.
_SODIUM, _LINES = 589.294e-9, 0.597e-9
# A visibility that falls by less tells nothing, and moves no radius.
_FADING = 0.003
# The two usual laws of distortion, from the image to the object and back, differ by 3 κ² in the fifth order: taken as
# one and a half standard deviations where the image does not tell.
_FIFTH = 2.0


def image_rows(
    found: Fitted,
    photograph: Photograph,
    variance: float,
    rivals: tuple[tuple[str, Fitted], ...],
    wavelength: float | None,
) -> list[tuple[str, float]]:
    """(source, standard deviation of the model's first number) of all that is not a given quantity.

    Noise with the parts' numbers held; then what each part's own numbers add; the law of a distortion; rival models
    that the image does not rule out; sodium's second line; and what halves of the field differ by beyond their noise.
    """
    solution = found.solution
    active = np.asarray(solution.active)
    own = list(chain.from_iterable(PARTS[part] for part in found.parts))
    plain = active.copy()
    plain[own] = False
    before = _deviation(solution, plain, variance)
    rows = [("noise", before)]
    for part in found.parts:
        if not PARTS[part]:
            continue
        plain[list(PARTS[part])] = active[list(PARTS[part])]
        now = _deviation(solution, plain, variance)
        rows.append((part, float(np.sqrt(max(now**2 - before**2, 0.0)))))
        before = max(now, before)
    if "distortion" in found.parts and "fifth order" not in found.parts:
        (fifth,) = PARTS["fifth order"]
        law = min(_FIFTH * float(numbers_of(found)[6]) ** 2, _APART * _told(solution, fifth, variance))
        rows.append(("distortion's law", abs(moved_by(found, fifth)) * law))
    rows += [(name, abs(float(numbers_of(rival)[0] - numbers_of(found)[0]))) for name, rival in rivals]
    if wavelength is not None and abs(wavelength - _SODIUM) < 0.6 * _LINES:
        row = _doublet(found)
        rows += [("sodium's two lines", row)] if row > 0 else []
    if (apart := halves_apart(found, photograph, variance)) > 0:
        rows.append(("model, by halves of the field", apart))
    return rows


def _doublet(found: Fitted) -> float:
    """Change of the first number if the light is sodium's doublet, 2 : 1, as far as the fringes fade as its do.

    The mean fringe of both lines is a cosine whose phase bends off the mean line's as the third power of the order,
    and whose visibility falls as the second: the share of that fall which is seen is the share of the change that
    counts.
    """
    order = np.asarray(found.solution.image[2]) - float(numbers_of(found)[3])
    apart = 2 * np.pi * order * _LINES / _SODIUM
    both = (2 * np.exp(1j * apart / 3) + np.exp(-2j * apart / 3)) / 3
    share = _faded(found, np.abs(both))
    if share == 0:
        return 0.0
    bend = np.angle(both) / (2 * np.pi)
    change = np.asarray(ls.responses(found.solution, found.kept, jnp.asarray(bend[None]))[1])[0]
    return share * abs(_pulled(found.solution, change))


def _faded(found: Fitted, wanted: np.ndarray) -> float:
    """How much of a visibility's fall, given at the nodes, the fringes show: 0 to 1."""
    frame, background = found.model.frame, np.asarray(found.solution.image[0])
    rows, columns = (
        np.clip(np.round(at).astype(int), 0, n - 1)
        for at, n in zip((frame.y, frame.x), found.weights.shape, strict=True)
    )
    used = found.weights[rows, columns] > 0
    x, y = (at / middle - 1 for at, middle in zip((frame.x, frame.y), frame.middle, strict=True))
    low = degrees(BACKGROUND)
    smooth = (chebvander(y, BACKGROUND)[:, low[:, 0]] * chebvander(x, BACKGROUND)[:, low[:, 1]]) @ background
    used &= smooth > 0.2 * np.max(smooth)
    if used.sum() < 10 or np.ptp(wanted[used]) < _FADING:
        return 0.0
    seen = np.abs(np.asarray(found.solution.image[1]))[used] / smooth[used]
    fall = wanted[used] - wanted[used].mean()
    return float(np.clip((fall @ seen) / (fall @ fall) / seen.max(), 0.0, 1.0))


def _deviation(solution: ls.Solution, active: np.ndarray, variance: float) -> float:
    return float(np.sqrt(ls.covariance(solution._replace(active=jnp.asarray(active)), variance)[0, 0]))


def _told(solution: ls.Solution, number: int, variance: float) -> float:
    """Standard deviation that a number which is held would have if it were free."""
    jacobian = np.asarray(solution.jacobian)
    basis = np.linalg.qr(jacobian[:, np.asarray(solution.active)])[0]
    column = jacobian[:, number]
    own = float(np.linalg.norm(column - basis @ (basis.T @ column)))
    return float(np.sqrt(variance)) / own if own > 0 else np.inf


def moved_by(found: Fitted, number: int) -> float:
    """Change of the first number when another one that is held moves by one: the implicit function theorem."""
    return _pulled(found.solution, np.asarray(found.solution.jacobian)[:, number])


def _pulled(solution: ls.Solution, change: np.ndarray) -> float:
    """Change of the first number that makes up for a change of the residuals, the others being free."""
    jacobian = np.asarray(solution.jacobian)[:, np.asarray(solution.active)]
    return -float(np.linalg.lstsq(jacobian, change, rcond=1e-12)[0][0])


def halves_apart(found: Fitted, photograph: Photograph, variance: float) -> float:
    """How far the first number is from that of the better half of the field, beyond what noise explains; 0 for nothing.

    The field is halved at its middle order, column and row. In each half one step of Gauss and Newton's method from
    the optimum moves curvature, centre, phase and illumination; the parts' numbers are held. Without a misfit the
    difference has the sum of both variances (Hausman's test, 1978); the whole field's number lies between the halves'
    as their variances say. The largest of the three ways to halve counts.
    """
    solution = found.solution
    active = np.asarray(solution.active).copy()
    active[list(chain.from_iterable(PARTS[part] for part in found.parts))] = False
    worst = 0.0
    for inside in _halvings(found, photograph.mask):
        first, second = (
            _step(found, photograph, np.where(half, found.weights, 0.0), active) for half in (inside, ~inside)
        )
        if first is None or second is None:
            continue
        (one, here), (other, there) = first, second
        apart, noise = (one - other) ** 2, (here + there) * variance
        if apart > max(_APART**2 * noise, (_ROUNDING * float(numbers_of(found)[0])) ** 2):
            worst = max(worst, np.sqrt(apart - noise) * min(here, there) / (here + there))
    return float(worst)


def _halvings(found: Fitted, mask: np.ndarray) -> list[np.ndarray]:
    """The field's first halves by order, column and row."""
    rows, columns = np.nonzero(mask)
    y, x = np.ogrid[: mask.shape[0], : mask.shape[1]]
    tables = [found.phase, np.broadcast_to(x, mask.shape), np.broadcast_to(y, mask.shape)]
    middles = [np.median(found.phase[rows, columns]), np.median(columns), np.median(rows)]
    return [table <= middle for table, middle in zip(tables, middles, strict=True)]


def _step(found: Fitted, photograph: Photograph, weights: np.ndarray, active: np.ndarray) -> tuple[float, float] | None:
    """The first number's step in part of the field, and its variance per unit of the noise's; None without either."""
    kept = found.kept
    part = moments(jnp.asarray(photograph.image), jnp.asarray(weights), kept.reference, kept.rough)
    local = localize(as_arrays(found.model), found.solution.unknowns.model)
    left, jacobian = (np.asarray(table) for table in ls.tangent(local, part, found.solution.unknowns))
    jacobian = jacobian[:, active]
    length = np.linalg.norm(jacobian, axis=0)
    if np.any(length == 0):
        return None
    _, singular, right = np.linalg.svd(jacobian / length, full_matrices=False)
    if singular[-1] < 1e-6 * singular[0]:
        return None
    inverse = (right.T / singular**2) @ right / np.outer(length, length)
    return -float(inverse[0] @ (jacobian.T @ left)), float(inverse[0, 0])
