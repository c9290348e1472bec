"""The waveform of a channel over the squared distance: the gap, and what each component of light makes of it."""

from collections.abc import Mapping
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float

# Names of channels by their numbers.
COLOURS = ("red", "green", "blue")


class Curve(NamedTuple):
    """The numbers of the gap over the squared distance u [px²], and of how fringes fade.

    - `log_rate`: of the path difference's half [m] per px², n s²/(2 R) of a lens of radius R.
    - `offset`: of the gap at the centre, times the index [um].
    - `blur`: standard deviation of a Gaussian blur [px]; `blur_red`, `blur_blue`: of these channels beyond it.
    - `red`, `blue`: magnification of these channels over the others' [percent].
    - `bend`: by how much the camera's distortion stretches r² at the rim.
    - `balance`: of close lines towards the longer ones, in standard deviations of their lamps' (`Palette.tilt`).
    - `tilt_red` to `curvature_blue`: of the logarithm of a channel's spectrum over the given one (`GivenLight`).
    - `gain_red` to `gain_blue`: contrast of a channel's fringes over that in the first picture of a set-up.
    """

    log_rate: float
    offset: float = 0.0
    blur: float = 1.0
    red: float = 0.0
    blue: float = 0.0
    bend: float = 0.0
    balance: float = 0.0
    blur_red: float = 0.0
    blur_blue: float = 0.0
    tilt_red: float = 0.0
    tilt_green: float = 0.0
    tilt_blue: float = 0.0
    curvature_red: float = 0.0
    curvature_green: float = 0.0
    curvature_blue: float = 0.0
    gain_red: float = 1.0
    gain_green: float = 1.0
    gain_blue: float = 1.0

    def magnification(self, channel: int) -> float:
        """Of a channel, over the middle one's."""
        return 1 + 0.01 * (self.red, 0.0, self.blue)[channel]

    def blur_of(self, channel: int) -> float:
        """Standard deviation of the blur of a channel [px]."""
        return self.blur + (self.blur_red, 0.0, self.blur_blue)[channel]

    def geometry(self, channel: int) -> tuple[float, ...]:
        """All that the fringes of one wave in a channel depend on."""
        return self.log_rate, self.offset, self.bend, self.magnification(channel), self.blur_of(channel)


# Standard deviations of what is known of the numbers before; None for nothing. Steps of difference quotients.
PRIORS: dict[str, float | None] = {
    "log_rate": None, "offset": None, "blur": 3.0, "red": 0.1, "blue": 0.1, "bend": 0.02, "balance": 1.0,
    "blur_red": 0.5, "blur_blue": 0.5,
    "tilt_red": 0.3, "tilt_green": 0.3, "tilt_blue": 0.3,
    "curvature_red": 0.3, "curvature_green": 0.3, "curvature_blue": 0.3,
    "gain_red": None, "gain_green": None, "gain_blue": None,
}  # fmt: skip
STEPS = {
    "log_rate": 1e-6, "offset": 1e-5, "blur": 1e-3, "red": 1e-4, "blue": 1e-4, "bend": 1e-5, "balance": 1e-3,
    "blur_red": 1e-3, "blur_blue": 1e-3,
    "tilt_red": 1e-3, "tilt_green": 1e-3, "tilt_blue": 1e-3,
    "curvature_red": 1e-3, "curvature_green": 1e-3, "curvature_blue": 1e-3,
    "gain_red": 1e-4, "gain_green": 1e-4, "gain_blue": 1e-4,
}  # fmt: skip


@runtime_checkable
class Waves(Protocol):
    """Wavelengths and full widths at half maximum of Gaussian profiles [m]."""

    @property
    def wavelengths(self) -> Float[np.ndarray, " waves"]: ...
    @property
    def widths(self) -> Float[np.ndarray, " waves"]: ...


@runtime_checkable
class Light(Waves, Protocol):
    """What the light of a channel may be made of: components, each a sum of waves.

    - `lines`: how many components are lines; `middles`: wavelengths whose half is the step of an order [m].
    - `free`: names of the curve's numbers that change the light of these channels.
    - `variants`: lights that would do as well, by name.
    """

    @property
    def lines(self) -> int: ...
    @property
    def middles(self) -> Float[np.ndarray, " middles"]: ...
    def free(self, channels: tuple[int, ...], /) -> tuple[str, ...]: ...
    def variants(self) -> Mapping[str, "Light"]: ...
    def shares_in(self, curve: Curve, channel: int, /) -> Float[np.ndarray, "waves components"]: ...


class View(NamedTuple):
    """What is given: pixel size over the index [m], 0 for unknown; sign of the fringes at contact; rim [px²]."""

    pixel_size: float
    sign: float
    rim: float


def gaps(curve: Curve, squares: Float[np.ndarray, "*shape"], channel: int, view: View) -> Float[np.ndarray, "*shape"]:
    """Gap times index [m] under the exact sphere: s + s²/(2R) of the sag s = r²/(2R), and the offset."""
    u = squares * curve.magnification(channel) ** 2 * (1 + curve.bend * squares / view.rim)
    rate = np.exp(curve.log_rate)
    sag = rate * u
    steep = rate / view.pixel_size**2 if view.pixel_size else 0.0
    return sag * (1 + steep * sag) + 1e-6 * curve.offset


def waves(
    palette: Light, curve: Curve, squares: Float[np.ndarray, " bins"], width: float, channel: int, view: View
) -> Float[np.ndarray, "bins components"]:
    """The fringes of each component of a channel's light."""
    return fringes(palette, curve, squares, width, channel, view) @ palette.shares_in(curve, channel)


def fringes(
    palette: Waves, curve: Curve, squares: Float[np.ndarray, " bins"], width: float, channel: int, view: View
) -> Float[np.ndarray, "bins waves"]:
    """The fringes of each wave, faded by its width, by blur and by the mean over a bin.

    Of a wavenumber profile of width w the visibility at a path D is exp(-(pi w D)² / (4 ln 2)); of a mean over bins of
    `width` in u it is a sinc. A Gaussian blur b turns exp(i a u), u = x² + y², into exp(i a u / q) / q with
    q = 1 - 2 i a b² (the integral is Gaussian): rings fade, and shrink by (2 a b²)².
    """
    path = 2 * gaps(curve, squares, channel, view)[:, None]
    wavenumbers = 1 / palette.wavelengths
    rate = np.exp(curve.log_rate)
    widths = palette.widths * wavenumbers**2
    slope = 4 * np.pi * rate * wavenumbers
    blurred = 2 * slope * curve.blur_of(channel) ** 2
    along = slope * blurred / (1 + blurred**2) * squares[:, None]
    fading = -along - (np.pi * widths * path) ** 2 / (4 * np.log(2))
    phase = 2 * np.pi * path * wavenumbers - blurred * along + np.arctan(blurred)
    in_bin = np.sinc(2 * rate * wavenumbers * width) / np.sqrt(1 + blurred**2)
    return view.sign * in_bin * np.exp(fading) * np.cos(phase)
