"""The source: collimated, monochromatic light of any state of polarization."""

from typing import Any, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Complex, Float

from newtonjax.numerics import (
    Scalar,
    Vector2,
    as_complex,
    as_scalar,
    as_vector,
    finite,
    namespace,
    require,
    require_number,
    require_size,
)
from newtonjax.scene.limits import WAVELENGTH
from newtonjax.scene.surfaces import Direction, frame


class Light(eqx.Module):
    """Collimated light of one wavelength, of unit irradiance on a plane across it.

    - `wavelength`: in vacuum [m].
    - `tilt`: the direction, -z turned about x, then about y [rad].
    - `polarization`: angle of the linear polarization (the ellipse's long axis) from x towards y [rad], about the
      light's own axis; None for unpolarized light (two perpendicular components of half the irradiance, whose
      intensities add).
    - `ellipticity`: angle whose tangent is the ratio of the ellipse's axes [rad], ±π/4 for circular light, above 0 for
      right-handed light (clockwise for who faces the source); None for linear polarization (Born and Wolf, Principles
      of Optics, section 1.4.2).
    - `degree`: of polarization, 0 to 1; None for 1. Partially polarized light is an unpolarized part and a polarized
      one; two components hold both, since the coherency matrix has two eigenvectors (section 10.9.2).
    """

    wavelength: Scalar = eqx.field(converter=as_scalar)
    tilt: Vector2 = eqx.field(converter=as_vector, default=(0.0, 0.0))
    polarization: Scalar | None = eqx.field(converter=as_scalar, default=None)
    ellipticity: Scalar | None = eqx.field(converter=as_scalar, default=None)
    degree: Scalar | None = eqx.field(converter=as_scalar, default=None)

    def __check_init__(self):
        require_number("wavelength", self.wavelength, f"a positive length, {WAVELENGTH.words}", WAVELENGTH.holds)
        require("light.tilt", self.tilt, "two finite angles in radians", finite)
        require_size("light.tilt", self.tilt, 2, "two angles in radians, about x and about y")
        require(
            "light.tilt", self.tilt, "angles whose light comes from above: both below π/2 = 1.5708 in size", _from_above
        )
        if self.polarization is None:
            if self.ellipticity is not None or self.degree is not None:
                raise ValueError(
                    "ellipticity or degree of polarization without polarization; give its angle, or leave all three out"
                )
            return
        require_number("polarization", self.polarization, "a finite angle in radians, or None", finite)
        if self.ellipticity is not None:
            require_number(
                "ellipticity", self.ellipticity, "-π/4 to π/4 in radians, or None", lambda e: np.all(np.abs(e) < 0.7854)
            )
        if self.degree is not None:
            require_number(
                "degree", self.degree, "0 (unpolarized) to 1, or None", lambda d: np.all((d >= 0) & (d <= 1))
            )


def _from_above(tilt: np.ndarray) -> bool:
    return bool(np.all(np.abs(tilt) < np.pi / 2))


def launch_frame(light: Light) -> tuple[Direction, Direction, Direction]:
    """Two directions across the light, and the direction in which it travels."""
    across_x, across_y, up = frame(light.tilt)
    return across_x, across_y, -up


def field_at_launch(light: Light) -> Complex[Any, "3 2"]:
    """Unit field vectors of two components, which do not interfere with each other.

    `Source.shares` says how strong they are. Fully polarized light has a second one too, of share 0. NumPy for known
    numbers.
    """
    across_x, across_y, _ = launch_frame(light)
    xp = namespace(light)
    if light.polarization is None:
        return as_complex(xp.stack([across_x, across_y], axis=1))
    angle = light.polarization
    along = as_complex(xp.cos(angle) * across_x + xp.sin(angle) * across_y)
    aside = as_complex(xp.cos(angle) * across_y - xp.sin(angle) * across_x)
    if light.ellipticity is not None:
        long, short = as_complex(xp.cos(light.ellipticity)), 1j * as_complex(xp.sin(light.ellipticity))
        along, aside = long * along + short * aside, long * aside + short * along
    return xp.stack([along, aside], axis=1)


class Source(NamedTuple):
    """What fields need of the light; NumPy for known numbers. What another kind touches stands in docs/extending.md.

    - `wavelength`: in vacuum [m].
    - `shares`: of the two polarization components in the irradiance, [2]. Apart from the fields: their square roots
      have no derivative at full polarization.
    """

    wavelength: Scalar
    shares: Float[Any, "2"]

    def irradiance(self, field: Complex[Any, "... 3 2"]) -> Float[Any, "..."]:
        """The square of a field, summed over components with their shares.

        Not |E|²: JAX's second derivative of that is 0 where a part of the field vanishes.
        """
        each = (field.real**2 + field.imag**2).sum(axis=-2)
        return (each * self.shares).sum(axis=-1)

    def mutual(self, first: Complex[Any, "... 3 2"], second: Complex[Any, "... 3 2"]) -> Complex[Any, "..."]:
        """2 Second·First*, twice the mutual intensity of two fields, summed over components with their shares."""
        each = (second * first.conj()).sum(axis=-2)
        return 2 * (each * as_complex(self.shares)).sum(axis=-1)

    def fringes(self, mutual, path: Float[Any, "..."]) -> tuple[Any, Float[Any, "..."]]:
        """Envelope and phase [turns] of the fringes of two fields, the second a path [m] behind the first."""
        return mutual, path * (1 / self.wavelength)  # one division, not one per pixel


def source_of(light: Light) -> Source:
    """The light's `Source`."""
    if light.polarization is None:
        return Source(light.wavelength, np.array([0.5, 0.5]))
    if light.degree is None:
        return Source(light.wavelength, np.array([1.0, 0.0]))
    return Source(light.wavelength, namespace(light).stack([1 + light.degree, 1 - light.degree]) / 2)
