"""A grid's scale in a fit: its standard deviation, the stretch of its pixels against the rings', its distortion."""

import json

import numpy as np
import pytest
from rings_data import WAVELENGTH, rings

import fitting
from fitting.parameters import camera_scale
from fitting.photograph.task import task_of
from fitting.shell.cli import main

SHAPE = (256, 256)


def scale(**changes):
    numbers = {
        "pixel_size": 5e-6, "pixel_size_sd": 5e-9, "stretch": 0.0, "shear": 0.0, "stretch_sd": 5e-4, "shear_sd": 5e-4,
        "distortion": 0.02, "distortion_sd": 0.003, "half_diagonal": np.hypot(255, 255) / 2,
    }  # fmt: skip
    return fitting.Scale("ok", **(numbers | changes))


def arguments(image, grid):
    names = ("pixel_size", "radius", "gap_index", "wavelength_sd", "pixel_size_sd", "radius_sd", "gap_index_sd")
    names += ("plate_radius", "plate_radius_sd", "view", "scene", "free", "fixed", "start", "transfer", "mask", "parts")
    names += ("page", "priors", "axis_px", "axis_px_sd", "view_angle", "view_angle_sd")
    return dict.fromkeys(names, None) | {
        "image": image,
        "scale": grid,
        "wavelength": WAVELENGTH,
    }


def test_the_scales_pixel_size_enters_with_its_standard_deviation():
    result = fitting.fit(rings(noise=0.02), wavelength=WAVELENGTH, scale=scale())
    assert dict(result.budget)["pixel_size"] == pytest.approx(2e-3 * result.radius, rel=1e-4)
    assert not [text for text in result.warnings if "are stretched" in text or "half diagonals" in text]


@pytest.mark.parametrize("changed", [{"stretch": 0.01}, {"shear": -0.01}])
def test_a_grid_that_is_stretched_and_rings_that_are_not_are_warned_of_with_numbers(changed):
    result = fitting.fit(rings(noise=0.02), wavelength=WAVELENGTH, scale=scale(**changed))
    (warning,) = [text for text in result.warnings if "are stretched" in text]
    # 0.01 at a standard deviation of 5e-4, next to which that of the rings is small.
    assert " standard deviations apart" in warning
    assert "The radius may be 1.0" in warning or "The radius may be 0.9" in warning


def test_rings_stretched_as_the_grid_is_are_not_warned_of():
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
    r2 = 25e-12 * ((x - 130) ** 2 * np.exp(0.02) + (y - 120) ** 2 * np.exp(-0.02))
    noise = 0.01 * np.random.default_rng(3).normal(size=SHAPE)
    image = 0.5 - 0.25 * np.cos(2 * np.pi * r2 / (0.3 * WAVELENGTH)) + noise
    alike, upright = (
        fitting.fit(image, wavelength=WAVELENGTH, scale=scale(stretch=stretch)) for stretch in (0.02, 0.0)
    )
    assert not [text for text in alike.warnings if "are stretched" in text]
    assert [text for text in upright.warnings if "stretched by 0.0" in text]


def test_a_stretch_that_is_not_fitted_is_what_the_image_would_give_it():
    image = rings(noise=0.02, seed=5)
    without, with_view = (
        fitting.fit(image, wavelength=WAVELENGTH, pixel_size=5e-6, parts={"oblique_view": wish})
        for wish in (False, True)
    )
    values, covariance = without.evidence.found.matrix.if_free(("stretch", "shear"), without.evidence.variance)
    free = [with_view.parameters[name] for name in ("stretch", "shear")]
    sds = np.sqrt(np.diag(covariance))
    assert values == pytest.approx([number.value for number in free], abs=0.1 * sds.min())
    assert sds == pytest.approx([number.sd for number in free], rel=0.05)


def test_the_grids_distortion_is_a_prior_in_half_diagonals_of_the_picture():
    image = rings(noise=0.02)
    assert task_of(arguments(image, scale())).priors["distortion"][:2] == pytest.approx((0.02, 0.003))
    # A quarter of the frame has half of its half diagonal: a quarter of the distortion there.
    cut = task_of(arguments(image[:128, :128], scale()))
    assert cut.priors["distortion"][:2] == pytest.approx((0.005, 0.00075), rel=0.02)
    assert any("half diagonals of 89.8 px, that of the grid 180.3 px" in text for text in cut.photograph.warnings)
    assert not task_of(arguments(image, scale(distortion=None, distortion_sd=None))).priors


def test_a_picture_larger_than_the_grids_is_said_to_be_of_another_camera():
    larger = task_of(arguments(np.tile(rings(noise=0.02), (2, 2)), scale()))
    assert "LARGER_THAN_GRID" in [text.code for text in larger.photograph.warnings]


def test_files_of_earlier_versions_get_half_of_the_difference_of_their_sides(tmp_path):
    file = tmp_path / "scale.json"
    sides = {"pixel_size_x_m": 5e-6 * np.exp(-0.005), "pixel_size_y_m": 5e-6 * np.exp(0.005)}
    file.write_text(json.dumps({"pixel_size_m": 5e-6, "pixel_size_sd_m": 3e-9, **sides}))
    camera = camera_scale(file)
    assert camera.pixel_size_sd == pytest.approx(np.hypot(3e-9, 0.005 * 5e-6))
    result = fitting.fit(rings(noise=0.02), wavelength=WAVELENGTH, scale=file)
    assert [text for text in result.warnings if "stretched by" in text and "-0.0100" in text]


def test_scales_that_are_none_are_refused(tmp_path):
    with pytest.raises(ValueError, match="scale and pixel_size both give the pixel size"):
        fitting.fit(rings(), wavelength=WAVELENGTH, scale=scale(), pixel_size=5e-6)
    with pytest.raises(ValueError, match="scale is 3"):
        camera_scale(3)
    with pytest.raises(ValueError, match="Scale of status 'refused' holds no pixel_size_m"):
        fitting.fit(rings(), wavelength=WAVELENGTH, scale=fitting.Scale("refused", "no grid"))
    with pytest.raises(FileNotFoundError, match="is not a file"):
        fitting.fit(rings(), wavelength=WAVELENGTH, scale=tmp_path / "none.json")
    (tmp_path / "text.json").write_text("[1, 2")
    with pytest.raises(ValueError, match="is no JSON"):
        fitting.fit(rings(), wavelength=WAVELENGTH, scale=tmp_path / "text.json")


def test_the_sodium_lenses_are_stretched_otherwise_than_their_reticle(shared):
    reticle = fitting.scale(shared / "photos" / "reticle_0.2mm.jpg", division=0.2e-3)
    result = fitting.fit(shared / "photos" / "lens_1000mm_sodium.jpg", wavelength=589.3e-9, scale=reticle)
    # By nothing that the image tells: its sign is noise.
    assert any(
        "are stretched by " in text and "0.000" in text.split("the grid")[0] and "by -0.0038" in text
        for text in result.warnings
    )
    # The reticle's sides differ by 0.4 %: of the radius as much.
    assert 0.003 < result.radius_sd / result.radius < 0.006


def test_the_grids_distortion_joins_that_of_the_image_as_their_deviations_say():
    """Two independent normal numbers: precisions add up; and the chain holds the same prior."""
    image, known = rings(noise=0.02), {"wavelength": WAVELENGTH, "parts": {"distortion": True, "fifth_order": False}}
    alone = fitting.fit(image, **known, pixel_size=5e-6).parameters["distortion"]
    sd = 2 * alone.sd
    grid = scale(distortion=alone.value + 3 * alone.sd, distortion_sd=sd)
    result = fitting.fit(image, **known, scale=grid)
    joined, precision = result.parameters["distortion"], 1 / alone.sd**2 + 1 / sd**2
    mean = (alone.value / alone.sd**2 + grid.distortion / sd**2) / precision
    assert joined.sd == pytest.approx(precision**-0.5, rel=0.02)
    assert joined.value == pytest.approx(mean, abs=0.05 * joined.sd)
    drawn = fitting.sample(result, steps=300, seed=0).of("distortion")
    assert drawn.std() == pytest.approx(joined.sd, rel=0.15)
    excluded = fitting.fit(image, wavelength=WAVELENGTH, scale=grid, parts={"distortion": False})
    assert "distortion" not in excluded.parameters


def test_a_lens_of_known_radius_is_a_scale_for_another(tmp_path, capsys):
    for name, radius in (("known", 0.3), ("other", 0.2)):
        np.save(tmp_path / f"{name}.npy", rings(radius, noise=0.02, seed=int(10 * radius)))
    lamp, file = ["--wavelength", "589.3nm", "--view", "reflected"], tmp_path / "scale.json"
    known = ["--radius", "0.3m", "--radius-sd", "0.4%", "--json", str(file)]
    assert main(["fit", str(tmp_path / "known.npy"), *lamp, *known]) == 0
    by_lens = fitting.FitResult.load(file)
    sd = by_lens.parameters["pixel_size"].sd
    assert sd / 5e-6 == pytest.approx(0.002, rel=0.01)
    capsys.readouterr()
    assert main(["fit", str(tmp_path / "other.npy"), *lamp, "--scale-from", str(file), "--json", "-"]) == 0
    answer = json.loads(capsys.readouterr().out)
    budget = {row["source"]: row["sd_m"] for row in answer["budget"]}
    assert budget["pixel_size"] == pytest.approx(0.004 * 0.2, rel=0.02)
    assert abs(answer["radius_m"] - 0.2) < 0.002 * 0.2
    assert "STRETCHED_OTHERWISE" not in answer["warning_codes"]
    in_python = fitting.fit(tmp_path / "other.npy", wavelength=589.3e-9, view="reflected", scale=by_lens)
    assert in_python.radius == pytest.approx(answer["radius_m"], rel=1e-12)


def test_a_fit_without_a_scale_ends_with_the_way_to_one(tmp_path, capsys):
    np.save(tmp_path / "rings.npy", rings(noise=0.02))
    assert main(["fit", str(tmp_path / "rings.npy"), "--wavelength", "sodium", "--view", "reflected"]) == 0
    commands = [line.split() for line in capsys.readouterr().out.splitlines() if line.startswith("    newtonjax ")]
    file = str(tmp_path / "scale.json")
    (_, again, points, _) = [[file if word == "scale.json" else word for word in words[1:]] for words in commands]
    assert main(points) == 0
    assert again[again.index("--wavelength") + 1] == "sodium"
    assert main(again) == 0
    assert "[[Next]]" not in capsys.readouterr().out
