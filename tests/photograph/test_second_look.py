"""Rings that a first look misses: beneath dust, a crosshair and print that are deeper than the fringes."""

import numpy as np
import pytest

import fitting
from fitting.parameters import Numbers
from fitting.photo import read, view_of
from fitting.photograph.second_look import bent_rings

WAVELENGTH, PIXEL_SIZE, SIZE = 589.3e-9, 10e-6, 320


def dusty(turns: np.ndarray, depth: float, seed: int) -> np.ndarray:
    """Fringes of so many turns and a swing of `depth`, beneath 70 grains of dust and a crosshair, with noise."""
    rng = np.random.default_rng(seed)
    light = 0.45 + depth / 2 * np.cos(2 * np.pi * turns)
    y, x = np.mgrid[:SIZE, :SIZE]
    for _ in range(70):
        column, row, radius = *rng.uniform(0, SIZE, 2), rng.uniform(2, 10)
        light[(x - column) ** 2 + (y - row) ** 2 < radius**2] *= 0.4
    light[(np.abs(y - 150) < 2) | (np.abs(x - 170) < 2)] *= 0.2
    return light + 0.02 * rng.normal(size=light.shape)


@pytest.mark.parametrize(("orders", "depth"), [(11.0, 0.08), (40.0, 0.12)])
def test_faint_rings_beneath_dust_and_a_crosshair_are_measured(orders, depth):
    y, x = np.mgrid[:SIZE, :SIZE] * PIXEL_SIZE
    r2 = (x - 1.7e-3) ** 2 + (y - 1.5e-3) ** 2
    radius = float(r2.max()) / (orders * WAVELENGTH)
    result = fitting.fit(dusty(r2 / radius / WAVELENGTH, depth, 4), wavelength=WAVELENGTH, pixel_size=PIXEL_SIZE)
    assert any("% of the field is darker or brighter than fringes" in text for text in result.warnings)
    assert abs(result.radius - radius) < 3 * result.radius_sd < 0.01 * radius


def test_a_spiral_beneath_dust_is_refused():
    y, x = np.mgrid[:SIZE, :SIZE] - SIZE / 2
    spiral = 11 * (x**2 + y**2) / (SIZE**2 / 2) + np.arctan2(y, x) / (2 * np.pi)
    assert fitting.fit(dusty(spiral, 0.08, 4), wavelength=WAVELENGTH, pixel_size=PIXEL_SIZE).status == "refused"


def _bent_rings(orders, share, distortion, shape=(300, 400)):
    """Rings of a lens whose principal curvatures differ by a share of their mean, under a camera that distorts."""
    y, x = np.mgrid[: shape[0], : shape[1]].astype(float)
    half = np.hypot(shape[0] - 1, shape[1] - 1) / 2
    u, v = (x - (shape[1] - 1) / 2) / half, (y - (shape[0] - 1) / 2) / half
    warp = 1 + distortion * (u**2 + v**2)
    cosine = np.sqrt(0.75)
    along, across = (cosine * u + 0.5 * v) * warp, (cosine * v - 0.5 * u) * warp
    turns = orders * ((1 + share / 2) * along**2 + (1 - share / 2) * across**2) + 0.3
    noise = 0.02 * np.random.default_rng(5).normal(size=shape)
    return 0.5 - 0.4 * np.cos(2 * np.pi * turns) + noise, orders / half**2


@pytest.mark.parametrize("share", [0.25, 0.57])
def test_rings_of_a_lens_with_two_radii_are_found_and_both_curvatures_right(share):
    image, curvature = _bent_rings(15.0, share, 0.0)
    result = fitting.fit(image, view="reflected", view_angle=0.0)
    numbers = Numbers(*result.evidence.found.numbers)
    assert result.status == "no-scale"
    # Of the curvatures' geometric mean; their ratio is exp(2 m).
    geometric = curvature * np.sqrt(1 - share**2 / 4)
    half = np.hypot(image.shape[0] - 1, image.shape[1] - 1) / 2
    assert numbers.curvature / half**2 == pytest.approx(geometric, rel=2e-3)
    stretch = np.hypot(numbers.stretch, numbers.shear)
    assert stretch == pytest.approx(0.5 * np.log((1 + share / 2) / (1 - share / 2)), abs=2e-3)


@pytest.mark.parametrize("distortion", [-0.12, 0.07])
def test_many_rings_that_a_camera_distorts_are_found_and_their_scale_covered(distortion):
    image, curvature = _bent_rings(65.0, 0.0, distortion, (480, 640))
    result = fitting.fit(image, view="reflected")
    assert abs(result.fringe_scale_per_px2 - curvature) < 3 * result.fringe_scale_sd < 3e-4 * curvature


@pytest.mark.parametrize("bend", ["saddle", "plane"])
def test_fringes_that_are_no_rings_are_no_bent_ones(bend):
    y, x = np.mgrid[:300, :400] / 250.0 - 0.6
    turns = 20 * (x**2 - 0.5 * y**2) if bend == "saddle" else 30 * x + 12 * y
    photograph = read(0.5 - 0.4 * np.cos(2 * np.pi * turns))
    assert bent_rings(photograph, view_of(photograph), 0.0) is None
