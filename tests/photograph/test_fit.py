"""The fit on rendered rings: it finds them, is as sharp as the data allow, says so, and refuses what it must."""

from importlib.resources import as_file, files

import numpy as np
import pytest
from rings_data import WAVELENGTH, bound, rings

import fitting
import newtonjax as nj
from fitting.model import PARTS
from fitting.parameters import rounded
from fitting.photo import find_rings, read

GIVEN = {"wavelength": WAVELENGTH, "pixel_size": 5e-6}


@pytest.fixture(scope="module")
def fitted():
    return fitting.fit(rings(noise=0.05), **GIVEN)


@pytest.mark.parametrize("radius", [0.05, 0.3, 0.6])
def test_radius_is_within_four_standard_deviations_and_these_equal_the_bound(radius):
    errors = []
    for seed in range(4):
        result = fitting.fit(rings(radius, noise=0.05, seed=seed), **GIVEN)
        expected = bound(0.05, radius, 5e-6, (256, 256), (130.0, 120.0))
        assert result.status == "ok"
        # 65536 pixels give the noise to 0.3 %; the bound is that of six unknowns, the ones this image calls for.
        assert result.radius_sd_noise == pytest.approx(expected, rel=0.05)
        errors.append((result.radius - radius) / expected)
    assert np.max(np.abs(errors)) < 4
    # The mean square of four standard normal numbers lies below 4.7 in 99.9 % of cases.
    assert np.mean(np.square(errors)) < 4.7


@pytest.mark.parametrize("centre", [(-150.0, 90.0), (120.0, 330.0), (0.0, 0.0), (300.0, -40.0)])
def test_centres_outside_of_the_frame_are_found(centre):
    result = fitting.fit(rings(0.3, centre=centre, noise=0.05), **GIVEN)
    assert result.status == "ok"
    assert np.hypot(*np.subtract(result.centre_px, centre)) < 0.5
    assert abs(result.radius - 0.3) < 4 * result.radius_sd


def test_search_finds_scale_and_centre_without_a_start():
    image = rings(0.3, noise=0.1)
    found = find_rings(read(image))
    assert found.scale == pytest.approx(25e-12 / (0.3 * WAVELENGTH), rel=0.02)
    assert np.hypot(found.centre[0] - 130, found.centre[1] - 120) < 3


@pytest.mark.parametrize(("dark", "view"), [(True, "reflected"), (False, "transmitted")])
@pytest.mark.parametrize("gap", [0.0, 60e-9, -100e-9])
def test_gap_comes_back_modulo_half_a_wavelength_in_either_view(dark, view, gap):
    result = fitting.fit(rings(gap=gap, noise=0.02, dark=dark), view=view, **GIVEN)
    assert abs(result.gap - gap) < 5 * result.parameters["gap"].sd
    assert result.parameters["gap"].sd < 1e-9


def test_any_two_of_radius_wavelength_and_pixel_size_give_the_third(fitted):
    by_wavelength = fitting.fit(rings(noise=0.05), radius=0.3, pixel_size=5e-6).parameters["wavelength"]
    by_pixel = fitting.fit(rings(noise=0.05), radius=0.3, wavelength=WAVELENGTH).parameters["pixel_size"]
    relative = fitted.radius_sd / fitted.radius
    assert abs(by_wavelength.value - WAVELENGTH) < 4 * by_wavelength.sd
    assert abs(by_pixel.value - 5e-6) < 4 * by_pixel.sd
    assert by_wavelength.sd / WAVELENGTH == pytest.approx(relative, rel=1e-2)
    assert by_pixel.sd / 5e-6 == pytest.approx(relative / 2, rel=1e-2)


@pytest.mark.parametrize("unknown", ["radius", "wavelength", "pixel_size", "gap_index"])
def test_a_steep_sphere_biases_no_quantity(unknown):
    # The sphere differs from its parabola by (r/R)²/4, 1 % at the corner; the search starts 1e-4 to 1e-3 away. Of so
    # small a sphere under 5 mm of glass no microscope sees the rings, so there is nothing that one would add.
    truth = {"radius": 0.9e-3, "wavelength": WAVELENGTH, "pixel_size": 1e-6, "gap_index": 1.0}
    image = rings(truth["radius"], truth["pixel_size"], microscope=False)
    given = {name: value for name, value in truth.items() if name != unknown}
    result = fitting.fit(image, free=("gap_index",) if unknown == "gap_index" else (), **given)
    assert result.parameters[unknown].value == pytest.approx(truth[unknown], rel=1e-9)


def test_index_of_a_liquid_is_measured_when_named_free():
    image = rings(index=1.333, noise=0.05)
    result = fitting.fit(image, radius=0.3, free=("gap_index",), **GIVEN)
    index = result.parameters["gap_index"]
    assert abs(index.value - 1.333) < 4 * index.sd
    answer = result.to_dict()
    assert answer["gap_index"] == index.value
    assert [set(row) for row in answer["budget"]] == [{"source", "sd"}] * len(result.budget)
    assert fitting.FitResult.from_dict(answer).budget == result.budget


def test_standard_deviations_of_scale_and_wavelength_enter_the_budget(fitted):
    result = fitting.fit(rings(noise=0.05), pixel_size_sd=0.05e-6, wavelength_sd=0.3e-9, **GIVEN)
    budget = dict(result.budget)
    # The sphere is steeper than its parabola, and looked at by a microscope: by 1/4 and 1 1/2 of (r/R)², which is 9e-6
    # in the corners, the exponents 2 and -1 are not exact.
    assert budget["pixel_size"] == pytest.approx(2 * 0.01 * result.radius, rel=3e-5)
    assert budget["wavelength"] == pytest.approx(0.3 / 589.3 * result.radius, rel=3e-5)
    assert result.radius_sd == pytest.approx(np.sqrt(sum(sd**2 for sd in budget.values())), rel=1e-12)
    ends = result.radius * np.exp(np.array([-1.96, 1.96]) * result.radius_sd / result.radius)
    assert result.radius_interval == pytest.approx(ends, rel=1e-6)
    # Where nothing else is uncertain, dust may hold the gap open by unknown waves: by 3 um, 4 1/4 times as much of R.
    waves = dict(fitted.budget)["whole waves of the gap"]
    assert waves == pytest.approx(4.25 * 3e-6, rel=1e-3)
    assert fitted.radius_sd == pytest.approx(np.linalg.norm(list(dict(fitted.budget).values())), rel=1e-12)
    # Parts that may be there add little to the noise of rings without any: the answer is the mean over all sets.
    assert fitted.radius_sd == pytest.approx(np.hypot(fitted.radius_sd_noise, waves), rel=0.05)


def test_without_a_pixel_size_the_fringe_scale_is_the_answer(fitted):
    result = fitting.fit(rings(noise=0.05), wavelength=WAVELENGTH)
    assert (result.status, result.radius) == ("no-scale", None)
    # Without a scale there is no sphere: r² differs from it by (r/R)²/4, 2e-6 here, far below the noise.
    assert abs(result.fringe_scale_per_px2 - fitted.fringe_scale_per_px2) < 0.2 * fitted.fringe_scale_sd
    assert "pixel_size" in result.message


def test_a_radius_that_no_lens_has_is_doubted_and_a_wavelength_that_no_light_has_is_refused(fitted):
    far = fitting.fit(rings(noise=0.05), wavelength=WAVELENGTH, pixel_size=5e-4)
    assert far.status == "ok"
    assert any("is not what lenses and lamps have, 1 mm to 1000 m" in text for text in far.warnings)
    assert not any("is not what lenses" in text for text in fitted.warnings)
    none = fitting.fit(rings(noise=0.05), radius=1000 * fitted.radius, pixel_size=5e-6)
    assert (none.status, none.radius) == ("refused", None)
    assert none.message.startswith("the wavelength of 0.58")
    assert none.message.endswith("check the units")


def test_covariance_agrees_with_the_standard_deviations(fitted):
    sds = np.sqrt(np.diag(fitted.covariance))
    assert fitted.names == ("radius", "centre_x_px", "centre_y_px", "gap")
    # The covariance is that of the mean over all sets of parts.
    rows = [sd for source, sd in fitted.budget if source == "noise" or source in PARTS]
    of_image = [np.linalg.norm(rows), *(fitted.parameters[name].sd for name in fitted.names[1:])]
    assert sds == pytest.approx(of_image, rel=1e-9)


def test_held_values_are_held_and_sharpen_the_radius(fitted):
    result = fitting.fit(rings(noise=0.05), fixed={"gap": 0.0, "centre_px": (130.0, 120.0)}, **GIVEN)
    assert result.gap == pytest.approx(0.0, abs=1e-15)
    assert result.centre_px == pytest.approx((130.0, 120.0), abs=1e-12)
    assert result.radius_sd_noise < 0.8 * fitted.radius_sd_noise
    assert abs(result.radius - 0.3) < 4 * result.radius_sd


def test_a_centre_that_is_held_beside_the_rings_is_refused_and_not_moved():
    """The sample's, 23 px off; an answer with the centre at its place was stated as of the given one."""
    with as_file(files("fitting") / "data" / "sample.png") as sample:
        result = fitting.fit(sample, fixed={"centre_px": (330.0, 215.0)}, wavelength=WAVELENGTH, pixel_size=8e-6)
    assert (result.status, result.radius) == ("refused", None)


def test_a_start_leads_to_the_same_optimum_as_the_search(fitted):
    result = fitting.fit(rings(noise=0.05), start={"radius": 0.305, "centre_px": (128.0, 122.0)}, **GIVEN)
    assert result.radius == pytest.approx(fitted.radius, rel=1e-7)


def test_uneven_light_is_modelled_as_the_image_calls_for(fitted):
    y, x = np.mgrid[-1:1:256j, -1:1:256j]
    lit = rings() * (0.8 - 0.3 * x - 0.25 * y * y) + 0.1 * x
    noisy = lit + 0.03 * np.random.default_rng(5).normal(size=lit.shape)
    result = fitting.fit(noisy, **GIVEN)
    assert abs(result.radius - 0.3) < 4 * result.radius_sd
    assert "degree 0 background" not in result.model["illumination"]
    assert "degree 0 background, degree 0 contrast" in fitted.model["illumination"]


def test_dirt_and_dead_pixels_are_weighted_down():
    image = rings(noise=0.03)
    rng = np.random.default_rng(1)
    image[rng.random(image.shape) < 0.02] = 2.5
    image[60:64, :] = 0.0
    result = fitting.fit(image, **GIVEN)
    assert abs(result.radius - 0.3) < 4 * result.radius_sd
    assert "Tukey" in result.model["outliers"]


def test_a_mask_of_the_user_leaves_pixels_out():
    image = rings(noise=0.05)
    image[:, 200:] = np.random.default_rng(2).random((256, 56))
    mask = np.ones(image.shape, bool)
    mask[:, 200:] = False
    result = fitting.fit(image, mask=mask, **GIVEN)
    assert abs(result.radius - 0.3) < 4 * result.radius_sd


def test_correlated_residuals_raise_the_noise_row_and_are_told():
    wave = 0.05 * np.sin(np.arange(256) / 9)[None] * np.cos(np.arange(256) / 11)[:, None]
    result = fitting.fit(rings(noise=0.02) + wave, **GIVEN)
    plain = fitting.fit(rings(noise=0.02), **GIVEN)
    assert result.radius_sd_noise > 2 * plain.radius_sd_noise
    assert any("neighbouring" in text for text in result.warnings)
    assert not any("neighbouring" in text for text in plain.warnings)


@pytest.mark.parametrize(
    ("image", "reason"),
    [
        (np.full((128, 128), 0.4), "uniform"),
        (np.random.default_rng(0).random((128, 128)), "no rings"),
        (np.random.default_rng(1).normal(size=(256, 256)) ** 2, "no rings"),
        (0.5 + 0.4 * np.cos(np.arange(256) / 3)[None] * np.ones((256, 1)), "straight"),
        (rings(60.0, noise=0.02), ""),
        (np.linspace(0, 1, 256)[None] * np.ones((256, 1)) + 0.01 * np.random.default_rng(2).random((256, 256)), ""),
    ],
    ids=["uniform", "noise", "speckle", "wedge", "a twentieth of a ring", "gradient"],
)
def test_what_holds_no_radius_is_refused_with_a_reason(image, reason):
    result = fitting.fit(image, **GIVEN)
    assert (result.status, result.radius) == ("refused", None)
    assert reason in result.message
    assert result.message


def other_rings(kind):
    """Fringes of 40 or 20 pixels that a sphere does not make, 400 x 400 pixels, with the noise of a camera."""
    y, x = np.mgrid[:400, :400].astype(float)
    r, polar = np.hypot(x - 210, y - 189), np.arctan2(y - 189, x - 210)
    turns = {
        "equidistant, centre outside": np.hypot(x + 100, y + 60) / 15,
        "spiral": np.hypot(x + 100, y + 60) / 20 + np.arctan2(y + 60, x + 100) / (2 * np.pi) * 3,
        "steeper than a sphere": (r / 50) ** 2.5 / 1.2,
        "ellipses": ((x - 210) ** 2 + 1.32 * (y - 189) ** 2) / 2500,
        "twice equal": r**2 / 2500,
        "arms": r**2 / 2500 + 3 * polar / (2 * np.pi),
    }[kind]
    image = np.cos(2 * np.pi * turns)
    if kind == "twice equal":
        image = (image + np.cos(2 * np.pi * ((x - 120) ** 2 + (y - 230) ** 2) / 3500)) / 2
    return 0.5 + 0.4 * image + 0.012 * np.random.default_rng(5).normal(size=r.shape)


def test_ellipses_seen_along_the_normal_have_two_radii():
    result = fitting.fit(other_rings("ellipses"), view_angle=0.0, **GIVEN)
    # Turns of (x² + 1.32 y²)/2500 px² are those of curvatures of 1 and 1.32.
    scale = GIVEN["pixel_size"] ** 2 / WAVELENGTH * 2500
    assert result.radius_across == pytest.approx(scale, rel=2e-3)
    assert result.radius_along == pytest.approx(scale / 1.32, rel=2e-3)


@pytest.mark.parametrize(
    "kind",
    ["equidistant, centre outside", "spiral", "steeper than a sphere", "twice equal", "arms"],
)
def test_fringes_that_one_sphere_does_not_make_give_no_radius(kind):
    result = fitting.fit(other_rings(kind), **GIVEN)
    assert (result.status, result.radius) in [("refused", None), ("not-converged", None)]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"wavelength": -1.0, "pixel_size": 1e-6}, "wavelength is -1.0; allowed"),
        ({"wavelength": WAVELENGTH, "pixel_size": np.nan}, "pixel_size is nan; allowed"),
        ({**GIVEN, "radius": 0.3}, "nothing is left to measure"),
        ({**GIVEN, "view": "sideways"}, "view is 'sideways'; allowed"),
        ({**GIVEN, "fixed": {"tilt": 0.0}}, "fixed is .*tilt.*; allowed"),
        ({**GIVEN, "start": {"radius": 1.0}}, "start needs centre_px"),
        ({**GIVEN, "free": ("tilt",)}, "free is"),
        ({**GIVEN, "transfer": "wrong"}, "transfer is 'wrong'; allowed"),
        ({**GIVEN, "mask": np.ones((3, 3), bool)}, "mask has shape"),
        ({"radius": 0.3, **GIVEN, "free": ("gap_index",), "fixed": {"gap": 1e-7}}, "fixed gap needs the gap_index"),
        ({**GIVEN, "pixel_size_sd": -1.0}, "pixel_size_sd is -1.0; allowed"),
    ],
)
def test_unusable_input_raises_and_says_what_is_allowed(arguments, words):
    with pytest.raises(ValueError, match=words):
        fitting.fit(rings(), **arguments)


@pytest.mark.parametrize(("view", "screen"), [("reflected", 1e-2), ("transmitted", 1e-1)])
def test_with_the_bench_as_the_model_a_distant_screen_costs_nothing(view, screen):
    truth = nj.newton_rings(2.0, WAVELENGTH, 30e-9, view, screen=screen)
    camera = nj.Camera((256, 256), 2e-5, centre_px=(131.0, 125.0))
    image = np.asarray(nj.render(truth, camera, nj.Traced()))
    image = (image - image.min()) / np.ptp(image) + 0.03 * np.random.default_rng(4).normal(size=image.shape)
    guess = nj.newton_rings(1.6, WAVELENGTH, 0.0, view, screen=screen)
    result = fitting.fit(image, scene=guess, pixel_size=2e-5, pixel_size_sd=2e-8)
    noise = result.radius_sd_noise
    assert abs(result.radius - 2.0) < 4 * noise
    assert abs(result.gap - 30e-9) < 5 * result.parameters["gap"].sd
    formula = fitting.fit(image, wavelength=WAVELENGTH, pixel_size=2e-5, view=view)
    assert abs(formula.radius - 2.0) > 50 * noise
    # The scale's row follows the bench, not the formula's exact 2: it must differ where the screen is far.
    assert 0.5 < dict(result.budget)["pixel_size"] / (2e-3 * result.radius) < 1.5


def test_report_and_json_say_the_same(fitted):
    found = fitted.to_dict()
    assert found["radius_m"] == fitted.radius
    assert f"radius = {rounded(fitted.radius, fitted.radius_sd)} ± " in fitted.report()
    assert {"status", "message", "radius_m", "radius_sd_m", "radius_interval_m", "radius_sd_noise_m"} <= set(found)
    assert {"fringe_scale_per_px2", "centre_px", "gap_m", "contact_radius_m", "explained_variance"} <= set(found)
    assert {"budget", "warnings", "model", "seconds"} <= set(found)


def test_picture_of_a_fit_has_its_four_views_and_unwraps_to_straight_lines(fitted):
    figure = fitted.figure()
    assert len([axes for axes in figure.axes if axes.get_title()]) == 4
    from fitting.photograph.figure import unwrap

    data, model, _, _ = unwrap(fitted.picture, fitted.centre_px)
    both = np.isfinite(data) & np.isfinite(model)
    assert np.corrcoef(data[both], model[both])[0, 1] > 0.98


def test_rings_behind_shield_and_collecting_lens_give_the_radius_of_the_bench():
    options = {"wavelength": 500e-9, "view": "reflected", "screen": 1.0, "collecting_lens": 0.1, "shield": 0.9e-3}
    camera = nj.Camera((200, 240), 100e-6, (130.0, 90.0))
    image = nj.render(nj.newton_rings(0.3, gap=0.1e-6, **options), camera, nj.Traced())
    result = fitting.fit(image, scene=nj.newton_rings(0.27, **options), pixel_size=100e-6)
    assert result.status == "ok"
    # The plane that the lens shows moves with the radius, of which the start is 10 % off: 3 (r/R)^2 of that.
    assert result.radius == pytest.approx(0.3, rel=1e-5)
    assert result.gap == pytest.approx(0.1e-6, abs=1e-9)


def test_a_standard_deviation_may_be_a_percentage_and_progress_is_told():
    steps = []
    image = rings(noise=0.02)
    percent = fitting.fit(
        image, **GIVEN, pixel_size_sd="0.1%", progress=lambda done, total: steps.append((done, total))
    )
    number = fitting.fit(image, **GIVEN, pixel_size_sd=1e-3 * GIVEN["pixel_size"])
    assert dict(percent.budget)["pixel_size"] == pytest.approx(dict(number.budget)["pixel_size"], rel=1e-12)
    assert steps == [(k, 4) for k in (1, 2, 3, 4)]
