"""The codes of photographs: plateau, black level, mosaic, transfer and JPEG, against their definitions."""

from dataclasses import replace
from io import BytesIO

import jax
import numpy as np
import pytest
from PIL import Image
from scipy import ndimage

import newtonjax as nj

KEY = jax.random.key(3)
STILL = nj.Camera((24, 30), 1e-5, exposure=4e8, full_well=1e9, read_noise=0.0, bits=16)
RESPONSE = nj.Response([450e-9, 550e-9, 650e-9], np.eye(3)[::-1])
LIGHT = np.random.default_rng(0).uniform(0.1, 2.0, (24, 30))
COLOURS = np.random.default_rng(1).uniform(0.1, 2.0, (24, 30, 3))


def test_codes_end_at_a_plateau_below_the_scale():
    camera = nj.Camera((24, 30), 1e-5, exposure=2e4, full_well=2755.0, full_scale=4095.0, bits=12)
    codes = np.asarray(camera.expose(LIGHT, KEY))
    assert codes.max() == 2755
    assert np.mean(codes == 2755) > 0.5


def test_no_light_has_the_code_of_the_black_level():
    camera = replace(STILL, black_level=300.0)
    assert set(np.unique(np.asarray(camera.expose(0 * LIGHT, KEY)))) == {300}
    codes = np.asarray(camera.expose(LIGHT, KEY)).astype(float)
    np.testing.assert_allclose(codes, 300 + 0.4 * LIGHT * (65535 - 300), rtol=1e-3)


@pytest.mark.parametrize("mosaic", ["RGGB", "BGGR", "GRBG", "GBRG"])
def test_a_mosaic_keeps_one_colour_and_takes_the_others_from_neighbours(mosaic):
    camera = replace(STILL, response=RESPONSE, mosaic=mosaic)
    codes = np.asarray(camera.expose(COLOURS, KEY)) / 65535 / 0.4
    kernel = np.array([[0.25, 0.5, 0.25], [0.5, 1.0, 0.5], [0.25, 0.5, 0.25]])
    for channel, colour in enumerate("RGB"):
        places = [divmod(at, 2) for at, letter in enumerate(mosaic) if letter == colour]
        site = np.zeros((24, 30))
        for row, column in places:
            site[row::2, column::2] = 1
        weight = ndimage.convolve(site, kernel, mode="mirror")
        near = ndimage.convolve(site * COLOURS[..., channel], kernel, mode="mirror") / weight
        expected = np.where(site > 0, COLOURS[..., channel], near)
        np.testing.assert_allclose(codes[..., channel], expected, rtol=2e-3)


def test_transfer_has_the_values_of_the_standard():
    camera = replace(STILL, bits=8, exposure=1e9, transfer="srgb")
    light = np.full((24, 30), 0.2140)
    # IEC 61966-2-1: the code 127.5 is 21.4 % of white; 1 % is 25.4.
    assert abs(float(np.asarray(camera.expose(light, KEY)).mean()) - 127.5) <= 0.5
    assert abs(float(np.asarray(camera.expose(0 * light + 0.01, KEY)).mean()) - 25.4) <= 0.5


def test_a_jpeg_is_that_of_its_quality():
    camera, light = replace(STILL, bits=8, jpeg=60), 0.3 * COLOURS[..., 0].round()
    plain = np.asarray(replace(camera, jpeg=None).expose(light, KEY))
    file = BytesIO()
    Image.fromarray(plain).save(file, "JPEG", quality=60)
    np.testing.assert_array_equal(np.asarray(camera.expose(light, KEY)), np.asarray(Image.open(file)))
    with pytest.raises(ValueError, match="jpeg within a transformation"):
        jax.jit(camera.expose)(light, KEY)


@pytest.mark.parametrize(
    ("numbers", "words"),
    [
        ({"mosaic": "RGBG"}, "mosaic is 'RGBG'"),
        ({"mosaic": "RGGB"}, "a response of three channels"),
        ({"transfer": "log"}, "transfer is 'log'"),
        ({"jpeg": 101, "bits": 8}, "jpeg is 101"),
        ({"jpeg": 90}, "bits=8"),
        ({"full_scale": 0.0}, "full_scale is 0"),
        ({"black_level": 65535.0}, "black_level is 65535"),
    ],
)
def test_what_no_camera_has_is_refused_in_one_line(numbers, words):
    with pytest.raises(ValueError, match=words) as caught:
        replace(STILL, **numbers)
    assert "\n" not in str(caught.value)
