"""Cosine and sine of a phase in turns."""

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from newtonjax.numerics import cos_turns, cosine_and_sine, sin_turns

# What the docstrings promise.
BOUND = {"float64": 1.3e-14, "float32": 3e-7}
EXACT = {cos_turns: lambda x: mpmath.cospi(2 * mpmath.mpf(x)), sin_turns: lambda x: mpmath.sinpi(2 * mpmath.mpf(x))}


@pytest.mark.parametrize("dtype", ["float64", "float32"])
@pytest.mark.parametrize("function", [cos_turns, sin_turns])
def test_error_stays_at_rounding_up_to_a_million_turns(function, dtype):
    rng = np.random.default_rng(1)
    awkward = np.array([0, 0.25, 0.5, 0.75, -0.5, 1.5, 0.125])
    phase = np.concatenate([awkward, rng.uniform(-2, 2, 500), rng.uniform(-1e6, 1e6, 500)]).astype(dtype)
    with mpmath.workdps(30):
        exact = np.array([float(EXACT[function](float(x))) for x in phase])
    value = function(jnp.asarray(phase))
    assert value.dtype == dtype
    assert np.abs(np.asarray(value, dtype=np.float64) - exact).max() < BOUND[dtype]


@pytest.mark.parametrize(("dtype", "bound"), [("float64", 1e-13), ("float32", 3e-7)])
def test_cosine_and_sine_of_a_fraction_are_those_of_its_turn(dtype, bound):
    awkward = [0, -0.0, 1e-9, -1e-9, 0.25, -0.25, 0.5, -0.5]
    fraction = np.concatenate([awkward, np.linspace(-0.5, 0.5, 501)]).astype(dtype)
    with mpmath.workdps(30):
        exact = np.array([[float(EXACT[f](float(y))) for y in fraction] for f in (cos_turns, sin_turns)])
    waves = cosine_and_sine(jnp.asarray(fraction))
    assert all(wave.dtype == dtype for wave in waves)
    assert np.abs(np.asarray(waves, dtype=np.float64) - exact).max() < bound


@given(st.floats(-1e9, 1e9))
def test_cosine_is_even_and_sine_is_odd(phase):
    assert cos_turns(-phase) == cos_turns(phase)
    assert sin_turns(-phase) == -sin_turns(phase)


@pytest.mark.parametrize("phase", [0.0, 0.25, 0.5, 3.7, -1e5 + 0.1])
def test_derivatives_are_those_of_the_exact_functions(phase):
    angle = 2 * np.pi * (phase - round(phase))
    # Two factors of 2π and the function's own error.
    for order, exact in enumerate([-2 * np.pi * np.sin(angle), -4 * np.pi**2 * np.cos(angle)]):
        derivative = jax.grad(cos_turns) if order == 0 else jax.grad(jax.grad(cos_turns))
        assert abs(derivative(phase) - exact) < 40 * 1.3e-14
        forward = jax.jvp(jax.grad(sin_turns), (phase,), (1.0,))[order]
        assert abs(forward - [2 * np.pi * np.cos(angle), -4 * np.pi**2 * np.sin(angle)][order]) < 40 * 1.3e-14


def test_whole_numbers_of_turns_are_taken_as_floats():
    assert abs(cos_turns(3) - 1) < 1.3e-14
    assert abs(sin_turns(jnp.arange(3))).max() < 1.3e-14
