"""The pixel size from a ruled grid: at any angle, with a distortion, with a deviation that holds; or refused."""

import json

import numpy as np
import pytest
from rings_data import rings
from shell import refusal

import fitting
from fitting.shell.cli import main


def grid(angle=0.17, period=15.7, kappa=0.0, noise=0.05, seed=0, shape=(300, 400), stretch=1.0):
    """Bright lines on grey, PERIOD pixels apart in the middle, behind a radial distortion."""
    y, x = np.mgrid[: shape[0], : shape[1]].astype(float)
    middle = (shape[1] - 1) / 2, (shape[0] - 1) / 2
    u2 = ((x - middle[0]) ** 2 + (y - middle[1]) ** 2) / (middle[0] ** 2 + middle[1] ** 2)
    dx, dy = (x - middle[0]) * (1 + kappa * u2), (y - middle[1]) * (1 + kappa * u2)
    turns = [(np.cos(angle) * dx + np.sin(angle) * dy) / period, (-np.sin(angle) * dx + np.cos(angle) * dy) / period]
    turns[1] = turns[1] / stretch + 0.3
    lines = [np.exp(-(((t - np.round(t)) * period / 1.3) ** 2)) for t in turns]
    return 0.4 + 0.5 * np.maximum(*lines) + noise * np.random.default_rng(seed).normal(size=shape)


@pytest.mark.parametrize("angle", [0.0, 0.17, np.pi / 4])
def test_pixel_size_and_angle_of_a_turned_grid(angle):
    found = fitting.scale(grid(angle), division=0.2e-3)
    assert found.status == "ok"
    assert abs(found.pixel_size - 0.2e-3 / 15.7) < 5 * found.pixel_size_sd < 1e-3 * found.pixel_size
    assert np.tan(2 * (found.angle - angle)) == pytest.approx(0.0, abs=2e-3)
    assert found.lines[0] > 10


@pytest.mark.parametrize("kappa", [0.02, -0.02])
def test_distortion_of_the_camera_comes_out_and_leaves_the_middle_true(kappa):
    found = fitting.scale(grid(kappa=kappa), division=1e-4)
    assert found.distortion == pytest.approx(kappa, abs=1e-3)
    assert abs(found.pixel_size / (1e-4 / 15.7) - 1) < 5e-4


def test_unequal_sides_give_their_geometric_mean_and_a_warning():
    found = fitting.scale(grid(angle=0.0, stretch=1.05), division=1e-4)
    assert found.pixel_size_x / found.pixel_size_y == pytest.approx(1.05, abs=1e-3)
    assert found.pixel_size == pytest.approx(np.sqrt(found.pixel_size_x * found.pixel_size_y))
    assert any("longer one way" in text for text in found.warnings)


@pytest.mark.parametrize("angle", [0.0, 0.4, -0.6])
def test_a_tilted_grid_is_said_at_any_angle_and_its_standard_deviation_holds_half_of_the_stretch(angle):
    scale = fitting.scale(grid(angle=angle, stretch=1.01), division=1e-4)
    m = np.log(1.01)
    # The second direction's lines are wider apart: what is along the first one is 1.01 times as long on the object.
    assert (scale.stretch, scale.shear) == pytest.approx((m * np.cos(2 * angle), m * np.sin(2 * angle)), abs=4e-4)
    (warning,) = [text for text in scale.warnings if "longer one way" in text]
    assert 0.95 < float(warning.partition("% of a radius")[0].rpartition("(")[2]) < 1.05
    assert scale.pixel_size_sd == pytest.approx(0.005 * scale.pixel_size, rel=0.05)
    # Of a grid seen at a slant the pixel is what it is along the axis of the tilt.
    assert abs(scale.pixel_size - 1e-4 / 15.7) < 1.2 * scale.pixel_size_sd


@pytest.fixture(scope="module")
def noisy_scales():
    return [fitting.scale(grid(noise=0.15, seed=seed, shape=(200, 260)), division=1e-4) for seed in range(12)]


def test_a_grid_along_its_normal_is_not_said_to_be_tilted_and_its_sides_have_standard_deviations(noisy_scales):
    assert not [text for scale in noisy_scales for text in scale.warnings if "longer one way" in text]
    errors = [(scale.pixel_size_x - 1e-4 / 15.7) / scale.pixel_size_x_sd for scale in noisy_scales]
    # Twelve of the jackknife's ratios: a root mean square beyond 2.5 would say that its deviations are half as large.
    assert 0.2 < np.sqrt(np.mean(np.square(errors))) < 2.5


def test_deviation_is_the_scatter_over_seeds_and_holds_the_divisions_own(noisy_scales):
    scatter = np.std([scale.pixel_size for scale in noisy_scales], ddof=1)
    assert 0.5 < np.median([scale.pixel_size_sd for scale in noisy_scales]) / scatter < 2.5
    wide = fitting.scale(grid(), division=1e-4, division_sd=1e-6)
    assert wide.pixel_size_sd == pytest.approx(0.01 * wide.pixel_size, rel=0.05)


@pytest.mark.parametrize(
    "image",
    [
        np.random.default_rng(0).random((256, 256)),
        np.ones((256, 256)) * 0.5 + 0.01 * np.random.default_rng(1).normal(size=(256, 256)),
        0.5 + 0.4 * np.cos(np.arange(256) / 3)[None] + 0.02 * np.random.default_rng(2).random((256, 256)),
        grid() ** 2 * np.cos(np.hypot(*np.mgrid[:300, :400]) / 3),
        rings(0.3, 5e-6, (400, 400)) + rings(0.4, 5e-6, (400, 400), (90.0, 260.0)),
        0.5 + 0.4 * np.cos(2 * np.pi * np.hypot(*(np.mgrid[:400, :400] - 200.0)) / 20),
    ],
    ids=["noise", "grey", "one direction", "grid behind rings", "two rings", "equidistant rings"],
)
def test_what_is_no_grid_is_refused(image):
    found = fitting.scale(image, division=1e-4)
    assert (found.status, found.pixel_size) == ("refused", None)
    assert found.message.startswith("no ")


def test_photographed_reticle_gives_the_pixel_size_that_was_read_off_it(shared):
    found = fitting.scale(shared / "photos" / "reticle_0.2mm.jpg", division=0.2e-3)
    assert found.pixel_size_x == pytest.approx(12.73e-6, rel=2e-3)
    assert found.pixel_size_y == pytest.approx(12.77e-6, rel=2e-3)
    assert np.degrees(found.angle) == pytest.approx(10, abs=1.5)
    assert any("pixels are 0.004 longer one way" in text for text in found.warnings)
    assert found.pixel_size_sd > 0.0019 * found.pixel_size
    assert found.half_diagonal == pytest.approx(np.hypot(639, 479) / 2)


@pytest.mark.parametrize("division", [0.0, -1e-4, np.nan, 2.0])
def test_divisions_that_are_none_are_refused(division):
    with pytest.raises(ValueError, match="division is"):
        fitting.scale(grid(), division=division)


def test_the_verb_writes_what_the_fit_reads(tmp_path, capsys):
    import imageio.v3 as iio

    iio.imwrite(tmp_path / "grid.png", np.uint8(np.clip(255 * grid(), 0, 255)))
    folder = tmp_path / "out"
    assert main(["scale", str(tmp_path / "grid.png"), "--division", "0.2mm", "--output-dir", str(folder)]) == 0
    scale = fitting.Scale.load(folder / "result.json")
    assert scale.pixel_size == pytest.approx(0.2e-3 / 15.7, rel=1e-3)
    assert scale.half_diagonal == pytest.approx(np.hypot(399, 299) / 2)
    assert (folder / "result.png").stat().st_size > 10_000
    iio.imwrite(tmp_path / "rings.png", np.uint8(200 * rings(1.0, 0.2e-3 / 15.7, (300, 400)) + 20))
    capsys.readouterr()
    command = ["fit", str(tmp_path / "rings.png"), "--wavelength", "589.3nm", "--json", "-"]
    assert main([*command, "--scale-from", str(folder / "result.json")]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["parameters"]["pixel_size"]["sd"] == scale.pixel_size_sd
    assert abs(answer["radius_m"] - 1.0) < 4 * answer["radius_sd_m"]


def test_a_file_without_a_pixel_size_or_a_second_pixel_size_is_refused(tmp_path, capsys):
    (tmp_path / "rings.png").write_bytes(b"")
    scale = tmp_path / "other.json"
    scale.write_text(json.dumps({"status": "refused", "pixel_size_m": None}))
    message = refusal(capsys, "fit", tmp_path / "rings.png", "--scale-from", scale, "--pixel-size", "1um")
    assert "both give the pixel size" in message
    assert "holds no pixel_size_m" in refusal(capsys, "fit", tmp_path / "rings.png", "--scale-from", scale)


def test_progress_counts_the_fits_of_a_grid():
    steps = []
    fitting.scale(grid(), division=1e-4, progress=lambda *step: steps.append(step))
    assert steps == [(done, 19) for done in (*range(3), *range(4, 20))]
