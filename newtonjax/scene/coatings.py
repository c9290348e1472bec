"""What stands on the faces of a gap: stacks of thin layers, or mirrors, and the amplitudes of light at such a face.

Characteristic matrices (Born and Wolf, Principles of Optics, section 1.6.2; Macleod, Thin-Film Optical Filters,
chapter 2), the time factor e^{-iωt}, so that absorbing matter has the index n + ik. Written in squares of cosines the
matrices have derivatives at a thickness of 0, at equal indices and at a layer's critical angle.
"""

from typing import Any, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Complex, Float

from newtonjax.numerics import Scalar, as_complex, as_scalar, as_vector, finite, namespace, require, require_number

# Below this square of a layer's phase its cosine and sine are series.
_SMALL = 1e-2
_LENGTHS = "0 or more metres for each layer"
_FRACTION = "a number from 0 to 1, or None"


def _numbers(values) -> Any:
    return None if values is None else as_vector(values)


class Coating(eqx.Module):
    """Thin layers on a face of a gap, or a mirror of known reflectance.

    Layers, in the order in which they lie on the glass, that on the glass first:

    - `thicknesses`: [m], [layers].
    - `indices`, `extinctions`: real and imaginary parts of their refractive indices n + ik, [layers]; no extinctions
      where no layer absorbs. An opaque metal is a layer of some 0.3 um.

    A mirror, the same for all wavelengths and angles:

    - `reflectance`: of the intensity, as seen from the gap; above 0 where its derivative is wanted.
    - `phase`: of the reflected amplitude [rad], as seen from the gap; None is 0.
    - `absorptance`: of the intensity, which passes the glass neither way; None is 0.

    Raises ValueError for layers and mirrors that do not exist, and where both are described.
    """

    thicknesses: Float[Any, " layers"] | None = eqx.field(converter=_numbers, default=None)
    indices: Float[Any, " layers"] | None = eqx.field(converter=_numbers, default=None)
    extinctions: Float[Any, " layers"] | None = eqx.field(converter=_numbers, default=None)
    reflectance: Scalar | None = eqx.field(converter=as_scalar, default=None)
    phase: Scalar | None = eqx.field(converter=as_scalar, default=None)
    absorptance: Scalar | None = eqx.field(converter=as_scalar, default=None)

    def __check_init__(self):
        layers, mirror = (self.thicknesses, self.indices), (self.reflectance, self.phase, self.absorptance)
        if any(part is not None for part in (*layers, self.extinctions)) == (self.reflectance is not None):
            raise ValueError("a coating is thicknesses with indices, or a reflectance; allowed: one of these")
        if self.reflectance is None:
            if any(part is None for part in layers) or any(part is not None for part in mirror):
                raise ValueError("a coating of layers takes thicknesses and indices, no phase and no absorptance")
            self._check_layers()
            return
        require_number("reflectance", self.reflectance, "a number from 0 to below 1", lambda v: (v >= 0) & (v < 1))
        if self.phase is not None:
            require_number("phase", self.phase, "a finite angle in radians, or None", finite)
        if self.absorptance is not None:
            require_number("absorptance", self.absorptance, _FRACTION, lambda v: (v >= 0) & (v <= 1))
            total = namespace(self).asarray(self.reflectance + self.absorptance)
            require("reflectance and absorptance", total, "a sum of at most 1", lambda v: v <= 1)

    def _check_layers(self) -> None:
        layers = self.thicknesses, self.indices, self.extinctions
        require("thicknesses", self.thicknesses, _LENGTHS, lambda v: np.isfinite(v) & (v >= 0))
        require("indices", self.indices, "a refractive index above 0 for each layer", lambda v: (v > 0) & (v < 100))
        if self.extinctions is not None:
            require(
                "extinctions", self.extinctions, "0 or more for each layer, or None", lambda v: (v >= 0) & (v < 100)
            )
        sizes = {np.shape(numbers) for numbers in layers if numbers is not None}
        if len(sizes) > 1 or len(next(iter(sizes))) != 1:
            raise ValueError(
                f"thicknesses, indices and extinctions have shapes {sorted(sizes)}; allowed: one number each per layer"
            )


class AllOrders(eqx.Module):
    """All reflections between the two faces of the gap, and what stands on these; see `newtonjax.fields.many_beams`.

    - `upper`, `lower`: coatings of the face above the gap and of the one below; None for bare glass.
    """

    upper: Coating | None = None
    lower: Coating | None = None

    def __check_init__(self):
        for name, part in (("upper", self.upper), ("lower", self.lower)):
            if not isinstance(part, Coating | None):
                raise ValueError(f"{name} is {part!r:.80}; allowed: a Coating, or None")


class FaceAmplitudes(NamedTuple):
    """Amplitudes of a face of the gap, of s and p polarization, [2, ...].

    Of the fields along the face, so that at normal incidence both polarizations have the same numbers.

    - `outside`, `inside`: reflected into the glass, and into the gap.
    - `through`: product of the two that pass the face in the two directions.
    - `transmittance`: of the flux.
    """

    outside: Complex[Any, "2 ..."]
    inside: Complex[Any, "2 ..."]
    through: Complex[Any, "2 ..."]
    transmittance: Float[Any, "2 ..."]


def face_amplitudes(
    coating: Coating | None, glass: Scalar, gap: Scalar, wavelength: Float[Any, "..."], square: Float[Any, "..."]
) -> FaceAmplitudes:
    """The amplitudes of a face between glass and gap.

    - `glass`, `gap`: their refractive indices; `wavelength`: in vacuum [m].
    - `square`: of the sine of the light's angle times the refractive index there: the same in all media.
    """
    xp = namespace(coating, glass, gap, wavelength, square)
    if coating is not None and coating.reflectance is not None:
        return _mirror(xp, coating, xp.broadcast_shapes(xp.shape(wavelength), xp.shape(square)))
    stack = _stack(coating)
    outside, forth, flux = _reflected_and_passed(xp, stack, glass, gap, wavelength, square)
    inside, back, _ = _reflected_and_passed(xp, stack[::-1], gap, glass, wavelength, square)
    return FaceAmplitudes(outside, inside, forth * back, flux)


def _mirror(xp, mirror: Coating, shape: tuple[int, ...]) -> FaceAmplitudes:
    reflectance: Any = mirror.reflectance
    ones = xp.ones((2, *shape))
    phase = 0.0 if mirror.phase is None else mirror.phase
    absorptance = 0.0 if mirror.absorptance is None else mirror.absorptance
    passed = 1.0 - reflectance - absorptance
    size = xp.sqrt(xp.asarray(reflectance, dtype=float))
    along, aside = as_complex(size * xp.cos(phase) * ones), as_complex(size * xp.sin(phase) * ones)
    return FaceAmplitudes(-along + 1j * aside, along + 1j * aside, as_complex(passed * ones), passed * ones)


def _stack(coating: Coating | None) -> list[tuple[Scalar, Scalar, Scalar | None]]:
    """Thickness, index and extinction of each layer, that on the glass first."""
    if coating is None or coating.thicknesses is None or coating.indices is None:
        return []
    absorbing = coating.extinctions
    return [
        (coating.thicknesses[k], coating.indices[k], None if absorbing is None else absorbing[k])
        for k in range(len(coating.indices))
    ]


def _reflected_and_passed(xp, layers, before: Scalar, beyond: Scalar, wavelength, square):
    """Amplitudes r and t of a stack between two transparent media, and the flux that passes, of s and p [2, ...].

    [B, C] = Π M [1, η], r = (η₀ B - C) / (η₀ B + C), t = 2 η₀ / (η₀ B + C), η the admittances.
    """
    first, last = (_admittances(xp, index, wavelength, square) for index in (before, beyond))
    electric, magnetic = xp.ones_like(last), last
    damping = xp.ones_like(last)
    for thickness, index, extinction in reversed(layers):
        matrix, attenuation = _matrix(xp, thickness, index, extinction, wavelength, square)
        (a, b), (c, d) = matrix
        electric, magnetic = a * electric + b * magnetic, c * electric + d * magnetic
        damping = damping * attenuation
    total = first * electric + magnetic
    passed = 2 * first * damping / total
    flux = last.real / first.real * (passed.real**2 + passed.imag**2)
    return (first * electric - magnetic) / total, passed, flux


def _admittances(xp, index: Scalar, wavelength, square) -> Complex[Any, "2 ..."]:
    """Of a transparent medium: n cos θ of s, n / cos θ of p."""
    along = xp.sqrt(index * index - square + 0.0 * wavelength)
    return as_complex(xp.stack([along, index * index / along]))


def _matrix(xp, thickness: Scalar, index: Scalar, extinction: Scalar | None, wavelength, square):
    """The characteristic matrix of a layer over e^{-iφ}, and e^{iφ}, φ its phase: neither grows with the thickness."""
    absorbing = 0.0 if extinction is None else extinction
    permittivity = as_complex(xp.asarray(index * index - absorbing * absorbing, dtype=float))
    permittivity = permittivity + 1j * as_complex(xp.asarray(2.0 * index * absorbing, dtype=float))
    along = permittivity - as_complex(xp.asarray(square + 0.0 * wavelength))
    length = as_complex(xp.asarray(2 * np.pi / wavelength * thickness + 0.0 * square))
    cosine, ratio, attenuation = _cosine_and_sine_ratio(xp, along * (length * length))
    sine_over_along = -1j * (ratio * length)
    # The sine over the admittance, and times it, of s and of p.
    over = xp.stack([sine_over_along, sine_over_along * along / permittivity])
    times = xp.stack([sine_over_along * along, sine_over_along * permittivity])
    return ((cosine, over), (times, cosine)), attenuation


def _cosine_and_sine_ratio(xp, square: Complex[Any, "..."]):
    """The cos φ and sin φ / φ of φ², both times e^{iφ}, and e^{iφ}: the root with an imaginary part of 0 or more.

    Of a small φ without the factor, which is then 1: series, since the root has no derivative at 0.
    """
    is_small = abs(square.real) + abs(square.imag) < _SMALL
    root = xp.sqrt(xp.where(is_small, 1.0 + 0.0j, square))
    root = xp.where(root.imag < 0, -root, root)
    factor = xp.exp(1j * root)
    twice = factor * factor
    near = xp.where(is_small, square, 0.0)
    cosine = 1 - near / 2 * (1 - near / 12 * (1 - near / 30 * (1 - near / 56 * (1 - near / 90))))
    ratio = 1 - near / 6 * (1 - near / 20 * (1 - near / 42 * (1 - near / 72 * (1 - near / 110))))
    return (
        xp.where(is_small, cosine, (twice + 1) / 2),
        xp.where(is_small, ratio, (twice - 1) / (2j * root)),
        xp.where(is_small, 1.0 + 0.0j, factor),
    )
