"""Whether the codes follow the light: the fringes' second harmonic, and the exponent that takes it away."""

from dataclasses import replace

import numpy as np
from numpy.polynomial.chebyshev import chebvander

from fitting.estimate import SIZES, Fitted, correlation
from fitting.model import SEARCHED, gap_phase
from fitting.photo import Photograph, reduce, thin
from fitting.photograph.averaging import variance_of
from fitting.photograph.refit import with_parts
from fitting.photograph.selection import Complete
from fitting.reasons import Reason

_PIXELS = 30_000
# A second harmonic below this share of the first moves no radius by its noise, and one within so many standard
# deviations is noise.
_SMALL, _SIGNIFICANT = 0.02, 6.0
_EXPONENTS = np.exp(np.linspace(np.log(0.3), np.log(3.5), 13))


def linearized(photograph: Photograph, fit: Fitted) -> Photograph | None:
    """The photograph with its codes raised to the exponent that makes the fringes sinusoidal; None for no need of it.

    At the fit's phase, fringes of two beams are a background and one cosine; a power law of the camera adds harmonics.
    The exponent is the one that leaves the least share of the variance over. Where that is the first or the last that
    is tried, the harmonics are no power law's: then the codes stay as they are, and the photograph's warnings say so.
    """
    model = fit.solution.problem.phase.exact
    if model is None or not _is_bent(fit):
        return None
    sample = thin(photograph.mask, _PIXELS)
    step = sample[0].step
    rows, columns = (at * step for at in np.nonzero(photograph.mask[sample]))
    weights = _weights_at(fit, rows, columns)
    rows, columns = rows[weights > 0], columns[weights > 0]
    light = photograph.codes.light((slice(None, None, step), slice(None, None, step)))[rows // step, columns // step]
    turns = gap_phase.phase(model, columns.astype(float), rows.astype(float), fit.numbers)
    basis = np.linalg.qr(_design(photograph.mask.shape, rows, columns, turns))[0]

    def left(exponent: float) -> float:
        value = np.sign(light) * np.abs(light) ** exponent
        value = value - value.mean()
        return 1 - float(((basis.T @ value) ** 2).sum() / (value @ value))

    tried = [left(exponent) for exponent in _EXPONENTS]
    at = int(np.argmin(tried))
    if at in (0, len(tried) - 1):
        photograph.warnings.append(Reason.NO_PURE_COSINE(exponent=float(_EXPONENTS[at])))
        return None
    a, b, c = tried[at - 1 : at + 2]
    bend = a - 2 * b + c
    step = np.log(_EXPONENTS[1] / _EXPONENTS[0])
    exponent = float(_EXPONENTS[at] * np.exp(step * np.clip(0.5 * (a - c) / bend if bend > 0 else 0.0, -1, 1)))
    if left(exponent) > 0.98 * left(1.0):
        return None
    transfer = f"{photograph.transfer}, then exponent {exponent:.3g} (fitted)"
    curve = replace(photograph.codes.curve, fitted=photograph.codes.curve.fitted * exponent)
    return replace(photograph, codes=replace(photograph.codes, curve=curve), transfer=transfer)


def _weights_at(fit: Fitted, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """The weights of the blocks in which pixels lie; 0 outside of the grid."""
    grid, weights = fit.reduced.grid, fit.left.weights
    at = [place // grid.block - first for place, (first, _) in ((rows, grid.rows), (columns, grid.columns))]
    inside = np.all([(k >= 0) & (k < n) for k, n in zip(at, weights.shape, strict=True)], axis=0)
    return np.where(inside, weights[tuple(np.where(inside, k, 0) for k in at)], 0.0)


def _is_bent(fit: Fitted) -> bool:
    """Whether the residual holds a second harmonic in phase with the fringes, beyond its noise."""
    left, grid = fit.left, fit.reduced.grid
    used = left.weights > 0
    turns, residual = 4 * np.pi * fit.phase[used], left.value[used].astype(float)
    swing = float(np.abs(fit.solution.point.modulus).mean())
    wave = np.cos(turns)
    wave -= wave.mean()
    amplitude = float(residual @ wave / (wave @ wave))
    quadrature = np.zeros(used.shape)
    quadrature[used] = residual * np.sin(turns)
    inflation = correlation(grid, quadrature, left.weights, SIZES)
    spread = float(np.std(residual)) / np.sqrt(wave @ wave) * np.sqrt(max(inflation, 1.0))
    return bool(abs(amplitude) > max(_SMALL * swing, _SIGNIFICANT * spread))


def _design(shape: tuple[int, int], rows: np.ndarray, columns: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Columns of a smooth background and a smooth contrast times the cosine, at some of the pixels."""
    y, x = (chebvander(2 * at / max(n - 1, 1) - 1, 4) for at, n in zip((rows, columns), shape, strict=True))
    smooth = np.stack([y[:, j] * x[:, total - j] for total in range(5) for j in range(total + 1)], axis=1)
    return np.concatenate([smooth, smooth[:, :6] * np.cos(2 * np.pi * turns)[:, None]], axis=1)


def with_another_curve(before: Complete, photograph: Photograph) -> Complete | None:
    """The same on a photograph whose codes follow the light by another curve; None where it needs a new search.

    A contact may have come with the curve.
    """
    fit = before.fit
    if not fit.converged or set(SEARCHED) & set(fit.parts) or before.runner_up is not None:
        return None
    reduced = reduce(photograph, fit.reduced.grid.block, dtype=fit.reduced.light.dtype.type)
    used = reduced.used & fit.reduced.used
    # Priors weigh against the image by its noise over its fringes, which the curve leaves as they are.
    growth = float(reduced.light[used].var() / fit.reduced.light[used].var())
    curved = replace(fit, reduced=reduced)
    fit = with_parts(curved, fit.parts, fit.numbers, before.priors, variance_of(fit)[0] * growth)
    return before._replace(fit=fit, photograph=photograph) if fit.converged else None
