"""The part of a view at an angle: round rings look elliptic."""

from types import MappingProxyType

import jax
import jax.numpy as jnp
import numpy as np

from fitting.model.part import AbstractPart
from fitting.parameters import Numbers


class ObliqueView(AbstractPart):
    """A camera that looks at an angle θ.

    The view makes one axis 1/cos θ longer on the object than in the image, and the path difference 2 t cos θ: of both
    together a stretch of determinant 1 is left, with sqrt(a² + b²) = -ln cos θ; so the curvature keeps its meaning.
    Pixels of unequal sides do the same when the pixel size is the geometric mean of both.
    """

    name = "oblique_view"
    parameters = ("stretch", "shear")
    is_warp = True
    stretches = ("stretch", "shear")
    # Of each component of the log-stretch -ln cos θ of a view that is meant to be normal, and is within 10 degrees.
    priors = MappingProxyType({"stretch": (0.0, 0.0187), "shear": (0.0, 0.0187)})
    prior_words = "a view within 10 degrees of the normal"
    advice = MappingProxyType({"oblique_view": "look along the normal"})

    def reach(self, numbers: Numbers):
        """1/cos θ, which the stretch of determinant 1 leaves out."""
        tilt = _tilt(numbers)
        return jnp.exp(tilt - 1e-6) if isinstance(tilt, jax.Array) else np.exp(tilt - 1e-6)

    def reach_slopes(self, numbers: Numbers, by_reach) -> dict:
        """With L = exp(sqrt(a² + b² + 1e-12) - 1e-6): dL = L (a da + b db) / sqrt(a² + b² + 1e-12)."""
        longer = by_reach * self.reach(numbers) / _tilt(numbers)
        return {"stretch": longer * numbers.stretch, "shear": longer * numbers.shear}


def _tilt(numbers: Numbers):
    # 1e-12 keeps the root's slope finite.
    square = numbers.stretch**2 + numbers.shear**2 + 1e-12
    return jnp.sqrt(square) if isinstance(square, jax.Array) else np.sqrt(square)
