"""Positions of straight fringes: the wedge's angle and thickness within their intervals, and what contradicts them."""

import numpy as np
import pytest
from shell import refusal

import fitting
from fitting.shell.cli import main

WAVELENGTH = 589.3e-9
ANGLE = 2e-3
SPACING = WAVELENGTH / (2 * np.tan(ANGLE))


def table(count=25, noise=10e-6, seed=0, sign=1.0, **columns):
    order = np.arange(3, count + 3)
    position = 5e-3 + sign * SPACING * order + noise * np.random.default_rng(seed).normal(size=count)
    return {"order": order, "position_mm": np.round(1e3 * position, 3), **columns}


def test_a_hair_between_two_plates_has_the_thickness_that_was_measured(shared):
    result = fitting.wedge(shared / "trials" / "wedge_hair.csv", wavelength=WAVELENGTH, length=42.65e-3)
    assert (result.spacing, result.spacing_sd) == pytest.approx((0.1354e-3, 0.0002e-3), abs=0.5e-7)
    assert result.wedge_angle == pytest.approx(2.177e-3, abs=1e-6)
    assert (result.thickness, result.thickness_sd) == pytest.approx((92.8e-6, 0.2e-6), abs=0.06e-6)
    # The first readings of the table lie apart from its line.
    assert any("the spacing changes by +4.3%" in text for text in result.warnings)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_intervals_of_angle_and_thickness_cover_in_either_direction(sign):
    results = [fitting.wedge(table(seed=k, sign=sign), wavelength=WAVELENGTH, length=0.04) for k in range(200)]
    inside = [low < ANGLE < high for low, high in (result.wedge_angle_interval for result in results)]
    thick = [low < 0.04 * np.tan(ANGLE) < high for low, high in (result.thickness_interval for result in results)]
    # Binomial: 1.5 % of 200.
    assert 0.90 < np.mean(inside) < 0.99
    assert inside == thick
    # Three alarms at 0.3 to 1 % each.
    assert sum(bool(result.warnings) for result in results) <= 8


def test_budget_rows_are_the_derivatives_of_the_angle():
    given = {"wavelength": WAVELENGTH, "gap_index": 1.33, "length": 0.04}
    sds = {"wavelength": 1e-9, "gap_index": 0.01, "length": 1e-4}
    result = fitting.wedge(table(), **given, **{f"{name}_sd": sd for name, sd in sds.items()})
    for name in ("wavelength", "gap_index"):
        high, low = (
            fitting.wedge(table(), **(given | {name: given[name] + step * sds[name]})).wedge_angle
            for step in (0.01, -0.01)
        )
        assert dict(result.budget)[name] * result.wedge_angle == pytest.approx(abs(high - low) / 0.02, rel=1e-3)
    relative = np.hypot(np.linalg.norm([sd for _, sd in result.budget]), 1e-4 / 0.04)
    assert result.thickness_sd == pytest.approx(result.thickness * relative, rel=1e-9)


def test_a_misread_fringe_a_miscount_and_a_bent_face_are_said():
    rows = table()
    rows["position_mm"][7] += 0.08
    result = fitting.wedge(rows, wavelength=WAVELENGTH)
    assert any("order 10" in text and "left out" in text for text in result.warnings)
    assert abs(result.wedge_angle - ANGLE) < 4 * result.wedge_angle_sd
    rows = table()
    rows["order"][12:] -= 1
    (warning,) = fitting.wedge(rows, wavelength=WAVELENGTH).warnings
    assert "orders 14 and 14 lie 0.9" in warning
    rows = table()
    rows["position_mm"] += 2e-3 * (rows["order"] - 15.0) ** 2
    assert any("the spacing changes by" in text for text in fitting.wedge(rows, wavelength=WAVELENGTH).warnings)


def test_stated_deviations_weigh_and_decide():
    stated = fitting.wedge(table(sd_mm=np.full(25, 0.02)), wavelength=WAVELENGTH)
    assert stated.spacing_sd == pytest.approx(20e-6 / np.sqrt(np.sum((np.arange(25) - 12.0) ** 2)), rel=1e-6)


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ({"order": [1, 2], "position_mm": [1.0, 2.0]}, "positions of 2 fringes"),
        ({"order": [1, 2, 3, 4], "position_mm": [1.0, 1.3, 0.8, 1.1]}, "do not determine a spacing"),
        ({"order": [1, 2, 3, 4], "position_um": [0.1, 0.2, 0.3, 0.4]}, "finer than the fringes of any wedge"),
    ],
)
def test_what_is_no_wedge_is_refused(rows, words):
    result = fitting.wedge(rows, wavelength=WAVELENGTH)
    assert (result.status, result.wedge_angle) == ("refused", None)
    assert words in result.message
    assert result.figure() is not None


def test_wrong_arguments_are_refused_in_one_line():
    for arguments, words in (
        ({"wavelength": 0.0}, "wavelength is 0.0"),
        ({"length": 0.0}, "length is 0.0; allowed"),
        ({"length_sd": 1e-4}, "length_sd is given without length"),
    ):
        with pytest.raises(ValueError, match=words):
            fitting.wedge(table(), **({"wavelength": WAVELENGTH} | arguments))
    with pytest.raises(ValueError, match="gives no positions of fringes"):
        fitting.wedge({"order": [1, 2, 3], "diameter_mm": [1, 2, 3]}, wavelength=WAVELENGTH)


def test_the_result_is_saved_and_drawn(tmp_path):
    result = fitting.wedge(table(), wavelength=WAVELENGTH, length=0.04)
    result.save(tmp_path / "wedge.json")
    assert fitting.WedgeResult.load(tmp_path / "wedge.json") == result
    assert len(result.figure().axes) == 1
    assert "thickness = " in result.report()


def test_the_verb_measures_a_table_and_rings_names_it(tmp_path, capsys):
    file = tmp_path / "wedge.csv"
    file.write_text("order,position_mm\n" + "\n".join(f"{m},{x}" for m, x in zip(*table().values(), strict=True)))
    assert main(["wedge", str(file), "--wavelength", "589.3nm", "--length", "40mm"]) == 0
    assert "thickness = " in capsys.readouterr().out
    assert "newtonjax wedge" in refusal(capsys, "rings", file, "--wavelength", "589.3nm")
    assert "--pixel-size, --scale-from: not of a table" in refusal(
        capsys, "wedge", file, "--wavelength", "589.3nm", "--pixel-size", "1um", "--scale-from", "scale.json"
    )
    assert "give --wavelength" in refusal(capsys, "wedge", file)
