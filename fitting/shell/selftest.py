"""Trials of the self-test: photographs and tables of rings whose true radius is known, measured as a user would.

Each truth is drawn, so is what a user knows of it: pixel size and wavelength scatter about what the fit is given by the
standard deviations that it is given. What is stated is then tested as a whole, not the noise alone.
"""

import warnings
from time import process_time
from typing import Any, NamedTuple

import numpy as np

import fitting
import newtonjax as nj

SIZE = 256
# Of what is known, relative: as a stage micrometer and a lamp's lines give them.
_PIXEL_SD, _WAVELENGTH_SD = 2e-4, 1e-4
# Standard deviation of a reading of a ring's place over the radius of the first ring.
_READING_SD = 5e-3


class Trial(NamedTuple):
    """One measurement: true radius [m], that measured, its standard deviation and interval, processor seconds."""

    radius: float
    measured: float | None
    sd: float
    interval: tuple[float, float]
    seconds: float
    status: str

    @property
    def deviations(self) -> float:
        """The error over the stated standard deviation."""
        return np.nan if self.measured is None else (self.measured - self.radius) / self.sd

    @property
    def is_covered(self) -> bool:
        """Whether the stated 95 % interval holds the truth."""
        low, high = self.interval
        return low <= self.radius <= high


def photograph_trial(seed: int, number: int) -> Trial:
    """A photograph of a random bench: radius 5 mm to 100 m, 8 to 40 rings, noise of 2 to 10 %, both views."""
    random = np.random.default_rng([seed, 0, number])
    radius = float(np.exp(random.uniform(np.log(5e-3), np.log(100.0))))
    wavelength = float(random.uniform(450e-9, 650e-9))
    gap, view = float(random.uniform(0, 5e-6)), str(random.choice(["reflected", "transmitted"]))
    pixel_size = float(np.sqrt(random.uniform(8, 40) * radius * wavelength) / (SIZE / np.sqrt(2)))
    x, y = SIZE / 2 + random.uniform(-0.2, 0.2, 2) * SIZE
    scene = nj.newton_rings(radius, wavelength, gap, view)
    image = np.asarray(nj.render(scene, nj.Camera((SIZE, SIZE), pixel_size, centre_px=(float(x), float(y)))))
    contrast = 0.5 * np.ptp(image)
    image = image + contrast * random.uniform(0.02, 0.1) * random.normal(size=image.shape)
    return _timed(radius, lambda: fitting.fit(image, view=view, **_knowledge(random, wavelength, pixel_size)))


def table_trial(seed: int, number: int) -> Trial:
    """A table of 8 to 30 rings of a random lens, read on both sides with an unknown gap at the centre."""
    random = np.random.default_rng([seed, 1, number])
    radius = float(np.exp(random.uniform(np.log(0.05), np.log(20.0))))
    wavelength = float(random.uniform(450e-9, 650e-9))
    order = np.arange(1, random.integers(9, 31))
    first = float(np.sqrt(radius * wavelength))
    diameter = 2 * np.sqrt((order + random.uniform(-0.4, 0.4)) * radius * wavelength)
    sd = _READING_SD * first
    reading = diameter + sd * random.normal(size=len(order))
    table = {"order": order, "diameter_mm": reading * 1e3, "sd_mm": np.full(len(order), sd * 1e3)}
    knowledge = _knowledge(random, wavelength, 1.0)
    light = {name: knowledge[name] for name in ("wavelength", "wavelength_sd")}
    return _timed(radius, lambda: fitting.rings(table, **light))


def _knowledge(random: np.random.Generator, wavelength: float, pixel_size: float) -> dict[str, Any]:
    """What a user knows of the true wavelength and pixel size."""
    nominal_wavelength, nominal_pixel = (
        truth * (1 + sd * random.normal()) for truth, sd in ((wavelength, _WAVELENGTH_SD), (pixel_size, _PIXEL_SD))
    )
    return {
        "wavelength": nominal_wavelength,
        "wavelength_sd": _WAVELENGTH_SD * nominal_wavelength,
        "pixel_size": nominal_pixel,
        "pixel_size_sd": _PIXEL_SD * nominal_pixel,
    }


def _timed(radius: float, measure: Any) -> Trial:
    began = process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of single photographs; here they are counted by their outcome
        result = measure()
    seconds = process_time() - began
    if result.radius is None or result.radius_sd is None:
        return Trial(radius, None, np.nan, (np.inf, -np.inf), seconds, result.status)
    return Trial(radius, result.radius, result.radius_sd, result.radius_interval, seconds, result.status)
