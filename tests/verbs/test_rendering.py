"""The public verbs."""

import json
import subprocess
import sys
import textwrap

import jax
import numpy as np
import pytest

import newtonjax as nj

WAVELENGTH = 500e-9
CAMERA = nj.Camera((12, 16), 60e-6)


def rings(radius=2.0, **more):
    return nj.newton_rings(radius, WAVELENGTH, 1e-6, **{"view": "transmitted", "screen": 1e-3, **more})


WITHOUT_X64 = """
    import json, jax, numpy as np, newtonjax as nj
    scene, camera = nj.newton_rings(2.0, 500e-9, 1e-6, "transmitted", screen=1e-3), nj.Camera((12, 16), 60e-6)
    eager = nj.render(scene, camera, method=nj.Traced())
    focused = nj.newton_rings(2.0, 500e-9, 1e-6, "transmitted", screen="gap")
    bench = lambda gap: nj.newton_rings(2.0, 500e-9, gap, "transmitted", screen="gap")
    closed = jax.jit(lambda gap: nj.render(bench(gap), camera, nj.ClosedForm()))
    closed = closed(1e-6)
    refusals = {}
    for name, method in (("Chebyshev", None), ("Traced", nj.Traced())):
        try:
            jax.jit(lambda gap: nj.render(bench(gap), camera, method))(1e-6)
        except RuntimeError as error:
            refusals[name] = str(error)
    print(json.dumps({
        "dtypes": [str(eager.dtype), str(closed.dtype)],
        "eager": np.asarray(eager, float).tolist(), "closed": np.asarray(closed, float).tolist(),
        "refusals": refusals, "x64": jax.config.jax_enable_x64,
    }))
"""


@pytest.fixture(scope="module")
def without_x64():
    """What a program sees that never touches JAX's configuration; its warnings are errors too."""
    program = [sys.executable, "-W", "error", "-c", textwrap.dedent(WITHOUT_X64)]
    return json.loads(subprocess.run(program, check=True, capture_output=True, text=True).stdout)


def test_eager_calls_compute_in_float64_and_return_float32_where_x64_is_off(without_x64):
    assert without_x64["dtypes"] == ["float32"] * 2
    assert without_x64["x64"] is False
    exact = np.asarray(nj.render(rings(), CAMERA, method=nj.Traced()))
    # Half a spacing of float32 below 1.
    assert np.abs(np.array(without_x64["eager"]) - exact).max() <= 2**-25


def test_the_closed_form_works_under_jit_in_float32(without_x64):
    exact = np.asarray(nj.render(rings(screen="gap"), CAMERA, method=nj.ClosedForm()))
    # A phase of 5 turns in float32 errs by some roundings of 3e-7 turns; the fringes' slope is 2π times 0.07.
    assert np.abs(np.array(without_x64["closed"]) - exact).max() < 2e-6


def test_tracing_in_float32_under_jit_is_refused_with_the_line_to_add(without_x64):
    assert set(without_x64["refusals"]) == {"Chebyshev", "Traced"}
    for name, message in without_x64["refusals"].items():
        assert message.startswith(f"{name} needs float64")
        assert 'jax.config.update("jax_enable_x64", True)' in message


def test_rendering_vmaps_and_uses_chebyshev_as_it_stands_where_no_method_is_given():
    radii = np.array([0.5, 2.0, -3.0])
    batch = jax.jit(jax.vmap(lambda radius: nj.render(rings(radius), CAMERA)))(radii)
    for one, radius in zip(batch, radii, strict=True):
        # The same sums in another order: paths of 16 mm are rounded at 1e-11 turns.
        np.testing.assert_allclose(one, nj.render(rings(radius), CAMERA, method=nj.Chebyshev()), atol=1e-10)


def test_inside_a_transformation_a_method_still_refuses_what_it_can_see():
    one_beam = jax.jit(lambda r: nj.render(rings(r, beams=["T0 T1 T2 T3"]), CAMERA, method=nj.ClosedForm()))
    with pytest.raises(ValueError, match="ClosedForm cannot honour beams"):
        one_beam(2.0)


def test_chunks_leave_no_seams():
    whole = nj.render(rings(), CAMERA, method=nj.Traced())
    pieces = nj.render(rings(), CAMERA, method=nj.Traced(chunk=7))
    np.testing.assert_allclose(pieces, whole, atol=1e-10)


def test_unpolarized_light_is_the_mean_of_two_polarizations():
    tilted = {"light_tilt": (0.2, 0.1)}
    both = (rings(polarization=angle, **tilted) for angle in (0.4, 0.4 + np.pi / 2))
    one, other = (nj.render(scene, CAMERA, method=nj.Chebyshev()) for scene in both)
    assert np.abs(one - other).max() > 1e-3
    unpolarized = nj.render(rings(**tilted), CAMERA, method=nj.Chebyshev())
    np.testing.assert_allclose(unpolarized, (one + other) / 2, atol=1e-10)


def test_rays_that_miss_leave_darkness_and_no_nan():
    """A strong lens reflects totally at its convex face beyond the radius R sin(critical angle) = R / n."""
    radius, n, pixel = 5e-3, 1.9, 0.2e-3
    scene = nj.newton_rings(
        radius,
        WAVELENGTH,
        1e-6,
        lens_index=n,
        screen=0.0,
        plate_thickness=1e-6,
        beams=["T0 T1 T2 T3"],
        view="transmitted",
    )
    image = np.asarray(nj.render(scene, nj.Camera((1, 81), pixel), method=nj.Traced()))[0]
    assert np.isfinite(image).all()
    x = np.abs(np.arange(81) - 40) * pixel
    # Rays bend outwards or inwards before they land; launched within R / n = 2.6 mm, they land within 5 mm.
    assert (image[x < 0.5e-3] > 0.5).all()
    assert (image[x > 7e-3] == 0).all()


def test_a_single_beam_has_the_irradiance_of_fresnel_and_the_lens_formula_on_the_axis():
    scene = rings(beams=["T0 T1 T2 T3"])
    image = np.asarray(nj.render(scene, nj.Camera((1, 81), 1e-6), method=nj.Traced()))[0, 40]
    # On the axis: four faces at normal incidence, and a lens of f = R / (n - 1) = 4 m that concentrates the light by
    # (1 - d / f)^-2 after 5 mm / 1.5 in the plate, 1 mm of air and a gap of 1 um.
    d = 5e-3 / 1.5 + 1e-3 + 1e-6
    np.testing.assert_allclose(image, 0.96**4 / (1 - d / 4.0) ** 2, rtol=1e-12)


def test_nodes_refuse_a_lens_that_ends_inside_the_image():
    """R = 1 mm seen over 2.6 mm: no ray of the direct beam lands near the rim."""
    scene, camera = nj.newton_rings(1e-3, 500e-9, screen=1e-4, view="transmitted"), nj.Camera((64, 64), 40e-6)
    for verb in (nj.render, nj.opd):
        with pytest.raises(ValueError, match="does not reach the whole image"):
            verb(scene, camera, nj.Chebyshev())
    assert isinstance(nj.plan(scene, camera).method, nj.Traced)
