"""What contradicts a line of rings: each rival is met by tables of its kind, and not by honest ones."""

import subprocess
import sys

import numpy as np
import pytest
from ring_tables import WAVELENGTH, measured, rings_of, warned

import fitting


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


def test_a_known_radius_gives_the_wavelength_with_its_budget():
    order = np.arange(1, 15)
    table = {"order": order, "diameter_mm": rings_of(order, noise=0.003)}
    result = fitting.rings(table, radius=1.0, radius_sd=0.002)
    assert abs(result.wavelength - WAVELENGTH) < 3 * result.wavelength_sd
    assert dict(result.budget)["radius"] == pytest.approx(0.002 * result.wavelength)
    assert result.wavelength_interval[0] < result.wavelength < result.wavelength_interval[1]
    inverse = fitting.rings(table, wavelength=result.wavelength)
    assert inverse.radius == pytest.approx(1.0, rel=1e-9)
    assert "wavelength = 588.5 ± 1.2 nm" in result.report()


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
