"""Rulers and discs of known size: the pixel size with error bars that hold, and what is neither."""

import imageio.v3 as iio
import numpy as np
import pytest

import fitting
from experiments.truth.scale_pictures import SIZE, disc, ruler
from experiments.truth.scales import deviation
from fitting.shell.cli import main


def test_rulers_give_the_pixel_size_within_their_deviation():
    deviations = np.array([deviation("ruler", seed) for seed in range(4)], dtype=float)
    assert np.abs(deviations).max() < 4


def test_a_ruler_beside_the_middle_of_a_slanted_view_gives_the_size_in_the_middle():
    # Lines that converge by 1 % towards the corner, 55 px beside the middle: 40 deviations off without their turns.
    assert abs(deviation("ruler", 8)) < 3


@pytest.mark.parametrize("kind", ["disc", "ring"])
def test_a_disc_and_a_ring_give_the_pixel_size_within_their_deviation(kind):
    deviations = [deviation(kind, seed) for seed in (2, 9, 12)]
    assert max(abs(value) for value in deviations if value is not None) < 4
    assert None not in deviations


def test_a_ruler_says_one_way_only_and_its_own_deviation_counts():
    image, distance = ruler(3)
    exact, uncertain = (fitting.scale(image, ruler=distance, ruler_sd=sd, transfer="linear") for sd in (None, "1%"))
    assert "ONE_WAY_ONLY" in exact.warning_codes
    assert uncertain.pixel_size_sd == pytest.approx(np.hypot(exact.pixel_size_sd, 0.01 * exact.pixel_size))
    assert exact.pixel_size_sd < 0.005 * SIZE
    assert exact.lines[0] >= 8
    assert exact.figure().axes


def test_what_is_no_ruler_and_no_disc_is_refused():
    noise = np.random.default_rng(0).normal(0.5, 0.1, (200, 240))
    assert fitting.scale(noise, ruler=1e-3).status == "refused"
    assert fitting.scale(noise, disc_diameter=1e-3).status == "refused"
    with pytest.raises(ValueError, match="give one of division, ruler and disc_diameter"):
        fitting.scale(noise, ruler=1e-3, division=1e-3)


def test_the_verb_measures_a_ruler_for_scale_from(tmp_path, capsys):
    image, distance = ruler(4)
    photo, scale = tmp_path / "ruler.png", tmp_path / "scale.json"
    iio.imwrite(photo, image)
    command = ["scale", str(photo), "--ruler", f"{1e6 * distance:.9g}um", "--transfer", "linear", "--json", str(scale)]
    assert main([*command, "--output-dir", str(tmp_path / "out")]) == 0
    assert fitting.Scale.load(scale).pixel_size == pytest.approx(SIZE, rel=0.005)
    rings = np.hypot(*np.mgrid[-100:101, -120:121]) ** 2
    np.save(tmp_path / "rings.npy", 0.5 + 0.4 * np.cos(2 * np.pi * rings / 1800))
    lamp = ("--wavelength", "589.3nm", "--transfer", "linear", "--json", str(tmp_path / "fit.json"))
    assert main(["fit", str(tmp_path / "rings.npy"), *lamp, "--scale-from", str(scale)]) == 0
    assert (tmp_path / "out" / "result.png").stat().st_size > 1000
    assert "divisions of" in capsys.readouterr().out


def test_a_disc_is_saved_and_drawn(tmp_path):
    image, diameter = disc(2, "disc")
    result = fitting.scale(image, disc_diameter=diameter, disc_diameter_sd="0.5%", transfer="linear")
    result.save(tmp_path / "scale.json")
    assert fitting.Scale.load(tmp_path / "scale.json") == result
    assert result.parameters["diameter"].value == pytest.approx(diameter)
    assert result.figure().axes


def test_a_bright_disc_is_measured_though_its_light_is_clipped():
    deviations = [deviation("disc, clipped", seed) for seed in (10_000, 10_004)]
    assert np.all(np.abs(np.array(deviations, dtype=float)) < 3)


def test_a_mask_takes_out_what_lies_beside_a_bright_disc():
    """A larger spot beside it, and a speck on its edge."""
    image, diameter = disc(10_008, "disc")
    beside = np.full((image.shape[0], 200), image.min())
    beside[20:220, 10:190] = image.max()
    picture = np.concatenate([image, beside], axis=1)
    picture[115:125, 190:206] = picture.max()
    mask = np.zeros(picture.shape, bool)
    mask[:, : image.shape[1]] = True
    mask[110:130, 185:210] = False
    result = fitting.scale(picture, disc_diameter=diameter, transfer="linear", mask=mask)
    assert abs(result.pixel_size - SIZE) < 3 * result.pixel_size_sd < 0.01 * SIZE
    unmasked = fitting.scale(picture, disc_diameter=diameter, transfer="linear")
    assert unmasked.pixel_size is None or abs(unmasked.pixel_size / SIZE - 1) > 0.01


def test_a_curve_that_is_a_guess_counts_for_a_disc():
    """Linear codes that are taken for sRGB, and sRGB that is said to be."""
    image, diameter = disc(10_002, "disc")
    guessed, linear = (fitting.scale(image, disc_diameter=diameter, transfer=curve) for curve in (None, "linear"))
    assert "DISC_CURVE" in guessed.warning_codes
    added = guessed.pixel_size_sd**2 - linear.pixel_size_sd**2
    assert np.sqrt(added) == pytest.approx(0.25 * abs(guessed.pixel_size - linear.pixel_size), rel=0.02)
    assert "DISC_CURVE" not in fitting.scale(image, disc_diameter=diameter, transfer="srgb").warning_codes


def test_fringes_are_no_ruler_and_a_contact_is_no_disc():
    y, x = np.mgrid[-100:101, -120:121]
    straight = 0.5 + 0.3 * np.cos(2 * np.pi * (x + 0.3 * y) / 15)
    assert fitting.scale(straight, ruler=1e-3, transfer="linear").reason == "LINES_OF_FRINGES"
    for phase in (0.0, 0.5):
        rings = 0.5 + 0.4 * np.cos(2 * np.pi * ((x**2 + y**2) / 900 + phase))
        assert fitting.scale(rings, disc_diameter=1e-3, transfer="linear").reason == "CONTACT_OF_A_LENS"


def test_a_lit_field_of_rings_is_no_disc():
    """A field stop around rings that lie beside its middle, and the same field without rings, which is a disc."""
    y, x = np.mgrid[-130:131, -140:141]
    field = 1 / (1 + np.exp(np.hypot(x, y) - 90))
    rings = np.cos(2 * np.pi * ((x - 25) ** 2 + (y + 15) ** 2) / 900)
    noise = np.random.default_rng(1).normal(0, 0.01, x.shape)
    crossed, plain = (0.05 + 0.7 * field * (1 + contrast * rings) + noise for contrast in (0.3, 0.0))
    assert fitting.scale(crossed, disc_diameter=1e-3, transfer="linear").reason == "LIT_FIELD"
    assert fitting.scale(plain, disc_diameter=1e-3, transfer="linear").pixel_size == pytest.approx(1e-3 / 180, rel=0.01)


def test_a_ring_wider_than_its_edge_is_blurred_keeps_its_width():
    # Its inner edge lay beyond the pixels that counted: 10.5 deviations off.
    assert abs(deviation("ring", 10_017)) < 3
