"""What the user knows of a part's numbers, and of where the camera looks, is in the answer, and said."""

import json

import numpy as np
import pytest
from rings_data import WAVELENGTH

import fitting
from fitting.shell import assignments, fit_arguments, fit_verb

GIVEN = {"wavelength": WAVELENGTH, "pixel_size": 2e-5, "view": "reflected"}
SHAPE, ORDERS, KAPPA = (300, 400), 14.0, -0.08
UNIT = np.hypot(299, 399) / 2
RADIUS = (UNIT * GIVEN["pixel_size"]) ** 2 / (ORDERS * WAVELENGTH)


def distorted(centre=(0.1, -0.2), kappa=KAPPA, noise=0.03, seed=0):
    """Rings of ORDERS r² (half diagonals) through a camera whose axis goes through the middle of the frame."""
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
    u = ((x - 199.5) + 1j * (y - 149.5)) / UNIT
    at, origin = (point * (1 + kappa * np.abs(point) ** 2) for point in (u, complex(*centre)))
    light = 0.5 + 0.4 * np.cos(2 * np.pi * (ORDERS * np.abs(at - origin) ** 2 + 0.3))
    return light + noise * np.random.default_rng(seed).normal(size=SHAPE)


@pytest.fixture(scope="module")
def plain():
    """The fit of the whole picture without a prior of the user's."""
    return fitting.fit(distorted(), **GIVEN)


def test_a_prior_of_the_users_is_in_the_fit_and_in_every_output(plain, tmp_path):
    stated = fitting.fit(distorted(), **GIVEN, priors={"distortion": (KAPPA, 1e-5)})
    assert plain.priors["distortion"]["source"] == "default"
    assert stated.priors["distortion"] == {"value": KAPPA, "sd": 1e-5, "source": "user", "reason": "given"}
    assert stated.to_dict()["priors"]["distortion"]["source"] == "user"
    assert "distortion: -0.08 ± 1e-05, given" in stated.report()
    assert stated.model["distortion"] == "its prior is given"
    assert stated.parameters["distortion"].sd < 1.001e-5 < plain.parameters["distortion"].sd
    assert stated.radius_sd < plain.radius_sd
    for result in (plain, stated):
        assert abs(result.radius - RADIUS) < 3 * result.radius_sd
    stated.save(tmp_path / "r.json")
    assert json.loads((tmp_path / "r.json").read_text())["priors"]["distortion"]["source"] == "user"
    assert fitting.FitResult.load(tmp_path / "r.json").report() == stated.report()


def test_a_prior_beside_the_truth_pulls_the_answer():
    """A prior as sharp as the image takes about half of the way: the variance that weighs it is known to a quarter."""
    light = distorted(noise=0.2)
    alone = dict.fromkeys(("oblique_view", "fifth_order", "lens_form", "contact"), False)
    free = fitting.fit(light, **GIVEN, parts=alone, priors={"distortion": (KAPPA, 1.0)}).parameters["distortion"]
    centre = KAPPA + 4 * free.sd
    pulled = fitting.fit(light, **GIVEN, parts=alone, priors={"distortion": (centre, free.sd)}).parameters["distortion"]
    assert (pulled.value - free.value) / (centre - free.value) == pytest.approx(0.5, abs=0.2)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"priors": {"distorton": (0, 1)}}, "'distorton' has no prior; allowed: stretch, .*perhaps distortion"),
        ({"priors": {"coma_x": (0, 1)}, "parts": {"lens_form": False}}, "a number of lens_form, which is left out"),
        ({"priors": {"coma_x": (0, "1%")}}, "has the sd '1%'; allowed: a number above zero"),
        ({"priors": {"coma_x": (0, -1)}}, "has the sd -1"),
        ({"priors": {"coma_x": 3}}, r"coma_x is 3; allowed: \(value, sd\)"),
        ({"priors": {"distortion": (2.0, 0.1)}}, "distortion is 2; allowed: between -0.3 and 0.3"),
        ({"priors": 3}, "allowed: a mapping of names"),
        ({"axis_px": (9000, 1)}, "axis_px has x = 9000; allowed here: between -50 and 449"),
        ({"axis_px": "ab"}, "allowed: two numbers"),
        ({"axis_px": (1, 1), "axis_px_sd": 0}, "axis_px_sd is 0"),
        ({"axis_px_sd": 3}, "without axis_px"),
        ({"axis_px": (1, 1), "priors": {"axis_x": (0, 0.1)}}, "both say where the axis is"),
    ],
)
@pytest.mark.usefixtures("untyped")
def test_what_is_no_prior_is_refused_in_one_line(arguments, words):
    with pytest.raises(ValueError, match=words):
        fitting.fit(distorted(), **GIVEN, **arguments)


CUTS = {
    "right": (slice(None), slice(120, None)),
    "corner": (slice(120, None), slice(150, None)),
}


@pytest.mark.parametrize("name", CUTS)
def test_a_cut_that_is_told_its_axis_agrees_with_the_whole(name, plain):
    rows, columns = CUTS[name]
    axis = (199.5 - (columns.start or 0), 149.5 - (rows.start or 0))
    picture = distorted()
    cut = fitting.fit(picture[rows, columns], **GIVEN, axis_px=axis)
    assert abs(cut.radius - plain.radius) < 2 * max(cut.radius_sd, plain.radius_sd)
    assert abs(cut.radius - RADIUS) < 2 * cut.radius_sd < 0.01 * RADIUS
    assert cut.priors["axis_x"]["source"] == "user"
    assert "axis" in dict(cut.budget)
    # Distortions about the middle of the cut are what is not there.
    astray = fitting.fit(
        picture[rows, columns], **GIVEN, axis_px=tuple((n - 1) / 2 for n in picture[rows, columns].shape[::-1])
    )
    assert abs(astray.radius - RADIUS) > 3 * abs(cut.radius - RADIUS)


def test_an_axis_less_well_known_leaves_the_radius_less_well_known():
    """The row is what the distortion's own axis moves the radius by."""
    picture, axis = distorted(noise=0.2)[:, 120:], (79.5, 149.5)
    near, vague = (fitting.fit(picture, **GIVEN, axis_px=axis, axis_px_sd=sd) for sd in (0.1, 30.0))
    assert dict(near.budget)["axis"] < dict(vague.budget)["axis"]
    assert near.radius_sd < vague.radius_sd


def test_the_shell_reads_priors_and_places():
    assert assignments.priors(["distortion=-0.01:0.02 axis-x=0.1:10%"]) == {
        "distortion": (-0.01, 0.02),
        "axis_x": (0.1, "10%"),
    }
    assert assignments.priors(["radius=1m:2cm pixel-size=5um:0.1%"]) == {
        "radius": (1.0, 0.02),
        "pixel_size": (pytest.approx(5e-6), "0.1%"),
    }
    assert assignments.place("640,480.5") == (640.0, 480.5)
    for text in ("distortion", "distortion=1", "=1:2", "distortion=a:1", "distortion=1:-1"):
        with pytest.raises(ValueError, match=r"give|number"):
            assignments.priors([text])
    with pytest.raises(ValueError, match="twice"):
        assignments.priors(["distortion=0:1", "distortion=0:2"])
    with pytest.raises(ValueError, match="give X,Y"):
        assignments.place("640")


@pytest.mark.parametrize("texts", [["centre=330,210"], ["radius=1m"], ["centre=1,2", "radius=1m", "fringe-scale=1e-5"]])
def test_a_start_at_the_shell_that_is_not_whole_says_what_it_lacks(texts):
    with pytest.raises(ValueError, match=r"give centre=X,Y, and radius=LENGTH or fringe-scale=NUMBER"):
        assignments.start(texts)


def test_the_shell_reads_what_is_held_and_where_a_fit_starts():
    assert assignments.held(["gap=120nm centre=640,480.5"]) == {
        "gap": pytest.approx(120e-9),
        "centre_px": (640.0, 480.5),
    }
    assert assignments.start(["centre=640,480", "radius=1m"]) == {"centre_px": (640.0, 480.0), "radius": 1.0}
    start = assignments.start(["centre=1,2 fringe-scale=1e-5"])
    assert start == {"centre_px": (1.0, 2.0), "fringe_scale_per_px2": 1e-5}
    for text, words in (("gap", "such as gap=0nm"), ("gap=5", "has no unit"), ("radius=1m", "allowed: centre, gap")):
        with pytest.raises(ValueError, match=words):
            assignments.held([text])
    options = fit_arguments.FitOptions(fix={"gap": 0.0}, start={"centre_px": (1.0, 2.0), "radius": 1.0})
    arguments = fit_arguments.arguments_of(options)
    assert arguments["fixed"] == {"gap": 0.0}
    assert arguments["start"] == {"centre_px": (1.0, 2.0), "radius": 1.0}


def test_the_shell_gives_a_chain_the_priors_of_what_it_draws():
    prior = {"radius": (1.0, 0.02), "distortion": (0.0, 0.02)}
    options = fit_arguments.FitOptions(prior=prior, steps=500, mcmc=True)
    assert options.of_chain == {"priors": {"radius": (1.0, 0.02)}, "steps": 500}
    assert fit_arguments.arguments_of(options)["priors"] == {"distortion": (0.0, 0.02)}
    for alone, words in ((options._replace(steps=None), "--prior radius"), (options, "--steps")):
        with pytest.raises(ValueError, match=f"{words} is of a chain; add --mcmc"):
            fit_verb.check_options(alone._replace(mcmc=False))


def test_a_prior_that_the_image_contradicts_is_a_finding_with_a_row(plain):
    result = fitting.fit(distorted(), **GIVEN, priors={"distortion": (0.0, 0.005)})
    tension = {finding.rival: finding for finding in result.rivals}["prior tension"]
    assert tension.value > tension.limit
    assert "distortion is -0.0" in tension.words
    assert tension.words in result.warnings
    assert dict(result.budget)["prior tension"] > 0
    assert abs(result.radius - RADIUS) < 2 * result.radius_sd
    assert "prior tension" not in {finding.rival for finding in plain.rivals}
