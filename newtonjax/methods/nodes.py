"""Rays at Chebyshev nodes, and smooth fields between them."""

from typing import Any

import equinox as eqx
from jaxtyping import Array, Bool, Float

from newtonjax.fields import (
    ErrorEstimate,
    Fields,
    arrivals_at,
    error_from_nodes,
    fields_at,
    opd_at,
    packed,
    path_difference,
    smooth,
    synthesize,
    synthesize_single,
)
from newtonjax.methods.base import AbstractMethod, require_two_beams
from newtonjax.numerics import chebyshev, is_concrete
from newtonjax.scene import Camera, Scene, corners, node_points


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
        fields = fields_at(scene, node_points(camera, self.nodes))
        if scene.shield is None:
            return fields
        return fields._replace(arrives=fields.arrives & arrivals_at(scene, corners(camera)).arrives.all())

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
        require_two_beams(scene)
        if is_concrete(scene, camera):
            bench = packed.pack(scene)
            return path_difference(packed.arrivals(bench, node_points(camera, self.nodes)), bench.pairs)
        return opd_at(scene, node_points(camera, self.nodes))

    def error(self, scene: Scene, camera: Camera) -> ErrorEstimate:
        """Bounds of this method's error from the decay of the coefficients. Infinite where a beam misses a node."""
        return error_from_nodes(self.fields(scene, camera), self.nodes)
