"""The radius from exact tables and from ones with errors: its law, its interval, its budget."""

import mpmath
import numpy as np
import pytest
from ring_tables import WAVELENGTH, table

import fitting
from fitting.tables.line import ring_line
from fitting.tables.sample import Sample


@pytest.mark.parametrize("radius", [1e-3, 0.05, 1.0, 50.0])
@pytest.mark.parametrize("offset", [0.0, 0.3, 4.0, -0.5])
def test_an_exact_sphere_gives_its_radius_whatever_the_first_order(radius, offset):
    result = fitting.rings(table(radius, offset=offset), wavelength=WAVELENGTH)
    assert result.radius == pytest.approx(radius, rel=1e-9)
    assert result.order_offset == pytest.approx(offset, abs=1e-6)


def test_contact_of_either_view_and_of_bright_rings_is_offset_zero():
    for view, bright, offset in (
        ("reflected", False, 0.0), ("transmitted", True, 0.0), ("transmitted", False, -0.5), ("reflected", True, -0.5)
    ):  # fmt: skip
        result = fitting.rings(table(offset=offset), wavelength=WAVELENGTH, view=view, bright=bright)
        assert result.order_offset == pytest.approx(0.0, abs=1e-9)
        assert result.gap == pytest.approx(0.0, abs=1e-15)


def test_a_liquid_and_an_oblique_view_follow_snells_law_at_fifty_digits():
    with mpmath.workdps(50):
        index, angle, radius = mpmath.mpf("1.333"), mpmath.radians(35), mpmath.mpf(2)
        cosine = mpmath.cos(mpmath.asin(mpmath.sin(angle) / index))
        heights = [m * mpmath.mpf(WAVELENGTH) / (2 * index * cosine) for m in range(1, 12)]
        diameters = [float(2000 * mpmath.sqrt(2 * radius * h - h * h)) for h in heights]
    rows = {"order": range(1, 12), "diameter_mm": diameters}
    result = fitting.rings(rows, wavelength=WAVELENGTH, gap_index=1.333, view_angle=np.radians(35))
    assert result.radius == pytest.approx(2.0, rel=1e-10)


def test_budget_rows_are_the_derivatives_of_the_radius():
    given = {"wavelength": WAVELENGTH, "gap_index": 1.333, "view_angle": 0.4, "pixel_size": 1e-5}
    exact = table(noise=0.01)
    rows = {"order": exact["order"], "diameter_px": exact["diameter_mm"] * 100}
    sds = {"wavelength": 1e-10, "pixel_size": 1e-7, "gap_index": 1e-3, "view_angle": 1e-3}
    result = fitting.rings(rows, **given, **{f"{name}_sd": sd for name, sd in sds.items()})
    for name, sd in sds.items():
        both = [fitting.rings(rows, **{**given, name: given[name] + sign * 1e-3 * sd}).radius for sign in (1, -1)]
        assert dict(result.budget)[name] == pytest.approx(abs(both[0] - both[1]) / 2e-3, rel=1e-4)
    assert result.radius_sd == pytest.approx(np.sqrt(sum(sd**2 for _, sd in result.budget)), rel=1e-12)


def test_intervals_cover_the_truth_as_often_as_they_say():
    inside, count = 0, 400
    for seed in range(count):
        result = fitting.rings(table(orders=range(1, 9), noise=0.02, seed=seed), wavelength=WAVELENGTH)
        inside += result.radius_interval[0] < 1.0 < result.radius_interval[1]
    # Equal errors of the diameters are not equal errors of their squares; binomial sd 1.1 %.
    assert 0.91 <= inside / count <= 0.985


def test_honest_tables_are_seldom_flagged():
    flagged = sum(
        any(ring.flag for ring in fitting.rings(table(noise=0.02, seed=seed), wavelength=WAVELENGTH).rings)
        for seed in range(300)
    )
    assert flagged <= 12


@pytest.mark.parametrize("wrong", [0, 7, 14])
def test_one_misread_ring_is_flagged_and_left_out(wrong):
    rows = table(noise=0.005)
    rows["diameter_mm"][wrong] += 0.35
    result = fitting.rings(rows, wavelength=WAVELENGTH)
    assert [k for k, ring in enumerate(result.rings) if ring.flag] == [wrong]
    assert abs(result.radius - 1.0) < 4 * result.radius_sd
    assert any("left out" in text for text in result.warnings)


@pytest.mark.parametrize(("first", "step"), [(5, 1), (9, -1), (12, 2)])
def test_a_skipped_or_doubled_count_is_set_right(first, step):
    rows = table(noise=0.003)
    rows["order"] = np.where(rows["order"] >= first, rows["order"] - step, rows["order"])
    result = fitting.rings(rows, wavelength=WAVELENGTH)
    assert [bool(ring.flag) for ring in result.rings] == [m >= first for m in range(1, 16)]
    assert abs(result.radius - 1.0) < 4 * result.radius_sd
    assert any("miscounted" in text for text in result.warnings)


def test_stated_deviations_weigh_the_readings():
    rows = table(noise=0.0)
    rows["sd_mm"] = np.full(15, 0.02)
    result = fitting.rings(rows, wavelength=WAVELENGTH)
    variance = (2 * rows["diameter_mm"] * 0.02) ** 2 / 16 + 2 * 0.01**4
    design = np.stack([rows["order"], np.ones(15)], axis=1) / np.sqrt(variance)[:, None]
    slope_sd = np.sqrt(np.linalg.inv(design.T @ design)[0, 0]) * 1e-6
    assert result.slope_sd == pytest.approx(slope_sd, rel=1e-6)
    assert result.radius_interval[1] - result.radius == pytest.approx(1.96 * result.radius_sd, rel=1e-3)


def test_two_rings_give_a_radius_without_a_deviation():
    result = fitting.rings(table(orders=(2, 9)), wavelength=WAVELENGTH)
    assert result.radius == pytest.approx(1.0, rel=1e-9)
    assert (result.radius_sd, result.radius_interval) == (None, None)
    assert any("no standard deviation" in text for text in result.warnings)


def test_what_gives_no_radius_is_refused():
    once = fitting.rings({"order": [3, 3], "diameter_mm": [2.0, 2.1]}, wavelength=WAVELENGTH)
    falling = fitting.rings({"order": [3, 2, 1], "diameter_mm": [2.0, 2.5, 3.0]}, wavelength=WAVELENGTH)
    assert (once.status, falling.status) == ("refused", "refused")
    assert "two orders" in once.message
    assert "outwards" in falling.message


def test_pixels_without_a_scale_give_the_fringe_scale():
    rows = table()
    result = fitting.rings({"order": rows["order"], "radius_px": rows["diameter_mm"] * 50}, wavelength=WAVELENGTH)
    assert (result.status, result.radius) == ("no-scale", None)
    # Without a scale there is no sphere, which differs from r² by (r/R)²/2, 2e-6.
    assert result.fringe_scale_per_px2 == pytest.approx(1e-10 / WAVELENGTH, rel=1e-5)


def test_a_line_without_scatter_flags_nothing():
    order = np.arange(1.0, 9.0)
    ordinate = 2.0 * order + 0.5
    line = ring_line(Sample(order, np.sqrt(ordinate), ordinate, None), 0.0)
    assert (line.slope, line.intercept) == pytest.approx((2.0, 0.5), rel=1e-12)
    assert not any(line.flags)


@pytest.mark.parametrize(("name", "value"), [("wavelength", WAVELENGTH), ("pixel_size", 1e-5), ("view_angle", 0.4)])
def test_a_standard_deviation_may_be_a_percentage(name, value):
    rows = {"order": [1, 2, 3, 4], "radius_px": [77.0, 108.5, 132.9, 153.6], "sd_px": [0.1] * 4}
    given = {"wavelength": WAVELENGTH, "pixel_size": 1e-5, "view_angle": 0.4}
    percent, number = (fitting.rings(rows, **given, **{f"{name}_sd": sd}) for sd in ("2%", 0.02 * value))
    assert dict(percent.budget)[name] == pytest.approx(dict(number.budget)[name], rel=1e-12)
    with pytest.raises(ValueError, match="view_angle, which is 0"):
        fitting.rings(rows, **{**given, "view_angle": 0.0}, view_angle_sd="2%")


def test_an_expected_radius_goes_with_differences_in_pixels():
    half = np.sqrt(np.arange(1.0, 9) * WAVELENGTH) / 1e-5 / 2
    columns = {"order": np.arange(1, 9), "left_px": 500 - half, "right_px": 500 + half}
    given = {"wavelength": WAVELENGTH, "pixel_size": 1e-5}
    assert fitting.rings(columns, expected_radius=0.26, **given).warnings == []
    (warning,) = fitting.rings(columns, expected_radius=1.0, **given).warnings
    assert "0.25 times the expected one" in warning
