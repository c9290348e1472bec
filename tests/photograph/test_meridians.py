"""Elliptic rings: a lens with two radii, or a view at an angle, as the view's angle says."""

import numpy as np
import pytest
from rings_data import WAVELENGTH

import fitting

GIVEN = {"wavelength": WAVELENGTH, "pixel_size": 2e-5, "view": "reflected"}
SHAPE, CENTRE, UNIT, ORDERS, AXIS = (300, 340), (150.0, 140.0), 226.0, 7.0, 0.4
RADIUS = (UNIT * GIVEN["pixel_size"]) ** 2 / (ORDERS * WAVELENGTH)
OBLIQUE = np.radians(15.0)


def elliptic(along, across, noise=0.02, seed=0):
    """Rings of curvatures `along` and `across` a direction AXIS, over that of RADIUS."""
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
    z = ((x - CENTRE[0]) + 1j * (y - CENTRE[1])) / UNIT * np.exp(-1j * AXIS)
    turns = ORDERS * (along * z.real**2 + across * z.imag**2) + 0.3
    return 0.5 + 0.4 * np.cos(2 * np.pi * turns) + noise * np.random.default_rng(seed).normal(size=SHAPE)


@pytest.fixture(scope="module")
def oblique():
    """A sphere seen at 15 degrees, and its fit without a view angle."""
    image = elliptic(1 / np.cos(OBLIQUE), np.cos(OBLIQUE))
    return image, fitting.fit(image, **GIVEN)


def covers(result, name, truth, deviations=1.96):
    number = result.parameters[name]
    return abs(number.value - truth) < deviations * number.sd


@pytest.mark.parametrize("share", [0.02, 0.2])
def test_a_lens_with_two_radii_seen_along_the_normal(share):
    """And with the view not given, both readings of the ellipse lie in the intervals."""
    image = elliptic(1 + share / 2, 1 - share / 2)
    radii = {"radius_along": RADIUS / (1 + share / 2), "radius_across": RADIUS / (1 - share / 2)}
    result = fitting.fit(image, **GIVEN, view_angle=0.0)
    for name, truth in radii.items():
        assert covers(result, name, truth, 3)
        assert result.parameters[name].sd < 1e-3 * truth
    assert covers(result, "astigmatism_axis", AXIS, 3)
    # 1 / mean curvature.
    assert abs(result.radius - RADIUS) < 3 * result.radius_sd < 1e-3 * RADIUS
    assert result.radius_along < result.radius < result.radius_across
    unsaid = fitting.fit(image, **GIVEN)
    mean = RADIUS / np.sqrt(1 - share**2 / 4)
    for name, truth in radii.items():
        assert covers(unsaid, name, truth)
        assert covers(unsaid, name, mean)
    assert covers(unsaid, "radius", RADIUS)
    assert covers(unsaid, "radius", mean)
    assert "a stated view angle decides" in unsaid.report()


@pytest.mark.parametrize("sd", [None, np.radians(1.0)])
def test_a_sphere_seen_at_an_angle_that_is_given(sd, oblique):
    image, unsaid = oblique
    result = fitting.fit(image, **GIVEN, view_angle=OBLIQUE, view_angle_sd=sd)
    assert covers(result, "radius", RADIUS)
    for name in ("radius_along", "radius_across"):
        assert covers(result, name, RADIUS)
        assert result.parameters[name].sd < 0.02 * RADIUS
    assert result.radius_sd < 1e-3 * RADIUS
    assert result.priors["stretch"]["source"] == "user"
    assert "a view at 15" in result.model["view or form"]
    assert covers(unsaid, "radius", RADIUS)
    assert covers(unsaid, "radius_along", RADIUS)


def test_a_lens_with_two_radii_seen_at_an_angle_is_covered():
    """The two stretches lie along one direction here, and add."""
    share = 0.05
    image = elliptic((1 + share / 2) / np.cos(OBLIQUE), (1 - share / 2) * np.cos(OBLIQUE))
    result = fitting.fit(image, **GIVEN, view_angle=OBLIQUE)
    assert covers(result, "radius_along", RADIUS / (1 + share / 2))
    assert covers(result, "radius_across", RADIUS / (1 - share / 2))
    assert covers(result, "radius", RADIUS)


def test_round_rings_have_no_two_radii_unless_the_view_is_given():
    image = elliptic(1.0, 1.0)
    assert fitting.fit(image, **GIVEN).radius_along is None
    result = fitting.fit(image, **GIVEN, view_angle=0.0)
    assert covers(result, "radius_along", RADIUS, 3)
    assert covers(result, "radius", RADIUS, 3)


def test_a_wavelength_from_a_lens_with_two_radii_takes_its_mean_curvature():
    share = 0.2
    given = {"pixel_size": GIVEN["pixel_size"], "radius": RADIUS, "view": "reflected"}
    result = fitting.fit(elliptic(1 + share / 2, 1 - share / 2), **given, view_angle=0.0)
    assert covers(result, "wavelength", WAVELENGTH, 3)
    assert result.parameters["wavelength"].sd < 1e-3 * WAVELENGTH


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"view_angle": 1.0}, "view_angle is 1.0; allowed: 0 to pi/4"),
        ({"view_angle": -0.1}, "allowed: 0 to pi/4"),
        ({"view_angle_sd": 0.1}, "without view_angle"),
        ({"view_angle": 0.0, "view_angle_sd": "10%"}, "which is 0"),
        ({"view_angle": 0.0, "priors": {"stretch": (0.0, 0.1)}}, "both say how the rings are stretched"),
        ({"view_angle": 0.0, "parts": {"oblique_view": False}}, "which parts leaves out"),
    ],
)
def test_what_is_no_view_is_refused_in_one_line(arguments, words):
    with pytest.raises(ValueError, match=words):
        fitting.fit(elliptic(1.0, 1.0), **GIVEN, **arguments)
