"""Rings of several lines in three channels: one radius, from made photographs and from a real one."""

import jax
import numpy as np
import pytest

import fitting
import newtonjax as nj
from experiments.truth.colour_pictures import Truth, picture, responses
from fitting.colour import BANDS_ALONE, ONE_LINE, ColourReason
from fitting.colour.amplitudes import background, solve
from fitting.colour.palette import Lines, lines_of_lamp, of_lamp
from fitting.colour.variants import Variant, spread_among
from fitting.colour.waveform import Curve, View, waves
from fitting.photograph.light_verdict import doubt_of
from fitting.photograph.light_words import LampLight

_TRUTH = Truth(0.15, 5.461e-6, 20e-9, (142.3, 105.8), 1.1, "mercury")


@pytest.fixture(scope="module")
def mercury():
    """The photograph of a lens of 150 mm under a mercury arc."""
    return picture(_TRUTH, np.random.default_rng(5), responses(), shape=(220, 300))


def test_a_blurred_component_is_the_integral_of_the_sharp_one_with_a_gaussian():
    palette, blur, squares = (
        of_lamp(Lines(np.array([546.1e-9]), np.ones(1)), 10.0),
        3.0,
        np.array([900.0, 6400.0, 19600.0]),
    )
    view, curve = View(0.0, -1.0, 2e4), Curve(float(np.log(1e-10)), 0.3, blur)
    at = np.linspace(-6 * blur, 6 * blur, 401)
    kernel = np.exp(-(at**2) / (2 * blur**2))
    weights = np.outer(kernel, kernel) / kernel.sum() ** 2
    around = (np.sqrt(squares)[:, None, None] + at) ** 2 + at[:, None] ** 2
    sharp = -np.cos(4 * np.pi * (1e-10 * around + 0.3e-6) / 546.1e-9)
    blurred = waves(palette, curve, squares, 0.0, 1, view)[:, 0]
    np.testing.assert_allclose(blurred, (sharp * weights).sum(axis=(1, 2)), atol=1e-6)


def test_amplitudes_are_found_and_never_negative():
    palette, squares = of_lamp(lines_of_lamp("mercury"), 10.0), np.linspace(0, 6e4, 800)
    columns = waves(palette, Curve(float(np.log(1e-10))), squares, 10.0, 1, View(0.0, -1.0, 6e4))
    truth = np.zeros(columns.shape[1])
    truth[[1, 2, 12]] = 0.2, 0.5, 0.3
    values = 1 + 1e-5 * squares + columns @ truth
    answer = solve(columns, background(squares, 3), values, np.ones(800))
    assert (answer.amplitudes >= 0).all()
    np.testing.assert_allclose(answer.model, values, atol=1e-3)
    assert answer.amplitudes[2] == pytest.approx(0.5, abs=0.02)


def test_all_channels_together_give_the_radius_within_its_interval(mercury):
    result = fitting.fit(mercury, light="mercury", pixel_size=5.461e-6, view="reflected")
    assert result.status == "ok"
    assert abs(result.radius - 0.15) < 2.5 * result.radius_sd < 0.003 * 0.15
    # To a wavelength's two hundredth, with the order: the achromatic centre says which ring is the first.
    assert result.gap == pytest.approx(20e-9, abs=3e-9)
    assert {"radius_red", "radius_green", "radius_blue"} <= set(result.parameters)
    assert fitting.FitResult.from_dict(result.to_dict()) == result
    assert result.figure().axes


def test_one_line_of_a_lamp_that_has_more_gets_their_effect_into_its_budget(mercury):
    result = fitting.fit(mercury, wavelength=546.1e-9, pixel_size=5.461e-6, view="reflected")
    assert "FURTHER_LINES" in result.warning_codes
    assert dict(result.budget)["further lines"] > 2e-3 * result.radius
    assert abs(result.radius - 0.15) < 1.96 * result.radius_sd
    # Grey photographs, and wavelengths of no such lamp, are not asked.
    for image, wavelength in ((mercury[..., 1], 546.1e-9), (mercury, 550e-9)):
        plain = fitting.fit(image, wavelength=wavelength, pixel_size=5.461e-6, view="reflected")
        assert "FURTHER_LINES" not in plain.warning_codes


@pytest.mark.parametrize(
    ("odds", "components", "reason"),
    [
        ({"mercury": 0.0, "helium": -32.0, ONE_LINE: -168.0, BANDS_ALONE: -500.0}, 5, None),
        ({"mercury": 0.0, "helium": 60.0, ONE_LINE: -168.0, BANDS_ALONE: -500.0}, 5, ColourReason.ANOTHER_LAMP),
        # Sodium's rings, which lines of mercury explain too at another scale.
        ({"mercury": 0.0, "helium": -9.0, ONE_LINE: -8.0, BANDS_ALONE: -500.0}, 5, ColourReason.ONE_LINE_SEEN),
        ({"sodium": 0.0, "helium": -9.0, ONE_LINE: 0.0, BANDS_ALONE: -500.0}, 1, None),
        ({"mercury": 0.0, "helium": -9.0, ONE_LINE: -8.0, BANDS_ALONE: 2.0}, 5, ColourReason.LINES_NOT_SEEN),
    ],
)
def test_a_light_of_several_lines_is_believed_where_no_single_line_explains_the_rings(odds, components, reason):
    light = LampLight(lines_of_lamp("mercury"))
    doubt = doubt_of(odds, light, components)
    assert (doubt and doubt.code) == (reason and reason.name)


def test_close_lines_are_one_component_whose_mean_wavelength_is_as_uncertain_as_their_ratio():
    lines = lines_of_lamp("mercury")
    palette = of_lamp(lines, 10.0)
    assert palette.lines == 4
    np.testing.assert_allclose(palette.shares[:, : palette.lines].sum(axis=0), 1)
    np.testing.assert_allclose(palette.tilt.sum(axis=0), 0, atol=1e-13)
    yellow = (lines.powers[-2:] @ lines.wavelengths[-2:]) / lines.powers[-2:].sum()
    assert palette.middles[3] == pytest.approx(yellow, rel=1e-12)
    # A tenth of the doublet's distance, about.
    assert (palette.wavelengths @ palette.tilt)[3] == pytest.approx(0.1 * 2.106e-9, rel=0.01)
    # The rings of a long path show the two.
    assert of_lamp(lines, 200.0).lines == 6


def test_faint_rings_are_not_taken_for_cut_off_ones(mercury):
    image = np.array(mercury) / 65535
    faint = 0.8 + 0.04 * image + np.random.default_rng(1).normal(0, 1e-3, image.shape)
    result = fitting.fit(faint, light="mercury", pixel_size=5.461e-6, view="reflected")
    assert result.status == "ok"
    assert "CHANNELS_CLIPPED" not in result.warning_codes
    assert abs(result.radius - 0.15) < 2.5 * result.radius_sd < 0.01 * 0.15


def test_a_model_that_noise_moves_far_says_little_of_the_best_one():
    steady, loose = Variant("steady", 3e-5, 1e-5), Variant("loose", 1e-3, 6e-4)
    assert spread_among([steady], 2e-5) == pytest.approx(np.sqrt(steady.excess))
    assert spread_among([steady, steady._replace(shift=0.5e-5)], 2e-5) == pytest.approx(np.sqrt(steady.excess / 2))
    # Half of the sum of squares would be 5.7e-4.
    assert spread_among([steady, loose], 2e-5) < 6e-5


def test_another_lamp_is_refused_with_the_name_of_the_right_one(mercury):
    result = fitting.fit(mercury, light="sodium", pixel_size=5.461e-6, view="reflected")
    assert (result.status, result.reason) == ("refused", "ANOTHER_LAMP")
    assert "mercury" in result.message


def test_a_channel_that_the_lamp_leaves_black_is_left_out_with_a_word(mercury):
    picture_of_two = np.array(mercury)
    picture_of_two[..., 2] = 0
    result = fitting.fit(picture_of_two, light="mercury", pixel_size=5.461e-6, view="reflected")
    assert abs(result.radius - 0.15) < 2.5 * result.radius_sd
    assert "radius_blue" not in result.parameters
    assert any(text.startswith("blue has light in less than half") for text in result.warnings)


def test_a_grey_picture_without_a_pixel_size_gives_the_fringe_scale_of_the_line_next_to_555_nm(mercury):
    result = fitting.fit(mercury[..., 0], wavelength="mercury", view="reflected")
    assert result.status == "no-scale"
    assert result.fringe_scale_per_px2 == pytest.approx(5.461e-6**2 / (0.15 * 546.074e-9), rel=3e-3)
    assert "blue" not in result.model["explained"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"light": "mercury", "wavelength": 5e-7}, "light and wavelength do not go together"),
        ({"light": "white"}, "has no lines"),
        ({"light": "mercurio"}, "nearest: mercury"),
        ({"channel": "violet"}, "allowed for this image: red, green, blue"),
    ],
)
def test_light_that_cannot_be_fitted_is_refused_in_one_line(mercury, arguments, message):
    with pytest.raises(ValueError, match=message):
        fitting.fit(mercury, **arguments)


@pytest.mark.shared
def test_a_mercury_arc_gives_the_catalogued_radius_in_all_channels(shared):
    photograph = shared / "trials" / "white_light_154.5mm.tif"
    result = fitting.fit(photograph, light="mercury", pixel_size=5.461e-6, pixel_size_sd=0.01e-6, view="reflected")
    # The catalogue states 1 %, and the scale 0.2 %.
    assert abs(result.radius - 0.1545) < 1.96 * np.hypot(result.radius_sd, 0.001545)
    by_channel = [result.parameters[f"radius_{name}"].value for name in ("red", "green", "blue")]
    assert np.ptp(by_channel) < 0.003 * result.radius
    assert "CHANNELS_CLIPPED" in result.warning_codes


@pytest.mark.parametrize("distortion", [0.01, 0.0])
def test_a_distortion_that_rings_show_is_in_the_model(distortion):
    wavelengths, nanometres = np.arange(380, 781, 5) * 1e-9, np.arange(380, 781, 5)
    curves = np.stack([np.exp(-0.5 * ((nanometres - middle) / 33) ** 2) for middle in (600, 535, 460)])
    camera = nj.Camera(
        (300, 400), 5e-6, exposure=8e4, full_scale=16e3, bits=16, blur=0.8, mosaic="RGGB",
        response=nj.Response(wavelengths, curves), lens=nj.CameraLens(distortion),
    )  # fmt: skip
    bench = nj.newton_rings(0.1545, light="mercury")
    codes = np.asarray(camera.expose(nj.render(bench, camera), jax.random.key(0)))
    result = fitting.fit(codes, light="mercury", pixel_size=5e-6, transfer="linear")
    assert abs(result.radius - 0.1545) < 3 * result.radius_sd
    assert result.radius_sd < 3e-3 * 0.1545
    assert ("not in the model" in result.model["distortion"]) == (distortion == 0)
