"""Parts of the model: each is found where it is, is not where it is not, and leaves the radius true."""

import re
from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest

import fitting
import newtonjax as nj
from experiments.truth.defects import DRAWN, WAVELENGTH, Case, photograph
from experiments.truth.drawn_parts import DrawnParts
from fitting import model
from fitting.estimate import problem_of, solve
from fitting.parameters import Numbers
from newtonjax.scene import hertz_gap

CASE = Case("none", 1.0, 10e-6, 384, (200.0, 180.0), 0.0, 0.05, 3, 12.0)
PARTS = {
    "distortion 2 %": "distortion",
    "tilt 8 deg": "oblique_view",
    "contact 0.3 mm": "contact",
}


def fit(case: Case, **given):
    image, pixel_size, sd = photograph(case)
    return fitting.fit(image, wavelength=WAVELENGTH, pixel_size=pixel_size, pixel_size_sd=sd, **given)


@pytest.fixture(scope="module")
def plain():
    """The fit of the photograph without a defect."""
    return fit(CASE)


@pytest.fixture(scope="module")
def almost_noiseless():
    """Without any noise rounding chooses the illumination."""
    return fit(replace(CASE, noise=1e-4))


@pytest.mark.parametrize("defect", PARTS)
def test_a_part_that_is_there_is_found_and_the_radius_is_true(defect):
    result = fit(replace(CASE, defect=defect))
    assert PARTS[defect] in result.evidence.found.parts
    # A contact is chosen, by a search; over the others the answer is averaged.
    assert result.model[PARTS[defect]].startswith("kept" if PARTS[defect] == "contact" else "probability 100%")
    assert abs(result.radius - 1) < 4 * result.radius_sd < 4e-3
    assert PARTS[defect] in dict(result.budget)


@pytest.mark.parametrize("defect", ["none", "gamma 2.2", "vignette 20 %", "doublet"])
def test_no_part_is_kept_where_none_is(defect, plain):
    result = plain if defect == "none" else fit(replace(CASE, defect=defect))
    assert result.evidence.found.parts == ()
    # What a fitted exponent leaves of a gamma's harmonics errs together in zones, and counts as that.
    assert abs(result.radius - 1) < 4 * result.radius_sd < (1e-3 if defect == "gamma 2.2" else 4e-4)


def test_a_distortion_that_the_first_fit_is_not_linear_in_is_measured():
    """19 % at half a diagonal, and rings beyond a corner: without the part the fit explains half of the light."""
    glass = {"lens_index": 1.5, "lens_thickness": 5e-3}
    parts = DrawnParts(("distortion",), {"distortion": -0.19, "axis_x": -0.009, "axis_y": -0.01}, 1e-7, glass)
    far = Case(DRAWN, 0.53, 6.76e-6, 256, (-48.5, -47.5), 1e-7, 0.02, 61, 26.0, parts)
    result = fit(far)
    assert abs(result.radius / far.radius - 1) < 3 * result.radius_sd / far.radius < 3e-3
    assert result.evidence.found.correlation < 2


def test_a_gamma_is_found_and_named():
    result = fit(replace(CASE, defect="gamma 2.2", noise=0.01))
    found = float(re.search(r"exponent ([0-9.]+) \(fitted\)", result.model["channel"])[1])
    assert found == pytest.approx(2.2, abs=0.1)
    stated = fit(replace(CASE, defect="gamma 2.2", noise=0.01), transfer=2.2)
    assert "fitted" not in stated.model["channel"]
    assert result.radius == pytest.approx(stated.radius, abs=4 * stated.radius_sd)


def test_contact_radius_comes_out_with_its_deviation():
    result = fit(replace(CASE, defect="contact 0.3 mm"), parts={"contact": True})
    parameter = result.parameters["contact_radius"]
    assert result.contact_radius == parameter.value
    assert abs(parameter.value - 0.3e-3) < 4 * parameter.sd < 0.01e-3
    assert result.model["contact"].startswith("asked for")
    assert "contact_radius" in result.names


@pytest.mark.parametrize(("disc", "orders"), [(0.19, 10.6), (0.08, 12.5)])
def test_a_film_far_beyond_its_prior_leaves_the_radius_of_pressed_faces_true(disc, orders):
    """A quarter of a turn in the contact, where a phase within 0.04 is expected: it is measured to 0.001."""
    rows, columns = 240, 320
    y, x = np.mgrid[:rows, :columns].astype(float)
    half = np.hypot(rows - 1, columns - 1) / 2
    r2 = ((x - 168) ** 2 + (y - 112) ** 2) / half**2
    turns = orders * np.asarray(hertz_gap(jnp.asarray(r2), jnp.asarray(disc**2))) + 0.25
    noise = 0.006 * np.random.default_rng(1).normal(size=x.shape)
    result = fitting.fit(0.6 - 0.3 * np.cos(2 * np.pi * turns) + noise, view="reflected")
    truth = orders / half**2
    assert "contact" in result.evidence.found.parts
    assert abs(result.fringe_scale_per_px2 - truth) < 3 * result.fringe_scale_sd < 3e-4 * truth


def test_a_contact_that_may_be_there_is_averaged_over():
    y, x = np.mgrid[:384, :384] * 10e-6
    r2 = jnp.asarray((x - 2e-3) ** 2 + (y - 1.8e-3) ** 2)
    gap = np.asarray(hertz_gap(r2, jnp.asarray(0.16e-3**2))) / 2
    image = 0.5 - 0.4 * np.cos(4 * np.pi * gap / WAVELENGTH) + 0.4 * np.random.default_rng(1).normal(size=x.shape)

    def answer(**given):
        warps = dict.fromkeys(("oblique_view", "distortion", "fifth_order", "lens_form"), False)
        scale = {"wavelength": WAVELENGTH, "pixel_size": 10e-6}
        return fitting.fit(image, **scale, transfer="linear", parts=warps | given)

    average, pressed, plain = answer(), answer(contact=True), answer(contact=False)
    chance = float(re.search(r"probability (\d+)%", average.model["contact"])[1]) / 100
    assert 0.02 < chance < 0.98
    scales, sds = (
        np.array([getattr(fit, name) for fit in (pressed, plain)])
        for name in ("fringe_scale_per_px2", "fringe_scale_sd")
    )
    weights = np.array([chance, 1 - chance])
    mean = weights @ scales
    # The chance is printed in whole percent, and the fits that are averaged are those on blocks.
    assert abs(average.fringe_scale_per_px2 - mean) < 0.01 * np.ptp(scales) + 0.2 * sds.max()
    mixed = float(np.sqrt(weights @ (sds**2 + (scales - mean) ** 2)))
    # Clusters of residuals, which a fit without the contact has, make it wider.
    assert 0.9 * mixed < average.fringe_scale_sd < 1.5 * mixed
    assert "contact" in dict(average.budget)


def test_wishes_are_kept():
    case = replace(CASE, defect="distortion 2 %")
    without = fit(case, parts={"distortion": False, "fifth_order": False})
    assert "distortion" not in without.evidence.found.parts
    assert abs(without.radius - 1) > 0.01
    asked = fit(CASE, parts={"distortion": True})
    assert asked.evidence.found.parts == ("distortion",)
    assert abs(asked.radius - 1) < 4 * asked.radius_sd


def test_a_part_that_is_forced_is_there_with_what_it_needs():
    result = fit(CASE, parts={"fifth_order": True, "oblique_view": False, "contact": False})
    assert result.evidence.found.parts == ("distortion", "fifth_order")
    assert all(result.model[part].startswith("asked for") for part in ("distortion", "fifth_order"))
    assert abs(result.radius - 1) < 4 * result.radius_sd
    pressed = fit(replace(CASE, defect="contact 0.3 mm"), parts={"film": True, "distortion": False})
    assert {"contact", "film"} <= set(pressed.evidence.found.parts)
    assert all(pressed.model[part].startswith("asked for") for part in ("contact", "film"))


@pytest.mark.parametrize("parts", [{"fifth_order": True, "distortion": False}, {"film": True, "contact": False}])
def test_a_part_that_is_forced_without_what_it_needs_is_refused(parts):
    needs = r"(fifth_order is let in without distortion|film is let in without contact), which it needs"
    with pytest.raises(ValueError, match=needs):
        fit(CASE, parts=parts)


def test_a_model_that_lacks_a_part_says_so_in_a_row_of_its_budget():
    rows = dict(fit(replace(CASE, defect="distortion 2 %"), parts=dict.fromkeys(model.PARTS, False)).budget)
    assert rows["model, by halves of the field"] > 5 * rows["noise"]


def test_parts_that_are_none_are_refused():
    with pytest.raises(ValueError, match="oblique_view, distortion"):
        fit(CASE, parts={"tilt": True})


@pytest.mark.parametrize("name", ["stretch", "distortion", "distortion_fifth_order"])
def test_sensitivity_to_a_held_number_is_that_of_refitting(name, almost_noiseless):
    """By the implicit function theorem at the optimum; refitting with the number moved by 1e-4 gives the same."""
    found, moved = almost_noiseless.evidence.found, []
    weighted = replace(found.reduced, weights=found.left.weights)
    for step in (1e-4, -1e-4):
        numbers = np.array(Numbers(*found.numbers)._replace(**{name: step}))
        problem = problem_of(found.model, {}, (), found.shape)
        moved.append(solve(problem, weighted, numbers, tolerance=1e-9)["curvature"])
    assert Numbers(*found.matrix.shift_by(name)).curvature == pytest.approx((moved[0] - moved[1]) / 2e-4, rel=2e-3)


@pytest.mark.parametrize("plate", [2.5, -1.5])
def test_the_lens_on_a_curved_plate_comes_out_with_the_plates_deviation(plate, plain):
    """Rings of 1/R + 1/R_plate: 1 m rings belong to a lens of 1 / (1 - 1/R_plate)."""
    result = fit(CASE, plate_radius=plate, plate_radius_sd=0.01)
    truth = 1 / (1 - 1 / plate)
    assert abs(result.radius - truth) < 4 * result.radius_sd
    assert dict(result.budget)["plate_radius"] == pytest.approx(0.01 * truth**2 / plate**2, rel=1e-3)
    assert dict(result.budget)["noise"] == pytest.approx(dict(plain.budget)["noise"] * truth**2, rel=1e-3)
    rows = [sd for source, sd in result.budget if source == "noise" or source in model.PARTS]
    assert np.sqrt(result.covariance[0, 0]) == pytest.approx(np.linalg.norm(rows), rel=1e-3)


def test_two_steep_spheres_face_to_face_are_not_one():
    """Sags of 20 mm each: their fourth order is a quarter of that of the one sphere of 10 mm, 1e-3 of the radius.

    The picture is traced: looked at through the upper one, the fourth order is ten times as large.
    """
    bench = nj.newton_rings(20e-3, WAVELENGTH)
    upper, sphere, plate, lower = bench.surfaces
    bench = replace(bench, surfaces=(upper, sphere, replace(plate, curvature=-1 / 20e-3), lower))
    camera = nj.Camera((300, 300), 1.6e-6, centre_px=(140.0, 160.0))
    image = np.asarray(nj.render(bench, camera, nj.Chebyshev(33)))
    image = image / image.max() + 0.01 * np.random.default_rng(0).normal(size=image.shape)
    given = {"wavelength": WAVELENGTH, "pixel_size": 1.6e-6, "view": "reflected", "fixed": {"gap": 0.0}}
    result = fitting.fit(image, **given, plate_radius=20e-3)
    rows = dict(result.budget)
    assert abs(result.radius - 20e-3) < 4 * rows["noise"]
    assert rows["noise"] < 1e-4 * result.radius
    assert result.radius_sd == pytest.approx(np.linalg.norm(list(rows.values())), rel=1e-9)


def test_plates_that_cannot_be_are_refused():
    for plate, said in ((0.5, "lens is not convex"), (-1e-3, "is below its rings"), (1.0001, "is zero within")):
        result = fit(CASE, plate_radius=plate, plate_radius_sd=min(1e-3, 0.1 * abs(plate)))
        assert (result.status, result.radius) == ("refused", None)
        assert said in result.message
    with pytest.raises(ValueError, match="plate_radius is 0"):
        fit(CASE, plate_radius=0.0)
    with pytest.raises(ValueError, match="without plate_radius"):
        fit(CASE, plate_radius_sd=0.1)
    with pytest.raises(ValueError, match="no scene; leave it out"):
        fitting.fit(np.ones((64, 64)), wavelength=WAVELENGTH, plate_radius=1.0)
