"""Seeded pictures of a part under a test plate, for the experiment on `fitting.plate_test`."""

from typing import NamedTuple

import numpy as np
from scipy import ndimage

from fitting.irregularity.zernike import noll, on_grid

TERMS = 15
# Fringes of power to Zernike term 4, rms.
POWER = 2 * np.sqrt(3)


class Look(NamedTuple):
    """How a picture is made: pixels of a side, noise of the mean light, blur [px rms], visibility, loss of light at
    the rim, and its part in r⁴.
    """

    size: int = 224
    noise: float = 0.05
    blur: float = 1.5
    visibility: float = 0.8
    vignette: float = 0.3
    quartic: float = 0.0


LOOK = Look()


class PlatePicture(NamedTuple):
    """A picture [rows, columns], its pupil (x, y, radius), and the light without fringes."""

    image: np.ndarray
    pupil: tuple[float, float, float]
    light: np.ndarray


def random_part(power: float, irregularity: float, rng: np.random.Generator, tilt: float = 0.5) -> np.ndarray:
    """A form [15], turns: power [fringes] of either sign, irregularity [rms], tilt up to so many fringes."""
    form = np.zeros(TERMS)
    angle, size = rng.uniform(0, 2 * np.pi), tilt * rng.uniform() / 4
    form[0] = rng.uniform()
    form[1:3] = size * np.cos(angle), size * np.sin(angle)
    form[3] = rng.choice([-1, 1]) * power / POWER
    orders = np.array([noll(term)[0] for term in range(5, TERMS + 1)])
    uneven = rng.standard_normal(TERMS - 4) * np.array([1.0, 0.67, 0.45])[orders - 2]
    form[4:] = irregularity * uneven / np.linalg.norm(uneven)
    return form


def plate_picture(
    form: np.ndarray, rng: np.random.Generator, look: Look = LOOK, light: np.ndarray | None = None
) -> PlatePicture:
    """A picture of a form under uneven light, dark about the pupil, blurred, with white noise."""
    radius = 0.49 * look.size
    centre = (look.size - 1) / 2
    axis = (np.arange(look.size) - centre) / radius
    u, v = np.meshgrid(axis, axis)
    squares = np.square(u) + np.square(v)
    if light is None:
        slope = rng.uniform(-0.15, 0.15, 2)
        light = 1 + slope[0] * u + slope[1] * v - look.vignette * squares + look.quartic * np.square(squares)
    fringes = 1 + look.visibility * np.cos(2 * np.pi * on_grid(form, axis, axis))
    image = ndimage.gaussian_filter(np.where(squares <= 1, light * fringes, 0.02), look.blur)
    return PlatePicture(image + look.noise * rng.standard_normal(image.shape), (centre, centre, radius), light)


def lamp_picture(light: np.ndarray, rng: np.random.Generator, look: Look = LOOK) -> np.ndarray:
    """A picture of the light alone, by the same camera, a little brighter."""
    return 1.1 * light + look.noise * rng.standard_normal(light.shape)


def pressed_pictures(form: np.ndarray, rng: np.random.Generator, look: Look = LOOK) -> list[PlatePicture]:
    """Three pictures, each pressed by about a third of a fringe more, which tilts the plate a little."""
    pictures: list[PlatePicture] = []
    for number in range(3):
        pressed = form.copy()
        pressed[0] -= number * (1 / 3 + 0.03 * rng.standard_normal())
        pressed[1:3] += 0.05 * rng.standard_normal(2)
        light = pictures[0].light if pictures else None
        pictures.append(plate_picture(pressed, rng, look, light))
    return pictures
