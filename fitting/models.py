"""What a phase is made of: the gap formula, or a traced bench.

A model turns a few free numbers, all of order one, into the phase and the shape of the contrast at an image's nodes.
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from numpy.polynomial.chebyshev import chebvander

from fitting.moments import ENVELOPE, node_grid
from newtonjax import chebyshev
from newtonjax.fields import fields_at, polar
from newtonjax.gap import required_gap
from newtonjax.scene import Scene

# The quantities of which the image measures one when the others are given: k = n s² / (R λ).
QUANTITIES = ("radius", "wavelength", "pixel_size", "index")

# A bench is traced on this many nodes to a side: its phase is far smoother than an image's products.
_TRACED = 13


class Frame(NamedTuple):
    """Pixel positions of the nodes [px], and the unit in which a model counts positions [px]."""

    x: np.ndarray
    y: np.ndarray
    middle: tuple[float, float]
    unit: float


def frame_of(shape: tuple[int, int]) -> Frame:
    """The nodes of an image of a shape; the unit is half its diagonal."""
    x, y = node_grid(ENVELOPE + 1)
    half_y, half_x = ((n - 1) / 2 for n in shape)
    return Frame(half_x * (1 + x), half_y * (1 + y), (half_x, half_y), float(np.hypot(half_x, half_y)))


def held_numbers(fixed: dict) -> tuple[int, ...]:
    """Which of a model's four free numbers do not move, for what the user fixed by name."""
    return ((1, 2) if "centre_px" in fixed else ()) + ((3,) if "gap" in fixed else ())


class GapModel(eqx.Module):
    """Fringes localized in the gap: phase 2 n t / λ of the exact sphere, seen along the normal.

    Free numbers: turns from curvature at half the image's diagonal (k unit²), centre offset from the middle
    [units] and phase [turns]. With c = s/R the sphere's curvature in 1/px, the phase is
    2 k r² / (1 + sqrt(1 - c² r²)) + phase; `sphere` holds factor and power of c = factor k^power
    (`quantity.Quantities.sphere`), factor 0 where it is not known: then k r².
    """

    frame: Frame
    sphere: tuple[Float[Array | np.ndarray, ""] | float, Float[Array | np.ndarray, ""] | float]

    def __call__(self, free: Float[Array, "4"]) -> Float[Array, "2 nodes"]:
        """Phase [turns] and relative contrast at the nodes."""
        turns, x, y, phase = free
        unit = self.frame.unit
        k = turns / unit**2
        dx = self.frame.x - self.frame.middle[0] - x * unit
        dy = self.frame.y - self.frame.middle[1] - y * unit
        r2 = dx * dx + dy * dy
        factor, power = self.sphere
        inside = 1 - (factor * jnp.abs(k) ** power) ** 2 * r2
        root = jnp.where(inside > 1e-6, jnp.sqrt(jnp.where(inside > 1e-6, inside, 1.0)), 1e-3)
        return jnp.stack([2 * k * r2 / (1 + root) + phase, jnp.ones_like(r2)])


class SceneModel(eqx.Module):
    """Fringes of a traced bench on its screen.

    `face` is the curved one. Free numbers: relative change of the unknown quantity, centre offset from the middle
    [units], and rise of what lies above the gap [half wavelengths].
    """

    frame: Frame
    scene: Scene
    pixel_size: Float[Array | np.ndarray, ""] | float
    face: int = eqx.field(static=True)
    unknown: str = eqx.field(static=True)

    def __call__(self, free: Float[Array, "4"]) -> Float[Array, "2 nodes"]:
        """Phase [turns] and relative contrast at the nodes, traced on fewer and interpolated."""
        ratio, x, y, rise = free
        scene = raise_lens(self.scene, rise * self.scene.wavelength / 2)
        pixel_size = self.pixel_size * (1 + ratio) if self.unknown == "pixel_size" else self.pixel_size
        if self.unknown != "pixel_size":
            scene = change(scene, self.unknown, 1 + ratio, self.face)
        at_x, at_y = node_grid(_TRACED)
        dx = self.frame.middle[0] * at_x - x * self.frame.unit
        dy = self.frame.middle[1] * at_y - y * self.frame.unit
        modulus, phase = polar(fields_at(scene, jnp.stack([dx, dy], axis=1) * pixel_size))
        table = chebyshev.coefficients(jnp.stack([phase[0], modulus[0] / jnp.mean(modulus[0])]))
        along = jnp.asarray(chebvander(chebyshev.nodes(ENVELOPE + 1), _TRACED - 1))
        return jnp.einsum("yj,fji,xi->fyx", along, table, along).reshape(2, -1)


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


@eqx.filter_jit
def localize(model: GapModel | SceneModel, free: Float[Array, " free"]) -> Local:
    """A model next to free numbers."""
    unit = jnp.eye(len(free))
    value, slope = jax.vmap(lambda e: jax.jvp(model, (free,), (e,)), out_axes=(None, -1))(unit)
    return Local(free, value, slope)


def as_arrays(tree):
    """Every number of a model as an array: Python numbers would be compiled in."""
    return jax.tree.map(lambda leaf: jnp.asarray(leaf, dtype=float), tree)


def curved_surface(scene: Scene) -> int:
    """Index of the one curved face of the gap. Raises ValueError where there is none, or more than one."""
    upper = required_gap(scene)
    curved = [k for k in (upper, upper + 1) if float(scene.surfaces[k].curvature) != 0]
    if len(curved) != 1:
        raise ValueError(f"{len(curved)} faces of the gap are curved; a fit of the radius takes one")
    return curved[0]


def quantities_of(scene: Scene, face: int) -> dict[str, float]:
    """The bench's own radius and wavelength [m], and the gap's index."""
    return {
        "radius": abs(1 / float(scene.surfaces[face].curvature)),
        "wavelength": float(scene.wavelength),
        "index": float(scene.media[required_gap(scene) + 1]),
    }


def change(scene: Scene, quantity: str, factor, face: int) -> Scene:
    """The scene with a quantity multiplied: a face's radius, the wavelength, or the gap's index."""
    if quantity == "wavelength":
        return eqx.tree_at(lambda s: s.light.wavelength, scene, scene.wavelength * factor)
    if quantity == "index":
        at = required_gap(scene) + 1
        media = jnp.asarray(scene.media)
        return eqx.tree_at(lambda s: s.media, scene, media.at[at].multiply(factor))
    return eqx.tree_at(lambda s: s.surfaces[face].curvature, scene, scene.surfaces[face].curvature / factor)


def raise_lens(scene: Scene, height) -> Scene:
    """The scene with everything above its gap raised [m]: screen, shield and collecting lens too if they are there."""
    up = jnp.array([0.0, 0.0, 1.0]) * height
    upper = required_gap(scene)

    def moved(s: Scene):
        parts = [s.surfaces[k].vertex for k in range(upper + 1)]
        if s.view == "transmitted":
            return parts
        return [*parts, s.screen.vertex, *(part.vertex for part in (s.shield, s.collecting_lens) if part is not None)]

    return eqx.tree_at(moved, scene, [vertex + up for vertex in moved(scene)])
