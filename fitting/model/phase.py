"""What a phase is made of: the gap formula, or a traced bench.

A model turns a few free numbers, all of order one, into the phase and the shape of the contrast at an image's nodes.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import ClassVar, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from numpy.polynomial.chebyshev import chebvander

from fitting.model.basis import ENVELOPE
from fitting.model.forming import form_turns
from fitting.model.microscope import Microscope, microscope_on, plate_curvature, sphere_of
from fitting.model.part import Shown
from fitting.model.parts import FLATTENING, PARTS, SHOWING, WARPS, numbers_of
from fitting.model.warp import Frame, on_object, reach
from fitting.parameters import EXPONENTS, Numbers, Quantities, change, quantities_of, raise_lens
from newtonjax.fields import fields_at, packed, polar
from newtonjax.numerics import chebyshev
from newtonjax.scene import Scene, gap_height

# A bench is traced on this many nodes to a side: its phase is far smoother than an image's products.
_TRACED = 13


class Answer(NamedTuple):
    """What a model's numbers say: quantities by name, and how the measured one changes with the first number.

    - `gap` [m], None where it is not known; `period`: of the gap, per turn [m].
    """

    values: dict[str, float]
    slope: float
    gap: float | None
    period: float


def shown_of(names: tuple[str, ...], numbers: Numbers, length, is_scaled: bool) -> dict[str, Shown]:
    """By number, what a result shows of parts; `length`: half a diagonal [m], or [px] without a scale."""
    shown = {name: Shown(name, getattr(numbers, name), 1.0) for name in numbers_of(names)}
    for part in (part for part in SHOWING if part.name in names):
        shown |= part.shown(numbers, length, is_scaled)
    return shown


class GapModel(eqx.Module):
    """Fringes localized in the gap: phase 2 n t / λ of the exact sphere, seen along the normal by a microscope.

    Free numbers: turns from curvature at half the image's diagonal (k unit²), centre offset from the middle
    [units], phase [turns], and those of the parts. With c = s/R the sphere's curvature in 1/px, the phase is
    2 k r² / (1 + sqrt(1 - c² r²)) + phase, where parts may change the share k r²; `sphere` holds factor and
    power of c = factor k^power (`parameters.Quantities.sphere`), factor 0 where it is not known: then k r². Of a lens
    on a curved plate c is the sum of both curvatures, and `plate` the plate's [1/px]. `microscope` adds what looking at
    the gap does to the path difference, a share of some c² r².
    """

    words: ClassVar[str] = "2 n t at normal incidence, {sphere}"
    parts: ClassVar[tuple[str, ...]] = tuple(PARTS)
    # Whether a held gap is so many turns, as what is given says.
    holds_turns: ClassVar[bool] = True

    frame: Frame
    sphere: tuple[Float[Array | np.ndarray, ""] | float, Float[Array | np.ndarray, ""] | float]
    plate: Float[Array | np.ndarray, ""] | float = 0.0
    microscope: Microscope = Microscope()

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
        microscope, w, flattened = self.microscope, both**2 * reaching, k * (share - r2)
        sphere, gap = microscope.sphere + (k / microscope.scale - 1) * microscope.change, microscope.gap
        per_order, per_turn = (w * sum(at * w**power for power, at in enumerate(table)) for table in (sphere, gap))
        turns = numbers.phase - microscope.touching
        # As in `gap_phase`.
        apex = turns - microscope.modulo * jnp.floor(turns + 0.25)
        smooth = k * r2 * (spheres + per_order) + flattened + numbers.phase + (flattened + apex) * per_turn
        return smooth + form_turns(self.frame, x, y, numbers)

    def answer(self, quantities: Quantities, numbers: Numbers, contact_phase: float) -> Answer:
        """What its numbers say, for what is given."""
        unit2 = self.frame.unit**2
        scale = float(numbers.curvature) / unit2
        if quantities.unknown is None:
            return Answer({"fringe_scale_per_px2": scale}, 1 / unit2, None, 1.0)
        values = quantities.values(scale)
        slope = values[quantities.unknown] / EXPONENTS[quantities.unknown] / numbers.curvature
        period = values["wavelength"] / (2 * values["gap_index"])
        turns = numbers.phase - contact_phase
        gap = float(turns - np.round(turns)) * period
        return Answer(values | {"fringe_scale_per_px2": scale}, slope, gap, period)

    def measured(self, quantities: Quantities, curvature, changed: Mapping):
        """The quantity that is measured, or the fringe scale, for its first number and changed given quantities."""
        scale = curvature / self.frame.unit**2
        return scale if quantities.unknown is None else quantities.measured_at(scale, changed)

    def first_number(self, quantities: Quantities, measured, changed: Mapping):
        """The inverse of `measured`."""
        return (measured if quantities.unknown is None else quantities.scale(measured, changed)) * self.frame.unit**2

    def changed(self, quantities: Quantities, numbers: Numbers, name: str, factor: float) -> "GapModel":  # noqa: ARG002
        """The model for other given quantities, one of which was multiplied."""
        scale = float(numbers.curvature) / self.frame.unit**2
        microscope = microscope_on(quantities, numbers, self.frame, self.microscope)
        return replace(
            self, sphere=sphere_of(quantities, scale), plate=plate_curvature(quantities), microscope=microscope
        )

    def traced(self, unknown: str | None, factors: Mapping) -> "GapModel":
        """The model with given quantities multiplied, inside a transformation."""
        if unknown not in ("radius", "pixel_size"):
            # Then the sphere is given: s/R, or with the index free as well.
            factor = self.sphere[0] * factors.get("pixel_size", 1.0) / factors.get("radius", 1.0)
        elif unknown == "radius":
            longer = factors.get("wavelength", 1.0) / factors.get("gap_index", 1.0)
            pixel = factors.get("pixel_size", 1.0)
            # The radius of the microscope's trace goes with another k then.
            at = self.microscope.scale * pixel**2 / longer
            return eqx.tree_at(lambda m: (m.sphere[0], m.microscope.scale), self, (self.sphere[0] * longer / pixel, at))
        else:
            factor = factors.get("wavelength", 1.0) / (factors.get("gap_index", 1.0) * factors.get("radius", 1.0))
            factor = self.sphere[0] * jnp.sqrt(factor)
        return eqx.tree_at(lambda m: m.sphere[0], self, factor)

    def effect(self, quantities: Quantities, curvature: float, change: float, name: str) -> float:
        """Relative change of the measured quantity per that of a given one, by which the first number changes so."""
        return (change / curvature - EXPONENTS[name]) / EXPONENTS[quantities.measured]


class SceneModel(eqx.Module):
    """Fringes of a traced bench on its screen.

    `face` is the curved one. Free numbers: relative change of the unknown quantity, centre offset from the middle
    [units], rise of what lies above the gap [half wavelengths], and those of the parts that move points.
    """

    words: ClassVar[str] = "traced bench"
    parts: ClassVar[tuple[str, ...]] = tuple(name for name in WARPS if not PARTS[name].polynomials)
    holds_turns: ClassVar[bool] = False

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
            for at, (low, high) in zip(
                chebyshev.node_grid(_TRACED), (_ends(self.frame.x), _ends(self.frame.y)), strict=True
            )
        )
        dx, dy = on_object(self.frame, at_x, at_y, numbers)
        modulus, phase = polar(fields_at(scene, jnp.stack([dx, dy], axis=1) * pixel_size))
        table = chebyshev.coefficients(jnp.stack([phase[0], modulus[0] / jnp.mean(modulus[0])]))
        along = jnp.asarray(chebvander(chebyshev.nodes(ENVELOPE + 1), _TRACED - 1))
        phase, contrast = jnp.einsum("yj,fji,xi->fyx", along, table, along).reshape(2, -1)
        return jnp.stack([phase, contrast if self.frame.contrast is None else contrast * self.frame.contrast])

    def answer(self, quantities: Quantities, numbers: Numbers, contact_phase: float) -> Answer:  # noqa: ARG002
        """What its numbers say: the gap is the scene's with the fitted rise, known modulo half a wavelength in it."""
        values = self._own()
        slope, period = values[quantities.measured], values["wavelength"] / 2
        values[quantities.measured] *= 1 + float(numbers.curvature)
        scale = values["gap_index"] * values["pixel_size"] ** 2 / (values["radius"] * values["wavelength"])
        gap = gap_height(self.scene) + float(numbers.phase) * period
        return Answer(values | {"fringe_scale_per_px2": scale}, slope, gap, period)

    def measured(self, quantities: Quantities, curvature, changed: Mapping):  # noqa: ARG002
        """The quantity that is measured, for its first number."""
        return self._own()[quantities.measured] * (1 + curvature)

    def first_number(self, quantities: Quantities, measured, changed: Mapping):  # noqa: ARG002  # others need all
        """The inverse of `measured`."""
        return measured / self._own()[quantities.measured] - 1

    def _own(self) -> dict[str, float]:
        return {**quantities_of(self.scene, self.face), "pixel_size": float(self.pixel_size)}

    def changed(self, quantities: Quantities, numbers: Numbers, name: str, factor: float) -> "SceneModel":  # noqa: ARG002
        """The model for other given quantities, one of which was multiplied."""
        if name == "pixel_size":
            return replace(self, pixel_size=self.pixel_size * factor)
        return replace(self, scene=change(self.scene, name, factor, self.face))

    def traced(self, unknown: str | None, factors: Mapping) -> "SceneModel":  # noqa: ARG002
        """The model with given quantities multiplied, inside a transformation."""
        scene, pixel_size = self.scene, self.pixel_size * factors.get("pixel_size", 1.0)
        for name in factors.keys() - {"pixel_size"}:
            scene = change(scene, name, factors[name], self.face)
        return eqx.tree_at(lambda m: (m.scene, m.pixel_size), self, (scene, pixel_size))

    def effect(self, quantities: Quantities, curvature: float, change: float, name: str) -> float:  # noqa: ARG002
        """Relative change of the measured quantity per that of a given one, by which the first number changes so."""
        return change / (1 + curvature)


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
