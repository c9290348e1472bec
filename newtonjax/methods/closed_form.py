"""The closed form of the gap at every pixel."""

from dataclasses import dataclass
from math import isqrt
from typing import ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from newtonjax.fields import (
    ErrorEstimate,
    Fields,
    closed_amplitudes,
    closed_fields,
    node_arrivals,
    node_fields,
    pack,
    polar,
)
from newtonjax.methods.base import CALL, AbstractMethod, CannotHonourError, pass_share
from newtonjax.methods.closed_form_float32 import closed_turns
from newtonjax.methods.error_of_means import means_error
from newtonjax.methods.gap_paths import of_points
from newtonjax.methods.many_beams import by_profile, profile_of
from newtonjax.methods.many_wavelengths import equal_thickness, has_channels, one_line
from newtonjax.methods.source_directions import error_of_profile
from newtonjax.numerics import cos_turns, is_concrete, require_concrete
from newtonjax.scene import (
    Camera,
    Gap,
    Scene,
    Source,
    Surface,
    channels_of,
    focus_height,
    gap_between,
    gap_of,
    gap_opd,
    is_known_nonzero,
    node_points,
    source_of,
)

# Passes of a cosine that a pixel costs.
_PIXEL = 1.6
# Steps of one order at which its slope is looked for.
_STEPS = 4001
# Nodes to a side at which the formula is compared with rays.
_NODES = 17


@dataclass(frozen=True, repr=False)
class ClosedForm(AbstractMethod):
    """Fringes of equal thickness by formula: path difference 2 n t(x, y) of the gap at normal incidence.

    For two beams that differ by one round trip in the gap, or all orders there, light along -z, and a screen focused
    on the gap; amplitudes are those on the axis (Born and Wolf, Principles of Optics, section 7.5). Within a
    transformation in float32 the phase of one line is computed in numbers of twice the bits.

    - `table_error`: of the amplitude of the fringes, where light of many wavelengths is tabulated over the path
      difference. Within a transformation the table has 4096 cells (8 lines or fewer are summed at every pixel
      instead): an error of 1e-4 up to 200 orders.
    """

    needs_float64: ClassVar[bool] = False
    traces_rays: ClassVar[bool] = False
    float32_error: ClassVar[float] = 2e-6

    table_error: float = 1e-5

    @property
    def generality(self) -> tuple[int, int]:
        return 0, 0

    def check(self, scene: Scene) -> None:
        """Raise CannotHonourError where 2 n t is not the path difference. Traced values pass."""
        if refused := _refused(scene):
            raise CannotHonourError("ClosedForm", *refused, "Chebyshev() or Traced()")

    def passes(self, scene: Scene, camera: Camera) -> float:
        del scene
        return CALL + _PIXEL * pass_share(camera)

    def bytes_per_pixel(self) -> int:
        return 30

    def image(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns *channels"]:
        if scene.all_orders is not None or scene.light.extent is not None:
            return by_profile(scene, camera, self.table_error)
        if has_channels(scene.light, camera):
            return equal_thickness(scene, camera, self.table_error)
        x, y = camera.axes()
        x, y = x[None, :], y[:, None]
        (background, mutual), source = closed_amplitudes(scene), source_of(scene.light)
        if jnp.result_type(float) == jnp.float32:
            envelope, _ = source.fringes(mutual, self.opd(scene, camera))
            return background + envelope * cos_turns(closed_turns(scene, camera))
        return _equal_thickness(gap_between(scene), source, background, mutual, x, y)

    def opd(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns"]:
        x, y = camera.axes()
        return jnp.broadcast_to(gap_opd(scene, x[None, :], y[:, None]), camera.shape)

    def error(self, scene: Scene, camera: Camera) -> ErrorEstimate:
        """`error_against` rays at 17 x 17 nodes; infinite where a beam misses one of them.

        Raises CannotHonourError as `check` and `check_camera`, and ValueError for traced values.
        """
        require_concrete("ClosedForm().error", scene, camera)
        self.check(scene)
        self.check_camera(camera)
        line = one_line(scene)
        bench = pack(line)
        fields = node_fields(bench, node_arrivals(bench, camera, _NODES))
        if not fields.arrives.all():
            return ErrorEstimate(np.inf, np.inf)
        phase, intensity = self.error_against(fields, line, camera)
        intensity += means_error(scene, camera)
        if scene.light.extent is not None:
            intensity += error_of_profile(scene, camera)
        if scene.all_orders is not None:
            from_orders = self.error_of_orders(phase, scene, camera)
            return from_orders._replace(intensity=max(from_orders.intensity, intensity))
        if not has_channels(scene.light, camera):
            return ErrorEstimate(phase, intensity)
        stretch = channels_of(scene.light, None).lines.ratios.max()
        return ErrorEstimate(phase * stretch, intensity * stretch + self.table_error)

    def error_of_orders(self, phase: float, scene: Scene, camera: Camera) -> ErrorEstimate:
        """What an error of the phase [turns] makes of all orders in the gap: the steepest slope of their profile."""
        steps = np.linspace(0.0, 1.0, _STEPS)
        profile = profile_of(scene, of_points(camera)).at(steps)
        slope = abs(np.diff(profile)).max() * (_STEPS - 1)
        of_table = 0.0 if one_line(scene).light is scene.light else self.table_error
        return ErrorEstimate(phase, float(phase * slope / profile.max()) + of_table)

    def error_against(self, fields: Fields, scene: Scene, camera: Camera) -> ErrorEstimate:
        """The error at a square grid of nodes, where the fields of rays are known; half as much again between them."""
        points = node_points(camera, isqrt(fields.phase.shape[-1]))
        formula = closed_fields(scene, points[:, 0], points[:, 1])
        (size, phase), (true_size, true_phase) = polar(formula), polar(fields)
        turns = abs(phase - true_phase)
        turns = abs(turns - np.round(turns)) + fields.rounding
        error = abs(formula.background - fields.background) + abs(abs(size) - abs(true_size))[0]
        error = error + 2 * np.pi * (turns * abs(true_size))[0]
        peak = fields.background.max() + abs(true_size).max()
        return ErrorEstimate(1.5 * float(turns.max()), 1.5 * float(error.max() / peak))


@jax.jit
def _equal_thickness(gap: Gap, source: Source, background, mutual, x, y) -> Float[Array, "rows columns"]:
    """Fringes of equal thickness: a program for every shape, not for every bench."""

    def image(profile):
        # The envelope is real: no sine, which would cost as much as the cosine.
        envelope, turns = source.fringes(mutual, gap.opd(x, y, profile))
        return background + envelope * cos_turns(turns)

    return jax.lax.cond(gap.is_shallow(x, y), lambda: image(Surface.shallow_sag), lambda: image(Surface.sag))


def _refused(scene: Scene) -> tuple[str, str] | None:
    """The part of a scene for which 2 n t is not the path difference, and what the formula takes; None for none."""
    upper = gap_of(scene)
    if upper is None:
        beams = f"beams {', '.join(map(repr, scene.beams))}"
        return beams, "it takes two that differ by one round trip in one gap"
    for part in ("shield", "collecting_lens"):
        if getattr(scene, part) is not None:
            return part, "it takes a bare screen"
    if is_known_nonzero(scene.light.tilt):
        return "light.tilt", "it takes light along -z"
    if scene.light.curvature is not None:
        return "light.curvature", "it takes plane waves"
    for k, surface in enumerate(scene.surfaces):
        if type(surface) is not Surface:
            return f"surfaces[{k}] of {type(surface).__name__}", "it takes spheres and planes"
        if words := surface.shape_words():
            return f"surfaces[{k}].{words[0]}", "it takes spheres and planes"
        if not surface.is_plane() and is_known_nonzero(surface.tilt):
            return f"surfaces[{k}].tilt", "it takes upright spheres"
    if is_known_nonzero(scene.screen.tilt):
        return "screen.tilt", "it takes an upright screen"
    if is_concrete(scene):
        z, focus = scene.screen.vertex[2], focus_height(scene, upper)
        if np.any(np.abs(z - focus) > 1e-9 + 1e-9 * np.abs(focus)):
            where = f"z = {float(focus):.6g} m, screen='gap'"
            return f"screen at z = {float(z):.6g} m", f"it takes one focused on the gap ({where})"
    return None
