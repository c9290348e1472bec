"""Lenses of one set-up under light of which nothing is given: ratios, fringe scales, and pictures of other light."""

import json

import numpy as np
import pytest
import tifffile
from scipy import ndimage
from shell import refusal

import fitting
from experiments.truth.colour_pictures import Truth, arc, picture, responses, spectrum
from fitting.colour.profiles import Profiles
from fitting.colour.unknown_light import unknown_light
from fitting.colour.unknown_problem import Number, SharedProblem
from fitting.colour.waveform import Curve, View
from fitting.shell.cli import main

_PIXEL = 5.461e-6
_SHAPE = (220, 300)
_FIRST = Truth(0.15, _PIXEL, 20e-9, (142.3, 105.8), 1.1, "led")
_SECOND = _FIRST._replace(radius=0.183, gap=45e-9, centre=(155.1, 117.2))


def _picture(truth: Truth, seed: int, light=None) -> np.ndarray:
    return picture(truth, np.random.default_rng(seed), responses(), _SHAPE, light=light)


def _ratio(*pictures, **given) -> fitting.Together:
    return fitting.ratio(*pictures, light="unknown", view="reflected", **given)


def _error(result: fitting.Together, expected: float) -> float:
    """Of a ratio, in standard deviations, which are at most 2e-3."""
    assert result.ratio
    assert result.ratio_sd
    assert result.ratio_sd < 2e-3
    return abs(result.ratio - expected) / result.ratio_sd


@pytest.fixture(scope="module")
def images():
    return [_picture(_FIRST, 1), _picture(_SECOND, 2)]


@pytest.fixture(scope="module")
def pair(images):
    return _ratio(*images)


def test_the_ratio_of_two_lenses_needs_neither_lamp_nor_camera(pair):
    assert pair.status == "no-scale"
    assert pair.reason == "RATIOS_ALONE"
    assert pair.value is None
    assert _error(pair, 0.183 / 0.15) < 2.5
    low, high = pair.ratio_interval
    assert low < 0.183 / 0.15 < high


def test_the_fringe_scale_is_that_of_the_mean_wave_of_the_middle_channel(pair):
    wavelengths, powers = spectrum("led")
    means = sorted((powers * curve / wavelengths).sum() / (powers * curve).sum() for curve in responses())
    for row, truth in zip(pair.members, (_FIRST, _SECOND), strict=True):
        assert abs(row.value - means[1] * _PIXEL**2 / truth.radius) < 2.5 * row.sd < 0.1 * row.value
        assert abs(row.alone - row.value) < 2.5 * row.alone_sd


def test_the_pair_the_other_way_round_has_the_inverse_ratio(images, pair):
    turned = _ratio(*images[::-1])
    assert abs(turned.ratio * pair.ratio - 1) < 0.5 * pair.ratio_sd


def test_a_picture_drawn_anew_at_another_scale_has_the_square_of_its_factor(images):
    # Of the same lens: its curvature in pixels falls with the square.
    factor = 1.1
    zoomed = np.asarray(
        ndimage.zoom(images[0].astype(float), (factor, factor, 1), order=3, grid_mode=True, mode="nearest")
    )
    drawn = np.clip(zoomed, 0, 65535).astype(np.uint16)
    actual = np.prod(np.divide(drawn.shape[:2], images[0].shape[:2])) ** 0.5
    result = _ratio(images[0], drawn)
    assert _error(result, actual**2) < 3


def test_three_lenses_have_their_ratios_to_the_first(images):
    third = _FIRST._replace(radius=0.128, gap=0.0)
    result = fitting.fit_together([*images, _picture(third, 3)], light="unknown", view="reflected")
    for row, radius in zip(result.members[1:], (0.183, 0.128), strict=True):
        assert row.ratio_sd
        assert abs(row.ratio - radius / 0.15) < 2.5 * row.ratio_sd < 1e-3


def test_narrow_lines_are_a_spectrum_as_any_other():
    light = arc(np.random.default_rng(4))
    result = _ratio(_picture(_FIRST, 5, light), _picture(_SECOND, 6, light))
    assert _error(result, 0.183 / 0.15) < 2.5


def test_brightest_rings_that_are_pressed_flat_are_left_out(images):
    # A knee without one level that is the highest.
    knee = 0.8 * images[0][..., 1].max()
    flat = [np.where(image > knee, knee + 0.05 * (image - knee), image).astype(np.uint16) for image in images]
    result = _ratio(*flat)
    assert "CHANNELS_CLIPPED" in result.warning_codes
    assert _error(result, 0.183 / 0.15) < 2.5


def test_a_picture_under_another_lamp_is_refused(images):
    other = _picture(_SECOND, 3, arc(np.random.default_rng(4)))
    result = _ratio(images[0], other)
    assert result.status == "refused"
    assert result.reason == "OTHER_LIGHT"


def test_a_picture_without_rings_is_named_and_leaves_too_few(images):
    noise = np.random.default_rng(1).integers(0, 60000, images[0].shape).astype(np.uint16)
    result = fitting.fit_together([images[0], noise], light="unknown", names=["rings", "noise"], view="reflected")
    assert result.status == "refused"
    assert result.reason == "TOO_FEW_PICTURES"
    assert "noise" in result.message


def _problem() -> tuple[SharedProblem, tuple[Curve, ...]]:
    """Two pictures of 60 bins in one channel, and curves near those of their rings."""
    rng = np.random.default_rng(3)
    squares = np.linspace(400.0, 2e4, 60)
    profiles = []
    for rate in (1e-10, 1.2e-10):
        turns = 2 * rate * squares[:, None] / np.array([540e-9, 580e-9])
        means = 1 - 0.4 * np.cos(2 * np.pi * turns).mean(axis=1) + 1e-3 * rng.normal(size=60)
        values, counts = np.broadcast_to(means, (1, 24, 60)).copy(), np.ones((24, 60))
        profiles.append(Profiles(squares, 300.0, values, values, counts, counts[None]))
    pictures = (0, 1)
    free = (
        Number("log_rate", (1,)), Number("offset", (0,)), Number("offset", (1,)), Number("blur", pictures),
        Number("gain_green", (1,)), Number("bend", pictures),
    )  # fmt: skip
    views = (View(5e-6, -1.0, 2e4),) * 2
    problem = SharedProblem(tuple(profiles), views, unknown_light(5e-6), (1,), np.full((2, 1), 1e-4), free)
    curves = tuple(Curve(float(np.log(1.001 * rate)), 0.002, 1.2) for rate in (1e-10, 1.2e-10))
    return problem, curves


@pytest.mark.parametrize("number", range(6))
def test_slopes_are_the_central_differences_of_the_sum_of_squares(number):
    problem, curves = _problem()
    numbers, step = problem.numbers(curves), 3 * problem.steps[number] * np.eye(6)[number]
    residual = problem.residual(curves)
    slope = problem.slopes(curves).T @ residual
    squares = [problem.residual(problem.with_numbers(curves, numbers + side * step)) for side in (1, -1)]
    expected = (squares[0] @ squares[0] - squares[1] @ squares[1]) / (4 * step[number])
    assert slope[number] == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"light": "mercury"}, "light is 'mercury'; allowed: 'unknown'"),
        ({"light": "unknown", "wavelength": 5.5e-7}, "light='unknown' and wavelength do not go together"),
        ({"light": "unknown", "channel": "red"}, "light='unknown' and channel do not go together"),
        ({"light": "unknown", "pixel_size": [5e-6, 6e-6]}, "pixel_size has several values"),
        ({"light": "unknown", "shared": "radius"}, "shared holds radius, which needs a wavelength"),
    ],
)
def test_what_does_not_go_with_unknown_light_is_refused(images, given, words):
    with pytest.raises(ValueError, match=words):
        fitting.fit_together(images, **given)


def test_one_picture_of_unknown_light_is_sent_to_the_ratio(images):
    with pytest.raises(ValueError, match=r"fitting\.ratio\(first, second, light='unknown'\)"):
        fitting.fit(images[0], light="unknown")


def test_the_shell_takes_unknown_light(images, tmp_path, pair, capsys):
    files = [tmp_path / "a.tif", tmp_path / "b.tif"]
    for file, image in zip(files, images, strict=True):
        tifffile.imwrite(file, image, photometric="rgb")
    out = tmp_path / "out"
    options = ["--light", "unknown", "--view", "reflected", "--output-dir", str(out)]
    assert main(["together", *map(str, files), *options]) == 0
    saved = json.loads((out / "result.json").read_text())
    assert saved["ratio"] == pytest.approx(pair.ratio, rel=1e-9)
    assert "one for all pictures" in (out / "report.html").read_text(encoding="utf-8")
    assert "--light unknown" in refusal(capsys, "fit", files[0], "--light", "unknown")
