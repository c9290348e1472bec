"""Rings of a lens that is steep where they lie: a sphere, misread rings and miscounts on it, its series."""

import numpy as np
import pytest
from ring_tables import WAVELENGTH, measured, rings_of, steep

import fitting


@pytest.mark.parametrize("first", [1, 100, 2000])
def test_rings_of_a_steep_lens_give_its_radius(first):
    """Exact sphere: h = m λ / 2, r² = 2 R h - h²; the widest ring is at 0.97 of the radius."""
    order = np.arange(first, first + 600, 40)
    height = order * 589.3e-9 / 2
    lens = 1e-3
    result = fitting.rings({"order": order, "radius_m": np.sqrt(2 * lens * height - height**2)}, wavelength=589.3e-9)
    assert result.status == "ok"
    assert result.radius == pytest.approx(lens, rel=1e-9)


def test_a_steep_lens_of_known_radius_is_a_sphere():
    order = np.arange(100, 700, 40)
    result = measured(order, rings_of(order, radius=1e-3), wavelength=None, radius=1e-3)
    assert result.wavelength == pytest.approx(WAVELENGTH, rel=1e-9)


@pytest.mark.parametrize("shift", [0, 8, 40])
@pytest.mark.parametrize("by_column", [True, False])
def test_series_of_a_steep_lens_may_be_counted_apart(shift, by_column):
    orders = np.arange(5.0, 101, 5)
    columns = {"order": np.concatenate([orders, orders + shift]), "diameter_mm": np.tile(steep(orders), 2)}
    if by_column:
        columns["series"] = np.repeat([1, 2], len(orders))
    result = fitting.rings(columns, wavelength=WAVELENGTH)
    assert result.radius == pytest.approx(1e-3, rel=1e-12)
    assert [text for text in result.warnings if "counted from different rings" not in text] == []


@pytest.mark.parametrize("place", [2, 10, 18])
@pytest.mark.parametrize("factor", [0.7, 1.3])
def test_a_misread_ring_of_a_steep_lens_is_left_out(place, factor):
    orders = np.arange(5.0, 101, 5)
    sizes = steep(orders)
    sizes[place] *= factor
    result = fitting.rings({"order": orders, "diameter_mm": sizes}, wavelength=WAVELENGTH)
    assert result.radius == pytest.approx(1e-3, rel=1e-12)
    assert [ring.order for ring in result.rings if ring.flag] == [orders[place]]


def test_a_miscount_of_a_steep_lens_is_set_right():
    orders = np.arange(5.0, 101, 5)
    columns = {"order": orders - 3 * (orders > 50), "diameter_mm": steep(orders)}
    result = fitting.rings(columns, wavelength=WAVELENGTH)
    assert result.radius == pytest.approx(1e-3, rel=1e-12)
    assert any("set right" in text for text in result.warnings)
