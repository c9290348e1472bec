"""The pixel size from two points and their distance."""

import json

import numpy as np
import pytest
from shell import refusal

import fitting
from fitting.shell.cli import main


def test_two_points_give_distance_over_pixels_with_the_error_of_pointing():
    result = fitting.scale(points=((10.0, 20.0), (310.0, 420.0)), distance=1e-3, distance_sd=2e-6, pointing_sd=0.5)
    assert result.pixel_size == pytest.approx(2e-6, rel=1e-12)
    relative = np.hypot(0.5 * np.sqrt(2) / 500, 2e-3)
    assert result.pixel_size_sd == pytest.approx(relative * 2e-6, rel=1e-12)
    assert result.warning_codes == ["PIXELS_TAKEN_AS_SQUARE"]
    assert "pixel size" in result.report()


def test_the_standard_deviation_is_the_scatter_of_pointing():
    rng = np.random.default_rng(5)
    places = np.array([[10.0, 20.0], [130.0, 180.0]]) + 0.5 * rng.normal(size=(500, 2, 2))
    results = [fitting.scale(points=pair.tolist(), distance=1e-3) for pair in places]
    inside = [abs(result.pixel_size - 5e-6) < 1.96 * result.pixel_size_sd for result in results]
    assert 0.92 < np.mean(inside) < 0.98


def test_points_at_one_place_are_refused():
    result = fitting.scale(points=((1.0, 1.0), (1.0, 1.0)), distance=1e-3)
    assert (result.status, result.reason) == ("refused", "POINTS_TOO_NEAR")


@pytest.mark.parametrize(
    "arguments",
    [{}, {"distance": 1e-3}, {"division": 1e-3, "points": ((0.0, 0.0), (1.0, 1.0)), "distance": 1e-3},
     {"points": ((0.0, 0.0),), "distance": 1e-3}, {"division": 1e-3}],
)  # fmt: skip
def test_what_does_not_go_together_is_refused(arguments):
    with pytest.raises(ValueError, match=r"give|need none"):
        fitting.scale(**arguments)


def test_a_scale_that_was_refused_is_no_scale_and_says_why(tmp_path):
    path = tmp_path / "scale.json"
    path.write_text(json.dumps(fitting.Scale("refused", "no ruler").to_dict()))
    with pytest.raises(ValueError, match=r"holds no pixel_size_m: the scale was refused \(no ruler\)"):
        fitting.fit(np.zeros((64, 64)), wavelength=589.3e-9, scale=path)


def test_the_shell_writes_what_a_fit_takes(tmp_path, capsys):
    file = tmp_path / "scale.json"
    command = ["scale", "--point", "120,340", "--point", "980,352", "--distance", "10mm", "--json", str(file)]
    assert main([*command, "--output-dir", str(tmp_path / "out")]) == 0
    assert {path.name for path in (tmp_path / "out").iterdir()} >= {"report.html", "result.png", "result.json"}
    assert "pixel size" in capsys.readouterr().out
    saved = json.loads(file.read_text())
    assert saved["pixel_size_m"] == pytest.approx(10e-3 / np.hypot(860, 12))
    assert fitting.Scale.load(file).pixel_size == saved["pixel_size_m"]
    from fitting.parameters import camera_scale

    assert camera_scale(file).pixel_size == saved["pixel_size_m"]
    assert "give X,Y in pixels" in refusal(capsys, "scale", "--point", "a", "--distance", "1mm")
