"""What a phase is made of: the gap formula, or a traced bench.

A model turns a few free numbers, all of order one, into the phase and the shape of the contrast at an image's nodes.
"""

from functools import partial
from typing import ClassVar, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from numpy.polynomial.chebyshev import chebvander

from fitting.model.basis import ENVELOPE, node_grid
from fitting.model.parts import FLATTENING, PARTS, WARPS
from fitting.model.warp import Frame, on_object, reach
from fitting.parameters import Numbers, change, raise_lens
from newtonjax.fields import fields_at, packed, polar
from newtonjax.numerics import chebyshev
from newtonjax.scene import Scene

# A bench is traced on this many nodes to a side: its phase is far smoother than an image's products.
_TRACED = 13


class GapModel(eqx.Module):
    """Fringes localized in the gap: phase 2 n t / λ of the exact sphere, seen along the normal.

    Free numbers: turns from curvature at half the image's diagonal (k unit²), centre offset from the middle
    [units], phase [turns], and those of the parts. With c = s/R the sphere's curvature in 1/px, the phase is
    2 k r² / (1 + sqrt(1 - c² r²)) + phase, where parts may change the share k r²; `sphere` holds factor and
    power of c = factor k^power (`parameters.Quantities.sphere`), factor 0 where it is not known: then k r². Of a lens
    on a curved plate c is the sum of both curvatures, and `plate` the plate's [1/px].
    """

    parts: ClassVar[tuple[str, ...]] = tuple(PARTS)

    frame: Frame
    sphere: tuple[Float[Array | np.ndarray, ""] | float, Float[Array | np.ndarray, ""] | float]
    plate: Float[Array | np.ndarray, ""] | float = 0.0

    def __call__(self, free: Float[Array, " free"]) -> Float[Array, "2 nodes"]:
        """Phase [turns] and relative contrast at the nodes."""
        phase = self.phase(self.frame.x, self.frame.y, free)
        phase = phase + Numbers(*free).curvature * (self.frame.block**2 - 1) / (6 * self.frame.unit**2)
        return jnp.stack([phase, jnp.ones_like(phase) if self.frame.contrast is None else self.frame.contrast])

    def phase(self, x, y, free: Float[Array, " free"]):
        """Phase [turns] at pixel positions [px]."""
        numbers, unit2 = Numbers(*free), self.frame.unit**2
        k = numbers.curvature / unit2
        dx, dy = on_object(self.frame, x, y, numbers)
        r2 = dx * dx + dy * dy
        factor, power = self.sphere
        both = factor * jnp.abs(k) ** power
        share = self.plate / jnp.where(both == 0, 1.0, both)
        reaching = r2 * reach(numbers)

        def steepened(curvature):
            inside = 1 - curvature**2 * reaching
            return 2 / (1 + jnp.where(inside > 1e-6, jnp.sqrt(jnp.where(inside > 1e-6, inside, 1.0)), 1e-3))

        spheres = (1 - share) * steepened(both - self.plate) + share * steepened(self.plate)
        share = r2
        for part in FLATTENING:
            share = part.flatten(share, unit2, numbers)
        return k * (r2 * spheres + (share - r2)) + numbers.phase

    def steepness(self, numbers: Numbers, rim: float) -> float:
        """(r/R)² of the sphere where the squared distance from the image's middle is `rim` [half diagonals²]."""
        (factor, power), unit = self.sphere, self.frame.unit
        return float(factor * abs(numbers.curvature / unit**2) ** power) ** 2 * rim * unit**2


class SceneModel(eqx.Module):
    """Fringes of a traced bench on its screen.

    `face` is the curved one. Free numbers: relative change of the unknown quantity, centre offset from the middle
    [units], rise of what lies above the gap [half wavelengths], and those of the parts that move points.
    """

    parts: ClassVar[tuple[str, ...]] = WARPS

    frame: Frame
    scene: Scene
    pixel_size: Float[Array | np.ndarray, ""] | float
    face: int = eqx.field(static=True)
    unknown: str = eqx.field(static=True)

    def __call__(self, free: Float[Array, " free"]) -> Float[Array, "2 nodes"]:
        """Phase [turns] and relative contrast at the nodes, traced on fewer and interpolated."""
        numbers = Numbers(*free)
        ratio, rise = numbers.curvature, numbers.phase
        scene = raise_lens(self.scene, rise * self.scene.wavelength / 2)
        pixel_size = self.pixel_size * (1 + ratio) if self.unknown == "pixel_size" else self.pixel_size
        if self.unknown != "pixel_size":
            scene = change(scene, self.unknown, 1 + ratio, self.face)
        at_x, at_y = (
            (low + high) / 2 + at * (high - low) / 2
            for at, (low, high) in zip(node_grid(_TRACED), (_ends(self.frame.x), _ends(self.frame.y)), strict=True)
        )
        dx, dy = on_object(self.frame, at_x, at_y, numbers)
        modulus, phase = polar(fields_at(scene, jnp.stack([dx, dy], axis=1) * pixel_size))
        table = chebyshev.coefficients(jnp.stack([phase[0], modulus[0] / jnp.mean(modulus[0])]))
        along = jnp.asarray(chebvander(chebyshev.nodes(ENVELOPE + 1), _TRACED - 1))
        phase, contrast = jnp.einsum("yj,fji,xi->fyx", along, table, along).reshape(2, -1)
        return jnp.stack([phase, contrast if self.frame.contrast is None else contrast * self.frame.contrast])

    def steepness(self, numbers: Numbers, rim: float) -> float:  # noqa: ARG002
        """What the gap formula leaves out of a steep sphere's view, a traced bench has."""
        return 0.0


def _ends(nodes):
    """The ends of the interval that Chebyshev nodes stand for."""
    half = (nodes[-1] - nodes[0]) / 2 / np.cos(np.pi / (2 * (ENVELOPE + 1)))
    middle = (nodes[-1] + nodes[0]) / 2
    return middle - half, middle + half


class Local(NamedTuple):
    """A model next to given free numbers: its phase and contrast at the nodes, and their derivatives.

    Every model looks alike from here on, so that the least squares are compiled once for all of them.
    """

    free: Float[Array, " free"]
    value: Float[Array, "2 nodes"]
    slope: Float[Array, "2 nodes free"]

    def __call__(self, free: Float[Array, " free"]) -> Float[Array, "2 nodes"]:
        """Phase [turns] and contrast to first order."""
        return self.value + self.slope @ (free - self.free)


# A bench's rays compile in two thirds of the time so.
@partial(jax.jit, compiler_options=packed.OPTIONS)
def localize(model: GapModel | SceneModel, free: Float[Array, " free"]) -> Local:
    """A model next to free numbers."""
    unit = jnp.eye(len(free))
    value, slope = jax.vmap(lambda e: jax.jvp(model, (free,), (e,)), out_axes=(None, -1))(unit)
    return Local(free, value, slope)


def as_arrays(tree):
    """Every number of a model as an array: Python numbers would be compiled in."""
    return jax.tree.map(lambda leaf: jnp.asarray(leaf, dtype=float), tree)
