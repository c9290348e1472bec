"""The numbers of a bench's light and of its pixels by name, and how each of them is moved."""

from collections.abc import Callable
from typing import Any

import equinox as eqx
import numpy as np

from newtonjax.numerics import module_of
from newtonjax.scene import Camera, Scene, Spectrum

Move = Callable[[Scene, Camera, Any], tuple[Scene, Camera]]
# A name, its value, a step that matters, and its move.
Entry = tuple[str, float, float, Move]
# Of which the image holds the square alone.
EVEN = ("gaussian_width", "source_size", "blur", "aperture")
# Steps of numbers that may be 0: widths of lines [m], sines of angles, curvatures of wavefronts [1/m], pixels.
_WIDTH, _SINE, _CURVATURE, _PIXELS = 1e-10, 1e-2, 1.0, 1.0


def light_entries(scene: Scene, camera: Camera) -> list[Entry]:
    """What light and camera have beyond one line, plane waves and points: only what is not None can be moved.

    "gaussian_width" and "lorentzian_width" are those of the widest line, which all lines share in proportion, or
    equally where all are 0; "line_splitting" is the distance of the outer lines, about the mean wavenumber. Gaussian
    widths, sizes and blur enter by their squares: the image is the same for a negative one.
    """
    spectrum, extent = scene.light.spectrum, scene.light.extent
    entries: list[Entry] = []
    if spectrum is not None:
        if spectrum.gaussian is not None:
            width = float(np.max(spectrum.gaussian))
            entries.append(("gaussian_width", width, max(width, _WIDTH), _gaussian))
        if spectrum.lorentzian is not None:
            width = float(np.max(spectrum.lorentzian))
            entries.append(("lorentzian_width", width, max(width, _WIDTH), _lorentzian))
        if len(spectrum.wavelengths) > 1:
            distance = float(np.ptp(spectrum.wavelengths))
            entries.append(("line_splitting", distance, max(distance, _WIDTH), _splitting))
    if extent is not None:
        sine = float(extent.sine)
        entries.append(("source_size", sine, max(sine, _SINE), _size))
    if scene.light.curvature is not None:
        curvature = float(scene.light.curvature)
        entries.append(("light_curvature", curvature, max(abs(curvature), _CURVATURE), _of_light))
    for name, move in (("blur", _blur), ("aperture", _aperture)):
        if (value := getattr(camera, name)) is not None:
            entries.append((name, float(value), max(float(value), _PIXELS), move))
    return entries


def _wider(widths, by) -> Any:
    """Widths of lines, the largest of them larger by a length."""
    xp = module_of(widths)
    largest = xp.max(widths)
    return widths + by if float(largest) == 0 else widths * (1 + by / largest)


def _of_spectrum(scene: Scene, name: str, value) -> Scene:
    return eqx.tree_at(lambda s: getattr(s.light.spectrum, name), scene, value)


def _gaussian(scene, camera, by):
    return _of_spectrum(scene, "gaussian", abs(_wider(scene.light.spectrum.gaussian, by))), camera


def _lorentzian(scene, camera, by):
    return _of_spectrum(scene, "lorentzian", _wider(scene.light.spectrum.lorentzian, by)), camera


def _splitting(scene, camera, by):
    spectrum: Spectrum = scene.light.spectrum
    wavenumbers = 1 / spectrum.wavelengths
    mean = 1 / spectrum.wavelength
    distance = np.ptp(spectrum.wavelengths)
    if distance == 0:
        raise ValueError("line_splitting of lines at one wavelength; give lines at two")
    stretched = mean + (wavenumbers - mean) * (1 + by / distance)
    return _of_spectrum(scene, "wavelengths", 1 / stretched), camera


def _size(scene, camera, by):
    extent = scene.light.extent
    return eqx.tree_at(lambda s: s.light.extent.sine, scene, abs(extent.sine + by)), camera


def _of_light(scene, camera, by):
    return eqx.tree_at(lambda s: s.light.curvature, scene, scene.light.curvature + by), camera


def _blur(scene, camera, by):
    return scene, eqx.tree_at(lambda c: c.blur, camera, abs(camera.blur + by))


def _aperture(scene, camera, by):
    return scene, eqx.tree_at(lambda c: c.aperture, camera, abs(camera.aperture + by))
