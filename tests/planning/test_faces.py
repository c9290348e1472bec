"""What no lens does within an image: end, pass through the plate, fold its rays; each in one line."""

import warnings

import jax
import numpy as np
import pytest
from shell import refusal

import newtonjax as nj
from fitting.shell.cli import main

# 10 mm to a side, 14 mm from corner to corner.
CAMERA = nj.Camera((24, 24), 10e-3 / 23)
DIPS = {"asphere": (-2e4,)}
ENDS = {"zernike": (0.0, 0.0, 0.0, 5e-8), "zernike_radius": 4e-3}
FOLDS = {"asphere": (3e7,)}


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (DIPS, "FACES_CROSS"),
        ({"radius_across": -1.0}, "FACES_CROSS"),
        ({"radius": -1.0}, "FACES_CROSS"),
        ({"plate_radius": -0.5}, "FACES_CROSS"),
        (ENDS, "SURFACE_ENDS"),
        ({"radius": 4e-3, "conic": 0.0}, "SURFACE_ENDS"),
        ({}, None),
        ({"gap": -3e-6}, None),
        ({"gap": -3e-6, "conic": -1.0}, None),
        ({"gap": 60e-6, **DIPS}, None),
        ({"lens_tilt": (1e-3, 0.0)}, None),
        ({"zernike": (0.0, 0.0, 0.0, 0.0, 3e-8), "zernike_radius": 8e-3}, None),
    ],
)
def test_a_plan_warns_of_faces_that_end_or_cross_within_the_image(words, code):
    plan = nj.plan(nj.newton_rings(**words), CAMERA)
    assert [said.code for said in plan.warnings] == ([] if code is None else [code])


def test_the_depth_of_a_crossing_is_that_of_the_heights():
    """R = 1 m and -2e4 r⁴ at the outermost of 17 nodes, 5 mm cos(π/34) off in x and y: 24.8 um - 49.2 um."""
    (said,) = nj.plan(nj.newton_rings(**DIPS), CAMERA).warnings
    assert said.values == {"x_mm": "-4.98", "y_mm": "-4.98", "depth_um": "24.4"}
    assert str(said) == (
        "the faces of the gap pass through each other, by 24.4 um at (-4.98, -4.98) mm: a real lens touches first; "
        "allowed: a gap larger by that (drawn are the fringes of the heights as they are)"
    )


def test_render_says_what_its_plan_warns_of():
    with pytest.warns(UserWarning, match="faces of the gap pass through each other, by 24.4 um"):
        nj.render(nj.newton_rings(**DIPS), CAMERA)
    ends = r"surfaces\[1\] ends 4 mm from its vertex, where its Zernike ends, and the image reaches 7.071 mm"
    for method in (None, nj.Traced()):
        with pytest.warns(UserWarning, match=ends):
            nj.render(nj.newton_rings(**ENDS), nj.Camera((3, 3), 5e-3), method)


def test_a_surface_that_folds_its_rays_is_refused_and_a_smaller_image_of_it_is_not():
    """3e7 r⁴ has a slope of 0.96 at 2 mm, which throws light out of the glass, and of 0.04 at 0.7 mm."""
    scene = nj.newton_rings(**FOLDS)
    for verb in (nj.plan, nj.render):
        with pytest.raises(ValueError, match=r"surfaces\[1\] \(asphere\): too steep .*, slopes up to .* its rays fold"):
            verb(scene, CAMERA)
    assert np.isfinite(nj.plan(scene, nj.Camera((24, 24), 1e-3 / 23)).intensity_error)


def test_nothing_is_said_under_a_transformation():
    def corner(gap):
        return nj.render(nj.newton_rings(gap=gap, **ENDS), nj.Camera((3, 3), 5e-3), nj.Traced())[0, 0]

    with pytest.warns(UserWarning, match="surfaces"):
        corner(0.0)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        jax.jit(corner)(0.0)
    assert not said


def test_the_shell_says_so_too(capsys, tmp_path):
    scene, picture = tmp_path / "scene.toml", tmp_path / "rings.png"
    camera = "\n[camera]\nshape = [24, 24]\npixel_size = 4.3e-4\n"
    scene.write_text("[newton_rings]\nradius = 1.0\nasphere = [-2e4]\n" + camera)
    assert main(["render", str(scene), "--output", str(picture)]) == 0
    assert "\nwarning: the faces of the gap pass through each other, by 2" in capsys.readouterr().out
    scene.write_text("[newton_rings]\nzernike = [0.0, 0.0, 0.0, 5e-8]\nzernike_radius = 4e-3\n" + camera)
    assert main(["render", str(scene), "--force", "--output", str(picture)]) == 0
    assert "\nwarning: surfaces[1] ends 4 mm from its vertex, where its Zernike ends" in capsys.readouterr().out
    scene.write_text("[newton_rings]\nradius = 1.0\nasphere = [3e7]\n" + camera)
    assert "too steep for this image" in refusal(capsys, "render", scene, "--output", tmp_path / "folded.png")
