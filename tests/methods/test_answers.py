"""What methods say of themselves before a pixel is computed: errors, refusals, which one serves more scenes."""

from dataclasses import replace

import jax
import numpy as np
import pytest

import newtonjax as nj

CAMERA = nj.Camera((48, 40), 40e-6)
FOCUSED = nj.newton_rings(1.0, 500e-9, 1e-6, "reflected", screen="gap")
BARE = nj.newton_rings(1.0, 500e-9, 1e-6, "reflected", screen=1e-3)
# At r/R 0.99 the rays of the direct beam fold on the microscope's image of the gap.
FOLDED = (
    nj.newton_rings(0.02, 500e-9, 1e-6, "transmitted", screen="gap"),
    nj.Camera((33, 33), 0.02 * 0.99 * 2**0.5 / 32),
)


@pytest.mark.parametrize("method", [nj.ClosedForm(), nj.Chebyshev(5), nj.Traced()])
def test_the_error_that_a_method_states_bounds_its_real_one(method):
    exact = nj.render(FOCUSED, CAMERA, nj.Traced())
    stated = method.error(FOCUSED, CAMERA)
    error = float(np.abs(nj.render(FOCUSED, CAMERA, method) - exact).max() / exact.max())
    assert error <= stated.intensity < 0.1
    assert 0 < stated.phase < 0.1


def test_the_closed_form_states_the_error_that_its_plan_has():
    plan = nj.plan(FOCUSED, CAMERA, 0.1)
    assert plan.method == nj.ClosedForm()
    assert nj.ClosedForm().error(FOCUSED, CAMERA) == (plan.phase_error, plan.intensity_error)


def test_rays_state_no_bound_where_they_fold():
    assert np.isinf(nj.Traced().error(*FOLDED).intensity)
    assert np.isfinite(nj.Traced().error(BARE, CAMERA).intensity)


def test_nodes_and_formula_state_no_bound_where_a_beam_does_not_arrive():
    strong = nj.newton_rings(1e-3, 500e-9, 1e-6, "reflected", screen="gap")
    wide = nj.Camera((8, 8), 300e-6)
    assert np.isinf(nj.ClosedForm().error(strong, wide).intensity)
    assert np.isinf(nj.Chebyshev(5).error(strong, wide).intensity)


@pytest.mark.parametrize("method", [nj.ClosedForm(), nj.Traced()])
def test_errors_that_need_numbers_say_so_inside_a_transformation(method):
    def error(gap):
        return method.error(nj.newton_rings(1.0, 500e-9, gap, "reflected", screen="gap"), CAMERA).intensity

    with pytest.raises(ValueError, match="needs numbers"):
        jax.jit(error)(1e-6)


def test_a_refusal_names_the_part_and_the_demand_apart():
    refusal = nj.ClosedForm().refusal(BARE)
    assert refusal is not None
    assert refusal.part.startswith("screen at z = ")
    assert refusal.demand.startswith("it takes one focused on the gap")
    assert str(refusal) == f"ClosedForm cannot honour {refusal.part}: {refusal.demand}; use Chebyshev() or Traced()"
    assert nj.ClosedForm().refusal(FOCUSED) is None
    assert nj.Traced().refusal(BARE) is None


def test_the_closed_form_takes_no_surface_whose_height_it_does_not_ask_for():
    class Bump(nj.Surface):
        """A surface of another height."""

        def sag(self, r2):
            return r2 * 0

    flat, lens, *plate = FOCUSED.surfaces
    scene = replace(FOCUSED, surfaces=(flat, Bump(lens.curvature, lens.vertex), *plate))
    with pytest.raises(ValueError, match=r"cannot honour surfaces\[1\] of Bump: it takes spheres and planes"):
        nj.render(scene, CAMERA, nj.ClosedForm())


def test_the_most_general_method_serves_all_scenes():
    methods = [nj.ClosedForm(), nj.Chebyshev(5), nj.Chebyshev(29), nj.Traced()]
    assert sorted(methods, key=lambda method: method.generality) == methods
    assert nj.Chebyshev(5).for_scenes([nj.Chebyshev(5), nj.Chebyshev(3)]) == nj.Chebyshev(5)
    # How many nodes the scene of the formula takes is not known.
    assert nj.Chebyshev(5).for_scenes([nj.Chebyshev(5), nj.ClosedForm()]) == nj.Chebyshev(17)
    # A scene that needs pixels in float64 gets them among others.
    planned = [nj.Chebyshev(3, "float64"), nj.Chebyshev(5)]
    assert nj.Chebyshev(5).for_scenes(planned) == nj.Chebyshev(5, "float64")
    assert nj.Traced().for_scenes(methods) == nj.Traced()


def test_a_method_is_shown_as_it_is_called():
    methods = [nj.Chebyshev(), nj.Chebyshev(3), nj.Chebyshev(3, "float64"), nj.ClosedForm(), nj.Splat(step=1e-6)]
    shown = ["Chebyshev()", "Chebyshev(nodes=3)", "Chebyshev(nodes=3, dtype='float64')", "ClosedForm()"]
    assert list(map(repr, methods)) == [*shown, "Splat(step=1e-06)"]
