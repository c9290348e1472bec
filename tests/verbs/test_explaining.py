"""What `explain` says: its numbers bound what a part really changes, and its page names every part."""

from dataclasses import replace

import jax
import numpy as np
import pytest

import newtonjax as nj
from fitting.shell.cli import main

CAMERA = nj.Camera((64, 64), 60e-6)


def errors(explanation):
    return {part.part: part.error for part in explanation.omissions}


@pytest.fixture(scope="module")
def reflected():
    scene = nj.newton_rings(0.5, 550e-9, 1e-6, "reflected", screen=5e-3, light_tilt=(0.05, 0.0))
    return scene, nj.explain(scene, CAMERA)


def worst(one, other):
    return float(np.abs(one - other).max() / max(one.max(), other.max()))


def test_predicted_changes_bound_the_real_ones_and_are_of_their_size(reflected):
    scene, said = reflected
    image, light = nj.render(scene, CAMERA, nj.Traced()), scene.light
    real = {
        "polarization": max(
            worst(image, nj.render(replace(scene, light=replace(light, polarization=p)), CAMERA, nj.Traced()))
            for p in (0.0, np.pi / 2)
        ),
        "tilt of the light": worst(image, nj.render(replace(scene, light=replace(light, tilt=(0.0, 0.0))), CAMERA)),
    }
    for part, change in real.items():
        assert change <= errors(said)[part] < 20 * change


def test_mean_over_a_pixel_is_the_sinc_of_the_fringes():
    scene = nj.air_wedge(2e-3, 500e-9, screen="gap")
    said = errors(nj.explain(scene, CAMERA))["mean over each pixel"]
    period = 500e-9 / (2 * np.tan(2e-3)) / 60e-6  # pixels
    contrast = 1 - np.sinc(1 / period)
    assert contrast * 0.45 < said < contrast  # half of the swing, half as much again for what lies between


def test_more_beams_are_bounded_by_what_they_change():
    scene = nj.newton_rings(2.0, 500e-9, view="reflected", screen="gap")
    more = nj.choose_beams(scene, number=12, reflections=4)
    change = float(np.abs(nj.render(more, CAMERA, nj.Traced()) - nj.render(scene, CAMERA, nj.Traced())).max())
    assert change / float(nj.render(scene, CAMERA).max()) < errors(nj.explain(scene, CAMERA))["more beams"]


def test_the_page_names_method_cost_and_parts(reflected):
    said = reflected[1]
    text = str(said)
    for word in (
        "method",
        "predicted",
        "measured",
        "polarization",
        "tilt of the light",
        "mean over each pixel",
        "rms width",
    ):
        assert word in text
    assert said.predicted_seconds > 0
    assert said.measured_seconds > 0
    assert "rays" in text


def test_fewer_pixels_than_nodes_are_traced():
    scene = nj.newton_rings(view="transmitted", screen=1e-3)
    assert isinstance(nj.plan(scene, nj.Camera((2, 2), 5e-6)).method, nj.Traced)
    assert isinstance(nj.plan(scene, nj.Camera((300, 300), 5e-6)).method, nj.Chebyshev)


def test_what_a_scene_does_without_costs_nothing():
    """The compiler's own count of operations, at the nodes: a beam or a shield left out takes operations away."""

    def count(scene):
        lowered = jax.jit(lambda s, c: nj.Chebyshev(9).image(s, c)).lower(scene, CAMERA)
        return lowered.compile().cost_analysis()["flops"]

    bare = nj.newton_rings(polarization=0.0, view="transmitted", screen=1e-3)
    assert count(bare) < count(replace(bare, beams=(*bare.beams, "T0 T1 R2 R1 R2 R1 T2 T3")))
    assert count(bare) < count(nj.newton_rings(polarization=0.0, shield=2e-3, view="transmitted", screen=1e-3))
    focused = nj.newton_rings(view="reflected", screen="gap")
    closed = jax.jit(lambda s, c: nj.ClosedForm().image(s, c)).lower(focused, CAMERA).compile().cost_analysis()["flops"]
    assert closed < count(focused)


def test_cost_grows_with_what_is_there():
    scene, large = nj.newton_rings(view="transmitted", screen=1e-3), nj.Camera((1024, 1024), 5e-6)
    assert nj.ClosedForm().passes(scene, large) < nj.Chebyshev(9).passes(scene, large)
    assert nj.Chebyshev(9).passes(scene, large) < nj.Chebyshev(17).passes(scene, large)
    assert nj.Chebyshev(17).passes(scene, large) < nj.Traced().passes(scene, large) / 100


def test_the_verb_prints_the_page(tmp_path, capsys):
    assert (
        main(
            ["render", "transmitted", "--screen", "1mm", "-o", str(tmp_path / "a.png"), "--shape", "64x64", "--explain"]
        )
        == 0
    )
    said = capsys.readouterr().out
    assert "not modelled, and the change" in said
    assert "predicted" in said


@pytest.mark.parametrize("tolerance", [0.0, -1.0, np.inf])
def test_tolerances_that_are_none_are_refused(tolerance):
    with pytest.raises(ValueError, match="allowed: a positive number"):
        nj.explain(nj.newton_rings(view="transmitted", screen=1e-3), CAMERA, tolerance)
