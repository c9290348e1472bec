"""Numbers of light and pixels in studies: slopes against formulas, and pairs that one picture does not separate."""

import json
from pathlib import Path

import numpy as np
import pytest

import newtonjax as nj
from experiments.truth import separable
from fitting import information, measurement, sensitivity
from fitting.parameters import chosen, knobs
from fitting.studies import derivative_images
from fitting.studies.fisher import derivatives
from fitting.studies.image_slopes import image_slopes
from fitting.studies.pixel_sums import image_of, slopes_of

ROOT = Path(__file__).parents[2]
CAMERA = nj.Camera((60, 50), 20e-6, centre_px=(22.0, 31.0))


def wide_line(gaussian=1e-9, lorentzian=2e-9):
    spectrum = nj.Spectrum((589e-9,), (1.0,), gaussian=(gaussian,), lorentzian=(lorentzian,))
    return nj.newton_rings(0.3, light=spectrum, gap=1e-6)


def test_slopes_by_rendered_images_are_those_of_the_nodes():
    scene = nj.newton_rings(0.5, 589e-9, gap=0.2e-6)
    names = ("radius", "gap", "centre_x", "exposure", "contrast", "stray", "wavelength", "pixel_size", "plate_tilt_x")
    numbers = list(chosen(knobs(scene, CAMERA), names).values())
    image, slopes = image_slopes(scene, CAMERA, numbers)
    table, changes = derivatives(scene, CAMERA, numbers, 17)
    expected = slopes_of(table, changes, CAMERA.shape)
    # Nodes have what little the amplitudes change towards the rim, the closed form does not.
    np.testing.assert_allclose(image, image_of(table, CAMERA.shape), atol=1e-4 * image.max())
    for name, slope, exact in zip(names, slopes, expected, strict=True):
        assert np.linalg.norm(slope - exact) < 1e-4 * np.linalg.norm(exact), name


def test_fringes_fade_with_widths_as_their_fourier_transforms():
    scene = wide_line()
    slopes = derivative_images(scene, CAMERA, ("contrast", "gaussian_width", "lorentzian_width"))
    x, y = CAMERA.axes()
    gap = 1e-6 + 0.3 - np.sqrt(0.09 - x**2 - y[:, None] ** 2)
    per_width = 2 * gap / 589e-9**2  # turns per metre of width
    expected = {
        "gaussian_width": -(np.pi**2 / (2 * np.log(2))) * per_width**2 * 1e-9,
        "lorentzian_width": -np.pi * per_width,
    }
    for name, factor in expected.items():
        exact = factor * slopes["contrast"]
        # What amplitudes change towards the rim is in the slope, and not in the background of the contrast.
        assert np.linalg.norm(slopes[name] - exact) < 1e-4 * np.linalg.norm(exact), name


def test_an_even_number_that_is_0_does_not_change_the_image_and_a_lorentzian_width_does():
    names = ("radius", "gap", "gaussian_width", "lorentzian_width", "blur")
    camera = nj.Camera((60, 50), 20e-6, centre_px=(22.0, 31.0), blur=0.0)
    undetermined = information(wide_line(0.0, 0.0), camera, free=names).undetermined
    unseen = [text.split(":")[0] for text in map(str, undetermined) if "the image does not change" in text]
    assert unseen == ["gaussian_width", "blur"]
    slope = derivative_images(wide_line(0.0, 0.0), camera, ("lorentzian_width",))["lorentzian_width"]
    wider = derivative_images(wide_line(0.0, 1e-14), camera, ("lorentzian_width",))["lorentzian_width"]
    np.testing.assert_allclose(slope, wider, atol=1e-3 * np.abs(wider).max())


def test_a_source_of_a_size_shortens_every_path_alike():
    sine = 0.02
    scene = nj.newton_rings(0.3, 589e-9, gap=1e-6, numerical_aperture=sine)
    slopes = derivative_images(scene, CAMERA, ("radius", "gap", "source_size"))
    longer = 1e-6 * slopes["gap"] - 0.3 * slopes["radius"]
    # The mean path over a disc is shorter by the part sin² / 4; fading adds 0.3 % here.
    expected = -sine / 2 * longer
    assert np.linalg.norm(slopes["source_size"] - expected) < 0.02 * np.linalg.norm(expected)


def test_numbers_of_a_bench_of_all_orders_are_those_of_its_closed_form():
    scene = nj.newton_rings(0.3, 589e-9, gap=1e-6, beams="all")
    named = {number.name for number in sensitivity(scene, CAMERA).neglected}
    assert "pixel_size" in named
    assert "light_tilt_x" not in named
    with pytest.raises(ValueError, match="light_tilt_x of a bench with all orders"):
        information(scene, CAMERA, free=("radius", "light_tilt_x"))


def test_studies_on_nodes_refuse_what_the_nodes_do_not_hold():
    scene = nj.newton_rings(0.5, 589e-9)
    for part in ({"blur": 1.0}, {"aperture": 1.0}, {"response": nj.cie_1931()}):
        camera = nj.Camera((20, 20), 30e-6, **part)
        with pytest.raises(ValueError, match="aperture, blur or response"):
            measurement(scene, camera)(np.zeros((20, 20)))


def test_pairs_that_one_picture_does_not_separate_are_told():
    rows = {case: separable.row(case, 120) for case in separable.CASES[:2]}
    blur_or_line, blur_or_gauss = rows.values()
    # On a sphere a Lorentzian line and a Gaussian blur are one function of the picture, but for the bend of a fringe.
    assert blur_or_line["correlation"] < -0.999999
    assert blur_or_line["sd of the first"] > 1000
    assert -0.96 < blur_or_gauss["correlation"] < -0.9


def test_the_manual_has_the_table_of_the_experiment():
    rows = json.loads((ROOT / "experiments/results/separable.json").read_text(encoding="utf-8"))
    assert [(row["first"], row["second"]) for row in rows] == [case[:2] for case in separable.CASES]
    assert separable.table(rows) in (ROOT / "docs/uncertainty.md").read_text(encoding="utf-8")
