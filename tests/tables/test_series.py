"""Several series of one table: of different scale, counted apart, or of another size."""

import numpy as np
import pytest
from ring_tables import WAVELENGTH, rings_of, warned

import fitting


def test_series_of_different_scale_widen_the_budget():
    order, number = np.tile(np.arange(1, 11), 4), np.repeat([1, 2, 3, 4], 10)
    scale = np.array([1.01, 0.99, 1.005, 0.995])[number - 1]
    table = {"order": order, "diameter_mm": rings_of(order, noise=0.002) * scale, "series": number}
    result = fitting.rings(table, wavelength=WAVELENGTH)
    assert warned(result, "the series differ by more than their readings' errors")
    # The radius goes with the square of the scale; the mean of four.
    assert dict(result.budget)["series"] == pytest.approx(np.std(scale[::10] ** 2, ddof=1) / 2, rel=0.15)
    del table["series"]
    unnamed = fitting.rings(table, wavelength=WAVELENGTH)
    assert unnamed.radius_sd == pytest.approx(result.radius_sd)
    assert "each beginning anew" in unnamed.model["series"]


def test_series_counted_from_different_rings_have_an_intercept_each():
    order, number = np.tile(np.arange(3, 12), 3), np.repeat([0, 1, 2], 9)
    table = {"order": order + number, "diameter_mm": rings_of(order, noise=0.003), "series": number}
    result = fitting.rings(table, wavelength=WAVELENGTH)
    assert warned(result, "counted from different rings")
    assert abs(result.radius - 1.0) < 3 * result.radius_sd
    assert max(abs(ring.residual) for ring in result.rings) < 1e-5


@pytest.mark.parametrize("by_column", [True, False])
@pytest.mark.parametrize(
    ("count", "odd", "column", "words"),
    [
        (5, 4, "radius_mm", "is 4.0 times the others in r²: diameters among radii"),
        (2, 0, "radius_mm", "is 4.0 times the other in r²: diameters among radii"),
        (5, 0, "diameter_mm", "is 0.25 times the others in r²: radii among diameters"),
        (2, 1, "diameter_mm", "is 0.25 times the other in r²: radii among diameters"),
    ],
)
def test_a_series_of_another_size_is_named(count, odd, column, words, by_column):
    rng = np.random.default_rng(0)
    order, number = np.tile(np.arange(1.0, 13), count), np.repeat(np.arange(count), 12)
    sizes = np.sqrt(order * WAVELENGTH) * 1e3 * (1 if column == "radius_mm" else 2)
    factor = np.where(number == odd, 2 if column == "radius_mm" else 0.5, 1.0)
    columns = {"order": order, column: sizes * factor + 2e-3 * rng.normal(size=len(order))}
    if by_column:
        columns["series"] = np.array(list("abcde"))[number]
    result = fitting.rings(columns, wavelength=WAVELENGTH)
    name = "abcde"[odd] if by_column else str(odd + 1)
    assert result.status == "refused"
    assert result.message.startswith(f"series {name} {words}")


@pytest.mark.parametrize(
    ("factor", "ratio", "by_column"), [(1e3, "1.0e+06", True), (0.1, "0.010", True), (0.1, "0.010", False)]
)
def test_a_series_in_another_unit_is_named(factor, ratio, by_column):
    order, number = np.tile(np.arange(1, 10), 3), np.repeat([1, 2, 3], 9)
    columns = {"order": order, "diameter_mm": rings_of(order, noise=0.002) * np.where(number == 3, factor, 1.0)}
    if by_column:
        columns["series"] = number
    result = fitting.rings(columns, wavelength=WAVELENGTH)
    assert result.status == "refused"
    assert result.message.startswith(f"series 3 is {ratio} times the others in r²: another unit among the sizes")
