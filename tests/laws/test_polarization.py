"""The state of polarization: Brewster's angle, sums of components, and Stokes parameters."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from compilations import QUICKLY

import newtonjax as nj
from newtonjax.scene import field_at_launch, source_of

CAMERA = nj.Camera((20, 24), 10e-6)
SPLAT = nj.Splat(step=4e-6, epsilon=1e-2)
# Skew: s and p mix, and differ.
SKEW = {
    "light_tilt": (0.5, 0.3),
    "lens_tilt": (2e-3, -1e-3),
    "plate_tilt": (-1e-3, 2e-3),
    "lens_index": 1.7,
    "screen": 2e-3,
}


def skew(**light):
    scene = nj.newton_rings(0.5, 500e-9, 1e-6, "reflected", **SKEW)
    return dataclasses.replace(scene, light=nj.Light(500e-9, SKEW["light_tilt"], **light))


def image(scene, method):
    return np.asarray(nj.render(scene, CAMERA, method))


def test_at_brewsters_angle_a_wedge_reflects_no_p_light():
    """Tan i = n (Brewster 1815); at the inner faces of the plates the angle is the complement, and Brewster's too."""
    seen = {}
    for name, angle in (("s", np.pi / 2), ("p", 0.0)):  # light tilted about y travels in the x-z plane
        wedge = nj.air_wedge(1e-4, 500e-9, 5e-6, light_tilt=(0.0, np.arctan(1.5)), polarization=angle)
        seen[name] = image(wedge, nj.Traced())
    assert seen["s"].min() > 0
    assert seen["p"].max() < 1e-6 * seen["s"].mean()
    assert seen["s"].max() > 0.05


@pytest.mark.parametrize("method", [nj.Chebyshev(9), SPLAT])
def test_unpolarized_light_is_the_mean_of_two_perpendicular_linear_ones(method):
    mean = (image(skew(polarization=0.7), method) + image(skew(polarization=0.7 + np.pi / 2), method)) / 2
    assert np.abs(image(skew(), method) - mean).max() < 1e-12
    assert np.abs(image(skew(polarization=0.7), method) - mean).max() > 1e-4


def test_the_degree_of_polarization_interpolates_between_the_unpolarized_and_the_polarized_image():
    """Three independent components, as the paper renders partially polarized light: two unpolarized, one polarized."""
    method = nj.Chebyshev(9)
    linear = {angle: image(skew(polarization=angle), method) for angle in (0.7, 0.0, np.pi / 2)}
    for degree in (0.0, 0.3, 1.0):
        three = degree * linear[0.7] + (1 - degree) * (linear[0.0] + linear[np.pi / 2]) / 2
        assert np.abs(image(skew(polarization=0.7, degree=degree), method) - three).max() < 1e-12


def stokes(light):
    """S0 to S3 of the launched light, from the coherency matrix (Born and Wolf 10.9.3, eq. 64)."""
    field = np.asarray(field_at_launch(light))
    matrix = sum(
        w * np.outer(column[:2], column[:2].conj()) for w, column in zip(source_of(light).shares, field.T, strict=True)
    )
    (xx, xy), (yx, yy) = matrix
    return np.real([xx + yy, xx - yy, xy + yx, 1j * (yx - xy)])


@pytest.mark.parametrize("degree", [None, 0.4])
@pytest.mark.parametrize("ellipticity", [None, 0.3, -np.pi / 4])
def test_the_launched_field_has_the_stokes_parameters_of_its_ellipse(ellipticity, degree):
    """S = P (cos 2χ cos 2ψ, cos 2χ sin 2ψ, sin 2χ) (Born and Wolf 1.4.2, eq. 45)."""
    psi, chi, p = 0.6, ellipticity or 0.0, 1.0 if degree is None else degree
    found = stokes(nj.Light(500e-9, polarization=psi, ellipticity=ellipticity, degree=degree))
    ideal = [1.0, p * np.cos(2 * chi) * np.cos(2 * psi), p * np.cos(2 * chi) * np.sin(2 * psi), p * np.sin(2 * chi)]
    # e^{-iωt}: the sign of S3 follows the sense of rotation.
    np.testing.assert_allclose(np.abs(found), np.abs(ideal), atol=1e-15)
    np.testing.assert_allclose(found[:3], ideal[:3], atol=1e-15)


def test_images_are_differentiable_in_the_state_at_its_ends_too():
    def bright(state):
        light = nj.Light(500e-9, SKEW["light_tilt"], polarization=state[0], ellipticity=state[1], degree=state[2])
        return nj.render(dataclasses.replace(skew(), light=light), CAMERA, nj.Chebyshev(5)).sum()

    slope, value = (jax.jit(f, compiler_options=QUICKLY) for f in (jax.grad(bright), bright))
    for at in ([0.3, 0.2, 0.5], [0.3, 0.0, 1.0], [0.0, np.pi / 4, 0.0]):
        steps = 1e-4 * np.eye(3)
        differences = [(value(jnp.asarray(at + s)) - value(jnp.asarray(at - s))) / 2e-4 for s in steps]
        np.testing.assert_allclose(slope(jnp.asarray(at)), differences, rtol=1e-6, atol=1e-6)


def test_the_launched_irradiance_is_one():
    for light in (nj.Light(1e-6), nj.Light(1e-6, polarization=0.3, degree=0.2), nj.Light(1e-6, polarization=1.0)):
        assert float(source_of(light).irradiance(field_at_launch(light))) == pytest.approx(1.0, abs=1e-15)


@pytest.mark.parametrize(
    ("state", "message"),
    [
        ({"degree": 0.5}, "degree of polarization without polarization"),
        ({"ellipticity": 0.5}, "without polarization"),
        ({"polarization": 0.0, "degree": 1.1}, "degree is 1.1; allowed: 0"),
        ({"polarization": 0.0, "ellipticity": 1.0}, "ellipticity is 1.0; allowed"),
    ],
)
def test_a_state_that_no_light_has_is_refused(state, message):
    with pytest.raises(ValueError, match=message):
        nj.Light(500e-9, **state)
