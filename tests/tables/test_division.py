"""The division that readings are read to: what it says of the answer where the readings scatter by less."""

import numpy as np
import pytest

import fitting
from fitting.tables.division import division

WAVELENGTH = 589.3e-9
_ROUNDED = "the standard deviation is that of the rounding"
_RIVALS = ("not a straight line", "than counted", "set right", "left out", "readings of one ring agree")


def test_equal_repeats_are_rounded_alike():
    single = fitting.rings({"order": [5, 10, 15], "diameter_mm": [3.43, 4.86, 5.95]}, wavelength=WAVELENGTH)
    columns = {"order": [5, 5, 5, 10, 10, 10], "diameter_mm": [3.43, 3.43, 3.43, 4.86, 4.86, 4.86]}
    repeated = fitting.rings(columns, wavelength=WAVELENGTH)
    assert any(_ROUNDED in text and "0.01 mm" in text for text in repeated.warnings)
    # Each diameter is uncertain by 0.01 mm / sqrt(12), and the slope is a difference of two squares.
    error = 0.01e-3 / np.sqrt(12) * np.hypot(3.43e-3, 4.86e-3) / 2 / 5 / WAVELENGTH
    assert repeated.radius_sd == pytest.approx(error, rel=1e-6)
    assert repeated.radius_sd > single.radius_sd


def test_readings_that_happen_to_lie_on_a_line_are_no_better_than_their_digits():
    result = fitting.rings({"order": [4, 8, 12], "diameter_mm": [2.80, 3.96, 4.85]}, wavelength=WAVELENGTH)
    assert 1e-3 < result.radius_sd / result.radius < 3e-3
    low, high = result.radius_interval
    assert high - low > 2 * result.radius_sd


def test_rounded_readings_are_within_their_intervals():
    covered = 0
    for seed in range(200):
        rng = np.random.default_rng(seed)
        radius, orders = rng.uniform(0.5, 2.0), 4.0 * np.arange(1, 8) + rng.uniform(0, 1)
        sizes = np.round(2e3 * np.sqrt(orders * WAVELENGTH * radius), 2)
        columns = {"order": np.tile(orders, 3), "diameter_mm": np.tile(sizes, 3)}
        low, high = fitting.rings(columns, wavelength=WAVELENGTH).radius_interval
        covered += low < radius < high
    assert covered >= 183  # of 190 three binomial deviations below 95 %


@pytest.mark.parametrize(
    ("cells", "step"),
    [
        (["3.430", "4.86"], 1e-3),
        ([3.43, 5.0], 1e-2),
        ([0.1 + 0.2, 1.0], 0.1),
        ([120, 150], 1.0),
        (["1e-3", "2.5e-3"], 1e-4),
        ([np.pi, np.sqrt(2)], 0.0),
    ],
)
def test_the_division_is_the_last_decimal_place(cells, step):
    assert division([cells], np.ones(2, bool)) == pytest.approx(step)


def test_exact_numbers_have_no_division():
    orders = np.arange(1.0, 16)
    result = fitting.rings({"order": orders, "radius_m": np.sqrt(orders * WAVELENGTH)}, wavelength=WAVELENGTH)
    assert not any(_ROUNDED in text for text in result.warnings)


def test_rounding_is_no_other_law_and_no_miscount():
    """Rounding alone, of tables with repeats: a residual is bounded, and repeats agree to the last digit."""
    suspected = 0
    for seed in range(150):
        rng = np.random.default_rng(seed)
        orders = rng.integers(1, 12) + np.arange(float(rng.integers(5, 16)))
        sizes = 2e3 * np.sqrt((orders + rng.uniform(0, 1)) * WAVELENGTH * rng.uniform(0.5, 5.0))
        noisy = np.tile(sizes, 2) + 1e-3 * rng.normal(size=2 * len(orders))
        columns = {"order": np.tile(orders, 2), "diameter_mm": np.round(noisy, 2)}
        warnings = fitting.rings(columns, wavelength=WAVELENGTH).warnings
        suspected += any(words in text for text in warnings for words in _RIVALS)
    assert suspected <= 4  # of 1.5 expected, two standard deviations
