"""Several photographs in one answer: ratios, one radius of many pictures, one camera, and who contradicts whom."""

import json

import numpy as np
import pytest

import fitting
from fitting.photograph.combination import _Levels, _spread
from fitting.photograph.joint import CAMERA_NUMBERS, Linear, View, joined, view_of
from fitting.shell.cli import main

SHAPE, WAVELENGTH, PIXEL = (160, 200), 589.3e-9, 1e-5
LAMP = {"wavelength": WAVELENGTH, "view": "reflected"}
NO_CONTACT = {"contact": False, "film": False, "lens_form": False, "oblique_view": False}


def lens(orders, distortion=0.0, seed=0, noise=0.02, wavelength=WAVELENGTH):
    """A photograph with so many orders at half a diagonal, of a camera with a distortion, and the lens's radius."""
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
    half = np.hypot(SHAPE[0] - 1, SHAPE[1] - 1) / 2
    u, v = (x - (SHAPE[1] - 1) / 2) / half, (y - (SHAPE[0] - 1) / 2) / half
    warp = 1 + distortion * (u**2 + v**2)
    r2 = (u * warp - 0.05) ** 2 + (v * warp + 0.08) ** 2
    turns = orders * r2 * WAVELENGTH / wavelength + 0.2
    noise = noise * np.random.default_rng(seed).normal(size=SHAPE)
    return 0.5 - 0.3 * np.cos(2 * np.pi * turns) + noise, (half * PIXEL) ** 2 / (orders * WAVELENGTH)


@pytest.fixture(scope="module")
def pair():
    images, radii = zip(lens(14.0, 0.015, 1), lens(11.0, 0.015, 2), strict=True)
    return fitting.ratio(*images, pixel_size=1.02 * PIXEL, pixel_size_sd="2%", **LAMP), radii


def test_the_ratio_of_two_lenses_does_not_know_the_scale(pair):
    result, radii = pair
    assert abs(result.ratio - radii[1] / radii[0]) < 3 * result.ratio_sd
    rows = dict(result.budget)
    assert rows.get("pixel_size", 0.0) < 1e-6
    assert result.ratio_sd < 1e-3
    # Each radius has the scale's whole error, 4 %.
    assert all(row.sd == pytest.approx(0.04 * row.value, rel=0.05) for row in result.members)
    assert result.ratio_interval[0] < result.ratio < result.ratio_interval[1]


def test_gaps_that_dust_holds_open_differ_by_less_than_each_is_wide(pair):
    # Gaps are even between 0 and g: g²/3 in the mean square each, g²/6 for a difference; R grows by as much a gap.
    result, radii = pair
    rows = [dict(fit.budget)["whole waves of the gap"] / fit.radius for fit in result.fits]
    assert rows[0] / rows[1] == pytest.approx(radii[1] / radii[0], rel=0.01)
    difference = 3 * (np.square(rows).sum() / 3 - rows[0] * rows[1] / 2)
    assert dict(result.budget)["whole waves of the gap"] / result.ratio == pytest.approx(np.sqrt(difference), rel=0.01)


def test_the_camera_has_one_distortion(pair):
    result, _ = pair
    value, sd = result.shared["distortion"]
    assert abs(value - 0.015) < 3 * sd < 0.001


def test_one_picture_together_with_none_is_its_own_average(pair):
    fit = pair[0].fits[0]
    evidence = fit.evidence
    average = evidence.averaging.mean(evidence.variance, ratio=evidence.ratio)
    joint = joined([view_of(evidence.averaging, evidence.variance, evidence.ratio, SHAPE)])
    assert joint.curvatures[0] == pytest.approx(average.numbers[0], rel=1e-12)
    assert joint.covariance[0, 0] == pytest.approx(average.covariance[0, 0], rel=1e-9)


def test_precisions_of_what_is_shared_add_up_and_the_prior_counts_once(pair):
    parts = frozenset(("distortion", "fifth_order"))
    views = []
    for fit in pair[0].fits:
        evidence = fit.evidence
        view = view_of(evidence.averaging, evidence.variance, 1.0, SHAPE)
        views.append(view._replace(options=tuple(option for option in view.options if option[0] == parts)))
    precisions = []
    for view in views:
        _, linear = view.options[0]
        free = np.isin(linear.names, ("distortion", "axis_x", "axis_y", "distortion_fifth_order"))
        precisions.append(linear.matrix[np.ix_(free, free)])
        prior = np.diag(linear.precision[free])
    covariance = np.linalg.inv(sum(precisions) + prior)
    joint = joined(views)
    least = np.sqrt(covariance[0, 0])
    # Larger only by the scatter of the pictures' own values.
    assert least * (1 - 1e-9) <= joint.shared["distortion"][1] < 3 * least


def view_of_camera(value, precision, prior, ratio, measured=1):
    """A picture that measures so many of the camera's numbers, and apart from them a curvature of variance 1."""
    size = len(CAMERA_NUMBERS)
    matrix = precision * np.diag(np.arange(size) < measured)
    pull, zeros = value * matrix.diagonal(), np.zeros(size)
    linear = Linear(CAMERA_NUMBERS, matrix, pull, value * pull.sum(), 1.0, zeros, 1.0, zeros, zeros, prior + zeros)
    return View(((frozenset(("distortion", "fifth_order")), linear),), ratio, 1.0, 100.0, SHAPE)


@pytest.mark.parametrize("ratio", [1.0, 3.0, 20.0])
def test_a_variance_that_explains_the_scatter_is_not_made_larger_by_it(ratio):
    # Two values 3 standard deviations to either side of their mean: chi-squared is 18 of one degree of freedom.
    views = [view_of_camera(side * 0.03, 1e4, 1e-6, ratio) for side in (1, -1)]
    assert joined(views).shared["distortion"][1] == pytest.approx(np.sqrt(max(18, ratio) / 2e4), rel=1e-3)


def test_numbers_that_their_prior_holds_scatter_with_all_their_freedom():
    # Each is one of its own standard deviations off the prior's middle, as chance has it: no reason to doubt any.
    views = [view_of_camera(side, 1.0, 1e6, 1.0, measured=4) for side in (1, -1)]
    np.testing.assert_allclose(joined(views).covariance, np.eye(2), rtol=1e-5)


@pytest.mark.parametrize("apart", [0.002, 0.016, 0.037, 0.296])
def test_two_exact_pictures_that_differ_have_all_their_spread(apart):
    spread = _spread(_Levels(np.array([0.0, apart]), {"pictures": 1e-30 * np.eye(2)}))
    assert spread == pytest.approx(apart**2 / 2, rel=1e-5)


def test_pictures_of_one_lens_give_one_radius_with_the_spread_between_them():
    wavelengths = [WAVELENGTH, 546.1e-9, 643.8e-9]
    images = [lens(12.0, seed=k, wavelength=wavelength)[0] for k, wavelength in enumerate(wavelengths)]
    truth = lens(12.0)[1]
    result = fitting.fit_together(
        images, shared=("radius", "distortion", "pixel_size"), wavelength=wavelengths, wavelength_sd="0.01%",
        pixel_size=PIXEL, view="reflected", parts=NO_CONTACT,
    )  # fmt: skip
    assert result.status == "ok"
    assert abs(result.value - truth) < 3 * result.sd
    assert result.sd < min(row.alone_sd for row in result.members)
    assert not [code for code in result.warning_codes if "CONTRADICT" in code]
    # Three lamps, each with an error of its own: less than that of one.
    assert dict(result.budget)["wavelength"] < 0.8e-4 * result.value
    values = [row.ratio for row in result.members]
    assert values == pytest.approx([1, 1, 1], abs=5 * max(row.ratio_sd or 0 for row in result.members))
    assert fitting.Together.from_dict(result.to_dict()) == result


def test_three_wavelengths_share_the_scales_error_and_average_their_own():
    lines = (435.8e-9, 546.1e-9, 578.0e-9)
    images, radii = zip(*(lens(14.0, seed=k, noise=0.1, wavelength=line) for k, line in enumerate(lines)), strict=True)
    given = {"pixel_size": PIXEL, "pixel_size_sd": "0.1%", "wavelength_sd": "0.1%", "view": "reflected"}
    shared = ("radius", "pixel_size", "distortion")
    together = fitting.fit_together(images, wavelength=list(lines), shared=shared, parts=NO_CONTACT, **given)
    alone = fitting.fit(images[1], wavelength=lines[1], parts=NO_CONTACT, **given)
    radius, sd = together.members[0].value, together.members[0].sd
    assert abs(radius - radii[0]) < 2 * sd < 2 * alone.radius_sd
    rows, of_one = dict(together.budget), dict(alone.budget)
    assert rows["pixel_size"] == pytest.approx(of_one["pixel_size"], rel=1e-3)
    assert rows["wavelength"] == pytest.approx(of_one["wavelength"] / np.sqrt(3), rel=1e-2)


def test_a_picture_of_another_camera_and_another_lens_is_named():
    images = [lens(12.0, 0.0, 1)[0], lens(12.0, 0.0, 2)[0], lens(12.4, 0.06, 3)[0]]
    forced = NO_CONTACT | {"distortion": True, "fifth_order": False}
    options = {"pixel_size": PIXEL, "names": ["first", "second", "third"], "parts": forced} | LAMP
    result = fitting.fit_together(images, **options)
    assert "PICTURE_CONTRADICTS" in result.warning_codes
    assert result.warnings[-1].startswith("third contradicts")
    assert result.members[2].contradiction > 5
    one_lens = fitting.fit_together(images, shared="radius", **options)
    assert (one_lens.status, one_lens.reason, one_lens.value) == ("refused", "NO_COMMON_VALUE", None)
    assert one_lens.warnings[-1].startswith("third contradicts")
    assert one_lens.message.endswith("measure each by itself, or leave out third")


def test_pictures_somewhat_apart_have_the_spread_in_their_deviation():
    images = [lens(orders, seed=k)[0] for k, orders in enumerate((12.0, 12.015))]
    result = fitting.fit_together(images, shared="radius", pixel_size=PIXEL, parts=NO_CONTACT, **LAMP)
    assert result.status == "ok"
    apart = abs(result.members[0].value - result.members[1].value)
    assert result.members[0].contradiction > 3
    assert dict(result.budget)["spread"] > 0.4 * apart
    assert result.sd > 0.4 * apart


def test_no_picture_counts_twice(tmp_path):
    picture = lens(12.0)[0]
    for name in ("a.npy", "copy_of_a.npy"):
        np.save(tmp_path / name, picture)
    copies = [tmp_path / "a.npy", tmp_path / "copy_of_a.npy"]
    with pytest.raises(ValueError, match=r"a.npy and copy_of_a.npy: pictures 1 and 2 are one picture, which would"):
        fitting.fit_together(copies, pixel_size=PIXEL, **LAMP)
    for verb in (fitting.fit_together, fitting.form):
        with pytest.raises(ValueError, match="are one picture"):
            verb([picture, picture[::-1], picture.copy()])


def test_a_picture_without_rings_is_left_out_and_two_are_needed():
    noise = np.random.default_rng(0).normal(size=SHAPE)
    image = lens(12.0)[0]
    result = fitting.fit_together([image, noise], pixel_size=PIXEL, **LAMP)
    assert (result.status, result.reason) == ("refused", "TOO_FEW_PICTURES")
    assert result.warning_codes == ["PICTURE_LEFT_OUT"]
    assert "picture 2 was left out: " in result.report()
    assert fitting.Together.from_dict(result.to_dict()) == result


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"images": [np.zeros((8, 8))]}, "allowed: a list of two photographs or more"),
        ({"shared": "form"}, "fitting.form"),
        ({"shared": ("radius",), "each": ("radius",)}, "radius is both shared and each picture's own"),
        ({"wavelength": [1e-7]}, "wavelength has 1 values for 2 pictures"),
        ({"names": ["a"]}, "a text for each of the 2 pictures"),
    ],
)
def test_what_cannot_be_put_together_is_refused_in_one_line(arguments, message):
    given = {"images": [lens(12.0)[0]] * 2, "pixel_size": PIXEL} | arguments
    with pytest.raises(ValueError, match=message):
        fitting.fit_together(**given)


def test_the_shell_puts_photographs_of_a_manifest_together(tmp_path, capsys):
    for name, orders in (("a", 12.0), ("b", 10.0)):
        np.save(tmp_path / f"{name}.npy", lens(orders, seed=int(orders))[0])
    (tmp_path / "list.csv").write_text("photo,wavelength\na.npy,589.3nm\nb.npy,sodium\n")
    command = ["together", str(tmp_path / "list.csv"), "--view", "reflected", "--no-contact", "--json", "-"]
    assert main(command) == 0
    answer = json.loads(capsys.readouterr().out)
    # Without a scale the ratio of the radii is there all the same.
    assert answer["status"] == "no-scale"
    assert abs(answer["ratio"] - 1.2) < 4 * answer["ratio_sd"] + 2e-5
    assert [row["name"] for row in answer["members"]] == ["a.npy", "b.npy"]
    assert main(["together", str(tmp_path / "a.npy")]) == 2
    assert "give two or more" in capsys.readouterr().err


def test_the_shell_puts_photographs_with_an_angle_of_view_together(tmp_path, capsys):
    for name, orders in (("a", 12.0), ("b", 10.0)):
        np.save(tmp_path / f"{name}.npy", lens(orders, seed=int(orders))[0])
    (tmp_path / "list.csv").write_text("photo,view_angle\na.npy,0deg\nb.npy,2deg\n")
    command = ["together", str(tmp_path / "list.csv"), "--view", "reflected", "--wavelength", "589.3nm", "--json", "-"]
    assert main([*command, "--view-angle-sd", "1deg", "--no-contact"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert abs(answer["ratio"] - 1.2) < 4 * answer["ratio_sd"]


@pytest.mark.parametrize(
    ("option", "words"), [("--fix=gap=0nm", "--fix is of one"), ("--wavelength=mercury", "mercury is light")]
)
def test_the_shell_names_what_is_of_one_photograph(tmp_path, capsys, option, words):
    files = [tmp_path / "a.npy", tmp_path / "b.npy"]
    for file in files:
        np.save(file, np.zeros((8, 8)))
    assert main(["together", *map(str, files), "--view", "reflected", option]) == 2
    refusal = capsys.readouterr().err
    assert words in refusal
    assert refusal.count("\n") == 1


def test_the_sodium_lenses_have_the_ratio_of_their_labels(shared):
    files = [shared / "trials" / "lens_850mm_sodium.jpg", shared / "photos" / "lens_1000mm_sodium.jpg"]
    # What `fitting.scale` says of photos/reticle_0.2mm.jpg.
    reticle = fitting.Scale(
        "ok", pixel_size=12.745e-6, pixel_size_sd=0.027e-6, stretch=-0.0038, shear=0.0, stretch_sd=3e-4, shear_sd=3e-4,
        distortion=0.0064, distortion_sd=0.0028, half_diagonal=399.3,
    )  # fmt: skip
    result = fitting.ratio(*files, **LAMP, scale=reticle)
    assert abs(result.ratio - 1000 / 850) < 1.5 * result.ratio_sd
    assert result.ratio_sd < 0.002
