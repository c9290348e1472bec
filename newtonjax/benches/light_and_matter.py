"""The light and the matter of a ready bench: wavelengths or spectra, sources, indices as numbers or names."""

from newtonjax.numerics import Scalar, is_concrete, namespace
from newtonjax.scene import Extent, Light, Spectrum, lamp, refractive_index

# Surroundings of a larger index make indices absolute.
_AIR = 1.0001


def mean_wavelength(light: str | Spectrum | None, wavelength: Scalar, ambient_index: Scalar) -> Scalar:
    """Of a light, as `light_of` takes it [m]."""
    spectrum = lamp(light, ambient_index) if isinstance(light, str) else light
    return wavelength if spectrum is None else spectrum.wavelength


def index_of(number: Scalar | str, wavelength: Scalar, ambient_index: Scalar = 1.0) -> Scalar:
    """A number as it is; of a name the index, absolute where the surroundings have the index of air or more."""
    if not isinstance(number, str):
        return number
    index = refractive_index(number, wavelength)
    is_absolute = is_concrete(ambient_index) and ambient_index > _AIR
    return index if number.lower() == "air" or not is_absolute else index * refractive_index("air", wavelength)


def light_of(
    light: str | Spectrum | None, wavelength: Scalar, ambient_index: Scalar, tilt, angle, degree, extent
) -> Light:
    """The light of a wavelength, or of a spectrum; a spectrum of one sharp line is its wavelength."""
    spectrum = lamp(light, ambient_index) if isinstance(light, str) else light
    if spectrum is not None:
        wavelength, spectrum = spectrum.wavelength, None if spectrum.is_sharp_line() else spectrum
    return Light(wavelength, tilt, angle, degree=degree, spectrum=spectrum, extent=extent)


def extent_of(angular_radius: Scalar | None, numerical_aperture: Scalar | None, ambient_index: Scalar) -> Extent | None:
    """The source of an angular radius [rad], or of an objective. Raises ValueError where both are given."""
    if angular_radius is not None and numerical_aperture is not None:
        raise ValueError("angular_radius and numerical_aperture are both given; allowed: one of them")
    if angular_radius is not None:
        return Extent(namespace(angular_radius).sin(angular_radius))
    return None if numerical_aperture is None else Extent(numerical_aperture / ambient_index)
