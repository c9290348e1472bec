"""Pixels weighed by the camera's noise: against the Cramér-Rao bound, against a mask, and what is refused."""

import re

import numpy as np
import pytest

import fitting
import newtonjax as nj
from experiments.truth.noise_weights import PARTS, PIXEL, SIZE, TRUTH, WAVELENGTH, camera, fringes
from fitting.shell import assignments

GIVEN = {"wavelength": WAVELENGTH, "pixel_size": PIXEL, "view": "reflected", "parts": PARTS}
LIGHT = 0.5 * (1 + 0.999 * fringes(*TRUTH))


def test_weights_by_noise_reach_the_bound_of_shot_noise_and_equal_ones_do_not():
    rows = {row["weights"]: row for row in camera(2000.0, 0.999, seeds=8)}
    assert rows.pop("equal")["scatter_over_bound"] > 1.2
    assert set(rows) == {"estimated", "shot", "photoelectrons"}
    for row in rows.values():
        assert row["scatter_over_bound"] < 1.05
        assert 0.95 * row["scatter_over_bound"] < row["stated_over_bound"] < 1.05


def test_noise_that_is_the_same_everywhere_leaves_the_radius():
    noisy = LIGHT + 0.02 * np.random.default_rng(3).normal(size=LIGHT.shape)
    alike, weighed = (fitting.fit(noisy, **GIVEN, noise=noise) for noise in (None, "estimated"))
    assert abs(weighed.radius - alike.radius) < 0.1 * alike.radius_sd_noise
    assert weighed.radius_sd_noise == pytest.approx(alike.radius_sd_noise, rel=0.03)


def test_pixels_of_ten_times_the_noise_hardly_count():
    right = np.arange(SIZE) >= 192
    sd = np.where(right, 0.2, 0.02) * np.ones((SIZE, 1))
    image = LIGHT + sd * np.random.default_rng(5).normal(size=LIGHT.shape)
    masked, weighed = fitting.fit(image, **GIVEN, mask=sd < 0.1), fitting.fit(image, **GIVEN, noise=sd**2)
    assert abs(weighed.radius - masked.radius) < 0.5 * masked.radius_sd_noise
    assert 0.9 * masked.radius_sd_noise < weighed.radius_sd_noise < masked.radius_sd_noise
    assert "variances of the pixels" in weighed.model["weights"]


@pytest.mark.parametrize(
    ("noise", "message"),
    [
        ("loud", "noise is 'loud'; allowed: \"estimated\""),
        ((0.0, 3.0), "allowed: a full well above 0"),
        ((1000.0, -1.0), "a read noise of 0 or more"),
        (np.zeros((SIZE, SIZE)), "variances of the image's shape"),
        (np.ones((3, 3)), "variances of the image's shape"),
    ],
)
def test_noise_that_no_camera_has_is_refused_in_one_line(noise, message):
    with pytest.raises(ValueError, match=re.escape(message)) as error:
        fitting.fit(LIGHT, **GIVEN, noise=noise)
    assert "\n" not in str(error.value)


def test_noise_is_refused_where_it_is_not_used():
    bench = nj.newton_rings(1.0, WAVELENGTH, beams="all", lens_coating="mirror:50%", plate_coating="mirror:50%")
    with pytest.raises(ValueError, match="leave noise out"):
        fitting.fit(LIGHT, scene=bench, pixel_size=PIXEL, noise="shot")
    with pytest.raises(ValueError, match="light and noise do not go together"):
        fitting.fit(LIGHT, light="mercury", pixel_size=PIXEL, noise="shot")


def test_the_shell_reads_noise_in_words_and_in_photoelectrons():
    assert assignments.noise("estimated") == "estimated"
    assert assignments.noise("10000,3") == (10000.0, 3.0)
    with pytest.raises(ValueError, match="give estimated, shot, or FULL_WELL,READ_NOISE"):
        assignments.noise("10000")
