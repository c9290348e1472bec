"""Tables that went wrong elsewhere, each with its right outcome; their README says where the numbers come from."""

import numpy as np
import pytest

import fitting

SODIUM = 589.3e-9


def of_trial(shared, name, **arguments):
    return fitting.rings(shared / "trials" / f"{name}.csv", **arguments)


def said(result, *words):
    return any(all(word in text for word in words) for text in [*result.warnings, result.message])


def test_equidistant_fringes_are_no_rings(shared):
    result = of_trial(shared, "wedge_not_rings", wavelength=SODIUM)
    assert (result.status, result.radius) == ("refused", None)
    assert "curvature of +51.0 standard deviations" in result.message
    assert "equidistant fringes, as of a wedge" in result.message
    assert not said(result, "set right")


def test_rings_missed_between_groups_are_counted(shared):
    result = of_trial(shared, "miscounted_between_groups", wavelength=SODIUM)
    # Inside of the groups 895 +- 27 and 863 +- 16 mm; weighted 871 +- 14.
    assert result.radius == pytest.approx(0.875, abs=0.008)
    assert result.radius_sd == pytest.approx(0.014, abs=0.004)
    assert said(result, "up to order 25 and from order 40 on", "2 rings were missed", "3 rings were missed")


def test_coarse_diameters_look_like_radii_where_a_rough_radius_says_so(shared):
    plain = of_trial(shared, "coarse_diameters_465nm", wavelength=465e-9)
    assert plain.radius == pytest.approx(0.0792, abs=0.003)
    assert plain.radius_sd == pytest.approx(0.011, abs=0.001)
    assert not said(plain, "look like")
    rough = of_trial(shared, "coarse_diameters_465nm", wavelength=465e-9, expected_radius=0.35)
    assert said(rough, "what the table calls diameters look like radii; if so, the radius is 0.3168 m")


def test_a_stated_deviation_far_above_the_scatter_is_noted(shared):
    result = of_trial(shared, "half_divisions_590nm", wavelength=590e-9)
    assert result.radius == pytest.approx(0.2486, abs=0.3 * 0.034)
    assert said(result, "scatter 0.035 times as far as their stated sd", "by their scatter the radius's sd is 0.0016 m")
    assert said(result, "1 reading of radius 0 (order 0): the centre, no ring; left out")


def test_series_that_share_the_error_of_each_ring_are_not_independent_readings(shared):
    result = of_trial(shared, "three_series", wavelength=SODIUM)
    # One radius from each series' own line by polyfit: 884.23, 883.90, 885.61 mm, each to +- 5 to 7.
    assert result.radius == pytest.approx(0.8846, abs=1e-3)
    assert 0.005 < result.radius_sd < 0.008
    assert dict(result.budget)["series"] == pytest.approx(
        np.std([0.88423, 0.88390, 0.88561], ddof=1) / 3**0.5, rel=0.02
    )
    assert result.model["series"].startswith("3, by their column; radius [m] of each, 1: 0.8842")
    assert said(result, "readings of one ring agree")


def test_an_ordinary_table_keeps_its_slope(shared):
    result = of_trial(shared, "lens_890mm", wavelength=SODIUM)
    assert (result.radius, result.radius_sd) == pytest.approx((0.8865, 0.0100), abs=1e-4)


def test_the_centre_is_no_ring(shared):
    result = of_trial(shared, "radii_with_ring_zero", wavelength=SODIUM)
    assert (result.radius, result.radius_sd) == pytest.approx((0.5397, 0.0090), abs=1e-4)
    assert result.order_offset == pytest.approx(1.52, abs=0.01)
    assert not any(ring.flag for ring in result.rings)
    assert max(abs(ring.residual) for ring in result.rings) < 0.2e-3
    assert said(result, "4 readings of radius 0 (order 0): the centre, no ring; left out")


def test_a_known_radius_measures_the_wavelength(shared):
    result = of_trial(shared, "two_rings_known_radius", radius=0.67241, radius_sd=2e-3)
    # (3.53² - 2.54²) mm² / (4 · 4 · 672.41 mm)
    assert result.wavelength == pytest.approx(558.5e-9, abs=0.1e-9)
    assert (result.measured, result.radius, result.wavelength_sd) == ("wavelength", None, None)


def test_positions_of_straight_fringes_are_no_ring_sizes(shared):
    with pytest.raises(
        ValueError,
        match="position_mm: positions of straight fringes, as of a wedge, give no radius, but the wedge",
    ):
        of_trial(shared, "wedge_hair", wavelength=SODIUM)


def test_one_reading_of_four_is_left_out_and_both_sides_are_named(shared):
    result = of_trial(shared, "four_series_one_misread", wavelength=547e-9, view_angle=np.radians(22))
    assert (result.radius, result.radius_sd) == pytest.approx((1.1607, 0.0067), abs=1e-4)
    assert said(result, "1 reading (1 of 4 of order 3) lies off the line of the others and was left out")
    assert "read from left_mm and right_mm" in result.model["rings"]
