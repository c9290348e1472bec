"""At the ends of what a bench can be: dark, found, refused or said; all of them in `extremes.py`."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from compilations import QUICKLY

import newtonjax as nj
from newtonjax.fields import fields_at
from newtonjax.scene import frame

TINY = nj.Camera((3, 3), 1e-3)


@pytest.mark.parametrize("tilt", [np.pi / 2, 2.0, np.pi, -1.7])
def test_light_from_below_is_refused(tilt):
    for both in ((tilt, 0.0), (0.0, tilt)):
        with pytest.raises(ValueError, match="light comes from above"):
            nj.newton_rings(2.0, light_tilt=both, view="transmitted", screen=1e-3)


@pytest.mark.parametrize("view", ["transmitted", "reflected"])
def test_rays_that_would_run_backwards_are_dark(view):
    """A lens upside down, which no ready bench has."""
    bench = nj.newton_rings(2.0, 500e-9, 1e-6, view, screen=1e-3)
    axis = frame((3.0, 0.0))[2]
    flat, convex = (replace(surface, tilt=(3.0, 0.0)) for surface in bench.surfaces[:2])
    flat = replace(flat, vertex=convex.vertex + 5e-3 * axis)
    turned = replace(bench, surfaces=(flat, convex, *bench.surfaces[2:]))
    assert not np.asarray(nj.render(turned, TINY, nj.Traced())).any()
    assert isinstance(nj.plan(turned, TINY).method, nj.Traced)


def test_at_grazing_incidence_every_ray_is_found():
    """At 89.9 degrees a launch coordinate is 573 times shorter than its way on the face."""
    grazing = nj.newton_rings(10e3, 500e-9, 1e-6, "reflected", light_tilt=(0.0, np.deg2rad(89.9)), screen=1e-3)
    middle = _where_the_axis_lands(grazing)
    points = middle + 1e-3 * np.stack(np.meshgrid([-1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]), axis=-1).reshape(-1, 2)
    fields = jax.jit(fields_at, compiler_options=QUICKLY)(grazing, jnp.asarray(points))
    assert np.asarray(fields.arrives).all()


def _where_the_axis_lands(scene):
    """Where the reflected ray through the launch plane's origin lands on the screen [m]."""
    from newtonjax.rays import gather, trace

    routes, setting = gather(scene)
    first = jax.tree.map(lambda leaf: leaf[0], routes)
    return np.asarray(trace(first, setting, jnp.zeros(2))[0].point)


def test_a_caustic_that_ends_in_the_image_leaves_no_error_to_state():
    """At r/R 0.99 the rays of the direct beam fold on the microscope's image of the gap."""
    radius = 20e-3
    scene = nj.newton_rings(radius, 500e-9, 1e-6, screen="gap", view="transmitted")
    chosen = nj.plan(scene, nj.Camera((33, 33), 0.99 * radius * np.sqrt(2) / 32))
    assert isinstance(chosen.method, nj.Traced)
    assert chosen.intensity_error == np.inf
    assert chosen.reason.code == "CAUSTIC"
    # A shield's edge is no caustic: there the rays' own rounding is all.
    shaded = nj.plan(
        nj.newton_rings(2.0, 500e-9, 1e-6, shield=0.5e-3, view="transmitted", screen=1e-3), nj.Camera((33, 33), 60e-6)
    )
    assert shaded.intensity_error < 1e-6


def test_a_program_in_float32_may_not_trace():
    with jax.enable_x64(False), pytest.raises(RuntimeError, match=r'jax\.config\.update\("jax_enable_x64", True\)'):
        jax.jit(
            lambda gap: nj.render(nj.newton_rings(2.0, gap=gap, view="transmitted", screen=1e-3), TINY, nj.Traced())
        )(1e-6)
