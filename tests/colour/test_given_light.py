"""Rings under a lamp and a camera whose curves are given: the waveform, the radius, and curves that are others."""

import numpy as np
import pytest
import tifffile
from shell import refusal

import fitting
import newtonjax as nj
from experiments.truth.colour_pictures import WAVELENGTHS, Truth, picture, responses, spectrum
from fitting.colour import Curves
from fitting.colour.given_fit import Misfit
from fitting.colour.given_light import given_light
from fitting.colour.waveform import Curve, View, waves
from fitting.shell.cli import main

_TRUTH = Truth(0.15, 5.461e-6, 20e-9, (142.3, 105.8), 1.1, "led")
_RESPONSE = nj.Response(WAVELENGTHS, responses())
_LED = nj.sampled_spectrum(*spectrum("led"))


def _picture(curves: np.ndarray, lamp: str = "led") -> np.ndarray:
    return picture(_TRUTH._replace(lamp=lamp), np.random.default_rng(7), curves, shape=(220, 300))


def _fit(image: np.ndarray, **given) -> fitting.FitResult:
    arguments = {"light": _LED, "response": _RESPONSE, "pixel_size": 5.461e-6, "pixel_size_sd": 0.0} | given
    return fitting.fit(image, view="reflected", **arguments)


@pytest.fixture(scope="module")
def led():
    """The photograph of a lens of 150 mm under a white LED."""
    return _picture(responses())


@pytest.mark.parametrize("tilt", [0.0, 0.4])
def test_the_waveform_of_a_channel_is_the_integral_over_lamp_times_camera(tilt):
    light = given_light(Curves(_LED, _RESPONSE), 12.0)
    squares = np.linspace(0, 3e4, 200)
    curve = Curve(float(np.log(1e-10)), 0.02, 0.0, tilt_green=tilt, curvature_green=tilt / 2)
    found = waves(light, curve, squares, 0.0, 1, View(0.0, -1.0, 3e4))[:, 0]
    at = np.linspace(380e-9, 780e-9, 8001)
    product = np.interp(at, *spectrum("led")) * np.interp(at, WAVELENGTHS, responses()[1])
    # The change is about the mean of the given spectrum by power per wavenumber.
    per_wavenumber = product * at**2
    x = (at - (per_wavenumber / at**2 @ at) / (per_wavenumber / at**2).sum()) / 50e-9
    product = product * np.exp(tilt * x - tilt / 2 * x**2)
    path = 2 * (1e-10 * squares + 2e-8)
    expected = -(np.cos(2 * np.pi * path[:, None] / at) @ product) / product.sum()
    np.testing.assert_allclose(found, expected, atol=2e-3)


def test_an_error_that_all_wavelengths_have_in_common_leaves_the_rings_as_they_are():
    squares, view = np.linspace(0, 3e4, 200), View(0.0, -1.0, 3e4)
    waveforms = []
    for scale in (1.0, 1.02):
        wavelengths, powers = spectrum("led")
        lamp = nj.sampled_spectrum(scale * wavelengths, powers)
        light = given_light(Curves(lamp, nj.Response(scale * WAVELENGTHS, responses())), 12.0)
        curve = Curve(float(np.log(scale * 1e-10)), scale * 0.02, 1.1)
        waveforms.append(waves(light, curve, squares, 30.0, 1, view))
    np.testing.assert_allclose(waveforms[0], waveforms[1], atol=1e-9)


def test_under_given_curves_the_radius_and_the_gap_are_within_their_intervals(led):
    result = _fit(led, wavelength_sd="0.02%")
    assert result.status == "ok"
    assert abs(result.radius - 0.15) < 2.5 * result.radius_sd < 0.002 * 0.15
    # The centre is achromatic: no half wave is open.
    assert result.gap == pytest.approx(20e-9, abs=2e-9)
    assert "lamp and camera curves" not in dict(result.budget)
    assert dict(result.budget)["wavelength"] == pytest.approx(2e-4 * result.radius)
    assert fitting.FitResult.from_dict(result.to_dict()) == result
    assert result.figure().axes


def test_curves_that_are_a_little_off_are_named_and_in_the_budget():
    result = _fit(_picture(responses(np.array([5.0, -4.0, 3.0]), 0.04)))
    assert "CURVES_OFF" in result.warning_codes
    assert dict(result.budget)["lamp and camera curves"] == pytest.approx(0.008 * result.radius)
    assert abs(result.radius - 0.15) < 1.96 * result.radius_sd


def test_the_command_reads_lamp_and_camera_from_files(led, tmp_path, capsys):
    at = WAVELENGTHS[::4] * 1e9
    for name, header, columns in (
        ("lamp.csv", "wavelength_nm,power", spectrum("led")[1][::4]),
        ("camera.csv", "wavelength_nm,red,green,blue", responses()[:, ::4].T),
    ):
        table = np.column_stack([at, columns])
        np.savetxt(tmp_path / name, table, delimiter=",", header=header, comments="")
    tifffile.imwrite(tmp_path / "rings.tif", led, photometric="rgb")
    names = (tmp_path / name for name in ("rings.tif", "lamp.csv", "camera.csv"))
    photograph, lamp, response = map(str, names)
    options = ["--pixel-size", "5.461um", "--view", "reflected", "--json", str(tmp_path / "fit.json")]
    assert main(["fit", photograph, "--light", lamp, "--response", response, *options]) == 0
    assert "lamp and camera curves" in capsys.readouterr().out
    result = fitting.FitResult.load(tmp_path / "fit.json")
    assert abs(result.radius - 0.15) < 0.1 * result.radius_sd
    # Nothing is said of the curves, and a lamp of another wavelength makes the same rings.
    assert dict(result.budget)["lamp and camera curves"] == pytest.approx(0.008 * result.radius)
    assert "WAVELENGTHS_ASSUMED" in result.warning_codes
    assert "camera's response" in refusal(capsys, "fit", photograph, "--light", lamp, "--response", tmp_path / "no.csv")


def test_the_rings_of_another_lamp_are_refused(led):
    result = _fit(led, light="white:D65")
    assert (result.status, result.reason, result.radius) == ("refused", "OTHER_CURVES", None)
    assert "1 to 13 %" in result.message


@pytest.mark.parametrize(
    ("size", "sd"),
    [
        (Misfit(1e-5, 4e-6, 1.0), 1e-4),
        (Misfit(1e-4, 4e-6, 1.0), 0.008),
        (Misfit(9e-3, 1e-3, 1.0), 0.03),
        # The rings ask for a change that such curves do not have, and go well with it then.
        (Misfit(4e-4, 1e-4, 6.0), 0.03),
        (Misfit(9e-3, 1e-3, 6.0), None),
        (Misfit(9e-3, 3e-3, 1.0), None),
        (Misfit(4e-4, 1e-4, 12.0), None),
    ],
)
def test_the_worse_the_curves_are_the_less_a_wavelength_is_known(size, sd):
    assert size.wavelength_sd == sd


def test_without_a_pixel_size_the_fringe_scale_is_that_of_the_middle_channel(led):
    result = _fit(led[..., 1], response=nj.Response(WAVELENGTHS, responses()[1:2]), pixel_size=None, pixel_size_sd=None)
    assert result.status == "no-scale"
    at, powers = spectrum("led")
    product = powers * responses()[1]
    mean = product.sum() / (product / at).sum()
    assert result.fringe_scale_per_px2 == pytest.approx(5.461e-6**2 / (0.15 * mean), rel=5e-3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"light": None}, "response is given without light"),
        ({"light": "mercury"}, "leave response out"),
        ({"response": "camera.txt"}, "allowed: cie_1931, or a file camera.csv"),
        ({"response": nj.Response(WAVELENGTHS, responses()[:2])}, "three channels"),
        ({"response": "camera.csv"}, "camera.csv is not a file"),
        ({"response": nj.Response(WAVELENGTHS, responses()[:1])}, "response has 1 channels, and the image 3"),
        ({"light": "led:900nm/20nm"}, "takes nothing"),
        ({"light": "589.3nm/lorentzian:9nm"}, "Gaussian profile, or samples"),
        ({"response": None}, "curves of the camera"),
        ({"wavelength": 5e-7}, "light and wavelength do not go together"),
    ],
)
def test_curves_that_cannot_be_used_are_refused_in_one_line(led, arguments, message):
    with pytest.raises(ValueError, match=message):
        _fit(led, **arguments)
