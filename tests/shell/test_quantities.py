"""Quantities with units and named lines, as users type them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fitting.shell import assignments, lamps, quantities


@pytest.mark.parametrize(
    ("text", "metres"),
    [
        ("589.3nm", 589.3e-9),
        ("12.75um", 12.75e-6),
        (" 12.75 µm ", 12.75e-6),
        ("2m", 2.0),
        ("-10nm", -1e-8),
        ("5e-3 mm", 5e-6),
        (".5inch", 0.0127),
        ("1cm", 0.01),
        ("+1km", 1000.0),
        ("5890Å", 589e-9),
    ],
)
def test_a_length_with_its_unit_becomes_metres(text, metres):
    assert quantities.length(text) == pytest.approx(metres, rel=1e-15)


@pytest.mark.parametrize(("text", "radians"), [("0.1mrad", 1e-4), ("180deg", np.pi), ("1arcsec", np.pi / 648000)])
def test_an_angle_with_its_unit_becomes_radians(text, radians):
    assert quantities.angle(text) == pytest.approx(radians, rel=1e-15)


@pytest.mark.parametrize(
    ("kind", "unit"), [(kind, unit) for kind, units in quantities._USUAL.items() for unit in units]
)
def test_the_usual_units_are_those_of_pint(kind, unit):
    root = quantities._registry().Quantity(1.0, unit).to_root_units()
    assert quantities._USUAL[kind][unit] == root.magnitude
    assert str(root.units) == {"length": "meter", "angle": "radian"}[kind]


@pytest.mark.parametrize(("text", "point"), [("1,3612um", "1.3612um"), ("589,3 nm", "589.3 nm"), ("-2,5m", "-2.5m")])
def test_a_decimal_comma_is_refused_with_the_same_length_with_a_point(text, point):
    with pytest.raises(ValueError, match=f"has a decimal comma; write a point: {point}"):
        quantities.length(text)


def test_a_length_is_the_float_nearest_to_what_is_typed():
    assert quantities.length("635nm") == 6.35e-7
    assert quantities.length("1.3612um") == 1.3612e-6


@pytest.mark.parametrize("text", ["589.3", "0", "-1e-9", "1."])
def test_a_bare_number_is_refused_with_the_units_offered(text):
    with pytest.raises(ValueError, match=r"has no unit; give one of nm, um, mm, cm or m, as in 589\.3nm"):
        quantities.length(text)


@pytest.mark.parametrize("text", ["5mrad", "3s", "2nm**2", "1/nm", "5flurbs", "5nm nm", "1m+1m", "5'", "5%"])
def test_a_unit_of_another_kind_is_refused(text):
    with pytest.raises(ValueError, match="is no unit of length"):
        quantities.length(text)


@pytest.mark.parametrize("text", ["5nm", "5%", "5ppm", "5dimensionless"])
def test_what_has_no_angle_is_no_angle(text):
    with pytest.raises(ValueError, match="is no unit of angle"):
        quantities.angle(text)


@pytest.mark.parametrize("text", ["nan nm", "nanm", "inf m", "-inf", "", "nm", "1e999m", "__import__('os')"])
def test_what_is_not_finite_is_refused(text):
    with pytest.raises(ValueError, match=r"is no length|too large|has no unit"):
        quantities.length(text)


@pytest.mark.parametrize("text", ["0nm", "-5um"])
def test_a_pixel_size_is_above_zero(text):
    with pytest.raises(ValueError, match="not above zero"):
        quantities.positive_length(text)


def test_a_standard_deviation_may_be_zero_but_not_negative():
    assert quantities.length_sd("0nm") == 0.0
    with pytest.raises(ValueError, match="is negative"):
        quantities.length_sd("-1nm")


@given(st.floats(1e-12, 1e12), st.sampled_from([("nm", 1e-9), ("um", 1e-6), ("mm", 1e-3), ("m", 1.0)]))
def test_any_number_is_read_to_its_last_digits(number, unit):
    assert quantities.length(f"{number!r}{unit[0]}") == pytest.approx(number * unit[1], rel=4e-16)


def assert_offers(message):
    assert "give" in message


@given(st.text(max_size=20))
def test_any_text_is_a_finite_length_or_refused_in_one_line(text):
    try:
        value = quantities.length(text)
    except ValueError as error:
        assert_offers(str(error))
    else:
        assert np.isfinite(value)


def test_a_named_line_is_in_air_where_air_counts_as_one():
    # NIST: Na D1 and D2 in air 589.5924 and 588.9950 nm, in vacuum 589.7558 and 589.1583 nm.
    assert lamps.wavelength("Sodium").within(1.0) == pytest.approx((589.5924e-9 + 588.9950e-9) / 2, rel=1e-6)
    assert lamps.wavelength("sodium-d2").within(1.00027) == pytest.approx(589.1583e-9, rel=5e-6)
    assert lamps.wavelength("hene").within(1.00027) == pytest.approx(632.9912e-9, rel=5e-6)
    assert lamps.wavelength("589.3nm").within(1.00027) == pytest.approx(589.3e-9, rel=1e-15)


def test_a_lamp_is_a_wavelength_to_choose_in_a_design():
    units = {"wavelength": "m", "gap": "m"}
    assert assignments.number("wavelength", "hene", units) == 632.8162e-9
    green = assignments.number("wavelength", "mercury:546nm/10nm", units)
    assert green == pytest.approx(546.074e-9, rel=1e-9)
    with pytest.raises(ValueError, match="no length"):
        assignments.number("gap", "hene", units)


def test_an_unknown_line_is_refused_with_the_lines_offered():
    with pytest.raises(ValueError, match="sodium, sodium-d1"):
        lamps.wavelength("sodiom")


def test_a_standard_deviation_of_a_length_may_be_a_percentage():
    assert quantities.length_sd(" 0.1% ") == "0.1%"
    assert quantities.length_sd("5nm") == pytest.approx(5e-9)
    for text in ("-1%", "1e999%", "%", "a%", "1nm%"):
        with pytest.raises(ValueError, match="is no percentage; give zero or more"):
            quantities.length_sd(text)
