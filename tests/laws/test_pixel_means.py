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


def supersampled(scene, camera, side, blur=0.0):
    """Means over side x side points a pixel, of a picture that is blurred before on a frame wider by some pixels."""
    rows, columns = camera.shape
    margin = int(np.ceil(6 * blur))
    middle = ((columns - 1) / 2, (rows - 1) / 2) if camera.centre_px is None else camera.centre_px
    wide = nj.Camera(
        ((rows + 2 * margin) * side, (columns + 2 * margin) * side),
        camera.pixel_size / side,
        tuple((at + margin + 0.5) * side - 0.5 for at in middle),
    )
    points = np.asarray(nj.render(scene, wide, nj.Chebyshev(17, table_error=1e-7)))
    if blur:
        points = gaussian_filter(points, blur * side, truncate=6.0)
    means = points.reshape(rows + 2 * margin, side, columns + 2 * margin, side).mean(axis=(1, 3))
    return means[margin : margin + rows, margin : margin + columns]


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


def test_methods_that_take_points_refuse_means():
    camera = replace(CAMERA, aperture=1.0)
    for method in (nj.ClosedForm(), nj.Traced()):
        with pytest.raises(ValueError, match="takes the light at pixels' centres"):
            nj.render(nj.newton_rings(0.2), camera, method)
    with pytest.raises(ValueError, match=r"blur is -1.0; allowed: 0 to 100"):
        replace(CAMERA, blur=-1.0)


def test_explain_has_the_mean_over_pixels_among_what_is_modelled():
    scene = nj.newton_rings(0.2)
    for camera, modelled in ((CAMERA, False), (replace(CAMERA, aperture=1.0), True)):
        (mean,) = [part for part in nj.explain(scene, camera).omissions if part.part == "mean over each pixel"]
        assert mean.modelled is modelled


def test_a_camera_of_colours_and_means_is_saved_and_loaded(tmp_path):
    camera = replace(CAMERA, aperture=1.0, blur=0.4, response=nj.cie_1931())
    nj.save_scene(tmp_path / "a.toml", nj.newton_rings(0.2), camera)
    _, loaded = nj.load_scene(tmp_path / "a.toml")
    assert (loaded.aperture, loaded.blur) == (1.0, 0.4)
    np.testing.assert_array_equal(loaded.response.curves, camera.response.curves)
