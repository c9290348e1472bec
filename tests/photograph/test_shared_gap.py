"""The gap of one lens from its rings in several wavelengths: which order it has, and how sure that is."""

import json

import numpy as np
import pytest

import fitting
from fitting.photograph.shared_gap import Fraction, shared_gap, window_of
from fitting.shell.cli import main

MERCURY = (546.074e-9, 578.01e-9)
HALF = 0.5 / (1 / MERCURY[0] - 1 / MERCURY[1])
LENS = {"view": "reflected", "shared": ("gap", "distortion")}
NO_PARTS = dict.fromkeys(("distortion", "fifth_order", "lens_form", "oblique_view"), False)


def fractions(gap, wavelengths=MERCURY, sd=1e-3, rng=None, relative_sd=0.0):
    """What pictures say of a gap; with `rng` off by a normal error."""
    off = np.zeros(len(wavelengths)) if rng is None else sd * rng.normal(size=len(wavelengths))
    turns = 2 * gap / np.array(wavelengths) + off
    rows = zip(turns - np.round(turns), wavelengths, strict=True)
    return [Fraction(turn, sd, wavelength, relative_sd) for turn, wavelength in rows]


def rings(gap, wavelength, seed, noise=0.02):
    """A picture of 12 rings of green; `gap` at the centre [m]."""
    y, x = np.mgrid[:160, :200].astype(float)
    squares = ((x - 92) ** 2 + (y - 85) ** 2) / 127.5**2
    turns = (12 * squares * 546e-9 + 2 * gap) / wavelength
    return 0.5 - 0.3 * np.cos(2 * np.pi * turns) + noise * np.random.default_rng(seed).normal(size=x.shape)


@pytest.fixture(scope="module")
def pair():
    images = [rings(3.217e-6, wavelength, seed) for seed, wavelength in enumerate(MERCURY)]
    return images, fitting.fit_together(images, wavelength=list(MERCURY), parts=NO_PARTS, **LENS)


@pytest.mark.parametrize("gap", [0.0, 0.3e-6, 3.217e-6, 4.7e-6])
def test_exact_phases_give_the_gap_back(gap):
    answer = shared_gap(fractions(gap), window_of(MERCURY))
    assert (answer.status, answer.value) == ("ok", pytest.approx(gap, abs=1e-13))
    assert answer.orders[0].orders == tuple(round(2 * gap / wavelength) for wavelength in MERCURY)


def test_the_window_is_half_of_the_synthetic_wavelength():
    low, high = window_of(MERCURY)
    assert -0.1e-6 < low < 0
    assert high - low == pytest.approx(HALF, rel=1e-12)
    # The closest pair has the longest one.
    assert np.ptp(window_of((435.8e-9, *MERCURY))) == pytest.approx(HALF, rel=1e-12)


@pytest.mark.parametrize(("sd", "least_told"), [(1e-3, 0.9), (4e-3, 0.5), (0.02, 0.0), (0.1, 0.0)])
def test_of_orders_that_are_told_99_of_100_are_right(sd, least_told):
    rng = np.random.default_rng(3)
    truths = rng.uniform(0, window_of(MERCURY)[1], 1000)
    answers = [shared_gap(fractions(gap, sd=sd, rng=rng), window_of(MERCURY)) for gap in truths]
    pairs = [(gap, answer.value) for gap, answer in zip(truths, answers, strict=True) if answer.value is not None]
    right = [abs(value - gap) < MERCURY[0] / 4 for gap, value in pairs]
    assert len(pairs) >= least_told * len(truths)
    assert sum(right) >= 0.99 * len(pairs)


def test_probabilities_are_shares_of_right_orders():
    rng = np.random.default_rng(4)
    truths = rng.uniform(0, window_of(MERCURY)[1], 2000)
    chances, hits = [], []
    for gap in truths:
        best = shared_gap(fractions(gap, sd=0.015, rng=rng), window_of(MERCURY)).orders[0]
        chances.append(best.probability)
        hits.append(abs(best.gap - gap) < MERCURY[0] / 4)
    # Student's tails are wider than those of the normal errors that are drawn: sure of less than what is right.
    assert np.mean(chances) < np.mean(hits) < np.mean(chances) + 0.1


def test_phases_of_no_gap_are_no_answer():
    found = fractions(2e-6, sd=1e-4)
    off = [found[0]._replace(turns=found[0].turns + 0.02), found[1]]
    answer = shared_gap(off, window_of(MERCURY))
    assert (answer.status, answer.message.code, answer.value) == ("undetermined", "PHASES_CONTRADICT", None)


def test_a_range_without_a_gap_of_these_phases_gives_none():
    answer = shared_gap(fractions(2e-6), (0.9e-6, 1.0e-6))
    assert (answer.status, answer.message.code, answer.value) == ("undetermined", "PHASES_CONTRADICT", None)
    # Next to its end there is one: nothing is so sharp as a range.
    assert shared_gap(fractions(2e-6), (2.0001e-6, 6.8e-6)).status == "ok"


def test_a_third_wavelength_tells_what_two_leave_open():
    gap, sd = 3.1e-6, 0.02
    two = shared_gap(fractions(gap, sd=sd), window_of(MERCURY))
    three = shared_gap(fractions(gap, (435.833e-9, *MERCURY), sd=sd), window_of(MERCURY))
    assert (two.status, two.message.code) == ("undetermined", "GAP_ORDER_UNDECIDED")
    assert three.orders[0].probability > two.orders[0].probability


def test_errors_of_the_wavelengths_grow_with_the_gap():
    near, far = (shared_gap(fractions(gap, relative_sd=1e-4), window_of(MERCURY)) for gap in (0.1e-6, 4e-6))
    assert far.sd > 1.3 * near.sd
    assert shared_gap(fractions(4e-6, relative_sd=1e-2), window_of(MERCURY)).status == "undetermined"


def test_pictures_in_two_lines_tell_the_gap(pair):
    _, result = pair
    gap = result.gap
    assert gap.status == "ok"
    assert abs(gap.value - 3.217e-6) < 3 * gap.sd < 3e-9
    assert gap.interval[0] < 3.217e-6 < gap.interval[1]
    assert gap.orders[0].orders == (12, 11)
    assert gap.orders[0].probability > 0.99
    assert result.parameters["gap"].value == gap.value
    assert "gap = 3.217" in result.report()
    assert np.linalg.norm([sd for _, sd in result.budgets()["gap [m]"]]) == pytest.approx(gap.sd)


def test_a_saved_gap_is_the_same(pair):
    saved = json.loads(json.dumps(pair[1].to_dict()))
    assert fitting.Together.from_dict(saved) == pair[1]
    assert fitting.Together.from_dict({name: saved[name] for name in saved if name != "gap"}).gap is None


def test_the_contact_order_is_half_a_turn_apart_in_transmission(pair):
    # Reflected rings, dark where the path is whole, are transmitted ones of a path half a wavelength longer: of no gap.
    images, _ = pair
    answer = fitting.fit_together(images, wavelength=list(MERCURY), parts=NO_PARTS, view="transmitted", shared="gap")
    assert answer.gap.status == "undetermined"


def test_two_channels_of_one_picture_tell_the_gap():
    lasers = (532e-9, 632.8e-9)
    green, red = (rings(1.1e-6, wavelength, seed) for seed, wavelength in enumerate(lasers))
    image = np.stack([red, green, np.zeros_like(red)], axis=-1)
    channels = {"channel": ["green", "red"], "wavelength": list(lasers), "parts": NO_PARTS}
    gap = fitting.fit_together([image, image], **channels, **LENS).gap
    assert abs(gap.value - 1.1e-6) < 3 * gap.sd


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"wavelength": MERCURY[0]}, "takes pictures in different wavelengths"),
        ({"wavelength": None, "radius": 1.0, "pixel_size": 1e-5}, "takes the wavelength of each picture"),
        ({"gap_range": (2e-6, 1e-6)}, "gap_range is .* the lowest and the highest"),
        ({"gap_range": (0.0, 5e-3)}, "up to 0.001 m"),
        ({"shared": "distortion", "gap_range": (0.0, 1e-6)}, 'add "gap" to shared'),
        ({"parts": {"contact": True}}, "parts a contact, in which the gap is 0"),
        ({"each": ("gap",)}, "gap is both shared and each picture's own"),
    ],
)
def test_what_has_no_gap_in_common_is_refused_in_one_line(pair, arguments, message):
    given = {"wavelength": list(MERCURY), "parts": NO_PARTS} | LENS | arguments
    with pytest.raises(ValueError, match=message):
        fitting.fit_together(pair[0], **given)


def test_the_shell_tells_the_gap_of_a_manifest(pair, tmp_path, capsys):
    for name, image in zip("ab", pair[0], strict=True):
        np.save(tmp_path / f"{name}.npy", image)
    (tmp_path / "list.csv").write_text("photo,wavelength\na.npy,546.074nm\nb.npy,578.01nm\n")
    command = ["together", str(tmp_path / "list.csv"), "--view", "reflected", "--share", "gap", "--no-distortion"]
    command += ["--no-lens-form", "--no-oblique-view", "--no-fifth-order"]
    assert main([*command, "--gap-range", "0um,4.9um", "--json", "-"]) == 0
    gap = json.loads(capsys.readouterr().out)["gap"]
    assert gap["gap_m"] == pytest.approx(3.217e-6, abs=2e-9)
    assert gap["window_m"] == pytest.approx([0, 4.9e-6])
    assert main([*command, "--gap-range", "5um,0um"]) == 2
    assert "is no range" in capsys.readouterr().err
