"""Light of a source at a finite distance: against images of the source in plane mirrors, and the law of thin lenses."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from mpmath import findroot, mp, mpf, sqrt

import newtonjax as nj
from fitting import derivative_images, information
from newtonjax.rays import amplitudes

WAVELENGTH = 589.3e-9
DISTANCE, HEIGHT, THICKNESS, INDEX = 0.05, 0.02, 1e-3, 1.5
CAMERA = nj.Camera((5, 6), 0.4e-3, centre_px=(0.3, 0.7))


def plate(curvature=1 / DISTANCE, beams=("R0", "T0 R1 T0"), tilt=(0.0, 0.0)):
    """A plate in air, seen in reflection on a plane above it."""
    return nj.Scene(
        surfaces=(nj.Surface(0.0, (0.0, 0.0, 0.0)), nj.Surface(0.0, (0.0, 0.0, -THICKNESS))),
        media=(1.0, INDEX, 1.0),
        light=nj.Light(WAVELENGTH, tilt, curvature=curvature),
        screen=nj.Surface(0.0, (0.0, 0.0, HEIGHT)),
        beams=beams,
    )


def path_through_plate(radius, distance):
    """Of the beam that is reflected at the plate's lower face, from a source over the axis, in 50 digits.

    `p` is n sin θ, which is the same in every layer (Snell's law).
    """
    mp.dps = 50
    air, glass = mpf(distance) + mpf(HEIGHT), 2 * mpf(THICKNESS)
    if radius == 0:
        return air + mpf(INDEX) * glass

    def miss(p):
        return air * p / sqrt(1 - p * p) + glass * p / sqrt(mpf(INDEX) ** 2 - p * p) - radius

    p = findroot(miss, radius / (air + glass / INDEX))
    return air / sqrt(1 - p * p) + mpf(INDEX) ** 2 * glass / sqrt(mpf(INDEX) ** 2 - p * p)


# The last: light that is gathered, as from a source behind the screen with the other sign of its paths.
@pytest.mark.parametrize("distance", [DISTANCE, 5.0, -0.2])
def test_path_differences_are_those_of_the_sources_images(distance):
    x, y = CAMERA.axes()
    radii = np.hypot(np.asarray(x)[None, :], np.asarray(y)[:, None])
    with jax.enable_x64(True):
        paths = np.asarray(nj.opd(plate(1 / distance), CAMERA, nj.Traced()))
    along = mpf(distance) + mpf(HEIGHT)

    def direct(radius):
        return (1 if along > 0 else -1) * sqrt(along**2 + mpf(float(radius)) ** 2)

    expected = [[float(path_through_plate(radius, distance) - direct(radius)) for radius in row] for row in radii]
    np.testing.assert_allclose(paths, expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize("polarization", [None, 0.0, 1.1])
def test_irradiance_falls_as_that_of_a_point_source(polarization):
    scene = plate(beams=("R0",))
    scene = replace(scene, light=replace(scene.light, polarization=polarization))
    x, y = CAMERA.axes()
    x, y = np.meshgrid(np.asarray(x), np.asarray(y))
    way = np.sqrt((DISTANCE + HEIGHT) ** 2 + x**2 + y**2)
    cosine = (DISTANCE + HEIGHT) / way
    r_s, r_p = amplitudes(1.0, INDEX, cosine, np.sqrt(1 - (1 - cosine**2) / INDEX**2))[:2]
    # The vector turned the least way has the azimuth about the axis that it had on it.
    azimuth = np.arctan2(y, x)
    share = 0.5 if polarization is None else np.cos(azimuth - polarization) ** 2
    reflectance = share * np.asarray(r_p) ** 2 + (1 - share) * np.asarray(r_s) ** 2
    with jax.enable_x64(True):
        image = np.asarray(nj.render(scene, CAMERA, nj.Traced()))
    np.testing.assert_allclose(image, reflectance * DISTANCE**2 * cosine / way**2, rtol=1e-12)


def test_nodes_and_pairs_of_rays_hold_light_of_a_near_source():
    camera = nj.Camera((24, 20), 20e-6)
    scene = nj.newton_rings(1.0, WAVELENGTH, 1e-6, source_distance=0.1)
    with jax.enable_x64(True):
        rays, nodes = (np.asarray(nj.render(scene, camera, method)) for method in (nj.Traced(), nj.Chebyshev(17)))
        plane = np.asarray(nj.render(nj.newton_rings(1.0, WAVELENGTH, 1e-6), camera))
        pairs = nj.splat(scene, camera, nj.Splat(step=5e-6, epsilon=4e-5))
    np.testing.assert_allclose(nodes, rays, atol=1e-10)
    assert abs(rays - plane).max() > 1e-3 * plane.max()
    # Pairs do not know how far the light has spread on its way.
    shown = pairs.image / pairs.image.mean()
    np.testing.assert_allclose(shown, rays / rays.mean(), atol=0.01)


def test_a_plan_does_not_take_the_closed_form_of_plane_waves():
    camera = nj.Camera((32, 32), 20e-6)
    scene = nj.newton_rings(1.0, WAVELENGTH, 1e-6, source_distance=0.1)
    assert isinstance(nj.plan(scene, camera).method, nj.Chebyshev)
    with pytest.raises(ValueError, match="plane waves"):
        nj.render(scene, camera, nj.ClosedForm())


def test_a_sum_over_a_near_disc_is_that_of_ten_thousand_points():
    sine, camera, scene = 2e-3, nj.Camera((3, 4), 0.4e-3), plate()
    scene = replace(scene, light=replace(scene.light, extent=nj.Extent(sine)))
    method = nj.Chebyshev(5)

    def lit_from(tilt):
        light = replace(scene.light, tilt=tilt, extent=None)
        return nj.render(replace(scene, light=light), camera, method)

    radii = sine * np.sqrt((np.arange(100) + 0.5) / 100)[:, None]
    angles = 2 * np.pi * (np.arange(100) + 0.5) / 100
    tilts = jnp.stack([(radii * np.cos(angles)).ravel(), (radii * np.sin(angles)).ravel()], axis=1)
    with jax.enable_x64(True):
        expected = jax.lax.map(lit_from, tilts, batch_size=500).mean(axis=0)
        image = nj.render(scene, camera, nj.OverSource(method, 4))
    np.testing.assert_allclose(image, expected, atol=1e-5 * float(expected.max()))


@pytest.mark.parametrize("curvature", [0.0, 3.0, -3.0])
def test_derivatives_in_the_curvature_hold_for_plane_waves_too(curvature):
    camera, weights = nj.Camera((6, 5), 60e-6), np.random.default_rng(1).normal(size=(6, 5))
    scene = nj.newton_rings(1.0, WAVELENGTH, 3e-6)

    def total(value):
        light = replace(scene.light, curvature=value)
        return (weights * nj.render(replace(scene, light=light), camera, nj.Chebyshev(9))).sum()

    with jax.enable_x64(True):
        slope, step = float(jax.grad(total)(curvature)), 1e-3
        expected = float(total(curvature + step) - total(curvature - step)) / (2 * step)
    np.testing.assert_allclose(slope, expected, rtol=1e-5, atol=1e-10)


def test_studies_of_nearly_plane_waves_are_those_of_plane_waves():
    camera = nj.Camera((48, 48), 60e-6, exposure=1e4)
    plane = nj.newton_rings(1.0, WAVELENGTH, 3e-6)
    nearly = replace(plane, light=replace(plane.light, curvature=1e-9))
    names = ("radius", "gap")
    expected, studied = (information(scene, camera, free=names) for scene in (plane, nearly))
    assert studied.sd("radius") == pytest.approx(expected.sd("radius"), rel=1e-6)


def test_studies_take_its_derivative():
    camera = nj.Camera((12, 10), 0.3e-3, exposure=1.0)
    scene = nj.newton_rings(1.0, WAVELENGTH, 3e-6, source_distance=0.2)
    with jax.enable_x64(True):
        slope = derivative_images(scene, camera, ("light_curvature",))["light_curvature"]
        lights = (replace(scene.light, curvature=5.0 + step) for step in (1e-3, -1e-3))
        ahead, behind = (np.asarray(nj.render(replace(scene, light=light), camera, nj.Traced())) for light in lights)
    np.testing.assert_allclose(slope, (ahead - behind) / 2e-3, atol=1e-4 * abs(slope).max())


@pytest.mark.parametrize("distance", [0.05, 0.1, 0.2, np.inf])
def test_a_collimator_obeys_the_law_of_thin_lenses(distance):
    options = {} if np.isinf(distance) else {"source_distance": distance}
    light = nj.newton_rings(1.0, collimator=0.1, lamp_radius=1e-3, **options).light
    if distance in (0.1, np.inf):
        assert light.curvature is None  # the lamp is in the focus
        assert light.extent.sine == pytest.approx(np.sin(np.arctan(1e-3 / 0.1)), rel=1e-14)
    else:
        image = 1 / (1 / 0.1 - 1 / distance)
        assert light.curvature == pytest.approx(-1 / image, rel=1e-14)
        assert light.extent.sine == pytest.approx(np.sin(np.arctan(1e-3 / distance)), rel=1e-14)


def test_files_hold_the_curvature(tmp_path):
    scene = nj.newton_rings(1.0, source_distance=0.3)
    nj.save_scene(tmp_path / "near.toml", scene)
    assert nj.load_scene(tmp_path / "near.toml")[0].light.curvature == scene.light.curvature


def test_explain_says_what_a_near_source_changes():
    camera = nj.Camera((64, 64), 20e-6)
    far = nj.explain(nj.newton_rings(1.0, WAVELENGTH, 1e-6), camera)
    note = next(part.note for part in far.omissions if part.part == "distance of the source")
    distance = float(note.split()[2])
    near = nj.explain(nj.newton_rings(1.0, WAVELENGTH, 1e-6, source_distance=distance), camera)
    change = next(part.error for part in near.omissions if part.part == "distance of the source")
    assert 0.3e-3 < change < 3e-3  # twice what it is at nodes
    assert f"from {distance:.4g} m away" in str(near)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"source_distance": 0.0}, "source_distance is 0"),
        ({"collimator": -0.1}, "collimator is -0.1"),
        ({"lamp_radius": 1e-3}, "give source_distance, or the focal length of a collimator"),
        ({"lamp_radius": 1e-3, "angular_radius": 1e-3, "collimator": 0.1}, "angular_radius and lamp_radius"),
        ({"lamp_radius": -1e-3, "collimator": 0.1}, "lamp_radius is -0.001"),
    ],
)
def test_what_no_lamp_has_is_refused_in_one_line(options, words):
    with pytest.raises(ValueError, match=words) as caught:
        nj.newton_rings(1.0, **options)
    assert "\n" not in str(caught.value)
    with pytest.raises(ValueError, match="curvature"):
        nj.Light(WAVELENGTH, curvature=np.nan)
