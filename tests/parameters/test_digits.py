"""Numbers in text."""

import numpy as np
import pytest

from fitting.parameters import between, exact, rounded, with_sd


@pytest.mark.parametrize(
    ("value", "sd", "text"),
    [
        (0.878726, 0.0162, "0.879 ± 0.016 m"),
        (0.30000082, 6.2e-7, "0.30000082 ± 6.2e-07 m"),
        (0.3000008, 6.2e-8, "0.300000800 ± 6.2e-08 m"),
        (879.3, 16.0, "879 ± 16 m"),
        (0.9996, 0.0996, "1.00 ± 0.10 m"),
        (9.99999, 0.01, "10.000 ± 0.010 m"),
        (1.2745e-5, 8.3e-9, "12.7450 ± 0.0083 um"),
        (-1.54e-12, 2.9e-12, "-0.0015 ± 0.0029 nm"),
        (9.857e-3, 1.4e-5, "9.857 ± 0.014 mm"),
        (0.0, 3e-9, "0 ± 3.0 nm"),
        (3e-5, 2.0, "3e-05 ± 2.0 m"),
        (5.58561e-7, None, "558.561 nm"),
        (0.0, 1.0, "0 ± 1.0 m"),
        (2.0, 0.0, "2 ± 0 m"),
        (float("inf"), 1.0, "inf ± 1.0 m"),
    ],
)
def test_a_value_stands_to_the_second_digit_of_its_standard_deviation(value, sd, text):
    assert with_sd(value, sd, "m") == text


def test_an_interval_and_a_given_number_are_in_a_unit_of_their_size():
    assert between((9.82877e-3, 9.88431e-3), 1.4e-5, "m") == "9.829 to 9.884 mm"
    assert between((0.97, 1.03), 0.016, "m") == "0.970 to 1.030 m"
    assert between((1.2, 1.4), 0.1) == "1.20 to 1.40"
    assert exact(5.893e-7, "m") == "589.3 nm"
    assert exact(1.5) == "1.5"


def test_what_is_left_out_is_less_than_a_tenth_of_the_standard_deviation():
    rng = np.random.default_rng(2)
    values = rng.normal(size=1000) * 10.0 ** rng.uniform(-9, 9, 1000)
    for value, sd in zip(values, 10.0 ** rng.uniform(-12, 9, 1000), strict=True):
        assert abs(float(rounded(value, sd)) - value) <= 0.0501 * sd
