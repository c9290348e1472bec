"""Fresnel's equations and Snell's law at one interface, against the tmm package and textbook angles."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import tmm

from newtonjax.rays import amplitudes
from newtonjax.rays.fresnel import complex_cosine, is_total, reflect_field, refract, transmit_field

UP = jnp.array([0.0, 0.0, 1.0])
PAIRS = [(1.0, 1.5), (1.5, 1.0), (1.33, 1.62), (1.5, 1.5)]
ANGLES = [0.0, 1e-8, 0.1, 0.5, 0.7]


def ray(angle, azimuth=0.6):
    """Direction downwards, and the unit vectors s and p of its plane of incidence (p x s along the ray)."""
    across = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    direction = np.sin(angle) * across - np.cos(angle) * np.array([0, 0, 1.0])
    s = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    return jnp.asarray(direction), s, np.cross(s, direction)


@pytest.mark.parametrize(("n1", "n2"), PAIRS)
@pytest.mark.parametrize("angle", ANGLES)
def test_amplitudes_are_those_of_tmm(n1, n2, angle):
    beyond = np.arcsin(n1 * np.sin(angle) / n2)
    ours = amplitudes(n1, n2, np.cos(angle), np.cos(beyond))
    peer = [f(pol, n1, n2, angle, beyond) for f in (tmm.interface_r, tmm.interface_t) for pol in "sp"]
    np.testing.assert_allclose(ours, peer, rtol=1e-14, atol=1e-15)


@pytest.mark.parametrize(("n1", "n2"), PAIRS)
@pytest.mark.parametrize("angle", [*ANGLES, 1.2])
def test_reflected_field_vectors_are_those_of_tmm_also_beyond_the_critical_angle(n1, n2, angle):
    direction, s, p = ray(angle)
    cos_t = complex_cosine(n1, n2, direction, UP)
    field = jnp.asarray(np.column_stack([s, p]) + 0j)
    out = np.asarray(reflect_field(n1, n2, direction, UP, -direction[2], cos_t, field))
    beyond = tmm.snell(n1, n2, angle)
    after = np.asarray(direction) * [1, 1, -1]
    np.testing.assert_allclose(out[:, 0], tmm.interface_r("s", n1, n2, angle, beyond) * s, atol=4e-15)
    np.testing.assert_allclose(out[:, 1], tmm.interface_r("p", n1, n2, angle, beyond) * np.cross(s, after), atol=4e-15)
    if n1 * np.sin(angle) > n2:
        np.testing.assert_allclose(np.linalg.norm(out, axis=0), 1, rtol=1e-14)


@pytest.mark.parametrize(("n1", "n2"), PAIRS)
@pytest.mark.parametrize("angle", ANGLES)
def test_transmitted_field_vectors_are_those_of_tmm_scaled_to_flux(n1, n2, angle):
    direction, s, p = ray(angle)
    after, cos_i, cos_t, passes = refract(n1, n2, direction, UP)
    assert passes
    field = jnp.asarray(np.column_stack([s, p]) + 0j)
    out = np.asarray(transmit_field(n1, n2, direction, UP, cos_i, cos_t, field))
    beyond = np.arcsin(n1 * np.sin(angle) / n2)
    flux = np.sqrt(n2 * np.cos(beyond) / (n1 * np.cos(angle)))
    np.testing.assert_allclose(out[:, 0], flux * tmm.interface_t("s", n1, n2, angle, beyond) * s, atol=4e-15)
    p_after = np.cross(s, after)
    np.testing.assert_allclose(out[:, 1], flux * tmm.interface_t("p", n1, n2, angle, beyond) * p_after, atol=4e-15)


def test_total_reflection_begins_at_the_critical_angle():
    critical = np.arcsin(1 / 1.5)
    below, above = (ray(critical + change)[0] for change in (-1e-9, 1e-9))
    assert not is_total(1.5, 1.0, below, UP)
    assert is_total(1.5, 1.0, above, UP)
    assert not is_total(1.0, 1.5, above, UP)


def test_refracted_direction_has_the_sine_of_snell_and_unit_length():
    for n1, n2 in PAIRS:
        direction, _, _ = ray(0.5)
        after, *_ = refract(n1, n2, direction, UP)
        assert abs(jnp.linalg.norm(after) - 1) < 2e-16 * 4
        assert abs(jnp.linalg.norm(after[:2]) - n1 / n2 * np.sin(0.5)) < 2e-16 * 4


@pytest.mark.parametrize("action", [reflect_field, transmit_field])
def test_field_gradients_at_normal_incidence_are_the_limit_of_small_angles(action):
    """The textbook unit vector along d x n has no derivative there; the projectors do."""

    def field(angle):
        direction = jnp.stack([jnp.sin(angle), jnp.zeros_like(angle), -jnp.cos(angle)])
        after = jnp.stack([jnp.ones_like(angle), jnp.zeros_like(angle), jnp.zeros_like(angle)])
        incoming = jax.lax.complex(after - jnp.dot(after, direction) * direction, jnp.zeros(3))[:, None]
        _, cos_i, cos_t, _ = refract(1.0, 1.5, direction, UP)
        return action(1.0, 1.5, direction, UP, cos_i, cos_t, incoming).real[:, 0]

    slope, at = jax.jit(jax.jacfwd(field))(0.0), jax.jit(field)
    h = 1e-4
    difference = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h)
    # A fourth-order difference of numbers of order 1: rounding 1e-16 over h.
    np.testing.assert_allclose(slope, difference, atol=1e-11)
    assert np.abs(slope).max() > 0.1
