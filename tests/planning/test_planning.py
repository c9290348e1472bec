"""The choice of a method keeps its promise."""

import dataclasses

import jax
import numpy as np
import pytest

import newtonjax as nj

WAVELENGTH = 589.3e-9
SHAPE = (32, 32)


def benches():
    """Twenty benches of many kinds, each with a camera: screens near and far, tilts, edges, and the gap in focus."""
    rng = np.random.default_rng(11)
    for k in range(17):
        radius = [0.02, 0.1, 0.5, 2.0, 20.0][k % 5]
        screen = ["gap", 1e-3, "gap", 10e-3, 50e-3, "gap"][k % 6]
        tilts = {n: tuple(rng.normal(0, 2e-3, 2)) for n in ("lens_tilt", "light_tilt")} if k % 3 == 2 else {}
        half = [0.3, 0.1, 0.02][k % 3] * min(radius, 0.05)
        scene = nj.newton_rings(radius, WAVELENGTH, [0.0, 2e-6][k % 2], "reflected", screen=screen, **tilts)
        yield scene, nj.Camera(SHAPE, 2 * half / SHAPE[0])
    # A camera that looks past the edge of total reflection, and a tiny field on the first bright ring, where
    # the closed form is exact enough.
    yield nj.newton_rings(5e-3, WAVELENGTH, view="reflected", lens_index=1.9, screen=1e-3), nj.Camera(SHAPE, 250e-6)
    yield nj.newton_rings(20.0, WAVELENGTH, view="reflected", screen="gap"), nj.Camera(SHAPE, 1e-6, (-2411.0, 15.5))
    yield nj.air_wedge(1e-4, WAVELENGTH, 3e-6, "reflected", screen="gap"), nj.Camera(SHAPE, 50e-6)


BENCHES = list(benches())


@pytest.fixture(scope="module")
def traced():
    return [np.asarray(nj.render(scene, camera, method=nj.Traced())) for scene, camera in BENCHES]


@pytest.fixture(scope="module")
def plans():
    return {tolerance: [nj.plan(*bench, tolerance) for bench in BENCHES] for tolerance in (1e-3, 1e-6)}


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6])
def test_planned_images_keep_within_the_tolerance_of_the_traced_ones(plans, traced, tolerance):
    for (scene, camera), plan, exact in zip(BENCHES, plans[tolerance], traced, strict=True):
        image = nj.render(plan.scene, camera, method=plan.method)
        error = np.abs(image - exact).max() / exact.max()
        assert error <= tolerance, (scene, plan.method, error)
        assert error <= plan.intensity_error, (scene, plan.method, error)


def test_plans_differ_with_the_bench_and_with_the_tolerance(plans):
    for chosen in plans.values():
        assert len({type(plan.method) for plan in chosen}) >= 2
    assert {type(plan.method) for chosen in plans.values() for plan in chosen} == {
        nj.ClosedForm,
        nj.Chebyshev,
        nj.Traced,
    }
    both = zip(*plans.values(), strict=True)
    assert sum(loose.method != tight.method for loose, tight in both) >= 5


def test_weak_beams_are_dropped_and_counted_in_the_error():
    weak = "T0 T1 R2 R1 R2 R1 R2 R1 R2 R1 R2 T1 T0"
    scene = nj.newton_rings(1.0, WAVELENGTH, view="reflected", screen=1e-3)
    scene, camera = dataclasses.replace(scene, beams=(*scene.beams, weak)), nj.Camera(SHAPE, 20e-6)
    plan = nj.plan(scene, camera, 1e-3)
    assert plan.dropped == (weak,)
    assert plan.scene.beams == scene.beams[:2]
    # Nine reflections of 0.2 each against two beams of one each: the bright fringe, 4 of a beam, changes by 4 · 0.2⁸.
    assert 0.2**8 <= plan.intensity_error <= 1e-3
    exact = nj.render(scene, camera, method=nj.Traced())
    error = np.abs(nj.render(plan.scene, camera, method=plan.method) - exact).max() / exact.max()
    assert 0.5 * 0.2**8 < error <= plan.intensity_error


@pytest.mark.parametrize("tolerance", [0.0, -1e-3, np.inf, np.nan])
def test_a_tolerance_that_promises_nothing_is_refused(tolerance):
    with pytest.raises(ValueError, match=r"tolerance is .*; allowed: a positive number"):
        nj.plan(*BENCHES[0], tolerance)


def test_planning_under_a_transformation_is_refused_with_what_to_do():
    with pytest.raises(ValueError, match="call it outside of jit, grad and vmap"):
        jax.jit(
            lambda radius: (
                nj.plan(nj.newton_rings(radius, view="transmitted", screen=1e-3), nj.Camera(SHAPE, 1e-5)).phase_error
            )
        )(1.0)
