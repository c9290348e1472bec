"""The basis of the fringe moments: products of Chebyshev polynomials over the image."""

from functools import cache

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from newtonjax.numerics import chebyshev, cos_turns, sin_turns

# Degrees of the basis: of the background alone, and of the envelope, which also carries e^{2πi(φ-φ0)}. A phase within a
# quarter turn of the reference needs about 12 more degrees than the contrast has (measured in test_moments.py).
BACKGROUND, ENVELOPE = 6, 16


@cache
def degrees(limit: int) -> np.ndarray:
    """(degree in y, degree in x) of every product of Chebyshev polynomials up to a total degree, lowest first."""
    products = np.array([(j, total - j) for total in range(limit + 1) for j in range(total + 1)])
    products.setflags(write=False)
    return products


# X and y in [-1, 1] of the envelope's nodes, row by row.
ENVELOPE_NODES = chebyshev.node_grid(ENVELOPE + 1)


def model_coefficients(background, modulus, phase, reference) -> Float[Array, " basis"]:
    """Coefficients of background + modulus cos 2πphase in the basis about a reference phase.

    `background`: coefficients by `degrees(BACKGROUND)`; the others: values at the envelope's nodes.
    """
    away = phase - reference
    both = jnp.stack([modulus * cos_turns(away), modulus * sin_turns(away)])
    table, products = chebyshev.coefficients(both), degrees(ENVELOPE)
    return jnp.concatenate([background, table[:, products[:, 0], products[:, 1]].ravel()])
