"""Rings that a first look misses: beneath dust, a crosshair and print that are deeper than the fringes."""

import numpy as np
import pytest

import fitting

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
