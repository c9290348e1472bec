"""Parts under a test plate: right and covered by few fringes, or a request; sign, radius, files, pages."""

import json
from dataclasses import replace

import imageio.v3 as iio
import numpy as np
import pytest

import fitting
from experiments.truth import plates
from experiments.truth.plate_pictures import LOOK, POWER, lamp_picture, plate_picture, pressed_pictures, random_part
from fitting.irregularity.blurring import blurred
from fitting.irregularity.plate_radius import PlateLengths, part_radius
from fitting.irregularity.plate_sign import signed_by_steps
from fitting.irregularity.zernike import terms_at
from fitting.shell.cli import main

LOOK = LOOK._replace(size=160)
LENGTHS = {"plate_radius": 0.25, "wavelength": 546.1e-9, "diameter": 0.05}


def picture_of(power: float, irregularity: float, seed: int, tilt: float = 0.5):
    rng = np.random.default_rng(seed)
    form = random_part(power, irregularity, rng, tilt)
    return form, plate_picture(form, rng, LOOK)


@pytest.fixture(scope="module")
def scene():
    form, picture = picture_of(1.0, 0.1, 3)
    return form, picture


@pytest.fixture(scope="module")
def result(scene):
    return fitting.plate_test(scene[1].image, pupil=scene[1].pupil, rings_move="outwards", **LENGTHS)


@pytest.fixture(scope="module")
def uneven():
    form, picture = picture_of(3.0, 0.3, 5)
    return form, picture, fitting.plate_test(picture.image, pupil=picture.pupil)


def test_power_and_irregularity_are_right(uneven):
    form, _, answer = uneven
    # Of two normal errors one exceeds 4 deviations once in 8000 pictures.
    assert answer.power[0] == pytest.approx(3.0, abs=min(0.05, 4 * answer.power[1]))
    assert answer.irregularity_rms[0] == pytest.approx(0.3, abs=min(0.05, 4 * answer.irregularity_rms[1]))
    signed = np.array(answer.form.coefficients) * np.sign(form[3])
    assert np.linalg.norm((signed - form)[4:]) < 0.01
    assert answer.visibility == pytest.approx(LOOK.visibility, abs=0.05)


def test_light_and_form_that_are_one_picture_are_refused_with_the_request_and_a_picture_of_the_light_helps():
    rng = np.random.default_rng(2)
    form = random_part(0.3, 0.02, rng, tilt=0.3)
    picture = plate_picture(form, rng, LOOK)
    refused = fitting.plate_test(picture.image, pupil=picture.pupil)
    assert (refused.status, refused.reason) == ("refused", "PLATE_UNDETERMINED")
    assert "three pictures, each pressed by about a third" in refused.message
    assert refused.power is None
    lamp = lamp_picture(picture.light, rng, LOOK)
    answer = fitting.plate_test(picture.image, pupil=picture.pupil, light_picture=lamp)
    assert answer.status == "ok", answer.message
    assert abs(answer.power[0] - 0.3) < min(0.05, 4 * answer.power[1])
    assert "PLATE_SIGN_OPEN" in answer.warning_codes
    assert answer.part is None
    assert np.linalg.norm(form[4:]) == pytest.approx(answer.irregularity_rms[0], abs=0.05)


@pytest.mark.parametrize(
    ("kind", "power", "irregularity", "seed"),
    [
        # Its blur, 0.08 px², is less than samples of a Gaussian can be.
        ("sharp", 3.0, 0.3, 5),
        # Its light follows its form along a valley.
        ("sharp", 0.3, 0.02, 5),
        # Tilts from picture to picture are as large as the steps.
        ("three pressed pictures", 1.0, 0.02, 3),
    ],
)
def test_pictures_that_are_hard_to_follow_are_answered(kind, power, irregularity, seed):
    outcome = plates.case(kind, power, irregularity, seed)
    assert outcome["outcome"] == "answered"
    assert max(map(abs, outcome["pulls"])) < 4


@pytest.mark.parametrize("variance", [0.0, 0.08, 0.3, 0.499, 0.6, 2.0])
def test_a_blur_of_any_variance_has_the_moments_of_a_gaussian(variance):
    """The second is s², the fourth 3 s⁴; samples of a Gaussian and a cut at four deviations leave 2 %."""
    point = np.zeros((41, 41))
    point[20, 20] = 1.0
    of_row = blurred(point, variance).sum(axis=0)
    x = np.arange(41) - 20
    moments = [float(of_row @ x**power) for power in (0, 2, 4)]
    np.testing.assert_allclose(moments, [1, variance, 3 * variance**2], rtol=0.02, atol=1e-12)


def test_three_pressed_pictures_give_the_form_and_its_sign():
    rng = np.random.default_rng(1)
    form = random_part(3.0, 0.05, rng)
    pictures = pressed_pictures(form, rng, LOOK)
    answer = fitting.plate_test([picture.image for picture in pictures], pupil=pictures[0].pupil)
    assert answer.status == "ok"
    # Without their blur three fringes were off by 3 to 7 deviations.
    assert answer.power[0] == pytest.approx(POWER * form[3], abs=3 * answer.power[1])
    assert answer.power[1] < 1e-3
    assert 0 < answer.form.budget["blur"]["power"] < 2e-4
    assert "PLATE_SIGN_OPEN" not in answer.warning_codes
    assert np.all(np.diff(answer.form.steps) % 1 > 0.5)
    opposite = -4 if form[3] > 0 else 4
    flipped = replace(answer.form, coefficients=[-x for x in answer.form.coefficients])
    flipped = replace(flipped, steps=[-x for x in answer.form.steps])
    assert "PLATE_SIGN_CONTRADICTS" in signed_by_steps(flipped, opposite).warning_codes


def test_pressed_pictures_of_two_parts_are_refused_as_such():
    rng = np.random.default_rng(1)
    first, second = (pressed_pictures(random_part(power, 0.3, rng), rng, LOOK) for power in (1.0, 3.0))
    images = [first[0].image, first[1].image, second[2].image]
    refused = fitting.plate_test(images, pupil=first[0].pupil)
    assert (refused.status, refused.reason) == ("refused", "PLATE_FRAMES_CONTRADICT")
    assert refused.power is None


def test_pressed_pictures_whose_blur_reaches_in_from_the_rim_are_refused():
    rng = np.random.default_rng(1)
    pictures = pressed_pictures(random_part(1.0, 0.05, rng), rng, LOOK._replace(blur=3.0))
    refused = fitting.plate_test([picture.image for picture in pictures], pupil=pictures[0].pupil)
    assert (refused.status, refused.reason) == ("refused", "PLATE_FRAMES_BLURRED")
    assert "blurred by 3 px at an aperture of 78 px radius" in refused.message


def test_rings_that_move_inwards_turn_the_sign(scene, result):
    _, picture = scene
    inwards = fitting.plate_test(picture.image, pupil=picture.pupil, rings_move="inwards", **LENGTHS)
    assert result.power[0] == -inwards.power[0]
    # The gap that grows outwards is that of a convex part of the smaller radius.
    assert result.part.radius < 0.25 < inwards.part.radius


def test_the_radius_of_a_part_is_that_of_two_spheres():
    # Sags of spheres of 250 mm and 249.9 mm at the rim of 20 mm, in fringes of λ/2.
    sag = [radius - np.sqrt(radius**2 - 0.01**2) for radius in (0.25, 0.2499)]
    power = (sag[1] - sag[0]) / (546.1e-9 / 2)
    part = part_radius(PlateLengths(0.25, 1e-4, 546.1e-9, 0.0, 0.02, 0.0), power, 0.01)
    assert part.difference == pytest.approx(-1e-4, abs=part.difference_sd)
    assert part.radius_sd == pytest.approx(1e-4, rel=0.02)
    assert dict(part.budget)["power"] == pytest.approx(546.1e-9 * 0.01 / 0.01**2 * 0.2499**2, rel=1e-3)
    convex_plate = part_radius(PlateLengths(-0.25, 1e-4, 546.1e-9, 0.0, 0.02, 0.0), power, 0.01)
    assert convex_plate.radius == pytest.approx(-0.2501, abs=1e-6)


def test_there_is_no_radius_where_the_aperture_of_the_diameter_is_not_seen(scene):
    """The form is then one of the largest circle, whose diameter nobody has given."""
    inside = slice(30, -30)
    answer = fitting.plate_test(scene[1].image[inside, inside], **LENGTHS, rings_move="outwards")
    assert {"PUPIL_NOT_SEEN", "PLATE_NO_RADIUS"} <= set(answer.warning_codes)
    assert answer.part is None
    assert "the radius of the part needs pupil" in answer.report()


def test_dark_lines_of_the_form_lie_on_the_dark_fringes(uneven):
    form, picture, answer = uneven
    panel = answer.figure().axes[1]
    lines = np.concatenate([path.vertices for drawn in panel.collections for path in drawn.get_paths()])
    x, y, radius = picture.pupil
    u, v = (lines - (x, y)).T / radius
    turns = terms_at(u, v, len(form)) @ form
    assert len(lines) > 200
    # At half a turn the gap's light is least; a line is at most a hundredth of a fringe beside it.
    assert np.abs(turns - np.round(turns)).min() > 0.49


def test_a_result_is_kept_in_a_file(result, tmp_path):
    result.save(tmp_path / "plate.json")
    loaded = fitting.PlateTest.load(tmp_path / "plate.json")
    assert loaded == result
    assert loaded.report() == result.report()
    assert loaded.parameters["radius"].unit == "m"
    assert "power" in repr(result)


@pytest.mark.parametrize(
    ("image", "reason"),
    [
        (np.ones((120, 120)), "UNIFORM"),
        (np.random.default_rng(0).normal(1.0, 0.3, (120, 120)), "PLATE_UNDETERMINED"),
    ],
)
def test_what_is_no_picture_of_a_part_is_refused(image, reason):
    assert fitting.plate_test(image, pupil=(59.5, 59.5, 55.0)).reason == reason


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"rings_move": "up"}, "rings_move is 'up'; allowed: outwards, inwards"),
        ({"plate_radius": 0.0}, "plate_radius is 0.0; allowed"),
        ({"plate_radius": 0.02, "diameter": 0.05}, "diameter is 0.05; allowed: 1e-5 to 0.04 m"),
        ({"light_picture": np.eye(40)}, "give one of the same camera"),
    ],
)
def test_what_cannot_be_meant_is_refused_in_one_line(scene, options, message):
    with pytest.raises(ValueError, match=message):
        fitting.plate_test(scene[1].image, pupil=scene[1].pupil, **options)


def test_the_verb_writes_its_answer_and_a_page(scene, tmp_path, capsys):
    _, picture = scene
    file = tmp_path / "plate.png"
    iio.imwrite(file, np.uint8(np.clip(110 * picture.image, 0, 255)))
    circle = ",".join(f"{number:g}" for number in picture.pupil)
    words = ["--plate-radius", "250mm", "--wavelength", "546.1nm", "--diameter", "50mm", "--transfer", "linear"]
    command = ["testplate", str(file), *words, "--pupil", circle, "--rings-move", "outwards", "--json", "-"]
    assert main([*command, "--output-dir", str(tmp_path / "out")]) == 0, capsys.readouterr().err
    answer = json.loads(capsys.readouterr().out)
    assert answer["power_fringe"] == pytest.approx(1.0, abs=0.05)
    assert answer["radius_m"] == pytest.approx(0.24995, abs=1e-5)
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "Budget of radius [m]" in page
    assert (tmp_path / "out" / "map.csv").exists()
