"""Units, and radii for diameters, that a table mistakes: doubted where the answer is none of a lens."""

import re

import numpy as np
import pytest
from ring_tables import WAVELENGTH, measured, rings_of, warned

import fitting


@pytest.mark.parametrize(("factor", "words"), [(1e3, "mm looks like um"), (0.1, "mm looks like cm")])
def test_a_unit_that_makes_no_lens_is_doubted(factor, words):
    order = np.arange(1, 12)
    result = measured(order, factor * rings_of(order, radius=0.05, noise=1e-4))
    text = " ".join([*result.warnings, result.message])
    assert "beyond 0.001 to 1000 m" in text
    if factor > 1:
        proposed = float(text.split(f"{words}; if so, the radius is ")[1].split()[0])
        assert proposed == pytest.approx(0.05, rel=1e-3)


def test_an_index_that_nothing_has_is_doubted_and_falls_with_the_square_of_the_sizes():
    """Rings of a lens of 1.2 m in air, whose radius is given as 0.6 m; and their radii called diameters, index 1."""
    order = np.arange(1, 12)
    sizes = rings_of(order, radius=1.2, noise=1e-4)
    of_index = {"wavelength": WAVELENGTH}
    lens = fitting.rings({"order": order, "diameter_mm": sizes}, radius=0.6, **of_index)
    assert any("the gap index of 0.5 is beyond 0.9 to 2.5" in text for text in lens.warnings)
    halved = fitting.rings({"order": order, "diameter_mm": sizes / 2}, radius=1.2, **of_index)
    assert any("look like radii; if so, the gap index is 1 " in f"{text} " for text in halved.warnings), halved.warnings
    assert not fitting.rings({"order": order, "diameter_mm": sizes}, radius=1.2, **of_index).warnings


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


def test_equal_readings_and_a_large_one_are_refused():
    for diameters in ([2.0, 2.0, 2.0, 2.0, 900.0], [2.0] * 5, [2.0, 2.0, 2.0, 2.0, 1e5]):
        result = measured(np.arange(1, 6), diameters)
        assert result.status == "refused"
        assert "f(a)" not in result.message


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
