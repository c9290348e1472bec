"""What a fit neglects biases it as its derivatives say: checked by fitting again with each number wrong."""

import csv
import json

import numpy as np
import pytest
from compilations import compilations
from shell import refusal

import fitting
import newtonjax as nj
from fitting.parameters import knobs
from fitting.shell.cli import main
from fitting.studies import derivative_images
from fitting.studies.sensitivities import refitted

TILTS = {"light_tilt": (0.1, 0.06), "plate_tilt": (1e-4, 2e-4), "lens_tilt": (0.0, 1e-3)}
SCENE = nj.newton_rings(2.0, 550e-9, 0.3e-6, "reflected", screen=20e-3, **TILTS)
CAMERA = nj.Camera((64, 60), 80e-6)
# By how much each number is held too large: the first four move the radius by 0.5 to 1 %. Of a tilt the effect is a
# square, of which the slope leaves δ over twice the tilt.
WRONG = {"pixel_size": 0.4e-6, "wavelength": 5e-9, "gap_index": 0.01, "screen": 2e-3, "light_tilt_x": 5e-3,
         "light_tilt_y": 5e-3, "lens_index": 0.05, "plate_tilt_x": 3e-5, "plate_tilt_y": 3e-5,
         "stray": 0.01}  # fmt: skip


@pytest.fixture(scope="module")
def found():
    return fitting.sensitivity(SCENE, CAMERA)


@pytest.mark.parametrize("name", WRONG)
def test_the_predicted_bias_is_that_of_a_fit(found, name):
    one = next(one for one in found.neglected if one.name == name)
    with compilations() as compiled:
        moved = refitted(SCENE, CAMERA, {name: WRONG[name]})["radius"]
    assert compiled.count == 0
    assert abs(moved) < 0.015 * 2.0
    assert moved == pytest.approx(one.slope * WRONG[name], rel=0.05, abs=1e-6 * 2.0)


def test_the_table_says_what_accuracy_takes(found):
    """R grows by 2 δs/s with a pixel size that is too large, and shrinks by δλ/λ."""
    table = {one.name: one for one in found.neglected}
    assert table["pixel_size"].tolerance == pytest.approx(1e-3 * 80e-6 / 2, rel=0.1)
    assert table["wavelength"].tolerance == pytest.approx(1e-3 * 550e-9, rel=0.1)
    assert table["pixel_size"].slope > 0 > table["wavelength"].slope
    assert found.sd == pytest.approx(fitting.information(SCENE, CAMERA).sd("radius"), rel=1e-6)
    order = [one.tolerance / one.size for one in found.neglected]
    assert order == sorted(order)
    assert "to know it to 0.002 m (0.001 of it)" in str(found)


def test_derivative_images_are_those_of_differences():
    names = ("radius", "gap", "stray")
    known = knobs(SCENE, CAMERA)
    made = derivative_images(SCENE, CAMERA, names)
    for name, step in (("radius", 1e-4), ("gap", 1e-11)):
        more, less = (known[name].move(SCENE, CAMERA, sign * step) for sign in (1, -1))
        slope = (nj.render(*more, nj.Chebyshev(17)) - nj.render(*less, nj.Chebyshev(17))) / (2 * step)
        exact = np.asarray(slope) * float(CAMERA.exposure)
        np.testing.assert_allclose(made[name], exact, atol=1e-4 * np.abs(exact).max())
    np.testing.assert_allclose(made["stray"], float(CAMERA.exposure), rtol=1e-12)


def test_the_verb_prints_a_table_and_writes_it_with_a_picture(tmp_path, capsys):
    path, folder = tmp_path / "scene.toml", tmp_path / "out"
    nj.save_scene(path, SCENE, CAMERA)
    assert main(["sensitivity", str(path), "--output-dir", str(folder)]) == 0
    said = capsys.readouterr().out
    assert "known to" in said
    answer = json.loads((folder / "sensitivity.json").read_text())
    with (folder / "sensitivity.csv").open(newline="") as file:
        assert [row["name"] for row in csv.DictReader(file)] == [one["name"] for one in answer["neglected"]]
    assert (folder / "sensitivity.png").read_bytes().startswith(b"\x89PNG")
    assert "is there already" in refusal(capsys, "sensitivity", path, "--output-dir", folder)
    assert "allowed: a positive fraction" in refusal(capsys, "sensitivity", path, "--relative-accuracy", "0")
    assert "is not a number of this scene; allowed: radius" in refusal(
        capsys, "sensitivity", path, "--target", "colour"
    )


def test_a_fit_that_cannot_be_made_is_refused():
    with pytest.raises(ValueError, match="does not converge"):
        refitted(SCENE, CAMERA, {"plate_tilt_x": 0.5})
    with pytest.raises(ValueError, match="allowed: radius"):
        refitted(SCENE, CAMERA, {"colour": 1.0})
