"""Images in light of many wavelengths against sums over them, and colours against the XYZ of a film."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from compilations import QUICKLY
from skimage.color import deltaE_ciede2000, xyz2lab, xyz2rgb
from tmm import coh_tmm

import newtonjax as nj

CAMERA = nj.Camera((9, 12), 30e-6)
DOUBLET = nj.Spectrum((588.9950e-9, 589.5924e-9), (1.0, 1.0))
# Where half a wavelength of the mean lies between the lines' orders: λ² / 2 Δλ / λ.
NULL = 588.9950 * 589.5924 / (589.5924 - 588.9950) / 2 / 589.2937


def brute_force(scene, camera, spectrum):
    """The sum of the images of single lines."""
    line = nj.Chebyshev(9)
    images = [
        share * np.asarray(nj.render(eqx.tree_at(lambda s: s.light.wavelength, scene, float(at)), camera, line))
        for at, share in zip(spectrum.wavelengths, spectrum.shares, strict=True)
    ]
    return np.sum(images, axis=0)


def contrast(spectrum, order):
    """Of the fringes of a thin wedge at an order of the mean wavelength."""
    gap = order * float(spectrum.wavelength) / 2
    image = np.asarray(nj.render(nj.air_wedge(5e-4, light=spectrum, gap=gap), nj.Camera((1, 400), 3e-6)))
    return np.ptp(image) / (image.max() + image.min())


def test_equal_lines_of_sodium_lose_their_fringes_near_order_494_and_have_them_back_at_987():
    assert pytest.approx(493.3, abs=0.5) == NULL
    assert contrast(DOUBLET, 0) > 0.99
    assert contrast(DOUBLET, NULL) < 0.01
    assert contrast(DOUBLET, 2 * NULL) == pytest.approx(contrast(DOUBLET, 0), rel=2e-3)


def test_lines_of_two_to_one_keep_a_third_of_their_visibility():
    two_to_one = nj.Spectrum(DOUBLET.wavelengths, (2.0, 1.0))
    assert contrast(two_to_one, NULL) == pytest.approx(1 / 3, rel=2e-3)


@pytest.mark.parametrize("words", ["sodium", "mercury"])
@pytest.mark.parametrize("place", [{"gap": 1e-7}, {"gap": 3e-6, "screen": 0.02, "light_tilt": (0.02, 0.0)}])
def test_an_image_is_the_sum_of_those_of_its_lines(words, place):
    scene = nj.newton_rings(0.2, light=words, **place)
    expected = brute_force(nj.newton_rings(0.2, **place), CAMERA, scene.light.spectrum)
    for tolerance in (1e-2, 1e-4):
        error = np.abs(np.asarray(nj.render(scene, CAMERA, tolerance=tolerance)) - expected).max()
        assert error <= tolerance * expected.max()
    traced = np.asarray(nj.render(scene, CAMERA, nj.Traced()))
    assert np.abs(traced - expected).max() < 1e-6 * expected.max()  # of the nodes of the single lines


def test_a_white_picture_is_the_sum_over_81_wavelengths():
    samples = nj.illuminant("E")
    lines = nj.Spectrum(samples.wavelengths, samples.weights)  # without what fills the steps between them
    scene = nj.newton_rings(0.2, light=lines, gap=5e-8)
    (x, y), index = CAMERA.axes(), 1.5
    gap = 5e-8 + 0.2 - np.sqrt(0.04 - x**2 - y[:, None] ** 2)
    r, t = (index - 1) / (index + 1), 1 - ((index - 1) / (index + 1)) ** 2
    phases = 4 * np.pi * gap[..., None] / lines.wavelengths
    fields = t**2 * r**2 * (1 + t**2 - 2 * t * np.cos(phases))  # through the lens's flat face twice
    expected = fields @ lines.shares
    method = nj.ClosedForm(table_error=1e-6)
    error = np.abs(np.asarray(nj.render(scene, CAMERA, method)) - expected).max()
    assert error <= 1e-6 * expected.max()


def test_a_table_over_the_carrier_serves_high_orders():
    narrow = nj.spectral_line(589e-9, 0.05e-9)
    scene = nj.air_wedge(2e-3, light=narrow, gap=300e-6)
    camera = nj.Camera((1, 300), 3e-4)  # 300 orders, of which hardly any fade
    x, _ = camera.axes()
    path = 2 * (300e-6 + np.tan(2e-3) * x)
    expected = narrow.coherence(path).real * np.cos(2 * np.pi * path / 589e-9)
    image = np.asarray(nj.render(scene, camera, nj.ClosedForm(table_error=1e-5)))[0]
    image = image / 0.96**2 - 0.04 * (1 + 0.96**2)  # two beams of glass of index 1.5, through its flat face twice
    np.testing.assert_allclose(image, -2 * 0.04 * 0.96 * expected, atol=1e-5 * 0.08)


def test_no_program_is_compiled_for_another_lamp(monkeypatch):
    camera = nj.Camera((16, 16), 30e-6)
    nj.render(nj.newton_rings(0.2, light="mercury"), camera)
    events = []
    jax.monitoring.register_event_duration_secs_listener(lambda name, *_, **__: events.append(name))
    for words in ("krypton", "mercury:546nm/10nm", "white:5500K", "white:D65"):
        nj.render(nj.newton_rings(0.21, light=words), camera)
    assert not [name for name in events if "backend_compile" in name]


# Numbers of a light, of a bench, and the awkward ones: no width, and two lines at one place.
NUMBERS = {
    "radius": 0.2, "gap": 1e-7, "first": 540e-9, "second": 555e-9, "weight": 0.4, "gaussian": 1e-9, "lorentzian": 1e-9,
}  # fmt: skip
PLACES = {
    "general": {},
    "no width": {"gaussian": 0.0, "lorentzian": 0.0},
    "equal lines": {"second": 540e-9, "gap": 0.0},
}


@pytest.mark.parametrize("method", [nj.ClosedForm(), nj.Chebyshev(5)], ids=lambda m: type(m).__name__)
def test_derivatives_of_all_numbers_are_those_of_differences(method):
    def image(numbers):
        spectrum = nj.Spectrum(
            jnp.stack([numbers["first"], numbers["second"]]),
            jnp.stack([numbers["weight"], 1.0 - numbers["weight"]]),
            jnp.stack([numbers["gaussian"], 0.0 * numbers["gaussian"]]),
            jnp.stack([numbers["lorentzian"], 0.0 * numbers["lorentzian"]]),
        )
        return nj.render(nj.newton_rings(numbers["radius"], light=spectrum, gap=numbers["gap"]), CAMERA, method)

    of_image = jax.jit(image, compiler_options=QUICKLY)
    forward = jax.jit(jax.jacfwd(image), compiler_options=QUICKLY)
    weights = np.random.default_rng(0).normal(size=CAMERA.shape)
    reverse = jax.jit(jax.grad(lambda numbers: (image(numbers) * weights).sum()), compiler_options=QUICKLY)
    for place in PLACES.values():
        values = {name: jnp.asarray(value) for name, value in (NUMBERS | place).items()}
        slopes, gradient = forward(values), reverse(values)
        for name, value in values.items():
            step = 1e-12 if name in ("gaussian", "lorentzian") else max(2e-5 * float(value), 1e-11)
            low, high = ({**values, name: value + sign * step} for sign in (-1, 1))
            expected = (of_image(high) - of_image(low)) / (2 * step)
            scale = np.abs(expected).max() + 1e-9 * np.abs(of_image(values)).max() / step
            np.testing.assert_allclose(slopes[name], expected, atol=2e-5 * scale, err_msg=name)
            assert gradient[name] == pytest.approx((expected * weights).sum(), abs=2e-4 * scale * 10)


def test_colours_of_rings_are_those_of_a_film_of_their_thickness():
    camera = nj.Camera((1, 200), 8.5e-6, response=nj.cie_1931())
    light = nj.illuminant("D65")
    # The third beam has 1/600 of the power; without it colours are up to dE 2.1 off, on the flanks of the first orders.
    scene = nj.newton_rings(0.2, light=light, beams=("R1", "R2", "R2-R1-R2"))
    image = np.asarray(nj.render(scene, camera))[0] / 0.96**2  # through the lens's flat face twice
    x, _ = camera.axes()
    thickness = 0.2 - np.sqrt(0.04 - x**2)
    assert thickness.max() > 1.7e-6  # six orders
    # Of a film of air between two glasses, all reflections in it (tmm; Byrnes 2016), with the CIE's curves at 5 nm.
    curves, powers = nj.cie_1931().curves, light.weights
    reflected = np.array(
        [
            [coh_tmm("s", [1.5, 1.0, 1.5], [np.inf, d * 1e9, np.inf], 0.0, at)["R"] for at in light.wavelengths * 1e9]
            for d in thickness[100::6]
        ]
    )
    expected = (reflected * powers) @ curves.T / (powers @ curves[1])
    # As an eye adapted to the brightest ring sees both.
    white = expected[:, 1].max()
    difference = deltaE_ciede2000(xyz2lab(expected / white), xyz2lab(image[100::6] / white))
    assert difference.max() <= 1.0


def test_srgb_is_that_of_the_standard():
    xyz = np.random.default_rng(1).uniform(0.0, 1.0, size=(50, 3))
    np.testing.assert_allclose(nj.to_srgb(xyz), xyz2rgb(xyz), atol=2e-3)  # of matrices of four and of six digits
    white = np.array([1.0985, 1.0, 0.35585])
    np.testing.assert_allclose(nj.to_srgb(white, white), 1.0, atol=1e-3)


def test_every_method_gives_the_same_colours():
    camera = nj.Camera((3, 5), 60e-6, response=nj.cie_1931())
    scene = nj.newton_rings(0.2, light="white:5500K")
    images = [np.asarray(nj.render(scene, camera, m)) for m in (None, nj.ClosedForm(), nj.Chebyshev(9), nj.Traced())]
    for image in images:
        assert image.shape == (3, 5, 3)
        np.testing.assert_allclose(image, images[-1], atol=1e-3 * images[-1].max())
    in_jit = jax.jit(lambda radius: nj.render(nj.newton_rings(radius, light="white:5500K"), camera, nj.ClosedForm()))
    np.testing.assert_allclose(in_jit(0.2), images[1], atol=1e-5)
    assert [rows.shape for _, rows in nj.blocks(scene, camera, rows=2)] == [(2, 5, 3), (1, 5, 3)]
