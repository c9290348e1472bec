"""Means over pixels and blurs against what they stand for: many points a pixel, and a convolution."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from compilations import QUICKLY
from scipy.ndimage import gaussian_filter

import newtonjax as nj

CAMERA = nj.Camera((24, 30), 24e-6)
BY_RAYS, BY_FORMULA = nj.Chebyshev(17, table_error=1e-7), nj.ClosedForm(1e-7)


def supersampled(scene, camera, side, blur=0.0, method=BY_RAYS):
    """Means over side x side points a pixel, of a picture that is blurred before on a frame wider by some pixels."""
    points, margin = blurred_points(scene, camera, side, blur, method)
    rows, columns = camera.shape
    means = points.reshape(rows + 2 * margin, side, columns + 2 * margin, side).mean(axis=(1, 3))
    return means[margin : margin + rows, margin : margin + columns]


def convolved(scene, camera, side, blur):
    """The middle of each pixel of that picture, of an odd number of points."""
    points, margin = blurred_points(scene, camera, side, blur, BY_FORMULA)
    middles = points[side // 2 :: side, side // 2 :: side]
    return middles[margin : margin + camera.shape[0], margin : margin + camera.shape[1]]


def blurred_points(scene, camera, side, blur, method):
    rows, columns = camera.shape
    margin = int(np.ceil(6 * blur))
    middle = ((columns - 1) / 2, (rows - 1) / 2) if camera.centre_px is None else camera.centre_px
    wide = nj.Camera(
        ((rows + 2 * margin) * side, (columns + 2 * margin) * side),
        camera.pixel_size / side,
        tuple((at + margin + 0.5) * side - 0.5 for at in middle),
    )
    points = np.asarray(nj.render(scene, wide, method))
    return (gaussian_filter(points, blur * side, truncate=6.0) if blur else points), margin


@pytest.mark.parametrize("light", ["589.3nm", "white:5500K"])
def test_a_mean_over_pixels_is_that_of_32_by_32_points(light):
    scene = nj.newton_rings(0.2, light=light, gap=3e-7)
    expected = supersampled(scene, CAMERA, 32)
    whole_pixels = replace(CAMERA, aperture=1.0)
    image = np.asarray(nj.render(scene, whole_pixels, tolerance=5e-5))
    assert np.abs(image - expected).max() <= 1e-4 * expected.max()
    point = np.asarray(nj.render(scene, CAMERA))
    assert np.abs(point - expected).max() > 3e-3 * expected.max()  # the mean is no small thing


@pytest.mark.parametrize("blur", [0.3, 0.8])
def test_a_blur_is_a_convolution(blur):
    # A part of a picture 100 pixels beside the centre, whose fringes are 4.3 to 3.5 pixels wide: half of Nyquist's.
    scene = nj.newton_rings(0.2, light="589.3nm", gap=3e-7)
    camera = nj.Camera((24, 30), 11e-6, centre_px=(-75.0, -70.0))
    expected = supersampled(scene, camera, 16, blur)
    image = np.asarray(nj.render(scene, replace(camera, aperture=1.0, blur=blur), tolerance=1e-4))
    assert np.abs(image - expected).max() <= 1e-3 * expected.max()


@pytest.mark.parametrize(("aperture", "blur"), [(1.0, 0.5), (0.0, 0.0)])
def test_derivatives_in_aperture_and_blur_are_those_of_differences(aperture, blur):
    def image(numbers):
        camera = replace(CAMERA, aperture=numbers["aperture"], blur=numbers["blur"])
        return nj.render(nj.newton_rings(numbers["radius"], gap=3e-7), camera, nj.Chebyshev(9))

    values = {"radius": jnp.asarray(0.2), "aperture": jnp.asarray(aperture), "blur": jnp.asarray(blur)}
    of_image = jax.jit(image, compiler_options=QUICKLY)
    slopes = jax.jit(jax.jacfwd(image), compiler_options=QUICKLY)(values)
    for name, value in values.items():
        step = 1e-6 if name == "radius" else 1e-4
        # Means are even in the side and in the blur, which begin at 0.
        low = {**values, name: jnp.abs(value - step)}
        expected = (of_image({**values, name: value + step}) - of_image(low)) / (2 * step)
        scale = jnp.abs(expected).max() + 1e-8 * of_image(values).max() / step
        np.testing.assert_allclose(slopes[name], expected, atol=1e-4 * scale, err_msg=name)


@pytest.mark.parametrize("options", [{"light": "sodium"}, {"light": "white:5500K"}, {"plate_coating": "mirror:30%"}])
@pytest.mark.parametrize(("aperture", "blur", "tolerance"), [(1.0, None, 1e-4), (None, 1.0, 1e-3), (1.0, 0.5, 1e-3)])
def test_tables_of_the_gap_hold_the_means_over_pixels(options, aperture, blur, tolerance):
    # Fringes 15 to 8 pixels wide; 3 of the finest harmonics that count.
    scene, camera = nj.newton_rings(0.2, gap=3e-7, **options), nj.Camera((24, 30), 10e-6, centre_px=(-40.0, -30.0))
    side = 33 if blur is None else 15
    expected = supersampled(scene, camera, side, blur or 0.0, BY_FORMULA)
    if aperture is None:
        expected = convolved(scene, camera, side, blur)
    means = replace(camera, aperture=aperture, blur=blur)
    image = np.asarray(nj.render(scene, means, BY_FORMULA))
    assert np.abs(image - expected).max() <= tolerance * expected.max()
    stated = BY_FORMULA.error(scene, means).intensity
    assert np.abs(image - expected).max() <= stated * expected.max()


@pytest.mark.parametrize(("aperture", "blur"), [(1.0, None), (1.0, 1.0)])
@pytest.mark.parametrize("options", [{"angular_radius": 0.01}, {"screen": 2e-3}, {"light": "mercury"}])
def test_what_a_plan_states_bounds_what_means_and_sources_err_by(options, aperture, blur):
    # 1.4 mm beside the centre of a steep lens: fringes 14 pixels wide, of which rays know more than the gap does.
    scene = nj.newton_rings(0.1545, **({"light": "sodium"} | options))
    camera = nj.Camera((16, 20), 4e-6, centre_px=(-300.0, -180.0))
    reference = nj.Chebyshev(9, table_error=1e-7)
    if "angular_radius" in options:
        reference = nj.OverSource(reference, 2)
    expected = supersampled(scene, camera, 15, blur or 0.0, reference)
    means = replace(camera, aperture=aperture, blur=blur)
    plan = nj.plan(scene, means)
    assert isinstance(plan.method, nj.Chebyshev)
    error = np.abs(np.asarray(nj.render(scene, means)) - expected).max() / expected.max()
    assert error <= min(plan.intensity_error, 1e-3)
    assert np.abs(np.asarray(nj.render(scene, camera)) - expected).max() > 3e-3 * expected.max()


@pytest.mark.parametrize("light", ["546nm/10nm", "546nm/10nm/lorentzian"])
def test_a_blur_takes_more_of_the_shorter_waves_of_a_line(light):
    if light.endswith("lorentzian"):
        light = nj.spectral_line(546e-9, 10e-9, "lorentzian")
    scene = nj.newton_rings(0.2, light=light, gap=6e-6)
    camera = nj.Camera((12, 14), 14e-6, centre_px=(-45.0, -30.0))  # fringes 9 pixels wide, of order 26
    expected = convolved(scene, camera, 15, 1.0)
    image = np.asarray(nj.render(scene, replace(camera, blur=1.0), BY_FORMULA))
    # Of one wave for the whole line, the picture is 2.5e-3 and 1.2e-3 off.
    assert np.abs(image - expected).max() <= 1e-4 * expected.max()


def test_a_blurred_parabola_is_exact_however_strong_the_blur():
    # The faces' parabola bends by 0.04 turns per pixel²; sums over its exact phase with the weights of the blur.
    wavelength, pixel, blur, radius = 500e-9, 40e-6, 2.0, 0.16
    scene = nj.newton_rings(radius, wavelength)
    camera = nj.Camera((9, 9), pixel, blur=blur)
    (x, y), offset = camera.axes(), np.linspace(-7, 7, 281) * blur * pixel
    weight = np.exp(-((offset / (blur * pixel)) ** 2) / 2)
    along = [np.exp(2j * np.pi / (radius * wavelength) * (at[:, None] + offset) ** 2) @ weight for at in (x, y)]
    waves = (along[1][:, None] * along[0]).real / weight.sum() ** 2
    r, t = 0.2, 1 - 0.2**2
    expected = t**2 * r**2 * (1 + t**2 - 2 * t * waves)
    image = np.asarray(nj.render(scene, camera, nj.ClosedForm(1e-8)))
    assert np.abs(image - expected).max() <= 1e-5 * expected.max()


@pytest.mark.parametrize(("aperture", "blur"), [(None, 1.0), (None, 2.0), (1.0, None), (1.0, 1.0)])
def test_what_is_stated_of_means_over_bent_fringes_is_what_they_err_by(aperture, blur):
    # Bent by 0.04 turns per pixel²: a blur is exact, the square of a pixel 3e-3 off, to first order in the bend.
    scene, points = nj.newton_rings(0.16, 500e-9), nj.Camera((17, 17), 40e-6)
    camera = replace(points, aperture=aperture, blur=blur)
    expected = supersampled(scene, points, 33 if blur is None else 15, blur or 0.0, BY_FORMULA)
    if aperture is None:
        expected = convolved(scene, points, 15, blur)
    error = np.abs(np.asarray(nj.render(scene, camera, BY_FORMULA)) - expected).max() / expected.max()
    stated = BY_FORMULA.error(scene, camera).intensity - BY_FORMULA.error(scene, points).intensity
    assert error <= stated + 2e-6
    assert stated <= 2 * error + 1e-5
    if aperture is None:
        assert isinstance(nj.plan(scene, camera).method, nj.ClosedForm)


@pytest.mark.parametrize("light", ["589nm", "mercury", "white:5500K"])
def test_derivatives_of_the_tables_are_those_of_differences_also_at_0(light):
    def image(numbers):
        camera = replace(CAMERA, aperture=numbers["aperture"], blur=numbers["blur"], pixel_size=10e-6)
        scene = nj.newton_rings(
            numbers["radius"], light=light, gap=numbers["gap"], numerical_aperture=numbers.get("numerical_aperture")
        )
        return nj.render(scene, camera, nj.ClosedForm())

    of_image, forward = (jax.jit(f, compiler_options=QUICKLY) for f in (image, jax.jacfwd(image)))
    general = {"radius": 0.2, "gap": 3e-7, "aperture": 1.0, "blur": 0.5}
    flat = {"radius": 0.2, "gap": 0.0, "aperture": 0.0, "blur": 0.0}
    places = [general, flat]
    if light == "mercury":
        places = [general | {"numerical_aperture": 0.1}, flat | {"numerical_aperture": 0.0}]
    for place in places:
        values = {name: jnp.asarray(value) for name, value in place.items()}
        slopes = forward(values)
        for name, value in values.items():
            step = {"radius": 1e-6, "gap": 1e-12}.get(name, 1e-4)
            low, high = value - step, value + step
            low = low if name in ("radius", "gap") else jnp.abs(low)  # images are even in the others
            expected = (of_image({**values, name: high}) - of_image({**values, name: low})) / (2 * step)
            scale = jnp.abs(expected).max() + 1e-8 * of_image(values).max() / step
            np.testing.assert_allclose(slopes[name], expected, atol=1e-4 * scale, err_msg=name)


def test_the_gradient_of_a_sum_over_blurred_white_pixels_is_that_of_differences():
    weights = np.random.default_rng(5).normal(size=(*CAMERA.shape, 3))

    def total(numbers):
        camera = replace(CAMERA, blur=numbers["blur"], pixel_size=10e-6, response=nj.cie_1931())
        scene = nj.newton_rings(numbers["radius"], light="white:5500K", gap=numbers["gap"])
        scene = replace(scene, light=replace(scene.light, wavelength=numbers["wavelength"]))
        return (nj.render(scene, camera, nj.ClosedForm()) * weights).sum()

    values = {"radius": 0.2, "gap": 3e-7, "wavelength": 550e-9, "blur": 0.8}
    of_sum = jax.jit(total, compiler_options=QUICKLY)
    gradient = jax.jit(jax.grad(total), compiler_options=QUICKLY)(values)
    for name, value in values.items():
        step = {"radius": 1e-6, "blur": 1e-4}.get(name, 1e-12)
        difference = of_sum({**values, name: value + step}) - of_sum({**values, name: value - step})
        expected = difference / (2 * step)
        # Of tables that err by 1e-4 of the fringes where their range is not known.
        assert float(gradient[name]) == pytest.approx(float(expected), rel=1e-4), name


def test_a_blur_or_an_area_compiles_nothing_new_where_light_is_tabulated():
    scene = nj.newton_rings(0.2, light="mercury", gap=3e-7)
    nj.render(scene, CAMERA, nj.ClosedForm())
    events = []
    jax.monitoring.register_event_duration_secs_listener(lambda name, *_, **__: events.append(name))
    nj.render(scene, replace(CAMERA, aperture=1.0, blur=0.5), nj.ClosedForm())
    assert not [name for name in events if "backend_compile" in name]


def test_a_method_that_takes_points_refuses_means():
    camera = replace(CAMERA, aperture=1.0)
    with pytest.raises(ValueError, match="takes the light at pixels' centres"):
        nj.render(nj.newton_rings(0.2), camera, nj.Traced())
    with pytest.raises(ValueError, match=r"blur is -1.0; allowed: 0 to 100"):
        replace(CAMERA, blur=-1.0)


def test_explain_has_the_mean_over_pixels_among_what_is_modelled():
    scene = nj.newton_rings(0.2)
    for camera, modelled in ((CAMERA, False), (replace(CAMERA, aperture=1.0), True)):
        (mean,) = [part for part in nj.explain(scene, camera).omissions if part.part == "mean over each pixel"]
        assert mean.modelled is modelled
        assert ("functions of the path difference, which err by" in mean.note) is modelled
    steep = nj.Camera((24, 30), 11e-6, centre_px=(-75.0, -70.0), aperture=1.0)
    assert "at nodes (functions of the path difference alone would err by" in str(nj.explain(scene, steep, 1e-4))


def test_a_camera_of_colours_and_means_is_saved_and_loaded(tmp_path):
    camera = replace(CAMERA, aperture=1.0, blur=0.4, response=nj.cie_1931())
    nj.save_scene(tmp_path / "a.toml", nj.newton_rings(0.2), camera)
    _, loaded = nj.load_scene(tmp_path / "a.toml")
    assert (loaded.aperture, loaded.blur) == (1.0, 0.4)
    np.testing.assert_array_equal(loaded.response.curves, camera.response.curves)
