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
    if number.lower() == "air" or not is_absolute:
        return index
    return index * refractive_index("air", wavelength)


def light_of(
    light: str | Spectrum | None,
    wavelength: Scalar,
    ambient_index: Scalar,
    tilt,
    angle,
    degree,
    extent: Extent | None,
    curvature: Scalar | None,
) -> Light:
    """The light of a wavelength, or of a spectrum; a spectrum of one sharp line is its wavelength."""
    spectrum = lamp(light, ambient_index) if isinstance(light, str) else light
    if spectrum is not None:
        wavelength, spectrum = spectrum.wavelength, None if spectrum.is_sharp_line() else spectrum
    return Light(wavelength, tilt, angle, degree=degree, spectrum=spectrum, extent=extent, curvature=curvature)


def curvature_of(source_distance: Scalar | None, collimator: Scalar | None) -> Scalar | None:
    """Of the wavefront of a lamp at a distance [m], behind a thin lens of a focal length [m]: 1/d - 1/f [1/m].

    None for plane waves: without either, and of a lamp in the focus.
    """
    if source_distance is None:
        return None
    if collimator is None:
        return 1 / source_distance
    is_in_focus = is_concrete(source_distance, collimator) and source_distance == collimator
    return None if is_in_focus else 1 / source_distance - 1 / collimator


def extent_of(
    angular_radius: Scalar | None,
    numerical_aperture: Scalar | None,
    ambient_index: Scalar,
    lamp_radius: Scalar | None,
    lamp_distance: Scalar | None,
) -> Extent | None:
    """The source of an angular radius [rad], of an objective, or of a round lamp at a distance.

    Raises ValueError where two are given, and for a lamp at no distance.
    """
    sizes = {
        "angular_radius": angular_radius,
        "numerical_aperture": numerical_aperture,
        "lamp_radius": lamp_radius,
    }
    names = [name for name, size in sizes.items() if size is not None]
    if len(names) > 1:
        raise ValueError(f"{' and '.join(names)} are both given; allowed: one of them")
    if angular_radius is not None:
        return Extent(namespace(angular_radius).sin(angular_radius))
    if numerical_aperture is not None:
        return Extent(numerical_aperture / ambient_index)
    if lamp_radius is None:
        return None
    if lamp_distance is None:
        way_out = "source_distance, or the focal length of a collimator"
        raise ValueError(f"lamp_radius without a distance; give {way_out}")
    xp = namespace(lamp_radius, lamp_distance)
    return Extent(lamp_radius / xp.sqrt(lamp_radius * lamp_radius + lamp_distance * lamp_distance))
