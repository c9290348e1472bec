"""Spectra: lamps by name, coherence against Fourier transforms, words and files that are refused."""

import numpy as np
import pytest
from scipy.integrate import quad

import newtonjax as nj
from fitting.shell import lamps
from newtonjax.benches.toml_files import scene_from_text, scene_text
from newtonjax.scene import LAMPS
from newtonjax.scene.lamp_lines import index_of_air

SIGMA = 1 / 589e-9


def gaussian(offset, width):
    return np.exp(-4 * np.log(2) * (offset / width) ** 2)


def lorentzian(offset, width):
    return 1 / (1 + (2 * offset / width) ** 2)


@pytest.mark.parametrize("path", [0.0, 2e-6, 40e-6, 200e-6])
@pytest.mark.parametrize(("shape", "profile"), [("gaussian", gaussian), ("lorentzian", lorentzian)])
def test_visibility_is_the_fourier_transform_of_the_line(shape, profile, path):
    width = 0.5e-9
    frequency = 2 * np.pi * width * SIGMA**2 * path  # per width of the line

    def scaled(offset):
        return profile(offset, 1.0)

    if path == 0:
        expected = 1.0
    elif shape == "lorentzian":
        expected = quad(scaled, 0, np.inf, weight="cos", wvar=frequency)[0] / (np.pi / 4)
    else:
        area = quad(scaled, 0, 8)[0]
        expected = quad(scaled, 0, 8, weight="cos", wvar=frequency)[0] / area
    coherence = nj.spectral_line(589e-9, width, shape).coherence(np.array(path))
    assert abs(coherence) == pytest.approx(expected, abs=1e-6)


def test_visibility_of_samples_is_the_fourier_transform_of_the_lines_between_them():
    wavelengths = np.linspace(500e-9, 600e-9, 21)
    powers = 1 + np.sin(np.linspace(0, 3, 21))
    fine = np.linspace(490e-9, 610e-9, 240_001)
    density = np.interp(fine, [495e-9, *wavelengths, 605e-9], [0, *powers, 0])
    spectrum = nj.sampled_spectrum(wavelengths, powers)
    for path in (0.0, 1e-6, 3e-6, 8e-6):
        expected = abs((density * np.exp(2j * np.pi * path / fine)).sum()) / density.sum()
        # The triangles are of wavenumber, not of wavelength: a step's second order.
        assert abs(spectrum.coherence(np.array(path))) == pytest.approx(expected, abs=2e-4)


def test_coherence_length_is_where_visibility_is_one_over_e():
    for shape in ("gaussian", "lorentzian"):
        line = nj.spectral_line(546e-9, shape=shape, coherence_length=1e-3)
        assert abs(line.coherence(np.array(1e-3))) == pytest.approx(np.exp(-1), rel=1e-6)


def test_air_and_vacuum_wavelengths_are_those_of_the_standards():
    # Of D2 Steck (2019), 589.158 326 4 nm in vacuum; of the laser and of Kr-86 the mise en pratique of the metre.
    for words, vacuum in (("sodium-d2", 589.1583264), ("hene", 632.9912126), ("krypton:605.6nm", 605.780210)):
        assert nj.lamp(words, 1.00027).wavelength == pytest.approx(vacuum * 1e-9, rel=1.5e-6)
    # Ciddor (1996), table 1: dry air of 15 C, 101 325 Pa and 450 ppm of carbon dioxide at 633 nm.
    assert index_of_air(633.0) == pytest.approx(1.00027653, abs=2e-8)
    assert nj.lamp("sodium").wavelength < nj.lamp("sodium", 1.00028).wavelength


def test_a_filter_passes_its_band():
    green = nj.lamp("mercury:546nm/10nm")
    assert green.wavelength == pytest.approx(546.074e-9, rel=1e-7)
    both = nj.lamp("mercury:578nm/10nm")
    # The two yellow lines by their strengths and the filter's flanks, and nothing of the green.
    passed = [s * gaussian(w - 578, 10) for w, s in LAMPS["mercury"]]
    assert both.wavelength == pytest.approx(1e-9 / np.average([1 / w for w, _ in LAMPS["mercury"]], weights=passed))
    line = nj.spectral_line(550e-9, 10e-9).filtered(545e-9, 10e-9)
    # The product of two Gaussians.
    assert line.wavelengths[0] == pytest.approx(547.5e-9)
    assert line.gaussian[0] == pytest.approx(10e-9 / np.sqrt(2))


@pytest.mark.parametrize(
    ("words", "parts"),
    [
        ("sodiom", ["'sodiom'", "nearest: sodium"]),
        ("mercury:520nm", ["mercury has no line there", "546.1nm"]),
        ("mercury:500nm/2nm", ["nothing of this light"]),
        ("589.3nm/-1nm", ["'-1nm'", "positive length"]),
        ("589.3nm/600nm", ["gaussian", "below its wavelength"]),
        ("589.3nm/boxcar:1nm", ["'boxcar'", "lorentzian"]),
        ("white:D66", ["'D66'", "D65"]),
        ("white:20K", ["temperature", "500"]),
        ("led:525nm", ["centre and width"]),
        ("nowhere.csv", ["nowhere.csv", "not a file"]),
    ],
)
def test_words_that_name_no_light_are_refused_in_one_line(words, parts):
    with pytest.raises(ValueError, match=r"^[^\n]*$") as error:
        nj.lamp(words)
    assert all(part in str(error.value) for part in parts)


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("wavelength_nm,power\n500,1\n501,1\n502,1\n520,1\n", "gap of 18 nm at 502 nm"),
        ("wavelength_nm,power\n500,1\n502,1\n501,1\n", "sample 3 lies below"),
        ("wavelength_nm,power\n0.5,1\n0.51,1\n0.52,1\n", "10 nm to 1 mm"),
        ("wavelength_nm,power\n500,1\n501,-1\n502,1\n", "negative"),
        ("wavelength_nm,power\n500,1\n501,x\n502,1\n", "line 3"),
        ("nm,power\n500,1\n", "allowed: wavelength_nm,power"),
        ("wavelength_nm,power\n500,1\n", "three or more"),
        ("", "empty"),
    ],
)
def test_files_of_no_spectrum_are_refused_in_one_line(text, part, tmp_path):
    (tmp_path / "lamp.csv").write_text(text)
    with pytest.raises(ValueError, match=r"^[^\n]*$") as error:
        nj.lamp(str(tmp_path / "lamp.csv"))
    assert "lamp.csv" in str(error.value)
    assert part in str(error.value)


def test_a_file_of_a_spectrum_is_its_samples(tmp_path):
    (tmp_path / "lamp.csv").write_text("# of a lamp\nwavelength_um,power\n0.5,1\n0.51,2\n0.52,1\n")
    expected = nj.sampled_spectrum(np.array([500e-9, 510e-9, 520e-9]), np.array([1.0, 2.0, 1.0]))
    path = np.array([1e-6, 5e-6])
    np.testing.assert_allclose(
        nj.lamp(str(tmp_path / "lamp.csv")).coherence(path), expected.coherence(path), rtol=1e-12
    )


def test_a_file_of_a_response_is_its_samples_of_each_channel(tmp_path):
    file = tmp_path / "camera.csv"
    file.write_text("# of a camera\nwavelength_nm,red,green,blue\n450,0,0.1,1\n550,0.2,1,0.1\n650,1,0.1,0\n")
    response = nj.camera_response(str(file))
    np.testing.assert_allclose(response.wavelengths, [450e-9, 550e-9, 650e-9], rtol=1e-15)
    np.testing.assert_array_equal(response.curves, [[0, 0.2, 1], [0.1, 1, 0.1], [1, 0.1, 0]])
    np.testing.assert_array_equal(nj.camera_response("cie_1931").curves, nj.cie_1931().curves)


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("wavelength_nm,red,green\n500,1,1\n510,1,1\n520,1,1\n", "2 channels"),
        ("wavelength_nm,red,green,blue\n500,1,1\n", "line 2"),
        ("wavelength_nm,red,green,blue\n500,1,1,0\n510,1,1,0\n520,1,1,0\n", "all 0"),
        ("red,green,blue\n500,1,1\n", "allowed: wavelength_nm,red,green,blue"),
    ],
)
def test_files_of_no_response_are_refused_in_one_line(text, part, tmp_path):
    (tmp_path / "camera.csv").write_text(text)
    with pytest.raises(ValueError, match=r"^[^\n]*$") as error:
        nj.camera_response(str(tmp_path / "camera.csv"))
    assert part in str(error.value)


def test_the_words_are_the_same_in_python_in_a_file_and_at_the_shell():
    scene = nj.newton_rings(light="mercury:578nm/10nm")
    of_file, _ = scene_from_text('[newton_rings]\nlight = "mercury:578nm/10nm"')
    by_hand = scene_text(scene)
    words = by_hand[: by_hand.index("[light.spectrum]")].replace("[light]", '[light]\nspectrum = "mercury:578nm/10nm"')
    written, _ = scene_from_text(by_hand)
    of_words, _ = scene_from_text(words + by_hand[by_hand.index("[screen]") :])
    for other in (of_file, written, of_words):
        np.testing.assert_array_equal(other.light.spectrum.shares, scene.light.spectrum.shares)
        np.testing.assert_array_equal(other.light.spectrum.wavelengths, scene.light.spectrum.wavelengths)
    assert lamps.wavelength("mercury:578nm/10nm").within(1.0) == pytest.approx(scene.wavelength, rel=1e-12)


def test_a_light_and_a_wavelength_are_refused_together():
    with pytest.raises(ValueError, match="wavelength and light are both given"):
        nj.newton_rings(wavelength=500e-9, light="sodium")
    assert nj.newton_rings(light="546nm").light.spectrum is None  # one sharp line is a wavelength


def test_white_points_of_illuminants_are_the_tabulated_ones():
    # CIE 015:2018, table 11.1.
    tabulated = {"A": (1.09850, 0.35585), "D65": (0.95047, 1.08883), "D50": (0.96422, 0.82521), "E": (1.0, 1.0)}
    for name, (x, z) in tabulated.items():
        spectrum = nj.illuminant(name)
        powers = nj.cie_1931().powers(spectrum.wavelengths, spectrum.shares).sum(axis=1)
        np.testing.assert_allclose(powers, [x, 1.0, z], atol=2e-4)


@pytest.mark.parametrize(
    "call",
    [
        lambda: nj.Spectrum([5e-7], [1.0, 2.0]),
        lambda: nj.Spectrum([5e-7], [0.0]),
        lambda: nj.sampled_spectrum(np.array([5e-7, 4e-7]), np.ones(2)),
        lambda: nj.illuminant("D66"),
        lambda: nj.black_body(20.0),
        lambda: nj.Response([4e-7, 5e-7], [[1.0, 1.0]], 9),
        lambda: nj.Response([4e-7, 5e-7], [[1.0, np.nan]]),
    ],
)
def test_what_is_no_spectrum_or_response_is_refused_in_one_line(call):
    with pytest.raises(ValueError, match=r"^[^\n]*allowed[^\n]*$"):
        call()
