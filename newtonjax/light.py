"""The source: collimated, monochromatic light, polarized or not."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Complex

from newtonjax.quantities import Scalar, Vector2, as_complex, as_scalar, as_vector, finite, positive, require
from newtonjax.surfaces import Direction, frame


class Light(eqx.Module):
    """Collimated light of one wavelength, of unit irradiance on a plane across it.

    - `wavelength`: in vacuum [m].
    - `tilt`: the direction, -z turned about x, then about y [rad].
    - `polarization`: angle of the linear polarization from x towards y [rad], about the light's own axis; None for
      unpolarized light (two perpendicular components of half the irradiance, whose intensities add).
    """

    wavelength: Scalar = eqx.field(converter=as_scalar)
    tilt: Vector2 = eqx.field(converter=as_vector, default=(0.0, 0.0))
    polarization: Scalar | None = None

    def __check_init__(self):
        require("wavelength", self.wavelength, "a positive length in metres", positive)
        require("light.tilt", self.tilt, "finite angles in radians", finite)
        if self.polarization is not None:
            require("polarization", self.polarization, "a finite angle in radians, or None", finite)


def launch_frame(light: Light) -> tuple[Direction, Direction, Direction]:
    """Two directions across the light, and the direction in which it travels."""
    across_x, across_y, up = frame(light.tilt)
    return across_x, across_y, -up


def field_at_launch(light: Light) -> Complex[Array, "3 polarizations"]:
    """Field vectors of the polarization components; their squares sum to 1."""
    across_x, across_y, _ = launch_frame(light)
    if light.polarization is None:
        return as_complex(jnp.stack([across_x, across_y], axis=1) * jnp.sqrt(0.5))
    angle = light.polarization
    return as_complex((jnp.cos(angle) * across_x + jnp.sin(angle) * across_y)[:, None])
