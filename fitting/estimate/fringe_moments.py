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

from fitting.model import BACKGROUND, ENVELOPE, degrees

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


def residuals(kept: Moments, coefficients: Float[Array, " basis"]) -> Float[Array, " basis"]:
    """Numbers whose squares sum to chi-squared less `kept.rest`."""
    return kept.root @ coefficients - kept.target
