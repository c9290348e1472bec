"""What a phase is made of: the gap formula, or a traced bench.

A model turns a few free numbers, all of order one, into the phase and the shape of the contrast at an image's nodes.
"""

from collections.abc import Iterable
from functools import partial
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from numpy.polynomial.chebyshev import chebvander

from fitting.model.basis import ENVELOPE, node_grid
from fitting.parameters import NUMBERS, Numbers, change, raise_lens
from newtonjax.fields import fields_at, packed, polar
from newtonjax.numerics import chebyshev
from newtonjax.scene import Scene, hertz_gap

# Numbers of the parts of a model; without its part a number is 0.
PARTS = {
    "oblique_view": ("stretch", "shear"),
    "distortion": ("distortion",),
    "fifth_order": ("distortion_fifth_order",),
    "contact": ("contact",),
    "film": (),
}

# A bench is traced on this many nodes to a side: its phase is far smoother than an image's products.
_TRACED = 13


class Frame(NamedTuple):
    """Pixel positions of the nodes [px], and the unit in which a model counts positions [px].

    The image may be means over blocks of `block` pixels a side: `contrast` [nodes] is what these leave of the fringes'
    (`block_contrast`, None for all of it), and they add a phase of (block² - 1) / 24 times its second derivatives, for
    r² fringes k (block² - 1) / 6.
    """

    x: np.ndarray
    y: np.ndarray
    middle: tuple[float, float]
    unit: float
    block: float = 1.0
    contrast: np.ndarray | None = None


def numbers_of(parts: Iterable[str]) -> tuple[str, ...]:
    """Names of the numbers that belong to parts."""
    return tuple(name for part in parts for name in PARTS[part])


def free_numbers(fixed: dict, parts: tuple[str, ...] = ()) -> tuple[str, ...]:
    """Names of the numbers that move, for what the user fixed by name, and the parts that are there.

    A contact pins the phase, unless a film keeps the pressed faces apart.
    """
    pinned = "gap" in fixed or ("contact" in parts and "film" not in parts)
    held = {*numbers_of(part for part in PARTS if part not in parts), *(("phase",) if pinned else ())}
    if "centre_px" in fixed:
        held |= {"centre_x", "centre_y"}
    return tuple(name for name in NUMBERS if name not in held)


def on_object(frame: Frame, x, y, free: Float[Array, " free"]):
    """Where pixels [px] lie on the object, from the rings' centre [px]: (x, y).

    - distortion κ, κ5: the object's point is u (1 + κ |u|² + κ5 |u|⁴) of the pixel's u, in units of half the diagonal
      from the middle (Brown 1966); the pixel size is that of the middle.
    - stretch a, shear b: the point's offset from the centre is exp([[a, b], [b, -a]] / 2) times what is seen. A view at
      an angle θ makes one axis 1/cos θ longer on the object than in the image, and the path difference 2 t cos θ: of
      both together this matrix of determinant 1 is left, with sqrt(a² + b²) = -ln cos θ; so the curvature keeps
      its meaning. Pixels of unequal sides do the same when the pixel size is the geometric mean of both.
    """
    numbers = Numbers(*free)
    x0, y0, a, b = numbers.centre_x, numbers.centre_y, numbers.stretch, numbers.shear
    kappa, fifth = numbers.distortion, numbers.distortion_fifth_order
    ux, uy = (x - frame.middle[0]) / frame.unit, (y - frame.middle[1]) / frame.unit

    def out(u2):
        return 1 + u2 * (kappa + fifth * u2)

    # The centre is a pixel too; beyond the frame nothing is known of the lens.
    by_pixel, by_centre = out(ux * ux + uy * uy), out(jnp.minimum(x0 * x0 + y0 * y0, 1.0))
    dx, dy = (ux * by_pixel - x0 * by_centre) * frame.unit, (uy * by_pixel - y0 * by_centre) * frame.unit
    # cosh and sinh(m)/m of m² = (a² + b²) / 4, as series: they have no root at 0, and 1e-9 is left at m = 0.4.
    m2 = (a * a + b * b) / 4
    even, odd = 1 + m2 / 2 * (1 + m2 / 12 * (1 + m2 / 30)), (1 + m2 / 6 * (1 + m2 / 20 * (1 + m2 / 42))) / 2
    return even * dx + odd * (a * dx + b * dy), even * dy + odd * (b * dx - a * dy)


class GapModel(eqx.Module):
    """Fringes localized in the gap: phase 2 n t / λ of the exact sphere, seen along the normal.

    Free numbers: turns from curvature at half the image's diagonal (k unit²), centre offset from the middle
    [units], phase [turns], those of `on_object`, and the contact's squared radius [units²]. With c = s/R the sphere's
    curvature in 1/px, the phase is 2 k r² / (1 + sqrt(1 - c² r²)) + phase, where a contact replaces the share k r² by
    k times Hertz's; `sphere` holds factor and power of c = factor k^power (`quantity.Quantities.sphere`), factor 0
    where it is not known: then k r². Of a lens on a curved plate c is the sum of both curvatures, and `plate` the
    plate's [1/px].
    """

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
        numbers = Numbers(*free)
        k = numbers.curvature / self.frame.unit**2
        dx, dy = on_object(self.frame, x, y, free)
        r2 = dx * dx + dy * dy
        factor, power = self.sphere
        # At an angle the object reaches 1/cos θ further than that matrix says; 1e-12 keeps the root's slope finite.
        longer = jnp.exp(jnp.sqrt(numbers.stretch**2 + numbers.shear**2 + 1e-12) - 1e-6)
        both = factor * jnp.abs(k) ** power
        share = self.plate / jnp.where(both == 0, 1.0, both)

        def steepened(curvature):
            inside = 1 - curvature**2 * r2 * longer
            return 2 / (1 + jnp.where(inside > 1e-6, jnp.sqrt(jnp.where(inside > 1e-6, inside, 1.0)), 1e-3))

        spheres = (1 - share) * steepened(both - self.plate) + share * steepened(self.plate)
        flattened = hertz_gap(r2, numbers.contact * self.frame.unit**2) - r2
        return k * (r2 * spheres + flattened) + numbers.phase


class SceneModel(eqx.Module):
    """Fringes of a traced bench on its screen.

    `face` is the curved one. Free numbers: relative change of the unknown quantity, centre offset from the middle
    [units], rise of what lies above the gap [half wavelengths], and those of `on_object`; there is no contact.
    """

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
        dx, dy = on_object(self.frame, at_x, at_y, free)
        modulus, phase = polar(fields_at(scene, jnp.stack([dx, dy], axis=1) * pixel_size))
        table = chebyshev.coefficients(jnp.stack([phase[0], modulus[0] / jnp.mean(modulus[0])]))
        along = jnp.asarray(chebvander(chebyshev.nodes(ENVELOPE + 1), _TRACED - 1))
        phase, contrast = jnp.einsum("yj,fji,xi->fyx", along, table, along).reshape(2, -1)
        return jnp.stack([phase, contrast if self.frame.contrast is None else contrast * self.frame.contrast])


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
