"""What else may have made the rings: each rival speaks up where it is, and not where it is not; programs read it."""

import json

import numpy as np
import pytest
from rings_data import WAVELENGTH

import fitting
import newtonjax as nj
from experiments.truth.rival_pictures import picture
from fitting.photograph.model_rivals import _nearest_power

# Pixels so large that the sphere's own law differs from r² by less than a millionth.
GIVEN = {"wavelength": WAVELENGTH, "pixel_size": 2e-5}
SHAPE, CENTRE, UNIT, ORDERS = (300, 340), (150.0, 140.0), 226.0, 10.0
RADIUS = (UNIT * GIVEN["pixel_size"]) ** 2 / (ORDERS * WAVELENGTH)


def polar(shift=(0.0, 0.0)):
    """Distance from the centre over half of the diagonal, and the angle."""
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
    x, y = (x - CENTRE[0] - shift[0]) / UNIT, (y - CENTRE[1] - shift[1]) / UNIT
    return np.hypot(x, y), np.arctan2(y, x)


def noisy(light, noise=0.02, seed=0):
    return light + noise * np.random.default_rng(seed).normal(size=SHAPE)


def wave(extra=0.0):
    rho, _ = polar()
    return np.cos(2 * np.pi * (ORDERS * rho**2 + 0.3 + extra))


def fired(light, **given):
    result = fitting.fit(light, **(GIVEN | given))
    return result, {finding.rival: finding for finding in result.rivals}


@pytest.mark.parametrize("noise", [0.003, 0.02, 0.1])
@pytest.mark.parametrize("seed", range(4))
def test_rings_with_noise_alone_have_no_rival(noise, seed):
    result, rivals = fired(noisy(0.5 + 0.4 * wave(), noise, seed))
    assert (result.status, rivals) == ("ok", {})
    assert abs(result.radius / RADIUS - 1) < 4 * result.radius_sd / RADIUS


def moved(length):
    """Rings that moved by so many pixels along x while the shutter was open."""
    shifts = length * (np.arange(32) / 31 - 0.5)
    return np.mean([0.5 + 0.4 * np.cos(2 * np.pi * ORDERS * polar((shift, 0.0))[0] ** 2) for shift in shifts], axis=0)


@pytest.mark.parametrize("length", [7.0, 9.0])
def test_what_motion_does_to_the_rings_is_a_row_as_large(length):
    result, _ = fired(noisy(moved(length), 0.002))
    rows = dict(result.budget)
    error = abs(result.radius - RADIUS)
    assert error > 4 * rows["noise"]
    assert 0.5 < rows["blur"] / error < 2.0
    assert "blur" not in dict(fired(noisy(0.5 + 0.4 * wave(), 0.002))[0].budget)


@pytest.mark.parametrize(("seed", "given"), [(5014, GIVEN), (12000, {"wavelength": WAVELENGTH})])
def test_rings_in_the_fourth_power_of_the_radius_are_not_taken_for_distorted_or_pressed_ones(seed, given):
    result = fitting.fit(picture("fourth power", seed).image, **given)
    assert (result.status, result.reason) == ("refused", "RIVAL_RING_LAW")
    assert abs(result.message.values["power"] - 4) < 0.5


def test_rings_in_another_power_of_the_radius_are_not_taken_for_newtons():
    rho, _ = polar()
    light = noisy(0.5 + 0.4 * np.cos(2 * np.pi * (4.0 * rho**2.5 + 0.3)))
    assert fitting.fit(light, **GIVEN).status == "refused"


def spiral(orders, arms):
    rho, angle = polar()
    return 0.5 + 0.4 * np.cos(2 * np.pi * (orders * rho**2 + arms * angle / (2 * np.pi)))


@pytest.mark.parametrize("orders", [8.0, 13.0, 20.0])
@pytest.mark.parametrize("arms", [1, 2, 3])
def test_a_spiral_is_refused(orders, arms):
    assert fired(noisy(spiral(orders, arms)))[0].status == "refused"


@pytest.mark.parametrize("orders", [13.0, 20.0])
def test_a_spiral_of_one_arm_is_refused_because_its_fringes_are_astray(orders):
    result, rivals = fired(noisy(spiral(orders, 1)))
    assert (result.status, result.radius) == ("refused", None)
    assert rivals["astray"].consequence == "refusal"
    assert rivals["astray"].value > rivals["astray"].limit
    assert "spiral" in result.message


def test_dust_and_print_are_not_taken_for_fringes_that_are_astray():
    light = 0.5 + 0.4 * wave()
    rng = np.random.default_rng(3)
    for row, column in rng.integers(0, 280, (60, 2)):
        light[row : row + 8, column : column + 5] = 0.0
    result, rivals = fired(noisy(light))
    assert result.status == "ok"
    assert "astray" not in rivals


def test_many_beams_are_told_by_their_harmonics_and_covered():
    rho, _ = polar()
    light = 1 / (1 + 1.2 * np.sin(np.pi * ORDERS * rho**2) ** 2)
    result, rivals = fired(noisy(light), transfer="linear")
    assert result.status == "ok"
    assert rivals["waveform"].value > rivals["waveform"].limit > 0
    assert any("more beams" in text for text in result.warnings)
    assert abs(result.radius / RADIUS - 1) < 3 * result.radius_sd / RADIUS


def test_a_camera_curve_is_no_other_waveform():
    _, rivals = fired(noisy(0.5 + 0.4 * wave(), 0.005) ** (1 / 2.2), transfer="linear")
    assert "waveform" not in rivals


@pytest.mark.parametrize("contrast", [0.15, 0.4])
def test_a_second_system_is_told_by_its_scale_and_contrast(contrast):
    rho, _ = polar((-60.0, 40.0))
    second = np.cos(2 * np.pi * 1.5 * ORDERS * rho**2)
    result, rivals = fired(noisy(0.5 + 0.3 * (wave() + contrast * second)))
    assert result.status == "ok"
    assert "1.5 times their scale" in rivals["second system"].words
    assert rivals["second system"].words in result.warnings
    assert abs(result.radius / RADIUS - 1) < 3 * result.radius_sd / RADIUS


@pytest.mark.parametrize("fold", [1, 3], ids=["coma", "trefoil"])
@pytest.mark.parametrize("size", [0.05, 0.1])
def test_a_lens_with_coma_or_trefoil_is_that_in_the_model(fold, size):
    """And no rival of it: what a tenth of a wave moves the radius by is far below its deviation of 0.02 %."""
    rho, angle = polar()
    result, rivals = fired(noisy(0.5 + 0.4 * wave(size * rho**3 * np.cos(fold * (angle - 0.4)))))
    assert (result.status, rivals) == ("ok", {})
    assert result.model["lens_form"] == "probability 100%"
    assert abs(result.radius / RADIUS - 1) < 2 * result.radius_sd / RADIUS < 1e-3


@pytest.mark.parametrize("seed", [12016, 20006, 20010])
def test_coma_of_half_a_turn_is_measured_and_no_axis_off_the_middle(seed):
    """A distortion about such an axis has coma too: of seed 12016 it gave a radius six standard deviations off."""
    made = picture("coma", seed)
    result = fitting.fit(made.image, **GIVEN)
    assert result.status == "ok"
    assert abs(result.radius / made.radius - 1) < 4 * result.radius_sd / made.radius < 2e-3
    form = {name: (result.parameters[name].value, result.parameters[name].sd) for name in ("coma_x", "coma_y")}
    assert np.hypot(*(value for value, _ in form.values())) > 0.1
    assert result.priors["coma_x"]["sd"] == 0.5


@pytest.mark.parametrize("seed", [50007, 60011, 60034])
def test_trefoil_beyond_half_a_turn_is_measured_though_no_linear_term_takes_it(seed):
    """A distortion about an axis off the middle gave a radius 30 % off, more than four standard deviations."""
    made = picture("trefoil", seed)
    result = fitting.fit(made.image, **GIVEN)
    assert result.status == "ok"
    assert abs(result.radius / made.radius - 1) < 4 * result.radius_sd / made.radius < 4e-3
    assert result.priors["trefoil_x"]["sd"] == 0.5


def test_a_form_that_is_excluded_is_a_rival_in_the_budget():
    rho, angle = polar()
    result, rivals = fired(noisy(0.5 + 0.4 * wave(0.1 * rho**3 * np.cos(angle))), parts={"lens_form": False})
    assert rivals["form"].consequence == "budget"
    assert result.model["form"] == rivals["form"].words
    # What is said of the scale is what the row holds.
    assert abs(rivals["form"].words.values["shift"]) == pytest.approx(rivals["form"].deviation)
    assert abs(result.radius / RADIUS - 1) < 2 * result.radius_sd / RADIUS < 0.03


def test_a_form_too_large_for_an_estimate_is_a_warning_that_says_no_number_of_the_scale():
    rho, angle = polar()
    _, rivals = fired(noisy(0.5 + 0.4 * wave(1.0 * rho**4 * np.cos(2 * angle))), parts={"lens_form": False})
    assert (rivals["form"].consequence, rivals["form"].deviation) == ("warning", 0.0)
    assert set(rivals["form"].words.values) == {"size"}
    assert 1 < rivals["form"].words.values["size"] < 4


@pytest.mark.parametrize("share", [0.05, 0.1, 0.15])
def test_a_lens_with_two_radii_is_a_rival_of_a_view_at_an_angle(share):
    """Of principal curvatures (1 ± share / 2) / R the mean's radius is R, what a view leaves unchanged is larger."""
    rho, angle = polar()
    along, across = rho * np.cos(angle - 0.4), rho * np.sin(angle - 0.4)
    turns = ORDERS * ((1 + share / 2) * along**2 + (1 - share / 2) * across**2) + 0.3
    result, rivals = fired(noisy(0.5 + 0.4 * np.cos(2 * np.pi * turns)))
    geometric_mean = RADIUS / np.sqrt(1 - share**2 / 4)
    row = dict(result.budget)["view or form"]
    assert row == pytest.approx(geometric_mean - RADIUS, rel=0.05)
    assert result.radius == pytest.approx(geometric_mean, rel=2e-4)
    assert abs(result.radius - RADIUS) < 1.96 * result.radius_sd
    assert (rivals["view or form"].consequence == "warning") == (share > 0.08)


def test_programs_read_rivals_from_the_file_of_a_result(tmp_path):
    rho, angle = polar()
    result, _ = fired(noisy(0.5 + 0.4 * wave(0.1 * rho**3 * np.cos(angle))), parts={"lens_form": False})
    result.save(tmp_path / "result.json")
    rows = json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))["rivals"]
    assert [row["rival"] for row in rows] == [finding.rival for finding in result.rivals]
    assert {"rival", "value", "limit", "consequence", "words", "deviation"} == set(rows[0])
    assert fitting.FitResult.load(tmp_path / "result.json").rivals == result.rivals


def test_a_fit_without_a_scale_is_asked_the_same():
    rho, _ = polar((-60.0, 40.0))
    light = noisy(0.5 + 0.3 * (wave() + 0.3 * np.cos(2 * np.pi * 1.5 * ORDERS * rho**2)))
    result, rivals = fired(light, pixel_size=None)
    assert result.status == "no-scale"
    assert "second system" in rivals


def test_a_fit_with_a_scene_is_asked_the_same():
    scene = nj.newton_rings(RADIUS, WAVELENGTH)
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
    image = np.asarray(nj.render(scene, nj.Camera(SHAPE, 2e-5)))
    image = image / image.max()
    plain, rivals = fired(noisy(image), scene=scene)
    assert (plain.status, rivals) == ("ok", {})
    second = np.cos(2 * np.pi * 1.5 * ORDERS * ((x - 110) ** 2 + (y - 190) ** 2) / UNIT**2)
    _, rivals = fired(noisy(image + 0.15 * second), scene=scene)
    assert "second system" in rivals


def test_the_scale_of_elliptic_rings_does_not_depend_on_the_sides_of_the_field():
    """Without a pixel size too it is that of the geometric mean of the radii; a slope over the field was not."""
    rho, angle = polar()
    along, across = rho * np.cos(angle), rho * np.sin(angle)
    turns = ORDERS * (1.05 * along**2 + 0.95 * across**2) + 0.3
    result, _ = fired(noisy(0.5 + 0.4 * np.cos(2 * np.pi * turns)), pixel_size=None)
    assert "oblique_view" in result.evidence.found.parts
    scale = ORDERS / UNIT**2 * np.sqrt(1.05 * 0.95)
    assert result.fringe_scale_per_px2 == pytest.approx(scale, rel=2e-4)


@pytest.mark.parametrize("seed", [292, *range(20)])
def test_a_power_of_a_phase_that_none_fits_is_a_number(seed):
    random = np.random.default_rng(seed)
    x, y = random.uniform(-1.5, 1.5, (2, 200))
    radius = np.hypot(x, y)
    spikes = (radius == radius.max(), radius == radius.min(), radius > np.sort(radius)[-3])
    for turns in (*(spike.astype(float) for spike in spikes), np.zeros(200), random.normal(size=200)):
        assert np.isfinite(_nearest_power([x, y], turns, np.ones(200), (0.0, 0.0))).all()
