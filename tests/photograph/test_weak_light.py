"""What a fit leaves out is said, and asked whether it agrees; what a person holds is asked of the picture, too."""

import numpy as np
import pytest
from rings_data import WAVELENGTH

import fitting
from fitting.photo import read

GIVEN = {"wavelength": WAVELENGTH, "pixel_size": 2e-5, "view": "reflected"}
SHAPE, CENTRE, UNIT, ORDERS = (320, 360), (150.0, 160.0), 240.0, 14.0
RADIUS = (UNIT * GIVEN["pixel_size"]) ** 2 / (ORDERS * WAVELENGTH)
Y, X = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
# Weak light right of this column.
EDGE = 200.0


def half_lit(closer=0.0, seed=0):
    """Rings in light that falls to a fifth across a line, beyond which they come closer by so much at the rim."""
    rho2 = ((X - CENTRE[0]) ** 2 + (Y - CENTRE[1]) ** 2) / UNIT**2
    beyond = np.clip((X - EDGE) / (SHAPE[1] - EDGE), 0.0, None)
    turns = ORDERS * rho2 + 0.5 + closer * beyond**2
    light = (0.55 + 0.4 * np.cos(2 * np.pi * turns)) * (0.25 + 1 / (1 + np.exp((X - EDGE) / 8)))
    stop = np.hypot((X - 180) / 175, (Y - 160) / 160) < 1
    noise = 0.004 * np.random.default_rng(seed).normal(size=SHAPE)
    return np.clip(light * stop + noise, 0, None) / 1.3


@pytest.mark.parametrize("seed", range(3))
def test_rings_that_go_on_in_weak_light_are_no_rival(seed):
    result = fitting.fit(half_lit(seed=seed), **GIVEN)
    assert (result.status, [finding.rival for finding in result.rivals]) == ("ok", [])
    assert abs(result.radius - RADIUS) < 3 * result.radius_sd


def test_the_report_says_why_pixels_are_left_out_and_how_many():
    photograph = read(half_lit())
    result = fitting.fit(half_lit(), **GIVEN)
    shares = {why: count / photograph.mask.size for why, count in photograph.left_out.items()}
    assert shares["lit weakly"] == pytest.approx(photograph.dim.mean(), abs=1e-9)
    assert 0.2 < shares["lit weakly"] < 0.5
    assert f"{shares['lit weakly']:.0%} lit weakly, {shares['dark']:.0%} dark" in result.model["pixels"]
    assert "lit weakly" in result.report()
    assert sum(photograph.left_out.values()) + photograph.mask.sum() == photograph.mask.size


def test_saturated_and_masked_pixels_are_counted_as_such():
    codes = np.uint8(np.clip(255 * half_lit() * 1.5, 0, 255))
    mask = X > 20
    photograph = read(codes, mask=mask)
    assert photograph.left_out["masked, hot or dead"] == (~mask).sum()
    assert photograph.left_out["saturated"] == (photograph.lit & ~photograph.mask).sum() > 0


def test_a_sharp_stop_leaves_nothing_in_weak_light():
    light = np.where(np.hypot(X - 180, Y - 160) < 100, 0.5 + 0.4 * np.cos(X / 5), 0.01)
    photograph = read(light)
    assert photograph.lit.mean() < 0.4
    assert photograph.dim.mean() < 0.04


def test_rings_that_lie_elsewhere_in_weak_light_are_refused():
    result = fitting.fit(half_lit(closer=6.0), **GIVEN)
    assert (result.status, result.reason) == ("refused", "RIVAL_WEAK_LIGHT_APART")


@pytest.mark.parametrize("closer", [-1.0, 1.0])
def test_rings_that_lie_a_little_elsewhere_in_weak_light_are_warned_of_and_a_row(closer):
    result = fitting.fit(half_lit(closer=closer), **GIVEN)
    assert result.status == "ok"
    assert "RIVAL_WEAK_LIGHT" in result.warning_codes
    rows = dict(result.budget)
    assert 0.01 < rows["weak light"] / result.radius < 0.15
    assert abs(result.radius - RADIUS) < 2 * result.radius_sd


@pytest.mark.parametrize(("gap", "warned"), [(0.0, False), (20e-9, True)])
def test_a_held_gap_that_the_picture_contradicts_is_said(gap, warned):
    result = fitting.fit(half_lit(), fixed={"gap": gap}, **GIVEN)
    assert ("HELD_CONTRADICTED" in result.warning_codes) == warned


@pytest.mark.parametrize(("offset", "warned"), [(0.0, False), (1.0, True)])
def test_a_held_centre_that_the_picture_contradicts_is_said(offset, warned):
    result = fitting.fit(half_lit(), fixed={"centre_px": (CENTRE[0] + offset, CENTRE[1])}, **GIVEN)
    assert ("HELD_CONTRADICTED" in result.warning_codes) == warned
