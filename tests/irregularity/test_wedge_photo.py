"""Photographs of straight fringes: the wedge's angle with error bars that hold, and what is no wedge."""

import json

import imageio.v3 as iio
import numpy as np
import pytest

import fitting
from experiments.truth.made_fringes import negative
from experiments.truth.wedge_pictures import PIXEL, WAVELENGTH, wedge_picture
from fitting.shell.cli import main

ANGLE, SPACING = 0.3, 17.0


def fringes(noise: float = 0.02, bend: float = 0.0, shape=(180, 220)) -> np.ndarray:
    """Fringes across a direction of 0.3 rad, 17 pixels apart in the middle."""
    y, x = (axis - (size - 1) / 2 for axis, size in zip(np.mgrid[: shape[0], : shape[1]], shape, strict=True))
    along = np.cos(ANGLE) * x + np.sin(ANGLE) * y
    turns = along / SPACING + bend * (x**2 + y**2) / 90**2
    return 0.5 + 0.3 * np.cos(2 * np.pi * turns) + noise * np.random.default_rng(3).normal(size=shape)


@pytest.fixture(scope="module")
def result() -> fitting.WedgePhoto:
    return fitting.wedge_photo(
        fringes(),
        wavelength=WAVELENGTH,
        pixel_size=4e-6,
        pixel_size_sd=2e-8,
        wavelength_sd="0.1%",
        length=42.65e-3,
        length_sd=1e-4,
        gap_index_sd=1e-4,
    )


def test_angles_rendered_by_the_bench_are_covered():
    """Of 8 pictures 7 or 8 are expected within 1.96 sd; of 2.5 sd and more one in 80."""
    deviations = []
    for seed in range(8):
        picture = wedge_picture(seed + 1000)
        answer = fitting.wedge_photo(picture.image, wavelength=WAVELENGTH, pixel_size=PIXEL)
        deviations.append((answer.wedge_angle - picture.angle) / answer.wedge_angle_sd)
    assert np.mean(np.abs(deviations) < 1.96) >= 0.85
    assert 0.5 < np.std(deviations) < 1.5


def test_spacing_direction_angle_and_thickness_are_those_of_the_fringes(result):
    assert abs(result.spacing_px - SPACING) < 4 * result.spacing_px_sd < 0.05
    assert abs(result.direction - ANGLE) < 4 * result.direction_sd < 0.01
    slope = WAVELENGTH / (2 * SPACING * 4e-6)
    assert result.wedge_angle == pytest.approx(np.arctan(slope), rel=1e-3)
    assert result.thickness == pytest.approx(42.65e-3 * slope, rel=1e-3)


def test_the_budget_holds_what_was_given_and_adds_up(result):
    budget = dict(result.budget)
    assert budget["pixel_size"] == pytest.approx(0.005)
    assert budget["wavelength"] == pytest.approx(0.001)
    assert budget["gap_index"] == pytest.approx(1e-4)
    assert budget["length"] == pytest.approx(1e-4 / 42.65e-3)
    assert np.linalg.norm(list(budget.values())) == pytest.approx(result.thickness_sd / result.thickness)


def test_a_bent_plate_is_said_and_counted():
    straight, bent = (fitting.wedge_photo(fringes(bend=bend), pixel_size=4e-6) for bend in (0.0, 0.5))
    assert "WEDGE_BENT" in bent.warning_codes
    assert "WEDGE_BENT" not in straight.warning_codes
    assert abs(bent.spacing_px - SPACING) < 2 * bent.spacing_px_sd
    assert dict(bent.budget)["bend"] > 10 * dict(straight.budget)["noise"]


def test_without_a_scale_the_spacing_in_pixels_is_the_answer():
    answer = fitting.wedge_photo(fringes(), wavelength=WAVELENGTH)
    assert (answer.status, answer.wedge_angle, answer.measured) == ("no-scale", None, "spacing_px")
    assert "pixel size not given" in answer.message


@pytest.mark.parametrize("kind", ["ellipses", "noise", "speckle", "dust", "gradient", "cloud", "text", "checkerboard"])
def test_what_is_no_wedge_is_refused(kind):
    assert fitting.wedge_photo(negative(kind, 0)).status == "refused"


@pytest.mark.parametrize(("kind", "seed"), [("spiral", 10), ("spiral", 11), ("equidistant circles", 3)])
def test_parts_of_circles_and_spirals_are_no_wedge(kind, seed):
    assert fitting.wedge_photo(negative(kind, seed)).reason == "FRINGES_CURVED"


def test_curved_and_few_fringes_are_refused_with_their_reason():
    curved = fitting.wedge_photo(fringes(bend=2.2))
    assert curved.reason in ("FRINGES_CURVED", "NO_STRAIGHT_FRINGES")
    y, x = np.mgrid[:180, :220]
    few = fitting.wedge_photo(0.5 + 0.3 * np.cos(2 * np.pi * x / 70) + 0 * y)
    assert few.reason in ("FEW_STRAIGHT_FRINGES", "NO_STRAIGHT_FRINGES")
    assert fitting.wedge_photo(np.ones((80, 90))).reason == "UNIFORM"


def test_a_ruled_grid_is_refused_and_led_to_scale(shared):
    answer = fitting.wedge_photo(shared / "photos/reticle_0.2mm.jpg", wavelength=WAVELENGTH)
    assert (answer.status, answer.reason) == ("refused", "OTHER_STRUCTURE")
    assert "is measured by scale" in answer.message


def test_photographs_of_wedges_are_measured_in_pixels(shared):
    """As counted by eye across the middle of each."""
    for name, spacing, within in (
        ("photos/wedge_straight_fringes", 20.4, 0.3),
        ("trials/straight_fringes_a", 22.4, 0.5),
    ):
        answer = fitting.wedge_photo(shared / f"{name}.jpg", wavelength=WAVELENGTH)
        assert answer.status == "no-scale"
        assert answer.spacing_px == pytest.approx(spacing, abs=within)


def test_a_scale_gives_the_pixel_size(tmp_path):
    scale = fitting.scale(points=[(0.0, 0.0), (1000.0, 0.0)], distance=4e-3, distance_sd=1e-6)
    scale.save(tmp_path / "scale.json")
    answers = [fitting.wedge_photo(fringes(), wavelength=WAVELENGTH, scale=s) for s in (scale, tmp_path / "scale.json")]
    assert answers[0].wedge_angle == answers[1].wedge_angle
    assert answers[0].parameters["pixel_size"].value == pytest.approx(4e-6)
    with pytest.raises(ValueError, match="both give the pixel size"):
        fitting.wedge_photo(fringes(), scale=scale, pixel_size=1e-6)
    with pytest.raises(ValueError, match="length is 0"):
        fitting.wedge_photo(fringes(), length=0.0)


def test_the_result_is_saved_loaded_and_drawn(result, tmp_path):
    result.save(tmp_path / "wedge.json")
    loaded = fitting.WedgePhoto.load(tmp_path / "wedge.json")
    assert loaded == result
    assert loaded.report() == result.report()
    assert result.figure().axes
    with pytest.raises(ValueError, match="has no photograph"):
        loaded.figure()


def test_the_verb_measures_a_photograph(tmp_path, capsys):
    photo, answer = tmp_path / "wedge.png", tmp_path / "wedge.json"
    iio.imwrite(photo, np.uint8(np.clip(255 * fringes(), 0, 255)))
    command = ["wedge", str(photo), "--wavelength", "sodium", "--pixel-size", "4um", "--length", "40mm"]
    assert main([*command, "--transfer", "linear", "--json", str(answer), "--output-dir", str(tmp_path / "out")]) == 0
    saved = json.loads(answer.read_text())
    assert saved["spacing_px"] == pytest.approx(SPACING, rel=0.01)
    assert saved["thickness_m"] == pytest.approx(40e-3 * 589.3e-9 / (2 * SPACING * 4e-6), rel=0.01)
    assert (tmp_path / "out" / "result.png").stat().st_size > 1000
    capsys.readouterr()
    assert main([*command, "--separator", "comma"]) == 2
    assert "--separator: not of a photograph" in capsys.readouterr().err
