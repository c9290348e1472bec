"""Rays at Chebyshev nodes, and smooth fields between them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from jaxtyping import Array, Bool, Float

from newtonjax.fields import (
    ErrorEstimate,
    Fields,
    arrivals_at,
    beats,
    error_from_nodes,
    fields_at,
    opd_at,
    packed,
    pairs,
    path_difference,
    smooth,
    synthesize,
    synthesize_single,
)
from newtonjax.methods.base import (
    CALL,
    INTERACTION,
    AbstractMethod,
    CannotHonourError,
    interactions,
    is_single,
    pass_share,
    require_two_beams,
    unreached,
)
from newtonjax.methods.closed_form import ClosedForm
from newtonjax.methods.gap_paths import channels_over_source, of_points, parallel
from newtonjax.methods.many_wavelengths import (
    InChannels,
    by_channels,
    channel_by_channel,
    has_channels,
    on_nodes,
    one_line,
    spectral,
    table_of,
    turn_range,
)
from newtonjax.methods.node_waves import (
    NodeLight,
    Waves,
    at_nodes,
    of_few_lines,
    of_one_direction,
    wave_count,
    wave_parts,
    waves_for,
)
from newtonjax.methods.pictures import OnNodes, SideBySide
from newtonjax.methods.source_directions import error_between_directions, light_at_nodes
from newtonjax.numerics import chebyshev, is_concrete, shown
from newtonjax.scene import Camera, Channels, Scene, channels_of, corners, has_lateral_colour, node_points, source_of

# Passes of a cosine: what a pixel costs for each degree of a field, and what else it costs.
_DEGREE, _PIXEL = 0.059, 0.27


@dataclass(frozen=True, repr=False)
class Chebyshev(AbstractMethod):
    """Rays traced at `nodes` x `nodes` Chebyshev points of the image, smooth fields in between.

    For fields without edges: every beam must reach every node.

    - `nodes`: 2 to 129 to a side.
    - `dtype`: "float64", or "float32" for the pixels, in half of the memory and, where the nodes resolve the fields, at
      most 2e-5 of the peak away up to 250 turns; rays and nodes are in float64 in either. None is JAX's setting.
      Derivatives are computed in float64. Light of many wavelengths, and colours, are computed in float64.
    - `table_error`: as of `ClosedForm`; by as much may what pixels leave of the fringes be off their table.
    """

    float32_error: ClassVar[float] = 1e-5
    sees_through_lens: ClassVar[bool] = True

    nodes: int = 17
    dtype: str | None = None
    table_error: float = 1e-5

    def __post_init__(self):
        if not isinstance(self.nodes, int) or not 2 <= self.nodes <= 129:
            raise ValueError(f"nodes is {shown(self.nodes)}; allowed: a whole number from 2 to 129, to a side")
        if self.dtype is not None and not (isinstance(self.dtype, str) and self.dtype in ("float32", "float64")):
            raise ValueError(f"dtype is {shown(self.dtype)}; allowed: 'float32', 'float64', or None for JAX's setting")

    def check(self, scene: Scene) -> None:
        """Refuses a source that is no point, but for fringes of a gap that the screen is focused on.

        `render` refuses where a beam does not reach the whole image.
        """
        if scene.light.extent is not None and ClosedForm().refusal(scene) is not None:
            demand = "it takes one whose screen is focused on the gap, in light along -z"
            raise CannotHonourError("Chebyshev", "light.extent on such a bench", demand, "OverSource()")

    @property
    def generality(self) -> tuple[int, int]:
        return 1, self.nodes

    def for_scenes(self, planned: Sequence[AbstractMethod]) -> "Chebyshev":
        """How many nodes a scene takes that another method would do for is not known: not fewer than the default.

        In float64 where one of the plans asks for it.
        """
        by_nodes = [method for method in planned if isinstance(method, Chebyshev)]
        nodes = self.nodes if len(by_nodes) == len(planned) else max(self.nodes, Chebyshev().nodes)
        # Pixels in float64 were planned where those in float32 would err too much.
        dtype = "float64" if any(method.dtype == "float64" for method in by_nodes) else self.dtype
        return Chebyshev(nodes, dtype, min(method.table_error for method in (self, *by_nodes)))

    def passes(self, scene: Scene, camera: Camera) -> float:
        pairs = len(scene.beams) * (len(scene.beams) - 1) // 2
        pixel = _PIXEL + pairs - 1 + _DEGREE * (1 + 2 * pairs) * self.nodes
        return CALL + pass_share(camera) * pixel + INTERACTION * interactions(scene) * self.nodes**2

    def shared_bytes(self, shape: tuple[int, int]) -> int:
        """Of the basis functions of all rows and columns."""
        return 16 * self.nodes * sum(shape)

    def describe(self) -> str:
        return f"Chebyshev, {self.nodes} x {self.nodes} nodes"

    def fields(self, scene: Scene, camera: Camera) -> Fields:
        """The fields at the nodes (row by row). They arrive only if the frame's corners do, which no node is at.

        In NumPy, by the program of all benches, where the numbers of scene and camera are known.
        """
        if is_concrete(scene, camera):
            return self._known_fields(scene, camera)
        fields = fields_at(scene, node_points(camera, self.nodes))
        if scene.shield is None:
            return fields
        return fields._replace(arrives=fields.arrives & arrivals_at(scene, corners(camera)).arrives.all())

    def _known_fields(self, scene: Scene, camera: Camera) -> Fields:
        bench = packed.pack(scene)
        return packed.node_fields(bench, packed.node_arrivals(bench, camera, self.nodes))

    def coefficients(self, fields: Fields) -> Float[Any, "fields nodes nodes"]:
        """Chebyshev coefficients of background, moduli and phases [turns]; NumPy makes NumPy."""
        return smooth(fields).coefficients

    def image(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns *channels"]:
        if has_lateral_colour(camera):
            return by_channels(self.image, scene, camera)
        if has_channels(scene.light, camera):
            beams = arrivals_at(parallel(scene), node_points(camera, self.nodes))
            couples = np.array(pairs(scene)).reshape(-1, 2)
            light = of_one_direction(beats(beams, couples, source_of(scene.light)))
            lines = channels_over_source(scene, camera).lines
            waves = Waves(wave_count(lines, camera.takes_means))
            ratios, _ = wave_parts(lines, waves.number)
            coefficients = chebyshev.coefficients(at_nodes(light, camera, ratios, waves))
            return on_nodes(coefficients, scene, camera)
        of_fields = synthesize_single if self.dtype == "float32" else synthesize
        return of_fields(self.coefficients(self.fields(scene, camera)), camera.shape)

    def picture(self, scene: Scene, camera: Camera) -> OnNodes | InChannels | SideBySide:
        if has_lateral_colour(camera):
            scenes, cameras, levels = zip(*channel_by_channel(scene, camera), strict=True)
            return SideBySide(tuple(map(self.picture, scenes, cameras)), tuple(map(float, levels)))
        if has_channels(scene.light, camera):
            return self.cuts(self.light(scene, camera), scene, camera)[1](self.nodes)
        fields = self._known_fields(scene, camera)
        if not fields.arrives.all():
            raise unreached(self)
        return self.picture_of(self.coefficients(fields), camera)

    def cuts(
        self, light: NodeLight, scene: Scene, camera: Camera
    ) -> tuple[Float[np.ndarray, "fields nodes nodes"], Callable[[int], OnNodes | InChannels]]:
        """Coefficients of a light at nodes, by whose decay cuts are judged, and its picture as cut to so many.

        Of few lines pixels come from smooth fields, else from tables.
        """
        extent, smooth_fields = scene.light.extent, None
        if camera.response is None and (extent is None or extent.radiances is None):
            lines = channels_of(scene.light, None).lines
            smooth_fields = of_few_lines(light, camera, lines, self.table_error)
        if smooth_fields is None:
            fields, waves = self._coefficients_and_waves(light, scene, camera)
            return fields, lambda count: self._in_channels(scene, camera, fields[:, :count, :count], waves)
        picture = OnNodes(smooth_fields, camera.shape, "float64", "float32" if is_single() else "float64")
        fields = chebyshev.coefficients(at_nodes(light, of_points(camera), np.ones(1), Waves(1)))
        return fields, lambda _: picture

    def light(self, scene: Scene, camera: Camera) -> NodeLight:
        """The light of a known scene at the nodes, of all directions of its source.

        Raises ValueError where a beam does not reach the whole image.
        """
        light = light_at_nodes(scene, camera, self.nodes)
        if not light.arrives.all():
            raise unreached(self)
        return light

    def _coefficients_and_waves(
        self, light: NodeLight, scene: Scene, camera: Camera
    ) -> tuple[Float[np.ndarray, "fields nodes nodes"], Waves]:
        """Of a light in many wavelengths: background, parts of the envelopes, turns; and what a table has beside."""
        lines = _channels(scene, camera, self.table_error).lines
        # Of the amplitude, and so half as much of the peak: with the table's own they stay within `table_error` of it.
        waves = waves_for(light, camera, lines, 0.5 * self.table_error)
        ratios, _ = wave_parts(lines, waves.number)
        return chebyshev.coefficients(at_nodes(light, camera, ratios, waves)), waves

    def _in_channels(self, scene: Scene, camera: Camera, coefficients: Float[Any, "fields nodes nodes"], waves: Waves):
        """The picture of such fields."""
        channels = _channels(scene, camera, self.table_error)
        low, high = turn_range(coefficients)
        _, parts = wave_parts(channels.lines, waves.number)
        table = table_of(channels, low, high, self.table_error)
        many = (len(coefficients) - 1) // 3
        only_real = not (table.over_carrier or coefficients[1 + many : 1 + 2 * many].any())
        tables = spectral(channels, low, high, table, only_real=only_real, parts=parts, means=waves.means)
        result = "float32" if is_single() else "float64"
        has_response = camera.response is not None
        return InChannels(coefficients, camera.shape, tables, table.over_carrier, has_response, result)

    def picture_of(self, coefficients: Float[Any, "fields nodes nodes"], camera: Camera) -> OnNodes:
        """The picture of fields whose coefficients are known already."""
        # An array of a type that the user's setting does not have would warn at every further step.
        setting = "float32" if is_single() else "float64"
        dtype = self.dtype or setting
        return OnNodes(coefficients, camera.shape, dtype, setting if is_single() else dtype)

    def opd(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns"]:
        values, _ = self.paths(scene, camera)
        return chebyshev.expand(chebyshev.coefficients(values[None]), camera.shape)[0]

    def opd_picture(self, scene: Scene, camera: Camera) -> OnNodes:
        values, arrives = self.paths(scene, camera)
        if not arrives.all():
            raise unreached(self)
        result = "float32" if is_single() else "float64"
        return OnNodes(chebyshev.coefficients(values[None]), camera.shape, "float64", result)

    def paths(self, scene: Scene, camera: Camera) -> tuple[Float[Any, " n"], Bool[Any, " n"]]:
        """Path differences of the two beams at the nodes [m], and where both arrive; NumPy for known numbers."""
        require_two_beams(scene)
        if is_concrete(scene, camera):
            bench = packed.pack(scene)
            return path_difference(packed.arrivals(bench, node_points(camera, self.nodes)), bench.pairs)
        return opd_at(scene, node_points(camera, self.nodes))

    def error(self, scene: Scene, camera: Camera) -> ErrorEstimate:
        """Bounds of this method's error from the decay of the coefficients. Infinite where a beam misses a node."""
        phase, intensity = error_from_nodes(self.fields(one_line(scene), camera), self.nodes)
        if not has_channels(scene.light, camera):
            return ErrorEstimate(phase, intensity)
        if scene.light.extent is not None:
            intensity += error_between_directions(scene, camera, self.light(scene, camera))
        stretch = channels_of(scene.light, None).lines.ratios.max()
        return ErrorEstimate(phase * stretch, intensity * stretch + self.table_error)


def _channels(scene: Scene, camera: Camera, tolerance: float) -> Channels:
    """What tables hold of a known light: its lines, and the cells of a map."""
    extent = scene.light.extent
    if extent is None or extent.radiances is None:
        return channels_of(scene.light, camera.response)
    return channels_over_source(scene, camera, 0.1 * tolerance)
