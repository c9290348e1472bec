"""A given quantity without a standard deviation: the report says first what the error bar lacks, and by how much."""

import json

import pytest
from rings_data import WAVELENGTH, rings

import fitting

IMAGE = rings(noise=0.02)
GIVEN = {"wavelength": WAVELENGTH, "pixel_size": 5e-6}


def beneath_the_answer(result):
    lines = result.report().splitlines()
    (at,) = [row for row, text in enumerate(lines) if text.strip().startswith(f"{result.measured} = ")]
    return lines[at + 1].strip()


def test_what_the_image_alone_says_is_said_to_be_so_right_beneath_the_radius():
    line = beneath_the_answer(fitting.fit(IMAGE, wavelength_sd=0.0, **GIVEN))
    assert line == (
        "± is of the image alone: pixel_size has no standard deviation; 1 % of pixel_size is 2 % of radius, 6 mm"
    )


@pytest.mark.parametrize("name", ["wavelength", "pixel_size", "gap_index"])
def test_a_percent_of_what_is_given_moves_the_radius_by_what_is_stated(name):
    given = GIVEN | {"gap_index": 1.001}
    result = fitting.fit(IMAGE, **given)
    moved = fitting.fit(IMAGE, **(given | {name: 1.01 * given[name]}))
    # To first order: the square of one percent is left.
    assert result.per_percent[name] == pytest.approx(abs(moved.radius - result.radius), rel=0.02)


def test_on_a_curved_plate_a_percent_moves_the_lenss_own_radius():
    given = GIVEN | {"plate_radius": -0.5}
    result, moved = (fitting.fit(IMAGE, **(given | {"pixel_size": size})) for size in (5e-6, 5.05e-6))
    assert result.per_percent["pixel_size"] == pytest.approx(abs(moved.radius - result.radius), rel=0.03)


def test_what_has_a_standard_deviation_is_not_named_and_air_has_none_to_give():
    assert not fitting.fit(IMAGE, wavelength_sd="0.1%", pixel_size_sd="1%", **GIVEN).per_percent
    line = beneath_the_answer(fitting.fit(IMAGE, pixel_size_sd="1%", **GIVEN))
    assert line.startswith("± does not include all: wavelength has no standard deviation; 1 % of wavelength is 1 % of ")
    line = beneath_the_answer(fitting.fit(IMAGE, wavelength=WAVELENGTH, radius=0.3))
    assert "radius and wavelength have no" in line or "wavelength and radius have no" in line
    assert "1 % of radius is 0.5 % of pixel_size, 25 nm" in line


def test_a_loaded_result_says_the_same(tmp_path):
    result = fitting.fit(IMAGE, **GIVEN)
    result.save(tmp_path / "fit.json")
    assert json.loads((tmp_path / "fit.json").read_text())["per_percent"]["pixel_size"] == pytest.approx(
        0.006, rel=0.01
    )
    assert beneath_the_answer(fitting.FitResult.load(tmp_path / "fit.json")) == beneath_the_answer(result)
