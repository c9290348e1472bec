"""Beams as words."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import newtonjax as nj
from newtonjax.scene import REST, itinerary, tables
from newtonjax.scene.beams import energy_on_axis, words

GLASS = (1.0, 1.5, 1.0, 1.5, 1.0)


def reflectance(a, b):
    return ((a - b) / (a + b)) ** 2


def test_two_faces_have_one_word_for_each_number_of_reflections():
    assert set(words(2, 4, "transmitted")) == {"T0 T1", "T0 R1 R0 T1", "T0 R1 R0 R1 R0 T1"}
    assert set(words(2, 3, "reflected")) == {"R0", "T0 R1 T0", "T0 R1 R0 R1 T0"}


def test_energies_over_all_words_approach_one_by_the_power_of_the_last_reflection():
    """For two faces the sum of both views misses 1 by what is still inside: (1 - R) R^(2k) after 2k reflections."""
    media, r = (1.0, 1.5, 1.0), reflectance(1.0, 1.5)
    for k in (1, 3, 5):
        both = [b.energy for view in ("transmitted", "reflected") for b in nj.enumerate_beams(media, view, 2 * k)]
        assert abs(1 - sum(both) - (1 - r) * r ** (2 * k + 1)) < 1e-15


def test_energies_of_four_faces_are_fresnel_products_strongest_first():
    r = reflectance(1.0, 1.5)
    found = nj.enumerate_beams(GLASS, "transmitted", 2)
    assert found[0].name == "direct"
    assert abs(found[0].energy - (1 - r) ** 4) < 1e-15
    # Six ways to reflect twice among four equal faces; the order of beams is that of their energies.
    assert len(found) == 7
    assert all(abs(b.energy - (1 - r) ** (b.word.count("T")) * r**2) < 1e-15 for b in found[1:])
    energies = [b.energy for b in found]
    assert energies == sorted(energies, reverse=True)


@given(
    st.integers(1, 4),
    st.integers(0, 4),
    st.sampled_from(["transmitted", "reflected"]),
    st.lists(st.floats(1, 3), min_size=5, max_size=5),
)
def test_every_enumerated_word_can_be_read_and_leaves_on_its_side(surfaces, reflections, view, indices):
    found = words(surfaces, reflections, view)
    assert len(set(found)) == len(found)
    for word in found:
        assert itinerary(word, surfaces).view == view
        assert word.count("R") <= reflections
        assert 0 <= energy_on_axis(word, indices[: surfaces + 1]) <= 1


@pytest.mark.parametrize(
    ("word", "message"),
    [
        ("T0 X1", "'X1' is no interaction; allowed: T or R"),
        ("T0 T2", "meets surface 1, not surface 2"),
        ("T0 R1 R1", "meets surface 0, not surface 1"),
        ("T0 T1 T2", "ends inside the stack of 4 surfaces"),
        ("", "ends inside the stack"),
        ("R0 T0", "no surface: the light has left the stack"),
    ],
)
def test_a_word_that_light_cannot_follow_is_refused_with_the_place(word, message):
    with pytest.raises(ValueError, match=message):
        itinerary(word, 4)


def test_tables_rest_where_a_word_is_shorter():
    table = tables(("T0 T1 T2 T3", "T0 T1 R2 R1 T2 T3"), 4)
    np.testing.assert_array_equal(table["action"][0], [0, 0, 0, 0, REST, REST])
    np.testing.assert_array_equal(table["action"][1], [0, 0, 1, 1, 0, 0])
    np.testing.assert_array_equal(table["before"][1], [0, 1, 2, 2, 2, 3])
    np.testing.assert_array_equal(table["beyond"][1], [1, 2, 3, 1, 3, 4])


def test_beams_are_chosen_by_number_energy_or_name():
    scene = nj.newton_rings(view="transmitted", screen=1e-3)
    assert nj.choose_beams(scene, number=1).beams == ("T0 T1 T2 T3",)
    assert nj.choose_beams(scene, names=("direct", "R2-R1")).beams == scene.beams
    assert nj.choose_beams(scene, energy=1e-3).beams == tuple(
        beam.word for beam in nj.enumerate_beams(GLASS, "transmitted") if beam.energy >= 1e-3
    )


def test_beams_are_chosen_in_every_scene_that_there_is():
    """Indices beyond those of the ready benches: what `Scene` takes, its beams are numbered for too."""
    beams = "R0", "T0 R1 T0"
    scene = nj.Scene((nj.Surface(), nj.Surface(0.0, (0, 0, -1e-3))), (1, 20, 1), nj.Light(5e-7), nj.Surface(), beams)
    assert nj.choose_beams(scene, number=2).beams == nj.choose_beams(scene, energy=1e-2, reflections=1).beams == beams
    assert nj.explain(scene, nj.Camera((8, 8), 1e-6)).omissions
    with pytest.raises(ValueError, match=r"media is \(1.0, -1.0\); allowed: positive refractive indices"):
        nj.enumerate_beams((1.0, -1.0))


@pytest.mark.parametrize(
    ("choice", "message"),
    [
        ({}, "exactly one of number, energy and names"),
        ({"number": 2, "energy": 0.1}, "exactly one of number, energy and names"),
        ({"names": ("R9-R8",)}, "'R9-R8' is unknown: light leaves the stack of 4 surfaces before it meets R9"),
        ({"names": "R1"}, "names is 'R1'; allowed: a tuple of words"),
        ({"energy": "x"}, "energy is 'x'; allowed: one number, a fraction of the incident flux"),
        ({"energy": float("nan")}, "energy is nan; allowed: one number"),
        ({"energy": 2.0}, "no beam is left of 7; the strongest has energy 0.849"),
    ],
)
@pytest.mark.usefixtures("untyped")
def test_a_choice_that_cannot_be_made_is_refused_with_the_reason(choice, message):
    with pytest.raises(ValueError, match=message):
        nj.choose_beams(nj.newton_rings(view="transmitted", screen=1e-3), **choice)


@pytest.mark.parametrize(
    ("beams", "message"),
    [
        ((), "beams is empty"),
        (("T0 T1 T2 T3", "T0 T1 T2 T3"), "holds a word twice"),
        (("T0 T1 T2 T3", "R0"), "leave on both sides"),
    ],
)
def test_a_scene_refuses_beams_that_cannot_meet(beams, message):
    with pytest.raises(ValueError, match=message):
        nj.newton_rings(beams=beams, view="transmitted", screen=1e-3)
