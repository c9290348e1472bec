"""What speaks for rings before any fit: real photographs and made ones, and few fringes with the light behind them."""

import numpy as np
import pytest
from rings_data import WAVELENGTH, coordinates, rings

import fitting
from fitting.parameters import one_blas_thread
from fitting.photo import evidence_of, find_rings, read
from fitting.photo.evidence import RingEvidence

# Share of the fringe power, orders, bend, share, coherence and harmonics of good rings.
GOOD = {"match": 0.7, "orders": 20.0, "bend": 10.0, "share": 0.9, "coherence": 0.9, "second": 0.0, "third": 0.0}
GOOD |= {"noise": 0.0, "plane": 0.0}


@pytest.fixture(autouse=True, scope="module")
def one_thread():
    """As in a fit: a BLAS with threads of its own spins between small products."""
    with one_blas_thread():
        yield


def evidence(image) -> RingEvidence:
    photograph = read(image)
    return evidence_of(photograph, find_rings(photograph))


@pytest.mark.parametrize(
    ("folder", "name", "verdict"),
    [
        ("photos", "eyepiece_arcs.jpg", "rings"),
        ("photos", "phone_blurred_cropped.jpg", "rings"),
        ("photos", "lens_1000mm_sodium.jpg", "rings"),
        ("trials", "lens_850mm_sodium.jpg", "rings"),
        ("trials", "white_light_154.5mm.tif", "rings"),
        ("trials", "slightly_bent_fringes.bmp", "rings"),
        ("photos", "wedge_straight_fringes.jpg", "straight"),
        ("photos", "reticle_0.2mm.jpg", "straight"),
        ("trials", "straight_fringes_a.jpg", "straight"),
        ("trials", "white_light_oblique.jpg", "no rings"),
        ("trials", "hologram_of_a_bead.jpg", "no rings"),
        ("trials", "air_film_not_a_sphere.tif", "no rings"),
        ("trials", "michelson_overlay.jpg", "no rings"),
        ("trials", "fabry_perot_cadmium.tif", "many beams"),
    ],
)
def test_real_photographs_are_told_apart(shared, folder, name, verdict):
    found = evidence(shared / folder / name)
    assert found.verdict == verdict
    assert bool(found.reason) == (verdict != "rings")


@pytest.mark.parametrize(
    ("changed", "verdict"),
    [
        ({}, "rings"),
        ({"bend": 0.5}, "straight"),
        ({"match": 0.3, "share": 0.3}, "no rings"),
        ({"match": 0.3, "coherence": 0.3}, "no rings"),
        ({"match": 0.1}, "no rings"),
        ({"match": 0.1, "plane": 0.6}, "straight"),
        ({"second": -0.3}, "many beams"),
        ({"third": 0.15}, "many beams"),
        ({"match": 0.5, "share": 0.2}, "rings"),
        ({"match": 0.1, "share": 0.19, "noise": 0.8}, "rings"),
        ({"match": 0.1, "share": 0.1, "noise": 0.8}, "no rings"),
    ],
)
def test_each_number_speaks_for_itself(changed, verdict):
    found = RingEvidence(**GOOD | changed)
    assert found.verdict == verdict
    assert (found.reason is None) == (verdict == "rings")


def test_a_refusal_says_what_was_measured_and_what_is_required():
    found = RingEvidence(**GOOD | {"match": 0.31, "share": 0.27})
    assert all(number in found.reason for number in ("31%", "27%", "90%", "50%"))
    none = RingEvidence(**GOOD | {"match": 0.1})
    assert all(number in none.reason for number in ("10%", "20%"))
    wedge = RingEvidence(**GOOD | {"match": 0.1, "plane": 0.6})
    assert all(words in wedge.reason for words in ("straight", "60%", "10%"))
    bent = RingEvidence(**GOOD | {"bend": 0.4})
    assert all(words in bent.reason for words in ("straight", "0.4", "0.75"))


@pytest.mark.parametrize("noise", [0.3, 0.5, 0.7])
@pytest.mark.parametrize("centre", [(130.0, 120.0), (-100.0, 60.0)])
def test_noise_as_strong_as_the_fringes_does_not_refuse_rings(noise, centre):
    assert evidence(rings(0.3, centre=centre, noise=noise)).verdict == "rings"


def test_fringes_of_many_beams_are_refused_before_a_fit():
    turns = coordinates((300, 300), (140.0, 160.0)) / 6000
    airy = 1 / (1 + 8 * np.sin(np.pi * turns) ** 2) + 0.01 * np.random.default_rng(0).normal(size=turns.shape)
    result = fitting.fit(airy, wavelength=WAVELENGTH)
    assert result.status == "refused"
    assert result.reason == "MANY_BEAM_RINGS"
    assert result.parameters["fringe_scale"].value == pytest.approx(1 / 6000, rel=2e-3)


@pytest.mark.parametrize("orders", [1.5, 2.0, 3.0])
@pytest.mark.parametrize("turns", [0.0, 0.3])
@pytest.mark.parametrize("slope", [0.0, 0.3])
def test_the_light_behind_a_few_fringes_does_not_move_their_scale(orders, turns, slope):
    """Taken off before the search, the background moved the scale of some of these by 13 to 79 %."""
    shape, centre = (256, 256), (204.0, 153.0)
    scale = orders / np.ptp(coordinates(shape, centre))
    image = rings(25e-12 / (scale * WAVELENGTH), centre=centre, gap=turns * WAVELENGTH / 2, noise=0.02)
    image = image + slope * np.linspace(-1, 1, 256)[:, None] ** 2
    found = find_rings(read(image))
    assert found.scale == pytest.approx(scale, rel=0.01)
    assert np.hypot(*np.subtract(found.centre, centre)) < 2


@pytest.mark.parametrize("seed", range(3))
def test_few_arcs_of_a_centre_far_outside_keep_their_scale(seed):
    """Three fringes that bend by half a turn; the search alone was up to 30 % off."""
    shape, centre = (300, 300), [(-150.0, 320.0), (420.0, -90.0), (150.0, 520.0)][seed]
    scale = 3.2 / np.ptp(coordinates(shape, centre))
    turns = scale * coordinates(shape, centre) + 0.2 * seed
    image = 0.5 + 0.4 * np.cos(2 * np.pi * turns) + 0.03 * np.random.default_rng(seed).normal(size=shape)
    assert find_rings(read(image)).scale == pytest.approx(scale, rel=0.02)
