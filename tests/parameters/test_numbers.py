"""One number: of Python, NumPy or JAX, and no array of one."""

import jax.numpy as jnp
import numpy as np
import pytest

from fitting.parameters import number, read_sd


@pytest.mark.parametrize("value", [2, 2.0, np.float32(2), np.array(2.0), jnp.array(2.0)])
def test_what_is_one_number_is_taken(value):
    assert number("radius", value) == 2.0


@pytest.mark.parametrize("value", [np.full(1, 2.0), np.full((1, 1), 2.0), jnp.full(1, 2.0), [2.0], "2", None])
def test_an_array_of_one_is_none(value):
    with pytest.raises(ValueError, match="allowed: one finite number in SI units"):
        number("radius", value)


def test_an_array_is_no_standard_deviation():
    for value in (np.full(1, 2.0), np.ma.masked, [np.ma.masked], [2.0]):
        assert np.isnan(read_sd(value)[1])
    assert read_sd(np.array(2.0)) == (False, 2.0)
    assert read_sd("2%") == (True, 0.02)
