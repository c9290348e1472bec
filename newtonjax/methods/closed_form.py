"""The closed form of the gap at every pixel."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from newtonjax.fields import closed_fields
from newtonjax.methods.base import AbstractMethod
from newtonjax.methods.closed_form_float32 import closed_turns
from newtonjax.numerics import cos_turns
from newtonjax.scene import Camera, Gap, Scene, gap_between, gap_opd, sag, shallow_sag, why_not_closed


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
