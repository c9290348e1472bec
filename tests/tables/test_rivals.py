"""What contradicts a line of rings: each rival is met by tables of its kind, and not by honest ones."""

import re
import subprocess
import sys

import numpy as np
import pytest

import fitting
from fitting.shell.cli import main

WAVELENGTH = 589.3e-9


def rings_of(order, radius=1.0, noise=0.0, seed=0):
    """Diameters [mm] of a sphere's rings."""
    order = np.asarray(order, float)
    height = order * WAVELENGTH / 2
    diameter = 2e3 * np.sqrt(2 * radius * height - height**2)
    return diameter + noise * np.random.default_rng(seed).normal(size=len(order))


def measured(order, diameter, **arguments):
    return fitting.rings({"order": order, "diameter_mm": diameter}, **{"wavelength": WAVELENGTH, **arguments})


def warned(result, *words):
    return any(all(word in text for word in words) for text in result.warnings)


@pytest.mark.parametrize(("first", "spacing"), [(0.3, 0.3), (1.0, 0.045), (2.0, 0.5)])
@pytest.mark.parametrize("noise", [1e-4, 0.01])
def test_equidistant_fringes_are_refused_by_name(first, spacing, noise):
    order = np.arange(1, 26)
    diameter = first + spacing * order + noise * np.random.default_rng(1).normal(size=25)
    result = measured(order, diameter)
    assert (result.status, result.radius) == ("refused", None)
    assert "r is one: equidistant fringes, as of a wedge" in result.message


def test_a_surface_of_the_fourth_power_is_refused_by_name():
    order = np.arange(1, 20)
    result = measured(order, 2 * order**0.25 + 0.003 * np.random.default_rng(2).normal(size=19))
    assert result.status == "refused"
    assert "r⁴ is one: a surface of the fourth power" in result.message


def test_a_slight_bend_is_a_row_of_the_budget():
    order = np.arange(1, 25)
    diameter = rings_of(order, noise=0.002)
    diameter *= np.sqrt(1 + 0.002 * (order - 12))
    result = measured(order, diameter)
    assert result.status == "ok"
    assert warned(result, "not a straight line", "half of that change is in the budget")
    # y (1 + c (m - 12)) is a parabola whose slope changes by 2 c (24 - 1) over the table.
    assert dict(result.budget)["curvature"] == pytest.approx(0.002 * 23 * result.radius / (1 + 0.002 * 0.5), rel=0.05)


@pytest.mark.parametrize("rings", [1, 2, 3])
@pytest.mark.parametrize("noise", [0.002, 0.01])
def test_rings_missed_between_groups_do_not_pass(rings, noise):
    counted = np.concatenate([np.arange(10, 16), np.arange(30, 36)])
    result = measured(counted, rings_of(counted + rings * (counted > 20), noise=noise))
    words = f"if {rings} ring{'s were' if rings > 1 else ' was'} missed"
    assert warned(result, "set right") or warned(result, words) or warned(result, f"({rings} missed)")
    assert abs(result.radius - 1.0) < 4 * result.radius_sd or warned(result, "do not exclude a miscount")


def test_two_miscounts_in_three_groups_are_both_seen():
    counted = np.concatenate([np.arange(5, 10), np.arange(25, 30), np.arange(45, 50)])
    order = counted + (counted > 20) + 2 * (counted > 40)
    result = measured(counted, rings_of(order, noise=0.002))
    assert abs(result.radius - 1.0) < 4 * result.radius_sd
    assert [ring.flag.split(":")[0] for ring in result.rings[::5]] == [
        "",
        "counted 1 too low",
        "counted 2 too low",
    ] or (warned(result, "set right"))


def test_a_gap_that_leaves_the_count_open_says_what_a_ring_more_would_change():
    order = np.array([1, 2, 3, 24, 25, 26])
    result = measured(order, rings_of(order, noise=0.02))
    assert warned(result, "do not exclude a miscount between orders 3 and 24", "(1 missed)")
    every = np.arange(1, 27)
    assert not warned(measured(every, rings_of(every, noise=0.02)), "miscount")


@pytest.mark.parametrize(("stated", "words"), [(0.1, "10 times as far"), (10.0, "0.1 times as far")])
def test_scatter_is_compared_with_what_is_stated_to_both_sides(stated, words):
    order = np.arange(1, 21)
    table = {"order": order, "diameter_mm": rings_of(order, noise=0.01), "sd_mm": np.full(20, 0.01 * stated)}
    result = fitting.rings(table, wavelength=WAVELENGTH)
    (text,) = [text for text in result.warnings if "stated sd" in text]
    factor = float(text.split("scatter ")[1].split(" times")[0])
    assert factor == pytest.approx(float(words.split()[0]), rel=0.4)
    assert ("by their scatter" in text) == (stated > 1)
    honest = fitting.rings({**table, "sd_mm": np.full(20, 0.01)}, wavelength=WAVELENGTH)
    assert not warned(honest, "stated sd")


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


@pytest.mark.parametrize(("factor", "words"), [(1e3, "mm looks like um"), (0.1, "mm looks like cm")])
def test_a_unit_that_makes_no_lens_is_doubted(factor, words):
    order = np.arange(1, 12)
    result = measured(order, factor * rings_of(order, radius=0.05, noise=1e-4))
    text = " ".join([*result.warnings, result.message])
    assert "beyond 0.001 to 1000 m" in text
    if factor > 1:
        proposed = float(text.split(f"{words}; if so, the radius is ")[1].split()[0])
        assert proposed == pytest.approx(0.05, rel=1e-3)


@pytest.mark.parametrize(
    ("column", "factor", "proposal"),
    [("radius_mm", 2, "radii look like diameters"), ("diameter_mm", 0.5, "diameters look like radii"),
     ("diameter_mm", 10, "mm looks like cm"), ("radius_mm", 1e3, "mm looks like um")],
)  # fmt: skip
def test_a_rough_radius_tells_what_was_mistaken(column, factor, proposal):
    order = np.arange(1, 12)
    sizes = rings_of(order, noise=1e-4) / (2 if column == "radius_mm" else 1)
    table = {"order": order, column: factor * sizes}
    result = fitting.rings(table, wavelength=WAVELENGTH, expected_radius=1.2)
    text = " ".join([*result.warnings, result.message])
    if proposal != "mm looks like cm":
        assert f"what the table calls {proposal}; if so, the radius is 1" in text
    honest = fitting.rings({"order": order, column: sizes}, wavelength=WAVELENGTH, expected_radius=1.2)
    assert not honest.warnings


@pytest.mark.parametrize(
    ("factor", "words"),
    [(0.5, "at twice their size: they look like radii among diameters"),
     (2.0, "at half their size: they look like diameters among radii")],
)  # fmt: skip
@pytest.mark.parametrize("first", [4, 8, 13])
def test_radii_among_diameters_are_told_by_their_size(factor, words, first):
    order = np.arange(1, 16)
    diameter = rings_of(order, noise=0.002)
    result = measured(order, np.where(order >= first, factor * diameter, diameter))
    assert result.status == "refused"
    assert f"the readings from order {first} on lie on the line {words}" in result.message
    proposed = float(result.message.split("the radius is then ")[1].split()[0])
    assert proposed == pytest.approx(1.0, abs=0.005)


def test_a_single_radius_among_diameters_is_named():
    order = np.arange(1, 16)
    diameter = rings_of(order, noise=0.002)
    result = measured(order, np.where(order == 9, diameter / 2, diameter))
    assert "1 of the readings left out lies on the line at twice the size: radii among diameters?" in result.warnings
    assert result.radius == pytest.approx(1.0, abs=0.005)
    diameter[4] += 0.2
    assert not warned(measured(order, diameter), "among")


def test_a_known_radius_gives_the_wavelength_with_its_budget():
    order = np.arange(1, 15)
    table = {"order": order, "diameter_mm": rings_of(order, noise=0.003)}
    result = fitting.rings(table, radius=1.0, radius_sd=0.002)
    assert abs(result.wavelength - WAVELENGTH) < 3 * result.wavelength_sd
    assert dict(result.budget)["radius"] == pytest.approx(0.002 * result.wavelength)
    assert result.wavelength_interval[0] < result.wavelength < result.wavelength_interval[1]
    inverse = fitting.rings(table, wavelength=result.wavelength)
    assert inverse.radius == pytest.approx(1.0, rel=1e-9)
    assert "wavelength = 5.8" in result.report()


def test_a_steep_lens_of_known_radius_is_a_sphere():
    order = np.arange(100, 700, 40)
    result = measured(order, rings_of(order, radius=1e-3), wavelength=None, radius=1e-3)
    assert result.wavelength == pytest.approx(WAVELENGTH, rel=1e-9)


def test_equal_readings_and_a_large_one_are_refused():
    for diameters in ([2.0, 2.0, 2.0, 2.0, 900.0], [2.0] * 5, [2.0, 2.0, 2.0, 2.0, 1e5]):
        result = measured(np.arange(1, 6), diameters)
        assert result.status == "refused"
        assert "f(a)" not in result.message


def test_refusals_of_the_command_name_the_reason(tmp_path, capsys):
    path = tmp_path / "wedge.csv"
    path.write_text("order,diameter (mm)\n" + "".join(f"{m},{0.5 + 0.1 * m}\n" for m in range(1, 20)))
    assert main(["rings", str(path), "--wavelength", "sodium"]) == 3
    assert "equidistant fringes" in capsys.readouterr().err
    path.write_text("order,diameter (mm)\n1,2.54\n5,3.53\n")
    assert main(["rings", str(path), "--radius", "672.41mm", "--radius-sd", "2mm"]) == 0
    assert "wavelength = 5.585" in capsys.readouterr().out
    assert main(["rings", str(path)]) == 2
    assert "give wavelength to measure the radius" in capsys.readouterr().err


def test_a_table_of_a_hundred_thousand_rows_takes_seconds(tmp_path):
    rng = np.random.default_rng(3)
    order = rng.integers(1, 40, 100_000)
    radius = np.sqrt(order * WAVELENGTH) + 1e-5 * rng.normal(size=len(order))
    radius[::100] *= rng.uniform(0.5, 1.5, 1000)
    rows = "".join(f"{m},{1e3 * r:.6f}\n" for m, r in zip(order, radius, strict=True))
    path = tmp_path / "rings.csv"
    path.write_text("order,radius_mm\n" + rows)
    program = (
        "import sys, time, fitting; began = time.process_time(); "
        f"result = fitting.rings(sys.argv[1], wavelength={WAVELENGTH}); result.report(); result.to_dict(); "
        "print(time.process_time() - began, result.radius, result.radius_sd)"
    )
    command = [sys.executable, "-c", program, str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    seconds, value, sd = map(float, done.stdout.split())
    assert abs(value - 1.0) < 4 * sd
    # Of processor time; a matrix of rows by rows would not fit into memory (80 GB), a loop over them takes an hour.
    assert seconds < 13


def _steep(orders):
    """Exact diameters [mm] of a ball of 1 mm radius, whose outer rings are a quarter as wide as it is."""
    height = orders * WAVELENGTH / 2
    return 2e3 * np.sqrt(2 * 1e-3 * height - height**2)


@pytest.mark.parametrize("shift", [0, 8, 40])
@pytest.mark.parametrize("by_column", [True, False])
def test_series_of_a_steep_lens_may_be_counted_apart(shift, by_column):
    orders = np.arange(5.0, 101, 5)
    columns = {"order": np.concatenate([orders, orders + shift]), "diameter_mm": np.tile(_steep(orders), 2)}
    if by_column:
        columns["series"] = np.repeat([1, 2], len(orders))
    result = fitting.rings(columns, wavelength=WAVELENGTH)
    assert result.radius == pytest.approx(1e-3, rel=1e-12)
    assert [text for text in result.warnings if "counted from different rings" not in text] == []


@pytest.mark.parametrize("place", [2, 10, 18])
@pytest.mark.parametrize("factor", [0.7, 1.3])
def test_a_misread_ring_of_a_steep_lens_is_left_out(place, factor):
    orders = np.arange(5.0, 101, 5)
    sizes = _steep(orders)
    sizes[place] *= factor
    result = fitting.rings({"order": orders, "diameter_mm": sizes}, wavelength=WAVELENGTH)
    assert result.radius == pytest.approx(1e-3, rel=1e-12)
    assert [ring.order for ring in result.rings if ring.flag] == [orders[place]]


def test_a_miscount_of_a_steep_lens_is_set_right():
    orders = np.arange(5.0, 101, 5)
    columns = {"order": orders - 3 * (orders > 50), "diameter_mm": _steep(orders)}
    result = fitting.rings(columns, wavelength=WAVELENGTH)
    assert result.radius == pytest.approx(1e-3, rel=1e-12)
    assert any("set right" in text for text in result.warnings)


def test_pixels_without_a_scale_are_warned_of_in_shares():
    order = np.concatenate([np.arange(1.0, 8), np.arange(20.0, 27)])
    noise = 0.3 * np.random.default_rng(0).normal(size=14)
    columns = {"order": order, "radius_px": 100 * np.sqrt(order) + noise, "sd_px": np.full(14, 3.0)}
    text = " ".join(fitting.rings(columns, wavelength=WAVELENGTH).warnings)
    assert "% smaller (1 missed)" in text
    assert "% larger (1 counted twice)" in text
    assert not re.search(r"\d m\b", text)
    in_metres = fitting.rings(columns, wavelength=WAVELENGTH, pixel_size=1e-5)
    missed = float(re.search(r"([\d.]+) m \(1 missed", " ".join(in_metres.warnings))[1])
    share = float(re.search(r"([\d.]+) % smaller", text)[1])
    assert share == pytest.approx(100 * (1 - missed / in_metres.radius), abs=0.1)


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


def test_repeats_that_are_rounded_alike_share_no_error():
    # Five series of one observer, read to half of the spacing of the outer rings: all equal, and off by up to 0.05 mm.
    order = np.tile(np.arange(3.0, 15.0), 5)
    diameters = np.round(2e3 * np.sqrt(order * WAVELENGTH), 1)
    result = fitting.rings({"order": order, "diameter_mm": diameters}, wavelength=WAVELENGTH)
    assert not warned(result, "readings of one ring agree")
    assert not warned(result, "than counted")
    # What the rings share beyond that is said as ever: here each ring's own 0.05 mm, read to a micrometre.
    shift = np.tile(0.05 * np.random.default_rng(0).normal(size=12), 5)
    fine = np.round(2e3 * np.sqrt(order * WAVELENGTH) + shift + 1e-3 * np.random.default_rng(1).normal(size=60), 3)
    assert warned(fitting.rings({"order": order, "diameter_mm": fine}, wavelength=WAVELENGTH), "readings of one ring")
