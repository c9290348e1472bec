"""Light as an argument of a fit: which lines a photograph under it may show."""

from typing import Any, NamedTuple

import numpy as np

from fitting.colour import Lines, lines_of
from newtonjax.numerics import shown
from newtonjax.scene import Spectrum, lamp

# Cameras see best here [m].
_MIDDLE = 555e-9
# What goes with the fit of all channels; the others are of the fit of one.
_APART = (
    "wavelength", "wavelength_sd", "scene", "free", "fixed", "start", "parts", "plate_radius", "plate_radius_sd",
    "priors", "axis_px", "view_angle", "channel", "noise",
)  # fmt: skip


class LampLight(NamedTuple):
    """The lines of a light that was given [m], and that to which the fringe scale refers."""

    lines: Lines

    @property
    def reference(self) -> float:
        """The line nearest to the middle of what cameras see [m]."""
        wavelengths = self.lines.wavelengths
        return float(wavelengths[np.argmin(np.abs(wavelengths - _MIDDLE))])

    @property
    def words(self) -> str:
        """The lines in nm, for a reader."""
        return ", ".join(f"{1e9 * line:.1f}" for line in np.sort(self.lines.wavelengths))


def light_of(arguments: dict[str, Any]) -> LampLight:
    """The light of the arguments of `fitting.fit`, of which a lamp's name may stand for a wavelength.

    Raises ValueError for what is no light, for light without lines, and beside what only the fit of one wavelength
    takes.
    """
    light = arguments["light"]
    if light is None and isinstance(arguments["wavelength"], str):
        light, arguments = arguments["wavelength"], arguments | {"wavelength": None}
    if not isinstance(light, str | Spectrum):
        raise ValueError(f"light is {shown(light)}; allowed: words such as 'mercury', or a Spectrum")
    for name in _APART:
        if arguments[name] is not None:
            raise ValueError(f"light and {name} do not go together: a fit under light has all channels; leave one out")
    lines = lines_of(lamp(light) if isinstance(light, str) else light)
    if not len(lines.wavelengths):
        raise ValueError(
            f"light is {shown(light)}, which has no lines: bands alone give no radius without the curves of the "
            "camera; allowed: a lamp such as 'mercury' or 'sodium', a line '546.1nm', or a wavelength behind a filter"
        )
    return LampLight(lines)
