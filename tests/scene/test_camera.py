"""The camera: where its pixels lie, and the photographs that it takes."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import newtonjax as nj

KEY = jax.random.key(6)


def test_pixels_are_centred_on_the_middle_of_the_image_unless_told():
    x, y = nj.Camera((3, 4), 2e-6).axes()
    np.testing.assert_allclose(x, [-3e-6, -1e-6, 1e-6, 3e-6], rtol=1e-15)
    np.testing.assert_allclose(y, [-2e-6, 0, 2e-6], rtol=1e-15)
    x, y = nj.Camera((3, 4), 2e-6, centre_px=(10.0, -1.0)).axes()
    np.testing.assert_allclose(x, np.arange(-10, -6) * 2e-6, rtol=1e-15)
    np.testing.assert_allclose(y, np.arange(1, 4) * 2e-6, rtol=1e-15)


def test_rows_are_y_and_columns_are_x():
    wedge = nj.air_wedge(1e-3, 500e-9, screen="gap")  # the gap opens towards +x
    path = np.asarray(nj.opd(wedge, nj.Camera((3, 5), 1e-4), method=nj.ClosedForm()))
    assert (np.diff(path, axis=1) > 0).all()
    assert not np.diff(path, axis=0).any()


@pytest.mark.parametrize("level", [0.02, 0.4])
def test_noise_of_a_photograph_has_the_variance_of_shots_reading_and_rounding(level):
    camera = nj.Camera((400, 400), 1e-6, exposure=8000.0, full_well=12_000.0, read_noise=30.0, bits=12)
    photo = np.asarray(camera.expose(jnp.full(camera.shape, level), KEY)).astype(float)
    electron = 4095 / 12_000.0
    mean, variance = 8000 * level * electron, (8000 * level + 30.0**2) * electron**2 + 1 / 12
    # Four standard deviations of the mean and of the variance of 160 000 pixels.
    assert abs(photo.mean() - mean) < 4 * np.sqrt(variance / photo.size)
    assert abs(photo.var() - variance) < 4 * variance * np.sqrt(2 / photo.size)


@pytest.mark.parametrize(("bits", "dtype"), [(8, np.uint8), (10, np.uint16), (16, np.uint16)])
def test_codes_saturate_at_the_top_of_their_depth(bits, dtype):
    camera = nj.Camera((2, 3), 1e-6, exposure=1e6, full_well=1e4, bits=bits)
    photo = camera.expose(jnp.ones(camera.shape), KEY)
    assert photo.dtype == dtype
    assert (np.asarray(photo) == 2**bits - 1).all()


def test_a_dark_image_reads_no_negative_codes():
    camera = nj.Camera((50, 50), 1e-6, read_noise=500.0)
    photo = np.asarray(camera.expose(jnp.zeros(camera.shape), KEY))
    assert 0.3 < (photo == 0).mean() < 0.7  # half of the read noise lies below zero, and is cut off
    assert photo.max() < 50  # where it wrapped around there would be codes near 255


def test_the_same_key_takes_the_same_photograph_and_another_key_another():
    camera, image = nj.Camera((8, 8), 1e-6), jnp.full((8, 8), 0.5)
    first, again, other = (np.asarray(camera.expose(image, key)) for key in (KEY, KEY, jax.random.key(7)))
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"shape": (0, 4)}, r"shape is \(0, 4\); allowed: \(rows, columns\), both at least 1"),
        ({"pixel_size": 0.0}, "pixel_size is 0.0; allowed: a positive length"),
        ({"pixel_size": np.nan}, "pixel_size is nan; allowed: a positive length"),
        ({"exposure": -1.0}, "exposure is -1.0; allowed: a positive number"),
        ({"full_well": 0.0}, "full_well is 0.0; allowed: a positive number"),
        ({"read_noise": -0.1}, "read_noise is -0.1; allowed: 0 or more"),
        ({"bits": 7}, "bits is 7; allowed: 8 to 16"),
    ],
)
def test_a_camera_that_cannot_be_is_refused_with_field_value_and_allowed(given, message):
    with pytest.raises(ValueError, match=message):
        nj.Camera(**{"shape": (4, 4), "pixel_size": 1e-6, **given})
