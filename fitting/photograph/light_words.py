"""Light as an argument of a fit: which lines a photograph under it may show, or which spectrum its channels see."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fitting.colour import Curves, Lines, lines_of
from newtonjax.numerics import shown
from newtonjax.scene import Response, Spectrum, camera_response, lamp

# Cameras see best here [m].
_MIDDLE = 555e-9
# What goes with the fit of all channels; the others are of the fit of one.
_APART = (
    "wavelength", "wavelength_sd", "scene", "free", "fixed", "start", "parts", "plate_radius", "plate_radius_sd",
    "priors", "axis_px", "view_angle", "channel", "noise",
)  # fmt: skip


class LampLight(NamedTuple):
    """The light that was given: its lines [m], or the curves of lamp and camera where it is of bands."""

    lines: Lines
    curves: Curves | None = None

    @property
    def reference(self) -> float:
        """The wavelength that the fringe scale is of: the line nearest to the middle of what cameras see [m].

        Under curves it is the middle one of the channels' means.
        """
        if self.curves is not None:
            return self.curves.mean
        wavelengths = self.lines.wavelengths
        return float(wavelengths[np.argmin(np.abs(wavelengths - _MIDDLE))])

    @property
    def words(self) -> str:
        """The lines, or the channels' means, in nm, for a reader."""
        wavelengths = self.lines.wavelengths if self.curves is None else self.curves.means
        return ", ".join(f"{1e9 * line:.1f}" for line in np.sort(wavelengths))


def light_of(arguments: dict[str, Any]) -> LampLight:
    """The light of the arguments of `fitting.fit`, of which a lamp's name may stand for a wavelength.

    Raises ValueError for what is no light, for light without lines and without the camera's response, and beside what
    only the fit of one wavelength takes.
    """
    light, response = arguments["light"], arguments["response"]
    if light is None and isinstance(arguments["wavelength"], str):
        light, arguments = arguments["wavelength"], arguments | {"wavelength": None}
    if light is None:
        raise ValueError("response is given without light: give the lamp's, such as light='white:D65' or 'lamp.csv'")
    if not isinstance(light, str | Spectrum):
        raise ValueError(f"light is {shown(light)}; allowed: words such as 'mercury', or a Spectrum")
    if isinstance(light, str) and light == "unknown":
        raise ValueError(
            "light='unknown' is for several photographs of one set-up, whose lenses then have ratios: "
            "fitting.ratio(first, second, light='unknown'); give the lamp, or leave light out for the fringe scale"
        )
    for name in _APART:
        # Of curves a person may know by how much all their wavelengths are off.
        if arguments[name] is not None and not (name == "wavelength_sd" and response is not None):
            raise ValueError(f"light and {name} do not go together: a fit under light has all channels; leave one out")
    spectrum = lamp(light) if isinstance(light, str) else light
    lines = lines_of(spectrum)
    if response is None and not len(lines.wavelengths):
        raise ValueError(
            f"light is {shown(light)}, which has no lines: bands alone give no radius without the curves of the "
            "camera; allowed: with them (response), or a lamp such as 'mercury' or 'sodium', a line '546.1nm', or a "
            "wavelength behind a filter"
        )
    if response is None:
        return LampLight(lines)
    if len(lines.wavelengths):
        raise ValueError(f"light is {shown(light)}, whose lines say more than the camera's curves; leave response out")
    return LampLight(lines, Curves(spectrum, _checked(response, spectrum, light)))


def _checked(response: Any, spectrum: Spectrum, light: Any) -> Response:
    """The response, which takes some of a light of bands. Raises ValueError for another one, and for other light."""
    if isinstance(response, str | Path):
        response = camera_response(str(response))
    if not isinstance(response, Response) or len(response.curves) not in (1, 3):
        raise ValueError(
            f"response is {shown(response)}; allowed: a file camera.csv, or a Response of three channels, red, green "
            "and blue, or of one"
        )
    if spectrum.triangle is None and (spectrum.gaussian is None or spectrum.lorentzian is not None):
        raise ValueError(f"light is {shown(light)} under a response; allowed: bands of Gaussian profile, or samples")
    if not len(Curves(spectrum, response).means):
        raise ValueError(f"the response takes nothing of light {shown(light)}; give the curves of this camera")
    return response
