"""A camera's lens: its laws, against pixels by themselves, pinholes in space, and the fit's own counting."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import fitting
import newtonjax as nj
from newtonjax.scene import corners, node_points, points_of, window

WAVELENGTH = 589.3e-9
SCENE = nj.newton_rings(1.0, WAVELENGTH, 1e-6)
LENS = nj.CameraLens(0.08, 0.01, (40.0, 30.0), (0.1, -0.2), 300.0, vignette=0.3)
CAMERA = nj.Camera((64, 80), 30e-6, lens=LENS)


def camera_with(**numbers):
    return replace(CAMERA, lens=nj.CameraLens(**numbers))


def test_a_pixel_looks_where_the_law_of_distortion_says():
    x, y = points_of(camera_with(distortion=0.08, fifth_order=-0.02, axis_px=(30.0, 20.0)), 70.0, 5.0)
    square = (40.0**2 + 15.0**2) / (np.hypot(63, 79) / 2) ** 2
    factor = 1 + 0.08 * square - 0.02 * square**2
    expected = 30e-6 * (np.array([30.0, 20.0]) + factor * np.array([40.0, -15.0]) - np.array([39.5, 31.5]))
    np.testing.assert_allclose([x, y], expected, rtol=1e-13)


@pytest.mark.parametrize("distance", [300.0, None])
@pytest.mark.parametrize("tilt", [(0.3, 0.0), (0.0, -0.4), (0.2, 0.5)])
def test_a_tilted_screen_is_seen_as_by_a_pinhole(tilt, distance):
    # Points of the plane, turned in space, and projected on the image; a telecentric lens drops the depth.
    plane = np.random.default_rng(0).uniform(-30, 30, (20, 2))
    space = Rotation.from_euler("xy", tilt).apply(np.column_stack([plane, np.zeros(20)]))
    scale = 1.0 if distance is None else distance / (distance + space[:, 2:])
    image = space[:, :2] * scale
    camera = camera_with(tilt=tilt, principal_distance_px=distance, axis_px=(39.5, 31.5))
    seen = np.stack(points_of(camera, image[:, 0] + 39.5, image[:, 1] + 31.5), axis=1)
    np.testing.assert_allclose(seen, 30e-6 * plane, atol=1e-17)


@pytest.mark.parametrize("pixel", [(0, 0), (63, 79), (12, 50)])
@pytest.mark.parametrize("method", [nj.Traced(), nj.Chebyshev(21)])
def test_a_pixel_is_the_image_of_a_camera_that_looks_there(pixel, method):
    row, column = pixel
    x, y = points_of(CAMERA, float(column), float(row))
    alone = nj.Camera((1, 1), 1e-6, centre_px=(-x / 1e-6, -y / 1e-6))
    with jax.enable_x64(True):
        image = np.asarray(nj.render(SCENE, CAMERA, method))
        expected = np.asarray(nj.render(SCENE, alone, nj.Traced()))
    np.testing.assert_allclose(image[row, column], expected[0, 0], rtol=1e-6)


def test_a_plan_counts_nodes_for_the_lens():
    with jax.enable_x64(True):
        chosen = nj.plan(SCENE, CAMERA)
        image, rays = (np.asarray(nj.render(SCENE, CAMERA, method)) for method in (chosen.method, nj.Traced()))
    assert isinstance(chosen.method, nj.Chebyshev)
    assert abs(image - rays).max() <= chosen.intensity_error * rays.max()
    for method in (nj.ClosedForm(), nj.Splat()):
        with pytest.raises(ValueError, match="cannot honour camera"):
            nj.render(SCENE, CAMERA, method)


def test_no_verb_leaves_the_lens_out():
    values = {"radius": [1.0, 2.0], "gap": 1e-6}
    for refused in (
        lambda: nj.sweep(nj.newton_rings, values, CAMERA, nj.ClosedForm()),
        lambda: nj.blocks(SCENE, CAMERA, nj.ClosedForm()),
        lambda: nj.opd(SCENE, CAMERA, nj.ClosedForm()),
        lambda: nj.ClosedForm().error(SCENE, CAMERA),
        lambda: nj.plan(nj.newton_rings(1.0, beams="all"), CAMERA),
    ):
        with pytest.raises(ValueError, match="cannot honour camera"):
            refused()
    with jax.enable_x64(True):
        images = nj.sweep(nj.newton_rings, {"radius": [1.0], "gap": 1e-6}, CAMERA)
        expected = nj.render(nj.newton_rings(1.0, gap=1e-6), CAMERA)
    np.testing.assert_allclose(images[0], expected, atol=1e-3 * float(expected.max()))


def test_means_over_pixels_are_those_of_the_finer_grid():
    fine, coarse = 8, nj.Camera((20, 24), 60e-6, lens=nj.CameraLens(0.05))
    camera = replace(coarse, aperture=1.0)
    # The same points on a grid eight times as fine, whose middles lie within the pixels.
    half_diagonals = np.hypot(20 * fine - 1, 24 * fine - 1) / fine / np.hypot(19, 23)
    many = nj.Camera((20 * fine, 24 * fine), 60e-6 / fine, lens=nj.CameraLens(0.05 * half_diagonals**2))
    with jax.enable_x64(True):
        image = np.asarray(nj.render(SCENE, camera, tolerance=1e-4))
        light = np.asarray(nj.render(SCENE, many, nj.Chebyshev(21)))
    expected = light.reshape(20, fine, 24, fine).mean(axis=(1, 3))
    np.testing.assert_allclose(image, expected, atol=2e-3 * expected.max())


def test_each_channel_has_its_own_size():
    sizes, curves = np.array([0.99, 1.0, 1.02]), np.eye(3)
    response = nj.Response([450e-9, 550e-9, 650e-9], curves)
    scene = nj.newton_rings(1.0, light="mercury", gap=1e-6)
    lens = nj.CameraLens(axis_px=(10.0, 12.0), magnifications=sizes)
    camera = nj.Camera((32, 36), 40e-6, response=response, lens=lens)
    with jax.enable_x64(True):
        image = np.asarray(nj.render(scene, camera, nj.Chebyshev(17)))
        rays = np.asarray(nj.render(scene, camera, nj.Traced()))
        rows = np.concatenate([part for _, part in nj.blocks(scene, camera, nj.Chebyshev(17), rows=7)])
        expected = []
        for channel, size in enumerate(sizes):
            axis = np.array([10.0, 12.0])
            centre = axis + (np.array([17.5, 15.5]) - axis) * size
            plain = nj.Camera((32, 36), 40e-6 / size, centre_px=centre, response=response)
            expected.append(np.asarray(nj.render(scene, plain, nj.Chebyshev(17)))[..., channel])
        planned = np.asarray(nj.render(scene, camera))
    np.testing.assert_allclose(image, np.stack(expected, axis=-1), atol=3e-5 * image.max())
    np.testing.assert_allclose(rays, image, atol=3e-5 * image.max())
    np.testing.assert_array_equal(rows, image)
    np.testing.assert_allclose(planned, image, atol=1e-3 * image.max())


def test_rows_by_themselves_look_where_they_did():
    part = window(CAMERA, 20, 17)
    np.testing.assert_allclose(points_of(part, 5.0, 3.0), points_of(CAMERA, 5.0, 23.0), rtol=1e-12)
    light = np.ones(CAMERA.shape)
    still = replace(CAMERA, exposure=4e8, full_well=1e9, read_noise=0.0, bits=16)
    whole = np.asarray(still.expose(light, jax.random.key(0))).astype(float)
    rows = np.asarray(window(still, 20, 17).expose(light[20:37], jax.random.key(1))).astype(float)
    np.testing.assert_allclose(rows, whole[20:37], rtol=1e-3)


def test_the_rim_is_darker_by_the_fourth_power_of_the_cosine():
    camera = nj.Camera((60, 80), 1e-5, exposure=4e8, full_well=1e9, read_noise=0.0, bits=16,
                       lens=nj.CameraLens(vignette=0.4))  # fmt: skip
    code = np.asarray(camera.expose(np.ones((60, 80)), jax.random.key(0))).astype(float)
    rows, columns = np.mgrid[:60, :80]
    tangent = np.hypot(rows - 29.5, columns - 39.5) / (np.hypot(59, 79) / 2) * np.tan(np.arccos(0.6**0.25))
    np.testing.assert_allclose(code, 0.4 * 65535 * np.cos(np.arctan(tangent)) ** 4, rtol=1e-3)


@pytest.mark.parametrize("values", [(0.0, 0.0, 0.0, 0.0), (0.05, 0.2, -0.1, 0.004)])
def test_derivatives_in_the_lens_are_right(values):
    def seen(values):
        distortion, tilt_x, tilt_y, nearness = values
        lens = nj.CameraLens(distortion, tilt=(tilt_x, tilt_y), principal_distance_px=1 / (nearness + 1e-3))
        return jnp.stack(points_of(nj.Camera((12, 14), 60e-6, lens=lens), 11.0, 2.0)) / 60e-6

    with jax.enable_x64(True):
        slopes, reverse = (np.asarray(of(seen)(jnp.array(values))) for of in (jax.jacfwd, jax.jacrev))
        for place, step in enumerate(1e-6 * np.eye(4)):
            expected = (seen(values + step) - seen(values - step)) / 2e-6
            np.testing.assert_allclose(slopes[:, place], expected, rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(reverse, slopes, rtol=1e-12)


def test_an_image_has_its_derivative_in_the_distortion():
    def image(distortion):
        camera = nj.Camera((12, 14), 60e-6, lens=nj.CameraLens(distortion))
        return nj.render(SCENE, camera, nj.Chebyshev(5))

    with jax.enable_x64(True):
        _, slope = jax.jvp(image, (0.02,), (1.0,))
        expected = (image(0.02 + 1e-5) - image(0.02 - 1e-5)) / 2e-5
    np.testing.assert_allclose(slope, expected, atol=1e-6 * float(abs(expected).max()))


def test_studies_look_through_the_lens():
    camera = nj.Camera((20, 24), 60e-6, exposure=1.0, lens=nj.CameraLens(0.1, tilt=(0.1, 0.2)))
    with jax.enable_x64(True):
        slope = fitting.derivative_images(SCENE, camera, ("radius",))["radius"]
        ahead, behind = (
            np.asarray(nj.render(nj.newton_rings(radius, WAVELENGTH, 1e-6), camera, nj.Traced()))
            for radius in (1 + 1e-5, 1 - 1e-5)
        )
    np.testing.assert_allclose(slope, (ahead - behind) / 2e-5, atol=1e-3 * abs(slope).max())


def test_a_fit_finds_the_distortion_that_a_picture_was_made_with():
    camera = nj.Camera((400, 400), 12e-6, exposure=8e3, lens=nj.CameraLens(0.04))
    image = nj.render(nj.newton_rings(0.5, WAVELENGTH), camera)
    codes = np.asarray(camera.expose(image, jax.random.key(0)))
    result = fitting.fit(codes, wavelength=WAVELENGTH, pixel_size=12e-6, transfer="linear")
    assert result.status == "ok"
    assert abs(result.radius - 0.5) < 3 * result.radius_sd
    distortion = result.parameters["distortion"]
    assert abs(distortion.value - 0.04) < 4 * distortion.sd
    assert distortion.sd < 0.004


def test_nodes_and_corners_lie_on_the_image():
    points, at_corners = node_points(CAMERA, 9), corners(CAMERA)
    assert points.shape == (81, 2)
    np.testing.assert_allclose(at_corners[3], points_of(CAMERA, 79.0, 63.0), rtol=1e-13)


@pytest.mark.parametrize(
    ("numbers", "words"),
    [
        ({"distortion": 0.5}, "lens.distortion is 0.5"),
        ({"tilt": (1.0, 0.0)}, "below 45 degrees"),
        ({"tilt": (0.1,)}, "two numbers"),
        ({"principal_distance_px": -3.0}, "a positive number of pixels"),
        ({"magnifications": (1.0, 2.0)}, "0.9 to 1.1"),
        ({"vignette": 1.0}, "0 to below 1"),
        ({"axis_px": (np.nan, 0.0)}, "two finite numbers"),
    ],
)
def test_what_no_lens_has_is_refused_in_one_line(numbers, words):
    with pytest.raises(ValueError, match=words) as caught:
        nj.CameraLens(**numbers)
    assert "\n" not in str(caught.value)


def test_magnifications_are_those_of_the_channels():
    with pytest.raises(ValueError, match="one for each channel"):
        nj.Camera((8, 8), 1e-5, lens=nj.CameraLens(magnifications=(1.0, 1.01, 0.99)))


def test_files_hold_the_lens(tmp_path):
    camera = nj.Camera((8, 9), 1e-5, lens=LENS, full_scale=2e4, black_level=12.0, transfer="srgb")
    nj.save_scene(tmp_path / "lens.toml", SCENE, camera)
    again = nj.load_scene(tmp_path / "lens.toml")[1]
    assert jax.tree.all(jax.tree.map(np.array_equal, again, camera))
    assert again.transfer == "srgb"
