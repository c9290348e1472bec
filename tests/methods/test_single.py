"""float32 where it is asked for or all there is: at most 2e-5 of the peak away from float64, up to 250 turns."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from compilations import QUICKLY

import newtonjax as nj
from newtonjax.fields import synthesize, synthesize_single
from newtonjax.methods.closed_form_float32 import closed_turns
from newtonjax.numerics import afresh, double

ALLOWED = 2e-5
# A square field's half diagonal in radii, for about 230 turns at most.
BENCHES = {
    "flat": {"radius": 2.0, "reach": 14e-3},
    "strong": {"radius": 0.02, "reach": 1.4e-3},
    "steep": {"radius": 60e-6, "reach": 59.9e-6, "wavelength": 550e-9},
    "concave": {"radius": -3.0, "reach": 18e-3, "gap": 20e-6},
    "tilted plate": {"radius": 1.0, "reach": 5e-3, "plate_tilt": (1e-3, -2e-3)},
    "liquid": {"radius": 0.5, "reach": 6e-3, "gap_index": 1.33, "gap": -1.1e-6},
}


def bench(name, view, **more):
    numbers = {"wavelength": 500e-9, "gap": 1e-6, "screen": "gap", **BENCHES[name], **more}
    reach = numbers.pop("reach")
    camera = nj.Camera((200, 177), reach * 2 / np.hypot(200, 177), centre_px=(80.3, 101.9))
    return nj.newton_rings(view=view, **numbers), camera


def turns_and_image(scene, camera, method):
    path = nj.opd(scene, camera, method)
    return float(np.ptp(np.asarray(path)) / scene.wavelength), np.asarray(nj.render(scene, camera, method))


@pytest.mark.parametrize("name", BENCHES)
@pytest.mark.parametrize("view", ["transmitted", "reflected"])
def test_the_closed_form_in_float32(name, view):
    scene, camera = bench(name, view)
    turns, exact = turns_and_image(scene, camera, nj.ClosedForm())
    assert 20 < turns < 300
    copies = afresh(scene, camera)
    with jax.enable_x64(False):
        image = jax.jit(lambda: nj.ClosedForm().image(*copies))()
    assert image.dtype == jnp.float32
    assert np.abs(np.asarray(image, float) - exact).max() <= 2e-6 * exact.max()


def test_what_a_user_passes_into_a_float32_program_is_taken_as_it_was_rounded():
    _, camera = bench("strong", "reflected")
    given = [float(np.float32(value)) for value in (0.02, 500e-9, 1e-6, camera.pixel_size)]

    def image(radius, wavelength, gap, pixel_size):
        scene = nj.newton_rings(radius, wavelength, gap, "reflected", screen="gap")
        return nj.render(scene, nj.Camera((200, 177), pixel_size), nj.ClosedForm())

    with jax.enable_x64(False):
        single = np.asarray(jax.jit(image)(*given), float)
    exact = np.asarray(image(*given))
    assert np.abs(single - exact).max() <= ALLOWED * exact.max()


@pytest.mark.parametrize("name", ["radius", "wavelength", "gap", "pixel_size", "plate_tilt"])
def test_gradients_of_the_closed_form_in_float32(name):
    value = {"radius": 2.0, "wavelength": 500e-9, "gap": 1e-6, "pixel_size": 20e-6, "plate_tilt": 1e-4}[name]

    def loss(number):
        numbers = {"radius": 2.0, "wavelength": 500e-9, "gap": 1e-6, "pixel_size": 20e-6, name: number}
        camera = nj.Camera((60, 50), numbers.pop("pixel_size"))
        if name == "plate_tilt":
            numbers["plate_tilt"] = (number, 0.0 * number)
        image = nj.render(nj.newton_rings(**numbers, view="transmitted", screen="gap"), camera, nj.ClosedForm())
        return (image * jnp.cos(jnp.arange(3000, dtype=image.dtype)).reshape(60, 50)).sum()

    exact = float(jax.grad(loss)(value))
    with jax.enable_x64(False):
        single = float(jax.jit(jax.grad(loss))(value))
        batch = jax.jit(jax.vmap(loss))(jnp.array([value, value], jnp.float32))
    assert single == pytest.approx(exact, rel=2e-3)
    np.testing.assert_allclose(np.asarray(batch), float(loss(float(np.float32(value)))), rtol=1e-3, atol=1e-3)


def test_the_phase_of_a_closed_form_keeps_its_bits_under_jit():
    """A compiler that reassociates sums or contracts products would leave 4e-6 turns or more of this."""
    scene, camera = bench("strong", "transmitted")
    exact = np.asarray(nj.opd(scene, camera, nj.ClosedForm())) / scene.wavelength
    copies = afresh(scene, camera)
    with jax.enable_x64(False):
        wrong = np.asarray(jax.jit(lambda: closed_turns(*copies))(), float) - exact
    assert np.abs(wrong - np.round(wrong)).max() < 1e-7


def test_double_floats_against_float64():
    random = np.random.default_rng(7)
    a, b = random.uniform(-3, 3, 5000), random.uniform(0.1, 3, 5000)
    with jax.enable_x64(False):
        pairs = double(a), double(b)
        found = jax.jit(lambda a, b: (a + b, a - b, a * b, a / b))(*pairs)
        a, b = ((np.asarray(d.high, float) + np.asarray(d.low, float)) for d in pairs)
        for made, exact in zip(found, (a + b, a - b, a * b, a / b), strict=True):
            value = np.asarray(made.high, float) + np.asarray(made.low, float)
            np.testing.assert_allclose(value, exact, rtol=2**-33, atol=2**-33)


@pytest.mark.parametrize("view", ["transmitted", "reflected"])
@pytest.mark.parametrize("name", [name for name in BENCHES if name != "steep"])  # nodes do not resolve a hemisphere
def test_pixels_in_float32_from_nodes(name, view):
    scene, camera = bench(name, view, screen=5e-3, light_tilt=(1e-3, 0.0))
    if name == "strong":  # behind it a bare screen has five times the fringes
        camera = nj.Camera(camera.shape, camera.pixel_size / 2.5)
    method = nj.Chebyshev(11)
    coefficients = np.asarray(method.coefficients(_fields(scene, camera)))
    for shape in ((1, 1), (2, 300), (7, 31), (513, 200)):
        for count in (2, 7, 11):
            exact = _synthesize(coefficients[:, :count, :count], shape)
            single = _synthesize_single(coefficients[:, :count, :count], shape)
            assert single.dtype == jnp.float32
            assert single.shape == shape
            assert np.abs(np.asarray(single, float) - exact).max() <= ALLOWED * exact.max()


# Of all benches, with a program for each shape and number of nodes.
_fields = jax.jit(nj.Chebyshev(11).fields, compiler_options=QUICKLY)
_synthesize, _synthesize_single = (jax.jit(f, static_argnums=1) for f in (synthesize, synthesize_single))


def test_derivatives_of_float32_pixels_are_those_of_float64():
    coefficients = jnp.asarray(np.random.default_rng(3).normal(size=(3, 5, 5)))
    made = [lambda c, f=f: f(c, (24, 32)) for f in (synthesize_single, synthesize)]
    one, other = (jax.jvp(f, (coefficients,), (jnp.cos(coefficients),))[1] for f in made)
    np.testing.assert_allclose(one, other, rtol=1e-6, atol=1e-6 * float(jnp.abs(other).max()))
    one, other = (jax.grad(lambda c, f=f: f(c)[5, 7])(coefficients) for f in made)
    np.testing.assert_allclose(one, other, rtol=1e-6, atol=1e-6 * float(jnp.abs(other).max()))


def test_a_method_in_float32_gives_float32():
    scene, camera = nj.newton_rings(2.0, 500e-9, 1e-6, view="transmitted", screen=1e-3), nj.Camera((24, 32), 60e-6)
    single = nj.render(scene, camera, nj.Chebyshev(5, "float32"))
    assert single.dtype == jnp.float32
    np.testing.assert_allclose(single, nj.render(scene, camera, nj.Chebyshev(5)), atol=1e-6)


def test_a_camera_that_a_float32_program_used_still_serves_in_float64():
    """JAX would hand the float32 array that it made of the camera's numbers to the float64 program, which fails."""
    scene, camera = bench("flat", "reflected")
    with jax.enable_x64(False):
        jax.jit(
            lambda gap: nj.render(
                nj.newton_rings(2.0, gap=gap, screen="gap", view="transmitted"), camera, nj.ClosedForm()
            )
        )(1e-6)
        assert nj.render(scene, camera).dtype == jnp.float32
    assert nj.render(scene, camera).dtype == jnp.float64


def test_a_scene_that_a_program_only_holds_becomes_a_constant_image():
    scene, camera = bench("flat", "reflected")
    exact = nj.render(scene, camera)
    image = jax.jit(lambda scale: scale * nj.render(scene, camera))(2.0)
    np.testing.assert_allclose(image, 2 * exact, rtol=1e-14)
    with jax.enable_x64(False):
        image = jax.jit(lambda scale: scale * nj.render(scene, camera, nj.Traced()))(2.0)
    np.testing.assert_allclose(image, 2 * exact, atol=2e-3)


def test_an_unknown_type_is_refused():
    with pytest.raises(ValueError, match="allowed: 'float32', 'float64'"):
        nj.Chebyshev(9, "float16")
