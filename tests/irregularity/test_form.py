"""The form of a surface from one picture: found without a start, at the bound, with honest deviations; or refused."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy import ndimage
from shell import refusal

import fitting
from experiments.truth.form_pictures import SOUND, Fault, picture, random_form
from experiments.truth.forms import pull, two_radii
from fitting.irregularity.disc import Pupil, disc_of
from fitting.irregularity.indications import indications
from fitting.irregularity.projection import Degrees, fit_form
from fitting.irregularity.zernike import terms_at
from fitting.shell.cli import main


def scene_of(kind: str, seed: int, terms: int = 15, size: int = 256, noise: float = 0.05, fault: Fault = SOUND):
    rng = np.random.default_rng(seed)
    return picture(random_form(kind, terms, rng), size, noise, rng, fault)


@pytest.fixture(scope="module")
def scene():
    return scene_of("open", 3)


@pytest.fixture(scope="module")
def result(scene):
    return fitting.form(scene.image, pupil=scene.pupil, wavelength=632.8e-9, pixel_size=20e-6)


@pytest.mark.parametrize(("kind", "terms"), [("open", 15), ("closed", 36), ("saddle", 15), ("saddle", 36)])
def test_a_form_is_found_without_a_start(kind, terms):
    scene = scene_of(kind, 5, terms, 320)
    result = fitting.form(scene.image, pupil=scene.pupil)
    assert result.status == "ok"
    assert len(result.coefficients) == terms
    errors, pulls = pull(result, scene.form)
    # The largest of 35 normal errors exceeds 4.5 once in 4000 pictures.
    assert np.abs(pulls).max() < 4.5
    assert np.abs(errors).max() < 2e-3


def test_errors_scatter_as_the_deviations_say():
    pulls = np.concatenate(
        [
            pull(fitting.form(made.image, pupil=made.pupil), np.pad(made.form, (0, 21)))[1]
            for made in (scene_of(kind, seed, size=200) for kind in ("open", "closed", "saddle") for seed in range(5))
        ]
    )
    # 210 terms: the rms of as many unit normals is 1 ± 0.05; the blur's row makes it a little less.
    assert 0.75 < np.sqrt(np.mean(np.square(pulls))) < 1.15


def test_the_covariance_is_the_bound_of_cramer_and_rao(scene):
    pupil, degrees = Pupil(*scene.pupil), Degrees()
    disc = disc_of(scene.image, np.ones(scene.image.shape, bool), pupil)
    fit = fit_form(disc, scene.form, degrees)
    rows, columns = np.nonzero(disc.weights)
    u, v = disc.u[columns], disc.v[rows]
    polynomials = [np.stack([u**a * v**b for a in range(n + 1) for b in range(n + 1 - a)], axis=1) for n in degrees]
    turns = 2 * np.pi * (terms_at(u, v, 15) @ fit.coefficients)
    model = np.hstack([polynomials[0], polynomials[1] * np.cos(turns)[:, None]])
    linear = np.linalg.lstsq(model, disc.light[rows, columns].astype(float), rcond=None)[0]
    contrast = polynomials[1] @ linear[polynomials[0].shape[1] :]
    jacobian = np.hstack([-2 * np.pi * (contrast * np.sin(turns))[:, None] * terms_at(u, v, 15), model])
    residual = disc.light[rows, columns] - model @ linear
    variance = residual @ residual / (len(u) - jacobian.shape[1])
    bound = variance * np.diag(np.linalg.inv(jacobian.T @ jacobian))[:15]
    np.testing.assert_allclose(np.sqrt(np.diag(fit.covariance) / bound), 1.0, atol=5e-3)


@pytest.mark.parametrize(
    ("fault", "distortion_sd", "rim"),
    [
        (Fault(further=0.01), 0.0, 0.0),
        (Fault(blur=2.0), 0.0, 0.0),
        (Fault(distortion=0.05), 0.05, 0.0),
        (Fault(slant=0.15), 0.0, 0.008),
        (Fault(gamma=0.8), 0.0, 0.0),
        (Fault(dust=40), 0.0, 0.0),
    ],
)
def test_deviations_cover_what_is_not_in_the_model(fault, distortion_sd, rim):
    covered = []
    for seed, kind in enumerate(("open", "closed", "saddle")):
        made = scene_of(kind, seed, size=360, fault=fault)
        result = fitting.form(made.image, pupil=made.pupil, pupil_sd=rim * made.pupil[2], distortion_sd=distortion_sd)
        covered.append(np.abs(pull(result, np.pad(made.form, (0, 21)))[1]) < 1.96)
    assert np.concatenate(covered).mean() > 0.8


@pytest.mark.parametrize(("radius", "seed"), [(1.02, 1), (1.2, 1), (np.inf, 1), (np.inf, 3), (-1.3, 1)])
def test_two_radii_and_their_axis_come_out(radius, seed):
    assert np.abs(two_radii(radius, seed)).max() < 3.5


def test_the_sign_of_all_is_open_unless_a_term_decides_it(scene, result):
    assert "FORM_SIGN_OPEN" in result.warning_codes
    target = np.sign(scene.form[1])
    signed = fitting.form(scene.image, pupil=scene.pupil, sign=int(2 * target))
    assert "FORM_SIGN_OPEN" not in signed.warning_codes
    assert np.abs(np.array(signed.coefficients)[1:] - scene.form[1 : len(signed.coefficients)]).max() < 5e-3
    turned = fitting.form(scene.image, pupil=scene.pupil, sign=int(-2 * target))
    np.testing.assert_allclose(turned.coefficients[1:], -np.array(signed.coefficients[1:]), rtol=1e-12)


def test_a_term_of_no_size_decides_no_sign():
    made = scene_of("open", 3)
    form = made.form.copy()
    form[10:] = 0.0
    again = picture(form, 256, 0.05, np.random.default_rng(0))
    assert "FORM_SIGN_UNDECIDED" in fitting.form(again.image, pupil=again.pupil, sign=11).warning_codes


def test_contours_of_the_form_lie_on_the_dark_fringes(scene, result):
    x, y, radius = scene.pupil
    rows, columns = np.indices(scene.image.shape)
    u, v = (columns - x) / radius, (rows - y) / radius
    inside = np.hypot(u, v) < 0.9
    turns = terms_at(u[inside], v[inside], len(result.coefficients)) @ result.coefficients
    dark = np.abs(turns - np.floor(turns) - 0.5) < 0.1
    bright = np.abs(turns - np.round(turns)) < 0.1
    assert scene.image[inside][dark].mean() < 0.4 * scene.image[inside][bright].mean()


def test_words_of_iso_10110_5_of_single_terms_are_closed_forms():
    for term, letters in ((4, {"A": 2 * np.sqrt(3), "RMSt": 1.0}), (6, {"B": 2 * np.sqrt(6), "RMSi": 1.0, "RMSa": 1.0}),
                          (11, {"B": 1.5 * np.sqrt(5), "C": 1.5 * np.sqrt(5), "RMSi": 1.0})):  # fmt: skip
        form, covariance = np.zeros(15), np.diag(np.full(15, 1e-4))
        form[term - 1] = 0.3
        words = indications(form, covariance)
        for name in words:
            # The middle of the grid and the rim are among the points, so peak and valley are exact.
            expected = 0.3 * letters.get(name, 1.0 if name == "RMSt" else 0.0)
            assert words[name][0] == pytest.approx(expected, abs=1e-12), (term, name)
    assert words["RMSi"][1] == pytest.approx(0.01)


def test_the_deviation_of_a_peak_to_valley_is_that_of_draws():
    rng = np.random.default_rng(4)
    form, root = random_form("rough", 15, rng), 2e-3 * rng.normal(size=(15, 15))
    value, sd = indications(form, root @ root.T)["B"]
    draws = [indications(form + root @ rng.normal(size=15), np.eye(15))["B"][0] for _ in range(300)]
    assert sd == pytest.approx(np.std(draws), rel=0.15)
    assert value == pytest.approx(np.mean(draws), abs=0.5 * sd)


def test_the_pupil_is_found_by_its_edge():
    made = scene_of("open", 8, size=400)
    result = fitting.form(made.image)
    assert result.status == "ok"
    found = np.array(result.pupil)
    assert np.abs(found - made.pupil).max() < 2.0
    assert 0.5 <= result.pupil_sd < 4.0
    assert next(iter(result.budget)) == "pupil"
    _, pulls = pull(result, np.pad(made.form, (0, 21)))
    assert np.abs(pulls).max() < 3.0


def test_a_picture_without_an_edge_is_one_of_its_largest_circle(scene):
    x, y, radius = (round(number) for number in scene.pupil)
    half = round(0.68 * radius)
    cut = scene.image[y - half : y + half, x - half : x + half]
    result = fitting.form(cut)
    assert "PUPIL_NOT_SEEN" in result.warning_codes
    assert result.pupil.radius == pytest.approx(half - 0.5)
    assert result.status == "ok"


def test_terms_are_those_that_the_picture_bears():
    rng = np.random.default_rng(11)
    form = np.zeros(36)
    form[:6] = 0.2, 4.0, 1.0, 0.5, 0.2, -0.1
    for terms in (6, 10, 21):
        form[6:terms] = 0.02 * rng.choice([-1, 1], terms - 6)
        made = picture(form, 300, 0.05, rng)
        assert len(fitting.form(made.image, pupil=made.pupil).coefficients) == terms
    assert len(fitting.form(made.image, pupil=made.pupil, terms=10).coefficients) == 10


@pytest.mark.parametrize(
    ("image", "code"),
    [
        (np.ones((200, 200)), "UNIFORM"),
        (np.random.default_rng(0).normal(1.0, 0.1, (300, 300)), "FORM_NO_FRINGES"),
        (ndimage.gaussian_filter(np.random.default_rng(1).normal(1.0, 1.0, (300, 300)), 4.0), "FORM_NOT_CONFIRMED"),
    ],
)
def test_what_shows_no_form_is_refused_with_a_reason(image, code):
    result = fitting.form(image)
    assert (result.status, result.reason) == ("refused", code)
    assert result.coefficients is None
    assert result.parameters == {}


@pytest.mark.parametrize("pupil", [(-300.0, 100.0, 60.0), (100.0, 900.0, 60.0), (5.0, 5.0, 30.0)])
def test_a_pupil_without_enough_of_the_picture_is_refused(scene, pupil):
    assert fitting.form(scene.image, pupil=pupil).reason == "TOO_FEW_PIXELS"


def test_a_masked_part_is_not_looked_at(scene):
    x, y, radius = (round(number) for number in scene.pupil)
    mask = np.ones(scene.image.shape, bool)
    mask[y - radius // 2 : y, x : x + radius // 2] = False
    image = np.where(mask, scene.image, 0.7)
    result = fitting.form(image, pupil=scene.pupil, mask=mask)
    assert np.abs(pull(result, np.pad(scene.form, (0, 21)))[1]).max() < 4.5


def test_few_fringes_are_refused_with_what_would_help():
    form = np.array([0.1, 1.1, 0.0, 0.1, 0.0, 0.05])
    made = picture(form, 300, 0.03, np.random.default_rng(0))
    result = fitting.form(made.image, pupil=made.pupil)
    assert result.status == "refused"
    assert result.reason in ("FORM_FEW_FRINGES", "FORM_NO_FRINGES")
    assert result.figure().texts


def test_a_result_is_kept_in_files(result, tmp_path):
    result.save(tmp_path / "form.json")
    loaded = fitting.Form.load(tmp_path / "form.json")
    assert loaded == result
    assert loaded.report() == result.report()
    with pytest.raises(ValueError, match="has no photograph"):
        loaded.figure()
    loaded.save_map(tmp_path / "map.csv")
    table = np.genfromtxt(tmp_path / "map.csv", delimiter=",", names=True)
    assert table.dtype.names == ("column_px", "row_px", "departure_nm", "sd_nm")
    assert np.ptp(table["departure_nm"]) == pytest.approx(result.indications["B"][0] * 316.4, rel=0.03)
    assert len(result.figure().axes) == 6
    low, high = result.interval(4)
    assert low < result.coefficients[3] < high
    with pytest.raises(ValueError, match="term 40 was not measured"):
        result.interval(40)


def test_a_reference_moves_the_radii_where_the_sign_lets_it(scene):
    arguments = {"pupil": scene.pupil, "wavelength": 632.8e-9, "pixel_size": 20e-6, "reference_radius": 2.0}
    assert "radius_along" not in fitting.form(scene.image, **arguments).parameters
    signed = fitting.form(scene.image, **arguments, sign=4)
    radius = signed.parameters["radius_along"].value
    assert 1 / radius == pytest.approx(0.5 + signed.curvatures.along)


def test_straight_fringes_have_power_and_astigmatism_with_deviations():
    x = np.arange(100.0)
    fringes = np.tile(0.5 + 0.3 * np.cos(2 * np.pi * x / 9), (80, 1))
    noise = np.random.default_rng(0).normal(0, 0.02, fringes.shape)
    result = fitting.form(fringes + noise, pupil=(50.0, 40.0, 38.0), sign=4)
    assert (result.status, len(result.coefficients)) == ("ok", 6)
    assert np.shape(result.quadratic_covariance) == (3, 3)
    assert "6 terms" in result.report()


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"terms": 3}, "terms is 3; allowed: 6, 10"),
        ({"sign": 1}, "sign is 1; allowed"),
        ({"pupil": (10.0, 10.0, 5.0)}, "pupil is .*; allowed: column, row and radius"),
        ({"pupil": (10.0, np.nan, 50.0)}, "pupil is nan; allowed: one finite number"),
        ({"pupil_sd": -1.0}, "pupil_sd is -1"),
        ({"distortion_sd": 0.7}, "distortion_sd is 0.7; allowed: 0 to 0.3"),
        ({"reference_radius": 0.0}, "reference_radius is 0"),
        ({"wavelength": 5.0}, "wavelength is 5"),
        ({"pixel_size_sd": 1e-7}, "pixel_size_sd is given without pixel_size"),
    ],
)
def test_what_cannot_be_meant_is_refused(scene, arguments, text):
    with pytest.raises(ValueError, match=text):
        fitting.form(scene.image, **arguments)


def test_the_command_writes_the_form_its_picture_and_its_map(scene, tmp_path, capsys):
    np.save(tmp_path / "fringes.npy", scene.image)
    circle = ",".join(f"{number:.2f}" for number in scene.pupil)
    arguments = ["form", str(tmp_path / "fringes.npy"), "--pupil", circle, "--wavelength", "632.8nm", "--sign", "-4"]
    assert main([*arguments, "--output-dir", str(tmp_path / "out")]) == 0
    assert "3/" in capsys.readouterr().out
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "result.png", "report.html", "report.txt", "result.json", "map.csv"
    }  # fmt: skip
    saved = json.loads((tmp_path / "out" / "result.json").read_text())
    assert saved["coefficients_fringe"][3] < 0
    assert saved["nm_per_fringe"] == pytest.approx(316.4)
    assert "no circle" in refusal(capsys, *arguments[:2], "--pupil", "1,2")
    assert "not a file" in refusal(capsys, "form", str(tmp_path / "none.png"))
    np.save(tmp_path / "flat.npy", np.ones((200, 200)))
    assert "uniform" in refusal(capsys, "form", str(tmp_path / "flat.npy"), status=3)


def test_rings_of_the_simulator_give_the_lens_that_was_drawn():
    sample = Path(__file__).resolve().parents[2] / "fitting" / "data" / "sample.png"
    result = fitting.form(sample, wavelength=5.89294e-7, pixel_size=8e-6, sign=4)
    radii = [result.parameters[name] for name in ("radius_along", "radius_across")]
    # Drawn with 0.8462 m; a sphere's own fourth order is 1e-5 of this sag.
    assert all(abs(row.value - 0.8462) < 3 * row.sd < 2e-4 for row in radii)
    assert len(result.coefficients) == 6


def test_bent_fringes_of_a_trial_give_the_form_that_another_program_gives(shared):
    result = fitting.form(shared / "trials" / "slightly_bent_fringes.bmp")
    assert result.fringes == pytest.approx(20.4, abs=0.6)
    # Takeda's transform, scikit-image's unwrapping and prysm's Zernikes on R = 240.9 px: |0.4501|, |0.2743|.
    assert abs(result.coefficients[3] - 0.4501) < 2 * result.sds[3] < 0.08
    astigmatism = np.hypot(*result.coefficients[4:6])
    assert abs(astigmatism - 0.2743) < 0.07


def test_arcs_of_a_trial_are_156_fringes(shared):
    result = fitting.form(shared / "trials" / "arcs_60_fringes.png", pupil=(790.0, 778.0, 770.0), pupil_sd=4.0)
    assert result.fringes == pytest.approx(156, abs=1)
    assert result.coefficients[3] == pytest.approx(6.76, abs=0.05)
    assert result.coefficients[10] == pytest.approx(1.176, abs=0.05)
    assert result.agreement > 0.99
