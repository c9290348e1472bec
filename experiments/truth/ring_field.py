"""A field of rings of a sphere, and what is drawn at random of it: what made pictures of rings are made of."""

from io import BytesIO

import imageio.v3 as iio
import numpy as np

# Pixels so large that the sphere's own law differs from r² by less than a millionth.
WAVELENGTH, PIXEL_SIZE = 589.3e-9, 2e-5


class RingField:
    """A field's pixels about the rings' centre; `rho`: distance over half of the diagonal; `orders` of rings there."""

    def __init__(self, rng: np.random.Generator):
        self.rng = rng
        rows, columns = (int(side) for side in rng.integers(256, 420, 2))
        self.y, self.x = np.mgrid[:rows, :columns].astype(float)
        self.u, self.v = 2 * self.x / (columns - 1) - 1, 2 * self.y / (rows - 1) - 1
        self.unit = float(np.hypot(rows - 1, columns - 1)) / 2
        self.centre = rng.uniform(0.2, 0.8, 2) * (columns, rows)
        self.orders = self.drawn(5.0, 20.0)
        self.angle = float(rng.uniform(0, 2 * np.pi))
        self.noise = self.drawn(0.005, 0.05)
        self.start = float(rng.uniform())

    def drawn(self, low: float, high: float) -> float:
        """A number whose logarithm is evenly distributed."""
        return float(np.exp(self.rng.uniform(np.log(low), np.log(high))))

    @property
    def radius(self) -> float:
        """Of the sphere whose rings these are [m]."""
        return (self.unit * PIXEL_SIZE) ** 2 / (self.orders * WAVELENGTH)

    @property
    def rho(self) -> np.ndarray:
        return np.hypot(self.x - self.centre[0], self.y - self.centre[1]) / self.unit

    @property
    def azimuth(self) -> np.ndarray:
        return np.arctan2(self.y - self.centre[1], self.x - self.centre[0]) - self.angle

    @property
    def turns(self) -> np.ndarray:
        """The sphere's phase [turns]."""
        return self.orders * self.rho**2 + self.start

    def along(self) -> tuple[np.ndarray, np.ndarray]:
        """Offsets from the centre along two axes at right angles, over half of the diagonal."""
        return self.rho * np.cos(self.azimuth), self.rho * np.sin(self.azimuth)

    def noisy(self, light: np.ndarray) -> np.ndarray:
        return light + self.noise * self.rng.normal(size=light.shape)

    def rings(self) -> np.ndarray:
        return light_of(self.turns)


def light_of(turns: np.ndarray) -> np.ndarray:
    return 0.5 + 0.4 * np.cos(2 * np.pi * turns)


def compressed(light: np.ndarray, quality: int) -> np.ndarray:
    """Light as the codes of an sRGB file of JPEG's."""
    code = np.clip(light, 0, 1)
    code = np.where(code <= 0.0031308, 12.92 * code, 1.055 * code ** (1 / 2.4) - 0.055)
    file = BytesIO(iio.imwrite("<bytes>", np.uint8(np.round(255 * code)), extension=".jpg", quality=quality))
    return np.asarray(iio.imread(file, extension=".jpg"))
