"""The measured radius as a function of image and assumptions: right, differentiable, batched, and refused where not."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from compilations import QUICKLY, compilations

import fitting
import newtonjax as nj

SCENE = nj.newton_rings(2.0, 550e-9, 0.3e-6, "reflected", screen="gap")
CAMERA = nj.Camera((48, 52), 100e-6)
ASSUMED = {"pixel_size": 100.2e-6, "wavelength": 550.3e-9}


@pytest.fixture(scope="module")
def measure():
    return fitting.measurement(SCENE, CAMERA)


@pytest.fixture(scope="module")
def on_few_nodes():
    """For what is traced as one program and compiled in a hurry: it runs in a third of the time."""
    return fitting.measurement(SCENE, CAMERA, method=nj.Chebyshev(9))


@pytest.fixture(scope="module")
def noisy():
    image = np.asarray(nj.render(SCENE, CAMERA, nj.Chebyshev(17)))
    return image + 0.03 * image.max() * np.random.default_rng(1).normal(size=image.shape)


def turned(image):
    """Three images: as it is, upside down, and left to right."""
    return jnp.stack([jnp.asarray(image), jnp.asarray(image)[::-1], jnp.asarray(image)[:, ::-1]])


def test_a_perfect_image_gives_the_scene_back(measure):
    found = measure(nj.render(SCENE, CAMERA, nj.Chebyshev(17)))
    assert bool(found.converged)
    assert float(found.numbers["radius"]) == pytest.approx(2.0, rel=1e-9)
    assert float(found.chi2) == pytest.approx(0.0, abs=1e-9)


def test_what_is_assumed_moves_it_as_the_formula_says(measure):
    """R = s² / (fringe scale λ)."""
    image = nj.render(SCENE, CAMERA, nj.Chebyshev(17))
    found = measure(image, **ASSUMED)
    assert float(found.numbers["radius"]) == pytest.approx(2.0 * 1.002**2 / (550.3 / 550), rel=1e-6)


def test_derivatives_are_those_of_differences(measure, noisy):
    """By the image in a random direction and by what is assumed, at an image with noise: second derivatives count."""

    def radius(image, pixel_size, wavelength):
        return measure(image, pixel_size=pixel_size, wavelength=wavelength).numbers["radius"]

    at = (jnp.asarray(noisy), *ASSUMED.values())
    slopes = jax.grad(radius, (0, 1, 2))(*at)
    direction = np.random.default_rng(2).normal(size=noisy.shape) * noisy.max()
    moves = [(direction, 0.0, 0.0, 1e-5), (0.0, 1e-6, 0.0, 1e-4), (0.0, 0.0, 1e-9, 1e-3)]
    for image, size, wave, step in moves:
        ahead, back = (
            radius(*(part + sign * step * move for part, move in zip(at, (image, size, wave), strict=True)))
            for sign in (1, -1)
        )
        exact = float(jnp.sum(slopes[0] * image) + slopes[1] * size + slopes[2] * wave)
        assert (float(ahead) - float(back)) / (2 * step) == pytest.approx(exact, rel=1e-5)


@pytest.mark.parametrize("wrong", [0.0, 1e-9, 1e-4])
def test_however_little_is_wrong_the_fit_ends(measure, wrong):
    """On a perfect image the last steps are rounding."""
    image = nj.render(SCENE, CAMERA, nj.Chebyshev(17))
    slope = jax.grad(lambda size: measure(image, pixel_size=size).numbers["radius"])(100e-6 * (1 + wrong))
    assert float(slope) == pytest.approx(2 * 2.0 / 100e-6 * (1 + wrong), rel=1e-4)


def test_hidden_numbers_give_what_known_ones_do(on_few_nodes, noisy):
    """Radius and chi-squared, and their derivatives: three images side by side in one traced program, and in NumPy."""

    def radius_and_chi2(image, *assumed):
        outcome = on_few_nodes(image, **dict(zip(ASSUMED, assumed, strict=True)))
        return outcome.numbers["radius"] + 5e-4 * outcome.chi2

    both = jax.value_and_grad(radius_and_chi2, (0, 1, 2))
    many = turned(noisy)
    traced = jax.jit(jax.vmap(both, (0, None, None)), compiler_options=QUICKLY)(many, *ASSUMED.values())
    for k, image in enumerate(many):
        value, slopes = both(image, *ASSUMED.values())
        assert float(traced[0][k]) == pytest.approx(float(value), rel=1e-9)
        for hidden, known in zip(traced[1], slopes, strict=True):
            np.testing.assert_allclose(hidden[k], known, rtol=1e-8, atol=1e-8 * np.abs(known).max())


def test_known_numbers_compile_nothing(noisy):
    with compilations() as compiled:
        found = fitting.measurement(SCENE, CAMERA)(noisy, **ASSUMED)
    assert found.converged
    assert compiled.count == 0


def test_what_has_no_rings_does_not_converge(measure):
    found = measure(np.zeros(CAMERA.shape))
    assert not bool(found.converged)
    assert np.isnan(float(found.numbers["radius"]))
    slope = jax.grad(lambda size: measure(jnp.zeros(CAMERA.shape), pixel_size=size).numbers["radius"])(100e-6)
    assert np.isnan(float(slope))


def test_it_refuses_with_a_line(measure):
    with pytest.raises(ValueError, match=r"the image has shape \(3, 3\); allowed: the camera's, \(48, 52\)"):
        measure(np.ones((3, 3)))
    with pytest.raises(ValueError, match="radius is free: it is determined, not assumed"):
        measure(np.ones(CAMERA.shape), radius=2.0)
    with pytest.raises(ValueError, match="'colour' is not a number of this scene"):
        measure(np.ones(CAMERA.shape), colour=1.0)
