"""Hertz's contact: against its formula in 50 digits, with derivatives at the awkward points."""

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest

from newtonjax.scene import hertz_gap


def exact(r2: float, a2: float) -> float:
    """Johnson (1985), eq. 3.42a, and a lifted sphere for a negative a²."""
    with mpmath.workdps(50):
        q, d = mpmath.mpf(r2), mpmath.mpf(a2)
        if a2 <= 0:
            return float(q - 2 * d)
        if q <= d:
            return 0.0
        a, r = mpmath.sqrt(d), mpmath.sqrt(q)
        return float(d * (q / d - 2 + (2 / mpmath.pi) * ((2 - q / d) * mpmath.asin(a / r) + mpmath.sqrt(q / d - 1))))


@pytest.mark.parametrize("a2", [-0.3, 0.0, 1e-12, 0.2, 1.0])
@pytest.mark.parametrize("r2", [0.0, 0.1, 0.2, 0.201, 1.0, 1.01, 7.0])
def test_gap_is_hertz_profile(r2, a2):
    assert float(hertz_gap(jnp.array(r2), jnp.array(a2))) == pytest.approx(
        exact(r2, a2), abs=1e-15 * (1 + r2), rel=1e-10
    )


@pytest.mark.parametrize(("r2", "a2"), [(1.0, 0.3), (0.1, 0.3), (0.3001, 0.3), (4.0, 0.3), (0.5, -0.2), (0.0, 0.3)])
def test_first_derivatives_are_those_of_the_formula(r2, a2):
    step = 1e-7
    slopes = jax.grad(hertz_gap, (0, 1))(jnp.array(r2), jnp.array(a2))
    low = max(r2 - step, 0.0)
    along = (exact(r2 + step, a2) - exact(low, a2)) / (r2 + step - low)
    pressing = (exact(r2, a2 + step) - exact(r2, a2 - step)) / (2 * step)
    np.testing.assert_allclose(slopes, (along, pressing), atol=2e-4)


@pytest.mark.parametrize(("r2", "a2"), [(0.0, 0.0), (0.3, 0.3), (0.0, -1.0), (0.3, 0.0)])
def test_derivatives_are_finite_at_the_centre_the_edge_and_without_contact(r2, a2):
    assert np.isfinite(jax.grad(hertz_gap, (0, 1))(jnp.array(r2), jnp.array(a2))).all()


def test_far_outside_a_disc_is_a_sphere_set_down_by_twice_its_square():
    """The next term falls as 8 a³ / (3 π r): 8.5e-4 of a² at r = 1000 a."""
    assert float(hertz_gap(jnp.array(1e6), jnp.array(1.0))) - 1e6 == pytest.approx(-2 + 8 / (3 * np.pi * 1e3), abs=1e-6)
