"""How an image is computed: at every pixel, on Chebyshev nodes, or by the closed form of the gap."""

import abc
from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Shaped

from newtonjax import chebyshev, packed
from newtonjax.aim import Arrival
from newtonjax.camera import Camera, corners
from newtonjax.fields import Fields, arrivals, fields_at, intensity, opd_at, path_difference
from newtonjax.gap import Gap, closed_fields, gap_between, gap_opd, why_not_closed
from newtonjax.precision import x64
from newtonjax.quantities import is_concrete
from newtonjax.scene import Scene
from newtonjax.single import closed_turns
from newtonjax.smooth import ErrorEstimate, error_from_nodes, smooth
from newtonjax.surfaces import sag, shallow_sag
from newtonjax.synthesis import synthesize, synthesize_single
from newtonjax.turns import cos_turns


class AbstractMethod(eqx.Module):
    """A way to compute images. Immutable and hashable: it may be a static argument."""

    @abc.abstractmethod
    def check(self, scene: Scene) -> None:
        """Raise ValueError, naming the part, where the method cannot honour a part of the scene."""

    @abc.abstractmethod
    def image(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns"]:
        """Irradiance at every pixel over the incident one."""

    @abc.abstractmethod
    def opd(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns"]:
        """Optical path difference of the scene's two beams at every pixel [m]."""


def _check_two_beams(scene: Scene) -> None:
    if len(scene.beams) != 2:
        raise ValueError(f"a path difference is between two beams; this scene has {len(scene.beams)}")


class Traced(AbstractMethod):
    """Rays aimed and traced at every pixel: the reference, and the way where fields are not smooth.

    A beam adds nothing to a pixel where none of its rays lands; where several do, at a caustic, one is followed, and
    `plan` says so. Works `chunk` pixels at a time, in constant memory.
    """

    chunk: int = eqx.field(static=True, default=16384)

    def __check_init__(self):
        if self.chunk < 1:
            raise ValueError(f"chunk is {self.chunk}; allowed: 1 pixel or more")

    def check(self, scene: Scene) -> None:
        """Every scene is honoured."""

    def image(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns"]:
        if is_concrete(scene, camera):
            return self._by_blocks(scene, camera, lambda bench, beams: intensity(packed.node_fields(bench, beams)))
        return at_every_pixel(lambda points: intensity(fields_at(scene, points)), camera, self.chunk)

    def opd(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns"]:
        _check_two_beams(scene)
        if is_concrete(scene, camera):
            return self._by_blocks(scene, camera, lambda bench, beams: path_difference(beams, bench.pairs)[0])
        return at_every_pixel(lambda points: opd_at(scene, points)[0], camera, self.chunk)

    def _by_blocks(self, scene: Scene, camera: Camera, function) -> Float[Array, "rows columns"]:
        with x64():
            return jnp.asarray(by_blocks(packed.pack(scene), camera, self.chunk, function))


def by_blocks(
    bench: packed.Packed, camera: Camera, chunk: int, function: Callable[[packed.Packed, Arrival], np.ndarray]
) -> Shaped[np.ndarray, "rows columns"]:
    """A function of a bench of known numbers and of its arriving beams, at every pixel, `chunk` pixels at a time."""
    (x, y), (rows, columns) = camera.axes(), camera.shape

    def block(first: int) -> np.ndarray:
        pixel = np.arange(first, min(first + chunk, rows * columns))
        points = np.stack([x[pixel % columns], y[pixel // columns]], axis=1)
        return function(bench, packed.arrivals(bench, points))

    return np.concatenate([block(first) for first in range(0, rows * columns, chunk)]).reshape(rows, columns)


def at_every_pixel(
    function: Callable[[Float[Array, "chunk 2"]], Shaped[Array, " chunk"]], camera: Camera, chunk: int
) -> Shaped[Array, "rows columns"]:
    """A function of screen points [m] at every pixel, `chunk` pixels at a time."""
    x, y = map(jnp.asarray, camera.axes())
    rows, columns = camera.shape
    count = min(chunk, rows * columns)
    chunks = -(-rows * columns // count)

    def block(start):
        pixel = jnp.minimum(start + jnp.arange(count), rows * columns - 1)
        return function(jnp.stack([x[pixel % columns], y[pixel // columns]], axis=1))

    flat = jax.lax.map(block, jnp.arange(chunks) * count)
    return flat.ravel()[: rows * columns].reshape(rows, columns)


class Chebyshev(AbstractMethod):
    """Rays traced at `nodes` x `nodes` Chebyshev points of the image, smooth fields in between.

    For fields without edges: every beam must reach every node.

    - `nodes`: 2 to 129 to a side.
    - `dtype`: "float64", or "float32" for the pixels, in half of the memory and, where the nodes resolve the fields, at
      most 2e-5 of the peak away up to 250 turns; rays and nodes are in float64 in either. None is JAX's setting.
      Derivatives are computed in float64.
    """

    nodes: int = eqx.field(static=True, default=17)
    dtype: str | None = eqx.field(static=True, default=None)

    def __check_init__(self):
        if not isinstance(self.nodes, int) or not 2 <= self.nodes <= 129:
            raise ValueError(f"nodes is {self.nodes!r}; allowed: a whole number from 2 to 129, to a side")
        if self.dtype is not None and not (isinstance(self.dtype, str) and self.dtype in ("float32", "float64")):
            raise ValueError(f"dtype is {self.dtype!r}; allowed: 'float32', 'float64', or None for JAX's setting")

    def check(self, scene: Scene) -> None:
        """Every part of a scene is honoured; `render` refuses where a beam does not reach the whole image."""

    def fields(self, scene: Scene, camera: Camera) -> Fields:
        """The fields at the nodes (row by row). They arrive only if the frame's corners do, which no node is at.

        In NumPy, by the program of all benches, where the numbers of scene and camera are known.
        """
        if is_concrete(scene, camera):
            bench = packed.pack(scene)
            return packed.node_fields(bench, packed.node_arrivals(bench, camera, self.nodes))
        fields = fields_at(scene, chebyshev.node_points(camera, self.nodes))
        if scene.shield is None:
            return fields
        return fields._replace(arrives=fields.arrives & arrivals(scene, corners(camera)).arrives.all())

    def coefficients(self, fields: Fields) -> Float[Any, "fields nodes nodes"]:
        """Chebyshev coefficients of background, moduli and phases [turns]; NumPy makes NumPy."""
        return smooth(fields).coefficients

    def image(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns"]:
        return self.image_and_reach(scene, camera)[0]

    def image_and_reach(self, scene: Scene, camera: Camera) -> tuple[Float[Array, "rows columns"], Bool[Array, ""]]:
        """The image, and whether every beam reaches every node: else it is not to be used."""
        fields = self.fields(scene, camera)
        made = synthesize_single if self.dtype == "float32" else synthesize
        return made(self.coefficients(fields), camera.shape), fields.arrives.all()

    def opd(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns"]:
        values, _ = self.paths(scene, camera)
        return chebyshev.expand(chebyshev.coefficients(values[None]), camera.shape)[0]

    def paths(self, scene: Scene, camera: Camera) -> tuple[Float[Any, " n"], Bool[Any, " n"]]:
        """Path differences of the two beams at the nodes [m], and where both arrive; NumPy for known numbers."""
        _check_two_beams(scene)
        if is_concrete(scene, camera):
            bench = packed.pack(scene)
            return path_difference(packed.arrivals(bench, chebyshev.node_points(camera, self.nodes)), bench.pairs)
        return opd_at(scene, chebyshev.node_points(camera, self.nodes))

    def error(self, scene: Scene, camera: Camera) -> ErrorEstimate:
        """Bounds of this method's error from the decay of the coefficients. Infinite where a beam misses a node."""
        return error_from_nodes(self.fields(scene, camera), self.nodes)


class ClosedForm(AbstractMethod):
    """Fringes of equal thickness by formula: path difference 2 n t(x, y) of the gap at normal incidence.

    For two beams that differ by one round trip in the gap, light along -z, and a screen focused on the gap; amplitudes
    are those on the axis (Born and Wolf, Principles of Optics, section 7.5). Within a transformation in float32 the
    phase is computed in numbers of twice the bits.
    """

    def check(self, scene: Scene) -> None:
        reason = why_not_closed(scene)
        if reason:
            raise ValueError(f"ClosedForm cannot honour {reason}; use Chebyshev() or Traced()")

    def image(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns"]:
        x, y = camera.axes()
        x, y = x[None, :], y[:, None]
        fields = closed_fields(scene, x[:, :1], y[:1])  # of a pixel: all have its amplitudes
        background, envelope = fields.background, fields.envelope[0].real
        if jnp.result_type(float) == jnp.float32:
            return background + envelope * cos_turns(closed_turns(scene, camera))
        return _equal_thickness(gap_between(scene), scene.wavelength, background, envelope, x, y)

    def opd(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns"]:
        x, y = camera.axes()
        return jnp.broadcast_to(gap_opd(scene, x[None, :], y[:, None]), camera.shape)


@jax.jit
def _equal_thickness(gap: Gap, wavelength, background, envelope, x, y) -> Float[Array, "rows columns"]:
    """Fringes of equal thickness: a program for every shape, not for every bench."""

    def image(profile):
        # One division, not one per pixel. The envelope is real: no sine, which would cost as much as the cosine.
        return background + envelope * cos_turns(gap.opd(x, y, profile) * (1 / wavelength))

    return jax.lax.cond(gap.is_shallow(x, y), lambda: image(shallow_sag), lambda: image(sag))
