"""The ways to compute an image: how far they agree, what they promise, what they refuse."""

import dataclasses
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from compilations import QUICKLY

import newtonjax as nj
from newtonjax.fields import error_from_nodes, fields_at, intensity, polar, synthesize
from newtonjax.numerics import chebyshev
from newtonjax.scene import middle, node_points

VIEWS = ("transmitted", "reflected")
WAVELENGTH = 500e-9
FIELD = nj.Camera((1024, 1024), 5e-6)
SMALL = (40, 40)


def pixels(camera, count=2000):
    """Indices of the corners, the middle and random pixels, and their points on the screen [m]."""
    rows, columns = camera.shape
    row, column = np.random.default_rng(4).integers(0, [[rows], [columns]], (2, count))
    row[:5], column[:5] = [0, 0, rows - 1, rows - 1, rows // 2], [0, columns - 1, 0, columns - 1, columns // 2]
    x, y = middle(camera.shape)
    return (row, column), np.column_stack([column - x, row - y]) * camera.pixel_size


@partial(jax.jit, compiler_options=QUICKLY)
def traced_polar(scene, points):
    fields = fields_at(scene, points)
    return fields.background, *polar(fields)


@pytest.mark.parametrize("view", VIEWS)
def test_nodes_give_the_phase_of_every_pixel_to_1e_9_turns(view, record_property):
    """5 mm field, R = 2 m, 500 nm: sampled at 2000 of 1024 x 1024 pixels, corners included."""
    scene = nj.newton_rings(2.0, WAVELENGTH, view=view, screen=1e-3)
    at, points = pixels(FIELD)
    both = np.concatenate([node_points(FIELD, 17), points])
    background, (modulus,), (phase,) = traced_polar(scene, both)
    at_nodes = chebyshev.coefficients(jnp.stack([background, modulus, phase])[:, : 17 * 17])
    background, modulus, phase = (field[17 * 17 :] for field in (background, modulus, phase))
    ours = [np.asarray(field)[at] for field in chebyshev.expand(at_nodes, FIELD.shape)]
    error = np.abs(ours[2] - phase).max()
    record_property("turns", float(error))
    assert error < 1e-9
    # Amplitudes below 1, summed over 17 x 17 products that are rounded at 1.1e-16 each.
    assert np.abs(ours[0] - background).max() < 289 * 1.1e-16
    assert np.abs(ours[1] - modulus).max() < 289 * 1.1e-16


def random_benches(view, count=25, seed=7):
    """Benches of radii 20 mm to 20 m with tilts and screens, and cameras that see up to a tenth of the radius."""
    rng = np.random.default_rng(seed)
    scenes, cameras = [], []
    for k in range(count):
        radius = 20e-3 * 1000 ** rng.uniform()
        tilts = {n: tuple(rng.normal(0, 3e-3, 2)) for n in ("lens_tilt", "plate_tilt", "light_tilt")}
        screen = [0.0, 1e-3, 10e-3, 50e-3][k % 4]
        gap = rng.choice([0.0, 1e-6, 20e-6])
        scenes.append(
            nj.newton_rings(radius, WAVELENGTH, gap, view, screen=screen, lens_index=rng.uniform(1.4, 1.8), **tilts)
        )
        half = min(0.1 * radius, 6e-3) * rng.uniform(0.3, 1)
        cameras.append(nj.Camera(SMALL, 2 * half / SMALL[0]))
    return scenes, cameras


def stack(modules):
    return jax.tree.map(lambda *leaves: jnp.stack([jnp.asarray(leaf, dtype=float) for leaf in leaves]), *modules)


@partial(jax.jit, compiler_options=QUICKLY)
def traced(scenes, cameras):
    """Image and phase [turns] at every pixel of every bench."""

    def one(pair):
        scene, camera = pair
        x, y = camera.axes()
        points = jnp.stack(jnp.meshgrid(x, y), axis=-1).reshape(-1, 2)
        fields = fields_at(scene, points)
        return intensity(fields).reshape(camera.shape), fields.phase[0].reshape(camera.shape)

    return jax.lax.map(one, (scenes, cameras))


@partial(eqx.filter_jit, compiler_options=QUICKLY)
def from_nodes(method, scenes, cameras):
    """Image, phase [turns] and promised error of every bench: what the method's verbs give, from one trace."""

    def one(pair):
        fields = method.fields(*pair)
        (phase,) = chebyshev.expand(chebyshev.coefficients(fields.phase), SMALL)
        image = synthesize(method.coefficients(fields), SMALL)
        return image, phase, error_from_nodes(fields, method.nodes)

    return jax.lax.map(one, (scenes, cameras))


@pytest.mark.parametrize("view", VIEWS)
def test_reported_error_bounds_the_real_one_on_random_benches(view):
    scenes, cameras = map(stack, random_benches(view))
    exact, path = traced(scenes, cameras)
    tested = 0
    for count in (5, 9):
        image, phase, promised = from_nodes(nj.Chebyshev(count), scenes, cameras)
        wrong = np.abs(image - exact).max(axis=(1, 2)) / np.abs(exact).max(axis=(1, 2))
        turns = np.abs(phase - path).max(axis=(1, 2))
        finite = np.isfinite(promised.intensity)
        assert (wrong <= promised.intensity)[finite].all()
        assert (turns <= promised.phase)[finite].all()
        tested += (finite & (turns > 1e-9)).sum()
    # A bound of rounding errors alone would show nothing: in many benches so few nodes must leave a real error.
    assert tested >= 15


def test_error_is_infinite_where_a_beam_misses_a_node():
    """Total reflection: a ray that leaves the glass of a strong lens near its edge passes no further."""
    scene = nj.newton_rings(5e-3, WAVELENGTH, lens_index=1.9, screen="gap", view="transmitted")
    wide, narrow = nj.Camera(SMALL, 200e-6), nj.Camera(SMALL, 10e-6)
    estimate = eqx.filter_jit(lambda camera: nj.Chebyshev(5).error(scene, camera), compiler_options=QUICKLY)
    assert np.isinf(estimate(wide).phase)
    assert np.isinf(estimate(wide).intensity)
    assert np.isfinite(estimate(narrow).phase)


@pytest.mark.parametrize(("view", "sign"), [("transmitted", 1), ("reflected", -1)])
def test_closed_form_is_the_two_beam_formula_of_the_exact_sphere(view, sign):
    """I = A² + B² ± 2AB cos(4π n t / λ), A and B by Fresnel at normal incidence; in extended precision."""
    n, liquid, gap, radius = 1.6, 1.33, 0.3e-6, 0.5
    scene = nj.newton_rings(
        radius, WAVELENGTH, gap, view, screen="gap", lens_index=n, plate_index=1.5, gap_index=liquid, ambient_index=1.0
    )
    camera = nj.Camera((7, 9), 100e-6, centre_px=(1.0, 2.5))
    long = np.longdouble
    x, y = (np.arange(9, dtype=long) - 1) * long(100e-6), (np.arange(7, dtype=long)[:, None] - long(2.5)) * long(100e-6)
    r2 = x * x + y * y
    t = long(gap) + r2 / (radius + np.sqrt(long(radius) ** 2 - r2))
    r = [(a - b) / (a + b) for a, b in [(1.0, n), (n, liquid), (liquid, 1.5), (1.5, 1.0)]]
    through = np.sqrt(1 - np.array(r) ** 2)
    if view == "transmitted":
        direct = np.prod(through)
        again = direct * r[2] * -r[1]
    else:
        direct, again = through[0] ** 2 * r[1], through[0] ** 2 * through[1] ** 2 * r[2]
    cosine = np.cos(4 * np.pi * liquid * (t / long(WAVELENGTH)).astype(float))
    image = nj.render(scene, camera, method=nj.ClosedForm())
    # 13 turns of phase, rounded at 1e-15 each in curvature and r².
    np.testing.assert_allclose(image, direct**2 + again**2 + 2 * direct * again * cosine, atol=5e-13)
    np.testing.assert_allclose(nj.opd(scene, camera, method=nj.ClosedForm()), 2 * liquid * t.astype(float), rtol=1e-14)
    assert np.sign(direct * again) == (sign if view == "transmitted" else np.sign(r[1] * r[2]))


def test_rings_seen_in_the_gap_have_the_radii_of_the_textbook():
    """Dark r² = m λ R reflected, r² = (2m - 1) λ R / 2 transmitted: the image there is at its least."""
    for view, dark in (("reflected", 3.0), ("transmitted", 2.5)):
        scene = nj.newton_rings(2.0, WAVELENGTH, view=view, screen="gap")
        size = np.sqrt(dark * WAVELENGTH * 2.0)
        camera = nj.Camera((1, 41), size / 1000, centre_px=(-980.0, 0.0))
        image = np.asarray(nj.render(scene, camera, method=nj.ClosedForm()))[0]
        # t = r²/2R + r⁴/8R³: the sphere moves the ring by r²/8R² of itself, 1e-7, far below a pixel of 1e-3.
        assert abs(int(image.argmin()) - 20) <= 1


def test_closed_form_of_a_wedge_grows_by_twice_the_tangent():
    scene = nj.air_wedge(2e-3, WAVELENGTH, gap=1e-6, screen="gap")
    path = nj.opd(scene, nj.Camera((2, 5), 1e-4), method=nj.ClosedForm())
    np.testing.assert_allclose(path, 2 * (1e-6 + np.tan(2e-3) * 1e-4 * np.arange(-2, 3)) * np.ones((2, 1)), rtol=1e-14)


FOCUSED = nj.newton_rings(1.0, WAVELENGTH, screen="gap", view="transmitted")
REFUSALS = {
    "beams 'T0 T1 T2 T3'": nj.newton_rings(1.0, WAVELENGTH, screen="gap", beams=["T0 T1 T2 T3"], view="transmitted"),
    "beams .*T0 R1 R0 T1": nj.newton_rings(
        1.0, WAVELENGTH, screen="gap", beams=["T0 T1 T2 T3", "T0 R1 R0 T1 R2 R1 T2 T3"], view="transmitted"
    ),
    r"light\.tilt": nj.newton_rings(1.0, WAVELENGTH, screen="gap", light_tilt=(0.0, 1e-3), view="transmitted"),
    r"surfaces\[1\]\.tilt": nj.newton_rings(1.0, WAVELENGTH, screen="gap", lens_tilt=(1e-3, 0.0), view="transmitted"),
    r"screen\.tilt": dataclasses.replace(FOCUSED, screen=dataclasses.replace(FOCUSED.screen, tilt=(1e-3, 0.0))),
    "screen at z = -0.006 m": nj.newton_rings(1.0, WAVELENGTH, view="transmitted", screen=1e-3),
}


@pytest.mark.parametrize("part", REFUSALS)
def test_closed_form_refuses_by_name_what_it_cannot_honour(part):
    with pytest.raises(ValueError, match=f"ClosedForm cannot honour {part}"):
        nj.ClosedForm().check(REFUSALS[part])
    with pytest.raises(ValueError, match=f"ClosedForm cannot honour {part}"):
        nj.render(REFUSALS[part], nj.Camera((4, 4), 1e-5), method=nj.ClosedForm())


@pytest.mark.parametrize("part", REFUSALS)
def test_what_the_closed_form_refuses_the_traced_methods_honour(part):
    nj.Chebyshev().check(REFUSALS[part])
    nj.Traced().check(REFUSALS[part])


@pytest.mark.parametrize("method", [nj.ClosedForm(), nj.Chebyshev(), nj.Traced()])
def test_a_path_difference_of_other_than_two_beams_is_refused(method):
    with pytest.raises(ValueError, match="between two beams; this scene has 1"):
        nj.opd(REFUSALS["beams 'T0 T1 T2 T3'"], nj.Camera((4, 4), 1e-5), method=method)


@pytest.mark.parametrize("count", [1, 130])
def test_a_count_of_nodes_that_no_grid_has_is_refused(count):
    with pytest.raises(ValueError, match=f"nodes is {count}; allowed: a whole number from 2 to 129"):
        nj.Chebyshev(count)


@pytest.mark.parametrize("count", [2, 5, 16])
def test_chebyshev_coefficients_reproduce_polynomials_of_their_degree(count):
    camera = nj.Camera((5, 7), 1e-3, centre_px=(1.0, 8.0))
    degree = count - 1

    def polynomial(points):
        return (1e3 * points[:, 0] - 2) ** degree - (1e2 * points[:, 1]) ** degree + 1

    values = polynomial(np.asarray(node_points(camera, count)))
    (pixel_values,) = chebyshev.expand(chebyshev.coefficients(jnp.asarray(values)[None]), camera.shape)
    x, y = camera.axes()
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    scale = np.abs(values).max()
    np.testing.assert_allclose(pixel_values.ravel(), polynomial(points), atol=1e-13 * scale)
