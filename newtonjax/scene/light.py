"""The source: light of any spectrum and any state of polarization."""

from dataclasses import replace
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
    is_concrete,
    namespace,
    require,
    require_number,
    require_size,
    shown,
)
from newtonjax.scene.extent import Extent
from newtonjax.scene.limits import WAVELENGTH
from newtonjax.scene.response import Response
from newtonjax.scene.spectrum import Lines, Spectrum, lines_of
from newtonjax.scene.vectors import Direction, frame


class Light(eqx.Module):
    """Light of unit irradiance on a plane across it: plane waves, or spherical ones.

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
    - `spectrum`: lines and bands; None for one sharp line. `wavelength` is then the one of the mean wavenumber, and
      the whole spectrum goes with it in proportion: give `spectrum.wavelength` for the spectrum as it is.
    - `extent`: of a source that is no point; None for light of one direction at each place.
    - `curvature`: of the wavefront where the light's axis meets the first vertex [1/m]: 1 over the distance of a point
      source, negative for light that a lens gathers beyond; None for plane waves. The irradiance there is 1, and falls
      off the axis. A source of some extent is a part of the sphere of that radius.
    """

    wavelength: Scalar = eqx.field(converter=as_scalar)
    tilt: Vector2 = eqx.field(converter=as_vector, default=(0.0, 0.0))
    polarization: Scalar | None = eqx.field(converter=as_scalar, default=None)
    ellipticity: Scalar | None = eqx.field(converter=as_scalar, default=None)
    degree: Scalar | None = eqx.field(converter=as_scalar, default=None)
    spectrum: Spectrum | None = None
    extent: Extent | None = None
    curvature: Scalar | None = eqx.field(converter=as_scalar, default=None)

    def __check_init__(self):
        if not isinstance(self.spectrum, Spectrum | None):
            raise ValueError(f"spectrum is {shown(self.spectrum)}; allowed: a Spectrum such as lamp('sodium'), or None")
        if not isinstance(self.extent, Extent | None):
            raise ValueError(f"extent is {shown(self.extent)}; allowed: an Extent such as Extent(0.01), or None")
        require_number("wavelength", self.wavelength, f"a positive length, {WAVELENGTH.words}", WAVELENGTH.holds)
        if self.curvature is not None:
            require_number("light.curvature", self.curvature, "a finite curvature in 1/m, or None", finite)
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
    - `lines`: of the spectrum, over the wavenumber of `wavelength`; None for one sharp line.
    """

    wavelength: Scalar
    shares: Float[Any, "2"]
    lines: Lines | None = None

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
        """Envelope and phase [turns] of the fringes of two fields, the second a path [m] behind the first.

        The envelope of several lines is complex: it holds what they are beside the mean wavenumber.
        """
        turns = path * (1 / self.wavelength)  # one division, not one per pixel
        return (mutual if self.lines is None else mutual * self.lines.coherence(turns)), turns


def source_of(light: Light) -> Source:
    """The light's `Source`."""
    lines = None if light.spectrum is None else lines_of(light.spectrum)
    return Source(light.wavelength, _component_shares(light), lines)


def _component_shares(light: Light) -> Float[Any, "2"]:
    if light.polarization is None:
        return np.array([0.5, 0.5])
    if light.degree is None:
        return np.array([1.0, 0.0])
    return namespace(light).stack([1 + light.degree, 1 - light.degree]) / 2


class Channels(NamedTuple):
    """What a camera takes of a light.

    - `lines`: of the light; one of ratio 1 where it has no spectrum.
    - `powers`: of the lines in each channel, [channels, lines]; one channel where the camera has no response.
    """

    lines: Lines
    powers: Float[Any, "channels lines"]


def channels_of(light: Light, response: Response | None) -> Channels:
    """The light's lines, and what the channels of a camera take of them."""
    one_line = Lines(np.ones(1), np.ones(1), None, None, None)
    lines = one_line if light.spectrum is None else lines_of(light.spectrum)
    if response is None:
        return Channels(lines, lines.shares[None])
    return Channels(lines, response.powers(light.wavelength / lines.ratios, lines.shares))


def lights_of_channels(light: Light, response: Response) -> list[tuple[Light, Scalar]]:
    """For each channel the light whose image in all wavelengths alike is the channel's, and how strong it is."""
    lines, powers = channels_of(light, response)
    spectrum = Spectrum(light.wavelength / lines.ratios, lines.shares) if light.spectrum is None else light.spectrum
    weighted = []
    for power in powers:
        level = power.sum()
        weights = power if not is_concrete(level) or level > 0 else lines.shares
        seen_by = replace(spectrum, weights=weights)
        wavelength = light.wavelength * (seen_by.wavelength / spectrum.wavelength)
        weighted.append((replace(light, wavelength=wavelength, spectrum=seen_by), level))
    return weighted
