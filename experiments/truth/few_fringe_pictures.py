"""Made pictures of half a fringe to six, with what real light adds, and pictures of as few that are not Newton's."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

WAVELENGTH, PIXEL_SIZE = 589.3e-9, 5e-6
FEWEST, MOST = 0.5, 6.0
RINGS = (
    "even light",
    "uneven light",
    "uneven contrast",
    "both uneven",
    "vignetting",
    "bright spot",
    "blur",
    "fading contrast",
    "8 bits",
    "wrong exponent",
    "dust",
    "round stop",
)
OTHERS = ("background", "bright spots", "straight", "ellipses", "cylinder", "saddle", "cones", "cloud")


@dataclass(frozen=True)
class FewFringes:
    """A picture [rows, columns], its fringes from end to end, and their scale [turns per px²]; None without rings."""

    image: np.ndarray
    fringes: float
    scale: float | None


def picture(kind: str, seed: int) -> FewFringes:
    """A picture of one kind with 0.5 to 6 fringes, noise of 0.5 to 10 %, the centre up to half a field outside."""
    rng = np.random.default_rng([seed, (RINGS + OTHERS).index(kind), 53])
    rows, columns = (int(side) for side in rng.integers(160, 320, 2))
    y, x = np.mgrid[:rows, :columns].astype(float)
    fringes = float(rng.uniform(FEWEST, MOST))
    noise = float(np.exp(rng.uniform(np.log(0.005), np.log(0.1))))
    low, high = (0.1, 0.9) if rng.random() < 0.5 else (-0.5, 1.5)
    centre = rng.uniform(low, high, 2) * (columns, rows)
    field = _Field(rng, x, y, fringes, centre)
    if kind in OTHERS:
        light = _with_light(field, np.cos(2 * np.pi * _OTHER_TURNS[kind](field))) if kind in _OTHER_TURNS else None
        light = _WITHOUT_FRINGES[kind](field) if light is None else light
        return FewFringes(light + noise * rng.normal(size=x.shape), fringes, None)
    scale = fringes / float(np.ptp(field.distance2))
    wave = np.cos(2 * np.pi * (scale * field.distance2 + rng.uniform()))
    return FewFringes(_RING_PICTURES[kind](field, wave, noise), fringes, scale)


@dataclass(frozen=True)
class _Field:
    """A field's pixels, its fringes, their centre (x, y) [px], and the generator of all that is drawn."""

    rng: np.random.Generator
    x: np.ndarray
    y: np.ndarray
    fringes: float
    centre: np.ndarray

    @property
    def distance2(self) -> np.ndarray:
        """Squared distance from the centre [px²]."""
        return (self.x - self.centre[0]) ** 2 + (self.y - self.centre[1]) ** 2

    @property
    def u(self) -> np.ndarray:
        return 2 * self.x / (self.x.shape[1] - 1) - 1

    @property
    def v(self) -> np.ndarray:
        return 2 * self.y / (self.x.shape[0] - 1) - 1

    def smooth(self, swing: float, degree: int = 3) -> np.ndarray:
        """A polynomial of random coefficients between -swing and swing."""
        powers = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i) if i + j]
        table = sum(self.rng.normal() * self.u**i * self.v**j for i, j in powers)
        return swing * (2 * (table - table.min()) / np.ptp(table) - 1)

    def noisy(self, light: np.ndarray, noise: float) -> np.ndarray:
        return light + noise * self.rng.normal(size=light.shape)

    def spot(self) -> np.ndarray:
        """A beam's Gaussian profile that leaves 5 to 60 % at half a side from its middle."""
        middle, edge = self.rng.uniform(-0.3, 0.3, 2), self.rng.uniform(0.05, 0.6)
        return np.exp(np.log(edge) * ((self.u - middle[0]) ** 2 + (self.v - middle[1]) ** 2))


def _with_light(field: _Field, wave: np.ndarray) -> np.ndarray:
    """Fringes under light that is uneven in half of the pictures."""
    light = 0.5 + 0.4 * wave
    return light if field.rng.random() < 0.5 else light * field.spot() + field.smooth(0.1, 2)


def _vignetted(field: _Field, wave: np.ndarray, noise: float) -> np.ndarray:
    loss = field.rng.uniform(0.2, 0.7)
    return field.noisy((0.5 + 0.4 * wave) * (1 - loss * (field.u**2 + field.v**2) / 2), noise)


def _blurred(field: _Field, wave: np.ndarray, noise: float) -> np.ndarray:
    """Visibility that falls as the fringes get finer: that of a Gaussian blur of 2 to 10 pixels."""
    cycles = 2 * field.fringes / np.ptp(field.distance2) * np.sqrt(field.distance2)
    visibility = np.exp(-2 * (np.pi * cycles * field.rng.uniform(2, 10)) ** 2)
    return field.noisy(0.5 + 0.4 * visibility * wave, noise)


def _fading(field: _Field, wave: np.ndarray, noise: float) -> np.ndarray:
    """Visibility that falls from the centre outwards, as a short coherence makes it."""
    reach = field.rng.uniform(0.4, 1.5) * field.distance2.max()
    return field.noisy(0.5 + 0.4 * wave * np.exp(-((field.distance2 / reach) ** 2)), noise)


def _coded(field: _Field, wave: np.ndarray, noise: float) -> np.ndarray:
    """8-bit codes of sRGB, the lightest parts at times saturated."""
    light = np.clip(field.noisy(field.rng.uniform(0.8, 1.2) * (0.5 + 0.4 * wave), noise), 0, 1)
    code = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    return np.uint8(np.round(255 * code))


def _bent_curve(field: _Field, wave: np.ndarray, noise: float) -> np.ndarray:
    """Codes of a camera whose curve is a power that the fit is not told."""
    exponent = np.exp(field.rng.uniform(np.log(0.5), np.log(2)))
    return np.maximum(field.noisy(0.5 + 0.4 * wave, noise), 0.0) ** exponent


def _dusty(field: _Field, wave: np.ndarray, noise: float) -> np.ndarray:
    light = 0.5 + 0.4 * wave
    rows, columns = light.shape
    for _ in range(25):
        at, width = field.rng.uniform(0, 1, 2) * (columns, rows), field.rng.uniform(1, 5)
        light[(field.x - at[0]) ** 2 + (field.y - at[1]) ** 2 < width**2] *= 0.3
    return field.noisy(light, noise)


def _stopped(field: _Field, wave: np.ndarray, noise: float) -> np.ndarray:
    """A round field, black around it."""
    side = min(field.x.shape)
    distance = np.hypot(field.u * field.x.shape[1] / side, field.v * field.x.shape[0] / side)
    return field.noisy(np.where(distance < field.rng.uniform(0.8, 1.0), 0.55 + 0.4 * wave, 0.0), noise)


_RING_PICTURES = {
    "even light": lambda field, wave, noise: field.noisy(0.5 + 0.4 * wave, noise),
    "uneven light": lambda field, wave, noise: field.noisy(0.5 + field.smooth(0.3) + 0.4 * wave, noise),
    "uneven contrast": lambda field, wave, noise: field.noisy(0.5 + (0.25 + field.smooth(0.15, 2)) * wave, noise),
    "both uneven": lambda field, wave, noise: field.noisy(
        0.5 + field.smooth(0.3) + (0.25 + field.smooth(0.15, 2)) * wave, noise
    ),
    "vignetting": _vignetted,
    "bright spot": lambda field, wave, noise: field.noisy(field.spot() * (0.5 + 0.4 * wave), noise),
    "blur": _blurred,
    "fading contrast": _fading,
    "8 bits": _coded,
    "wrong exponent": _bent_curve,
    "dust": _dusty,
    "round stop": _stopped,
}


def _straight(field: _Field) -> np.ndarray:
    angle = field.rng.uniform(0, np.pi)
    along = np.cos(angle) * field.x + np.sin(angle) * field.y
    return field.fringes * along / np.ptp(along) + field.rng.uniform()


def _squares(field: _Field) -> tuple[np.ndarray, np.ndarray]:
    """Squared distances from the centre along two axes at right angles."""
    angle = field.rng.uniform(0, np.pi)
    x, y = field.x - field.centre[0], field.y - field.centre[1]
    return (np.cos(angle) * x + np.sin(angle) * y) ** 2, (np.cos(angle) * y - np.sin(angle) * x) ** 2


def _quadric(field: _Field, ratio: float) -> np.ndarray:
    """Turns that grow with the square of one distance, and `ratio` times as much with that of the other."""
    along, across = _squares(field)
    turns = along + ratio * across
    return field.fringes * turns / np.ptp(turns) + field.rng.uniform()


def _cone(field: _Field) -> np.ndarray:
    distance = np.sqrt(field.distance2)
    return field.fringes * distance / np.ptp(distance) + field.rng.uniform()


# Ellipses 1.6 to 3 times as long as wide: a view at 48 degrees, and more than a fit allows.
_OTHER_TURNS = {
    "straight": _straight,
    "ellipses": lambda field: _quadric(field, field.rng.uniform(1.6, 3.0) ** 2),
    "cylinder": lambda field: _quadric(field, 0.0),
    "saddle": lambda field: _quadric(field, -1.0),
    "cones": _cone,
}


def _spots(field: _Field) -> np.ndarray:
    """A few oblong bright spots."""
    light = 0.1 + 0.0 * field.x
    for _ in range(int(field.rng.integers(1, 4))):
        middle, widths = field.rng.uniform(-0.7, 0.7, 2), field.rng.uniform(0.2, 0.8, 2)
        angle = field.rng.uniform(0, np.pi)
        u, v = field.u - middle[0], field.v - middle[1]
        along, across = np.cos(angle) * u + np.sin(angle) * v, np.cos(angle) * v - np.sin(angle) * u
        light += 0.5 * np.exp(-((along / widths[0]) ** 2) - (across / widths[1]) ** 2)
    return light


def _cloud(field: _Field) -> np.ndarray:
    cloud = ndimage.gaussian_filter(field.rng.normal(size=field.x.shape), min(field.x.shape) / field.rng.uniform(5, 15))
    return 0.5 + 0.25 * cloud / cloud.std()


_WITHOUT_FRINGES = {
    "background": lambda field: 0.5 + field.smooth(0.4, int(field.rng.integers(1, 6))),
    "bright spots": _spots,
    "cloud": _cloud,
}
