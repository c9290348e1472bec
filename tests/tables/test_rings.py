"""Tables of ring readings: published ones, exact ones, and ones with every fault that a reader makes."""

import csv
import json

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fitting
from fitting.shell import lamps
from fitting.shell.cli import main
from fitting.tables.line import ring_line
from fitting.tables.sample import Sample

WAVELENGTH = 589.3e-9


def table(radius=1.0, orders=range(1, 16), offset=0.0, wavelength=WAVELENGTH, noise=0.0, seed=0):
    """Exact diameters [mm] of a sphere's dark rings: its height h is the order's; r² = 2 R h - h²."""
    orders = np.array(list(orders), dtype=float)
    height = (orders + offset) * wavelength / 2
    diameters = 2e3 * np.sqrt(2 * radius * height - height**2)
    return {"order": orders, "diameter_mm": diameters + noise * np.random.default_rng(seed).normal(size=len(orders))}


# Name, arguments, radius and standard deviation [m] that the folder's README prints, and the last digit it prints.
PUBLISHED = [
    ("lens_1550mm", {"wavelength": 589e-9}, 1541.3, 4.4),
    ("oblique_22deg", {"wavelength": 547e-9, "view_angle": np.radians(22)}, 1150.0, None),
    ("lens_1000mm", {"wavelength": WAVELENGTH, "pixel_size": 1e-3 / 77.28}, 1076.0, None),
    ("repeats_rings_1_11", {"wavelength": WAVELENGTH}, 1062.4, 6.4),
]


@pytest.mark.parametrize(("name", "given", "radius", "sd"), PUBLISHED, ids=[row[0] for row in PUBLISHED])
def test_published_tables_give_their_published_radius(shared, name, given, radius, sd):
    result = fitting.rings(shared / "tables" / f"{name}.csv", **given)
    assert result.status == "ok"
    assert 1e3 * result.radius == pytest.approx(radius, abs=0.55 if radius > 1e3 else 0.5)
    if sd is not None:
        assert 1e3 * result.radius_sd == pytest.approx(sd, rel=0.015)


def test_reading_errors_as_large_as_the_rings_give_a_finite_radius_and_deviation(shared):
    result = fitting.rings(shared / "tables" / "coarse_microscope.csv", wavelength=590e-9)
    # The table's slope without its deviations is 113 +- 7 mm; its deviations allow three times as much.
    assert result.radius == pytest.approx(0.113, abs=0.007)
    assert 0.01 < result.radius_sd < 0.04


def test_a_misread_ring_is_flagged_and_not_averaged_away(shared):
    result = fitting.rings(shared / "tables" / "misread.csv", wavelength=WAVELENGTH)
    assert [bool(ring.flag) for ring in result.rings] == [False, False, True]
    assert any("misread" in text for text in result.warnings)
    # 848 +- 481 mm; three readings leave one degree of freedom, for which Student's 97.5 % quantile is 12.7.
    assert (result.status, result.radius) == ("refused", None)
    assert "below 6.96 m" in result.message
    assert "order 7 is the likeliest to be misread" in result.message


def test_diameters_in_place_of_radii_are_noticed_where_the_radius_is_roughly_known(shared):
    path, given = shared / "tables" / "radii_in_pixels.csv", {"wavelength": WAVELENGTH, "pixel_size": 33.3e-6}
    result = fitting.rings(path, pixel_size_sd=3e-6, expected_radius=0.47, **given)
    assert any("look like diameters" in text for text in result.warnings)
    right = fitting.rings(path, columns={"diameter_px": "radius_px"}, pixel_size_sd=3e-6, expected_radius=0.47, **given)
    assert not any("look like" in text for text in right.warnings)
    assert abs(right.radius - 0.47) < 2 * right.radius_sd


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


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ({"x": [1, 2], "diameter_mm": [1, 2]}, "no column 'order'"),
        ({"order": [1, 2], "size": [1, 2]}, "no ring sizes"),
        ({"order": [1, 2], "diameter_mm": [1, "x"]}, "'x' is not a number"),
        ({"order": [1, 2], "diameter_mm": [1, -2]}, "negative"),
        ({"order": [1, 2], "diameter_mm": [1, 2], "sd_mm": [0, 1]}, "above zero"),
        ({"order": [1, 2], "diameter_mm": [1]}, "different lengths"),
        ({"order": ["", ""], "diameter_mm": [1, 2]}, "complete"),
    ],
)
def test_tables_that_cannot_be_read_say_why(rows, words):
    with pytest.raises(ValueError, match=words):
        fitting.rings(rows, wavelength=WAVELENGTH)


@pytest.mark.parametrize(
    "wrong",
    [{"wavelength": 0.0}, {"wavelength": 589.3}, {"pixel_size_sd": 1e-7},
     {"view": "side"}, {"view_angle": 2.0}, {"gap_index": -1.0}, {"wavelength_sd": -1.0},
     {"columns": {"diameter_mm": "D"}}, {"gap_index": 0.1, "view_angle": 0.5}],
)  # fmt: skip
def test_arguments_out_of_range_are_refused(wrong):
    with pytest.raises(ValueError, match=r"allowed|index|column|without"):
        fitting.rings(table(), **{"wavelength": WAVELENGTH, **wrong})


def test_files_with_semicolons_commas_comments_and_gaps_are_read(tmp_path):
    file = tmp_path / "readings.csv"
    file.write_text("\ufeff# microscope 2\norder;left_mm;right_mm\n1;10,0;12,0\n\n2;9,6;\n3;9,0;13,0\n4;8,7;13,3\n")
    result = fitting.rings(file, wavelength=WAVELENGTH)
    assert [ring.radius for ring in result.rings] == pytest.approx([1e-3, 2e-3, 2.3e-3])
    assert any("empty cell" in text for text in result.warnings)


def test_columns_that_disagree_are_noted(tmp_path):
    rows = table()
    rows["left_mm"], rows["right_mm"] = 10 - rows["diameter_mm"] / 2, 10 + rows["diameter_mm"] / 2
    assert not fitting.rings(rows, wavelength=WAVELENGTH).warnings
    rows["diameter_mm"] = rows["diameter_mm"] * 1.05
    assert any("disagree by up to 5.0%" in text for text in fitting.rings(rows, wavelength=WAVELENGTH).warnings)


@given(st.lists(st.tuples(st.integers(0, 30), st.floats(0, 1e3)), min_size=2, max_size=12))
def test_any_table_of_numbers_gives_an_answer_or_a_reason(readings):
    order, diameter = zip(*readings, strict=True)
    try:
        result = fitting.rings({"order": order, "diameter_mm": diameter}, wavelength=WAVELENGTH)
    except ValueError:
        return
    assert result.status in ("ok", "refused")
    assert result.radius_interval is None or 0 < result.radius_interval[0] <= result.radius <= result.radius_interval[1]
    assert all(np.isfinite(ring.residual) for ring in result.rings)
    json.dumps(result.to_dict(), allow_nan=False)
    assert result.report()


def test_a_line_without_scatter_flags_nothing():
    order = np.arange(1.0, 9.0)
    ordinate = 2.0 * order + 0.5
    line = ring_line(Sample(order, np.sqrt(ordinate), ordinate, None), 0.0)
    assert (line.slope, line.intercept) == pytest.approx((2.0, 0.5), rel=1e-12)
    assert not any(line.flags)


def test_the_verb_prints_writes_and_exits(tmp_path, capsys):
    rows, file = table(noise=0.01), tmp_path / "rings.csv"
    with file.open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["ring", "D"])
        writer.writerows(zip(rows["order"], rows["diameter_mm"], strict=True))
    named = ["--column", "order=ring", "--column", "diameter_mm=D"]
    command = ["rings", str(file), "--wavelength", "589.3nm", *named]
    assert main([*command, "--json", "-"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["radius_m"] == pytest.approx(1.0, abs=4 * answer["radius_sd_m"])
    assert {"order", "radius_m", "residual_m", "flag"} == set(answer["rings"][0])
    assert main([*command, "--output-dir", str(tmp_path / "out")]) == 0
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"result.png", "report.txt", "result.json"}
    assert main([*command, "--output-dir", str(tmp_path / "out")]) == 2
    assert "--force" in capsys.readouterr().err
    assert main([*command, "--column", "radius"]) == 2
    assert main(["rings", str(tmp_path / "none.csv"), "--wavelength", "589.3nm"]) == 2
    assert "is not a file" in capsys.readouterr().err


@pytest.mark.parametrize("first", [1, 100, 2000])
def test_rings_of_a_steep_lens_give_its_radius(first):
    """Exact sphere: h = m λ / 2, r² = 2 R h - h²; the widest ring is at 0.97 of the radius."""
    order = np.arange(first, first + 600, 40)
    height = order * 589.3e-9 / 2
    lens = 1e-3
    result = fitting.rings({"order": order, "radius_m": np.sqrt(2 * lens * height - height**2)}, wavelength=589.3e-9)
    assert result.status == "ok"
    assert result.radius == pytest.approx(lens, rel=1e-9)


def written(tmp_path, text):
    path = tmp_path / "table.csv"
    path.write_text(text)
    return path


RINGS = "1,0.768\n2,1.086\n3,1.33\n4,1.535\n"


def test_the_column_that_is_named_is_the_one_that_counts(tmp_path):
    path = written(tmp_path, "sep=,\n # read twice\nOrder,diameter_mm\n" + RINGS)
    plain = fitting.rings(path, wavelength=589.3e-9)
    named = fitting.rings(path, wavelength=589.3e-9, columns={"radius_mm": "diameter_mm"})
    assert named.radius == pytest.approx(4 * plain.radius, rel=1e-5)  # the sag differs by (r/R)²


def test_standard_deviations_in_another_unit_count(tmp_path):
    rows = "".join(f"{row},5\n" for row in RINGS.split())
    um = fitting.rings(written(tmp_path, "order,diameter_mm,sd_um\n" + rows), wavelength=589.3e-9)
    rows = "".join(f"{row},0.005\n" for row in RINGS.split())
    mm = fitting.rings(written(tmp_path, "order,diameter_mm,sd_mm\n" + rows), wavelength=589.3e-9)
    assert um.radius_sd == pytest.approx(mm.radius_sd)
    rows = "".join(f"{row},5\n" for row in RINGS.split())
    odd = fitting.rings(written(tmp_path, "order,diameter_mm,sd_px\n" + rows), wavelength=589.3e-9)
    assert any("sd_px was not used" in text for text in odd.warnings)


@pytest.mark.parametrize(
    ("text", "columns", "message"),
    [
        ("order,diameter_mm,diameter_mm\n1,2,3\n2,3,4\n", None, "'diameter_mm' twice"),
        ("order,diameter_mm\n" + RINGS, {"foo": "diameter_mm"}, "cannot be named 'foo'"),
        ("order,diameter_mm\n" + RINGS, {"left_mm": "diameter_mm"}, "needs its partner"),
        ("order,diameter_mm\n1,1_54\n2,3\n", None, "is not a number"),
        ("order,radius_m\n1,1e200\n2,2e200\n", None, "beyond all rings"),
        ("order,radius_mm,sd_mm\n1,1,1e-300\n2,2,1\n3,3,1\n", None, "of one size"),
        ("order,radius_mm\n1e16,1\n1e17,2\n", None, "beyond all rings"),
    ],
)
def test_a_table_that_misleads_is_refused(tmp_path, text, columns, message):
    with pytest.raises(ValueError, match=message):
        fitting.rings(written(tmp_path, text), wavelength=589.3e-9, columns=columns)


@pytest.mark.parametrize(("name", "value"), [("wavelength", WAVELENGTH), ("pixel_size", 1e-5), ("view_angle", 0.4)])
def test_a_standard_deviation_may_be_a_percentage(name, value):
    rows = {"order": [1, 2, 3, 4], "radius_px": [77.0, 108.5, 132.9, 153.6], "sd_px": [0.1] * 4}
    given = {"wavelength": WAVELENGTH, "pixel_size": 1e-5, "view_angle": 0.4}
    percent, number = (fitting.rings(rows, **given, **{f"{name}_sd": sd}) for sd in ("2%", 0.02 * value))
    assert dict(percent.budget)[name] == pytest.approx(dict(number.budget)[name], rel=1e-12)
    with pytest.raises(ValueError, match="view_angle, which is 0"):
        fitting.rings(rows, **{**given, "view_angle": 0.0}, view_angle_sd="2%")


def test_the_lamp_brings_its_standard_deviation(tmp_path):
    path = written(tmp_path, "order,diameter_mm\n" + RINGS)
    budgets = []
    for name, options in (("lamp", []), ("zero", ["--wavelength-sd", "0nm"]), ("wide", ["--wavelength-sd", "0.6nm"])):
        answer = tmp_path / f"{name}.json"
        assert main(["rings", str(path), "--wavelength", "sodium", *options, "--json", str(answer)]) == 0
        result = json.loads(answer.read_text())
        budgets.append({row["source"]: row["sd_m"] / result["radius_m"] for row in result["budget"]})
    assert budgets[0]["wavelength"] == pytest.approx(lamps.wavelength("sodium").sd / 589.3e-9, rel=1e-3)
    assert "wavelength" not in budgets[1]
    assert budgets[2]["wavelength"] == pytest.approx(0.6 / 589.3, rel=1e-3)


def test_an_expected_radius_goes_with_differences_in_pixels():
    half = np.sqrt(np.arange(1.0, 9) * WAVELENGTH) / 1e-5 / 2
    columns = {"order": np.arange(1, 9), "left_px": 500 - half, "right_px": 500 + half}
    given = {"wavelength": WAVELENGTH, "pixel_size": 1e-5}
    assert fitting.rings(columns, expected_radius=0.26, **given).warnings == []
    (warning,) = fitting.rings(columns, expected_radius=1.0, **given).warnings
    assert "0.25 times the expected one" in warning
