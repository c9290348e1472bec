"""Fringe moments: a few hundred numbers that hold the whole image's Gaussian likelihood.

For a reference phase φ0 and smooth fields, sums over pixels of w e^{2πi m φ0} T_i(x) T_j(y) are taken once. The model
is written in the basis {T, T cos 2πφ0, -T sin 2πφ0}; its weighted Gram matrix follows from the moments by
T_i T_j = (T_{i+j} + T_{|i-j|}) / 2, and with a factor of that matrix chi-squared becomes a sum of as many
squares as there are basis functions, up to a constant. Exact for any model whose fields the basis resolves.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from newtonjax import chebyshev
from newtonjax.turns import cos_turns, sin_turns

# Degrees of the basis: of the background alone, and of the envelope, which also carries e^{2πi(φ-φ0)}. A phase within a
# quarter turn of the reference needs about 12 more degrees than the contrast has (measured in tests/test_moments.py).
BACKGROUND, ENVELOPE = 6, 16
# Directions in which the data hold less than this share of the largest eigenvalue are rounding, not data.
_RANK = 1e-13
# A Cholesky factor whose smallest pivot is above this share of its largest has lost no more than rounding.
_SOUND = 1e-8


class Moments(NamedTuple):
    """What is kept of an image.

    - `root` [basis, basis], `target` [basis]: chi-squared = |root coefficients - target|² + `rest`.
    - `reference`: the reference phase at the envelope's nodes (row by row) [turns].
    """

    root: Float[Array, "basis basis"]
    target: Float[Array, " basis"]
    rest: Float[Array, ""]
    reference: Float[Array, " nodes"]


def degrees(limit: int) -> np.ndarray:
    """(degree in y, degree in x) of every product of Chebyshev polynomials up to a total degree, lowest first."""
    both = [(j, i) for total in range(limit + 1) for j in range(total + 1) for i in [total - j]]
    return np.array(both)


def node_grid(count: int) -> tuple[np.ndarray, np.ndarray]:
    """X and y in [-1, 1] of a grid of Chebyshev nodes, row by row."""
    at = chebyshev.nodes(count)
    y, x = np.meshgrid(at, at, indexing="ij")
    return x.ravel(), y.ravel()


def _gram(table: Float[Array, "degrees degrees"], left: np.ndarray, right: np.ndarray) -> Float[Array, "left right"]:
    """Σ q (T_a T_b) for pairs of basis functions, from the moments of q."""
    (jl, il), (jr, ir) = left.T[:, :, None], right.T[:, None, :]
    total = 0.0
    for j in (jl + jr, abs(jl - jr)):
        for i in (il + ir, abs(il - ir)):
            total = total + table[j, i]
    return total / 4


def moments(
    sums: Float[np.ndarray, "8 degrees degrees"], square: float, reference: Float[np.ndarray, " nodes"]
) -> Moments:
    """Moments from their sums about a reference phase (`fringe_sums.Sums`)."""
    return _factorize(jnp.asarray(sums), jnp.asarray(square), jnp.asarray(reference))


@jax.jit
def _factorize(table: Float[Array, "8 degrees degrees"], square: Float[Array, ""], reference) -> Moments:
    w, wc, ws, wc2, ws2, wd, wdc, wds = table
    low, high = degrees(BACKGROUND), degrees(ENVELOPE)
    cross = jnp.concatenate([_gram(wc, low, high), -_gram(ws, low, high)], axis=1)
    flat, even, odd = _gram(w, high, high), _gram(wc2, high, high), _gram(ws2, high, high)
    fringes = jnp.block([[flat + even, -odd], [-odd, flat - even]]) / 2
    gram = jnp.block([[_gram(w, low, low), cross], [cross.T, fringes]])
    data = jnp.concatenate([wd[tuple(low.T)], wdc[tuple(high.T)], -wds[tuple(high.T)]])
    lower = jnp.linalg.cholesky(gram)
    pivots = jnp.diag(lower) ** 2
    # Cholesky's factor where the basis is well determined, which is quicker; eigenvectors where it is not.
    sound = jnp.isfinite(lower).all() & (pivots.min() > _SOUND * pivots.max())
    root, target = jax.lax.cond(sound, _by_cholesky, _by_eigenvectors, gram, lower, data)
    return Moments(root, target, square - target @ target, reference)


def _by_cholesky(gram, lower, data):
    del gram
    return lower.T, jax.scipy.linalg.solve_triangular(lower, data, lower=True)


def _by_eigenvectors(gram, lower, data):
    del lower
    value, vector = jnp.linalg.eigh(gram)
    kept = value > _RANK * value[-1]
    root = jnp.sqrt(jnp.where(kept, value, 0.0))
    return root[:, None] * vector.T, jnp.where(kept, (vector.T @ data) / jnp.where(kept, root, 1.0), 0.0)


def model_coefficients(background, modulus, phase, reference) -> Float[Array, " basis"]:
    """Coefficients of background + modulus cos 2πphase in the basis about a reference phase.

    `background`: coefficients by `degrees(BACKGROUND)`; the others: values at the envelope's nodes.
    """
    away = phase - reference
    both = jnp.stack([modulus * cos_turns(away), modulus * sin_turns(away)])
    table = chebyshev.coefficients(both)
    high = degrees(ENVELOPE)
    return jnp.concatenate([background, table[:, high[:, 0], high[:, 1]].ravel()])


def residuals(kept: Moments, coefficients: Float[Array, " basis"]) -> Float[Array, " basis"]:
    """Numbers whose squares sum to chi-squared less `kept.rest`."""
    return kept.root @ coefficients - kept.target
