"""Rings of many beams: finesse and fringe scale with their deviations, and a radius of a coated bench alone."""

import numpy as np
import pytest

import fitting
import newtonjax as nj
from experiments.truth.sharp_rings import deviations, half_level_finesse, made
from fitting.photograph.sharp_waveform import NAMES, finesse_of, slopes, waveform

GIVEN = {"pixel_size": 10e-6, "pixel_size_sd": 1e-8}


@pytest.mark.parametrize(("seed", "finesse"), [(5, 3.0), (8, 9.0), (12, 30.0)])
def test_sharp_rings_are_measured_and_give_no_radius(seed, finesse):
    scattered = deviations(made(seed, finesse))
    assert scattered is not None
    assert max(map(abs, scattered.values())) < 4


def test_the_finesse_is_that_of_half_levels():
    for ratio in (0.2, 0.5, 0.9):
        assert finesse_of(ratio, 0.0) == pytest.approx(half_level_finesse(ratio), rel=1e-3)


@pytest.mark.parametrize("variance", [0.0, 0.02])
def test_slopes_of_the_waveform_of_many_beams_are_its_central_differences(variance):
    x, y = np.random.default_rng(1).uniform(-0.7, 0.7, (2, 50))
    values = (2.1, -0.1, 0.05, 0.19, 0.6, 0.02, -0.03, 0.05, -0.04, 0.03, -0.02, variance)
    numbers = dict(zip(NAMES, values, strict=True))
    names, step = NAMES if variance else NAMES[:-1], 1e-6
    for name, slope in zip(names, slopes(numbers, x, y, names).T, strict=True):
        ends = (waveform({**numbers, name: numbers[name] + sign * step}, x, y) for sign in (1, -1))
        assert slope == pytest.approx(np.subtract(*ends) / (2 * step), rel=1e-6, abs=1e-6)


def test_a_coated_bench_makes_a_radius_of_sharp_rings():
    picture = made(3, 6.0)
    bench = nj.newton_rings(1.0, 500e-9, lens_coating="mirror:60%", plate_coating="mirror:60%")
    result = fitting.fit(picture.image, scene=bench, **GIVEN)
    radius = 1e-10 / (picture.scale * 500e-9)
    assert result.status == "ok"
    assert abs(result.radius - radius) < 4 * dict(result.budget)["phase polynomials"]
    assert result.radius_sd == pytest.approx(2e-3 * radius, rel=0.1)
    assert fitting.FitResult.from_dict(result.to_dict()) == result


def test_what_is_no_ring_of_many_beams_is_refused_though_the_bench_is_coated():
    rng = np.random.default_rng(0)
    bench = nj.newton_rings(1.0, 500e-9, plate_coating="mirror:60%")
    result = fitting.fit(rng.normal(0.5, 0.1, (120, 140)), scene=bench, **GIVEN)
    assert (result.status, result.reason) == ("refused", "SHARP_RINGS_MISFIT")


def test_rings_of_fabry_and_perot_have_a_finesse_and_no_radius(shared):
    photograph = shared / "trials" / "fabry_perot_cadmium.tif"
    result = fitting.fit(photograph, wavelength=643.8e-9, pixel_size=10e-6, transfer="linear")
    assert (result.status, result.reason, result.radius) == ("refused", "MANY_BEAM_RINGS", None)
    finesse, scale = result.parameters["finesse"], result.parameters["fringe_scale"]
    # Another program, with other polynomials: 4.4 in every variant, and 84 300 to 84 900 px², 86 000 with u³.
    assert finesse.value == pytest.approx(4.45, abs=0.15)
    assert 84_000 < 1 / scale.value < 85_200
    assert 0.005 < scale.sd / scale.value < 0.02
    guessed = fitting.fit(photograph, wavelength=643.8e-9).parameters["finesse"]
    assert abs(guessed.value - finesse.value) < 2.5 * guessed.sd
