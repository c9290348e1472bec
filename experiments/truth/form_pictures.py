"""Seeded pictures of fringes of known forms, for the experiment on `fitting.form`."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from fitting.irregularity.zernike import on_grid, polar_values, terms_at

KINDS = ("open", "closed", "saddle", "rough", "few")


@dataclass(frozen=True)
class Picture:
    """A picture [rows, columns] of a form [terms], turns, in a pupil (x, y, radius)."""

    image: np.ndarray
    form: np.ndarray
    pupil: tuple[float, float, float]


def random_form(kind: str, terms: int, rng: np.random.Generator) -> np.ndarray:
    """A form of a kind, turns rms a term."""
    form = np.zeros(36)
    low, high = {"rough": (0.4, 0.1)}.get(kind, (0.12, 0.04))
    form[4:15] = low * rng.standard_normal(11)
    form[15:] = high * rng.standard_normal(21)
    angle = rng.uniform(0, 2 * np.pi)
    sign = rng.choice([-1, 1])
    tilt, power, astigmatism = {
        "open": (rng.uniform(3, 7), rng.uniform(0, 0.8), 0.0),
        "closed": (rng.uniform(0, 1), rng.uniform(2.5, 6), 0.0),
        "saddle": (rng.uniform(0, 1.5), rng.uniform(0, 0.3), rng.uniform(1.8, 4)),
        "rough": (rng.uniform(2, 4), rng.uniform(0, 2), 0.0),
        "few": (rng.uniform(0, 0.7), rng.uniform(0.3, 0.9), 0.0),
    }[kind]
    form[0] = rng.uniform(0, 1)
    form[1:3] += tilt * np.cos(angle), tilt * np.sin(angle)
    form[3] += sign * power
    turn = rng.uniform(0, 2 * np.pi)
    form[4:6] += astigmatism * np.cos(turn), astigmatism * np.sin(turn)
    return form[:terms]


def fringes_of(form: np.ndarray) -> float:
    """Fringes over the pupil: the phase from least to largest."""
    axis = np.linspace(-1, 1, 101)
    inside = np.square(axis)[:, None] + np.square(axis) <= 1
    return float(np.ptp(on_grid(form, axis, axis)[inside]))


class Fault(NamedTuple):
    """What is wrong with a picture: further terms [turns rms each], blur [px rms], distortion at the rim, a slant
    of the view [rad], an exponent of the light, and spots of dust.
    """

    further: float = 0.0
    blur: float = 0.0
    distortion: float = 0.0
    slant: float = 0.0
    gamma: float = 1.0
    dust: int = 0


SOUND = Fault()


def picture(form: np.ndarray, size: int, noise: float, rng: np.random.Generator, fault: Fault = SOUND) -> Picture:
    """A picture of a form under uneven light, white noise of that share of its mean, dark about the pupil."""
    radius = 0.49 * size
    centre = (size - 1) / 2 + rng.uniform(-0.5, 0.5, 2)
    u, v = np.meshgrid(*((np.arange(size) - middle) / radius for middle in centre))
    u = u / np.cos(fault.slant)
    squares = np.square(v) + np.square(u)
    phase = _phase(form, u, v, fault, rng)
    slope = rng.uniform(-0.15, 0.15, 4)
    light = 1 + slope[0] * u + slope[1] * v - 0.2 * squares
    contrast = 0.8 * light * (1 + slope[2] * u + slope[3] * v)
    image = np.where(squares <= 1, light + contrast * np.cos(2 * np.pi * phase), 0.02)
    if fault.blur:
        image = ndimage.gaussian_filter(image, fault.blur)
    for x, y, spot in zip(*rng.integers(0, size, (2, fault.dust)), rng.integers(1, 5, fault.dust), strict=True):
        image[max(y - spot, 0) : y + spot, max(x - spot, 0) : x + spot] *= 0.4
    image = image + noise * rng.standard_normal((size, size))
    if fault.gamma != 1:
        image = np.maximum(image, 1e-3) ** fault.gamma
    return Picture(image, form, (float(centre[0]), float(centre[1]), radius))


def _phase(form: np.ndarray, u: np.ndarray, v: np.ndarray, fault: Fault, rng: np.random.Generator) -> np.ndarray:
    scale = 1 + fault.distortion * (np.square(u) + np.square(v) - 1)
    phase = on_grid(form, u[0], v[:, 0]).ravel()
    u, v = (u * scale).ravel(), (v * scale).ravel()
    if fault.distortion:
        phase = terms_at(u, v, len(form)) @ form
    if fault.further:
        # The two orders beyond the 36 terms.
        for term in range(37, 56):
            phase += fault.further * rng.standard_normal() * polar_values(term, u, v)
    return phase.reshape(scale.shape)
