"""Moments hold the image's likelihood: against sums over all pixels in NumPy."""

import jax.numpy as jnp
import numpy as np
import pytest
from rings_data import WAVELENGTH, coordinates, rings

import fitting
from fitting.estimate import frame_on, moments, sums
from fitting.estimate.fringe_moments import residuals
from fitting.model import BACKGROUND, GapModel, as_arrays, degrees, localize, model_coefficients
from fitting.photo import Grid, Photograph, reduce
from fitting.photo.codes import Codes, Curve

SHAPE, PIXEL = (200, 256), 5e-6
FRAME = frame_on(Grid(SHAPE, 1, (0, 200), (0, 256)))
STEEP = WAVELENGTH / PIXEL


@pytest.fixture(scope="module")
def gap_model():
    return as_arrays(GapModel(FRAME, (STEEP, 1.0)))


def kept_of(image, mask, reference):
    """Moments in double precision of an image, and the light that its blocks are counted from."""
    reduced = reduce(Photograph(Codes(image, Curve(1.0, 1.0)), mask, mask, "grey", "linear"), 1, np.float64)
    return moments(*sums(reduced, np.asarray(reference))), reduced.offset


def nine(*first):
    """A model's numbers, those of its parts zero."""
    return np.array([*first, 0.0, 0.0, 0.0, 0.0, 0.0])


def exact(numbers, smooth, size):
    """The image of free numbers (as GapModel counts them) in NumPy."""
    frame = FRAME
    turns, x, y, phase, *_ = numbers
    r2 = coordinates(SHAPE, (frame.middle[0] + x * frame.unit, frame.middle[1] + y * frame.unit))
    k = turns / frame.unit**2
    argument = 2 * k * r2 / (1 + np.sqrt(1 - (k * STEEP) ** 2 * r2)) + phase
    tilt = np.linspace(-1, 1, SHAPE[1])[None]
    return smooth[0] + smooth[1] * tilt + size * np.cos(2 * np.pi * argument), argument


def test_log_likelihood_from_moments_equals_the_sum_over_all_pixels(gap_model):
    rng = np.random.default_rng(3)
    best = nine(6.0, 0.05, -0.04, 0.4)
    truth, phase = exact(best, (0.5, 0.05), 0.4)
    image = truth + 0.05 * rng.normal(size=SHAPE)
    weights = rng.random(SHAPE) > 0.2
    kept, offset = kept_of(image, weights, localize(gap_model, jnp.asarray(best)).value[0])
    worst = 0.0
    for _ in range(100):
        numbers = best + nine(*rng.normal(size=4) * [0.1, 0.01, 0.01, 0.1])
        away = np.abs(exact(numbers, (0.5, 0.05), 0.4)[1] - phase).max()
        numbers = best + (numbers - best) * min(1.0, 0.25 / away)
        smooth, size = (0.5 + 0.05 * rng.normal(), 0.05 * rng.normal()), 0.4 + 0.05 * rng.normal()
        background = np.zeros(len(degrees(BACKGROUND)))
        background[[0, 1 + int(degrees(1)[1][0] == 1)]] = smooth  # the second one is T_1(x)
        background[0] -= offset
        argument, shape = localize(gap_model, jnp.asarray(numbers)).value
        left = residuals(kept, model_coefficients(jnp.asarray(background), size * shape, argument, kept.reference))
        full = np.sum(weights * (image - exact(numbers, smooth, size)[0]) ** 2)
        worst = max(worst, abs(float(left @ left + kept.rest) - full) / (2 * 0.05**2))
    assert worst < 1e-3


def test_degrees_begin_with_the_constant_then_x_and_y():
    assert {tuple(pair) for pair in degrees(1)} == {(0, 0), (0, 1), (1, 0)}
    assert tuple(degrees(2)[0]) == (0, 0)
    assert len(degrees(6)) == 28


def test_the_picture_of_a_fit_is_the_model_at_every_pixel_and_made_when_asked_for():
    image = rings(noise=0.0, shape=SHAPE)
    result = fitting.fit(image, wavelength=WAVELENGTH, pixel_size=PIXEL)
    picture = result.picture
    assert "fitted" not in vars(picture)
    unit = picture.photograph.image.max() / image.max()
    assert np.abs(picture.fitted - unit * image).max() < 1e-6
    assert picture.weights.shape == SHAPE
    assert 0 < picture.weights.max() <= 1


def test_far_from_the_reference_moments_are_wrong_so_fits_must_watch_the_excursion(gap_model):
    """Two turns away chi-squared is off by far more than one: the reason for `Solution.excursion`."""
    best, far = nine(6.0, 0.0, 0.0, 0.4), nine(10.0, 0.0, 0.0, 0.4)
    image = exact(best, (0.5, 0.0), 0.4)[0]
    kept, offset = kept_of(image, np.ones(SHAPE, bool), localize(gap_model, jnp.asarray(best)).value[0])
    argument, shape = localize(gap_model, jnp.asarray(far)).value
    background = jnp.zeros(len(degrees(BACKGROUND))).at[0].set(0.5 - offset)
    left = residuals(kept, model_coefficients(background, 0.4 * shape, argument, kept.reference))
    full = np.sum((image - exact(far, (0.5, 0.0), 0.4)[0]) ** 2)
    assert abs(float(left @ left + kept.rest) - full) / (2 * 0.05**2) > 1
