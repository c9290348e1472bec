"""Sources of an angular size: against sums over 10 000 points, and what microscopes know of their apertures."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import newtonjax as nj
from newtonjax.methods import parallel
from newtonjax.methods.many_beams import profile_of
from newtonjax.rays import amplitudes

CAMERA = nj.Camera((6, 7), 0.1e-3)
WAVELENGTH = 500e-9


def film_of_two_beams(thickness, squares, glass=1.5):
    """Reflected by a gap of air in glass, each of two beams once, [points, thicknesses]: Fresnel's amplitudes."""
    in_air, in_glass = np.sqrt(1 - squares), np.sqrt(1 - squares / glass**2)
    cosine = np.cos(4 * np.pi / WAVELENGTH * in_air[:, None] * thickness)
    total = 0.0
    for r in amplitudes(glass, 1.0, in_glass, in_air)[:2]:
        passed = 1 - r**2  # of the flux, by every face
        first, second = passed * r, -passed * passed * r
        total = total + 0.5 * ((first**2 + second**2)[:, None] + 2 * (first * second)[:, None] * cosine)
    return total


def test_a_disc_is_the_sum_of_ten_thousand_points():
    sine = 0.3
    scene = nj.newton_rings(1.0, WAVELENGTH, 1e-6, angular_radius=np.arcsin(sine))
    with jax.enable_x64(True):
        image = np.asarray(nj.render(scene, CAMERA, nj.ClosedForm(table_error=1e-8)))
        thickness = np.asarray(nj.opd(parallel(scene), CAMERA)) / 2
    squares = sine**2 * (np.arange(10_000) + 0.5) / 10_000
    expected = film_of_two_beams(thickness.ravel(), squares).mean(axis=0)
    np.testing.assert_allclose(image.ravel(), expected, atol=1e-6 * expected.max())
    assert np.ptp(image) < 0.97 * np.ptp(np.asarray(nj.render(parallel(scene), CAMERA)))


@pytest.mark.parametrize("sine", [0.99, 0.999])
def test_grazing_light_has_as_many_directions_as_its_amplitudes_need(sine):
    scene = nj.newton_rings(1.0, WAVELENGTH, 1e-6, numerical_aperture=sine)
    turns = np.linspace(0.0, 4.0, 81)
    # Even in the cosine of the angle, for sin² = 1 - cos².
    cosines = np.sqrt(1 - sine**2) + (1 - np.sqrt(1 - sine**2)) * (np.arange(10_000) + 0.5) / 10_000
    expected = cosines / cosines.sum() @ film_of_two_beams(turns * WAVELENGTH / 2, 1 - cosines**2)
    profile = profile_of(scene, CAMERA).at(turns)[0]
    np.testing.assert_allclose(profile, expected, atol=1e-6 * expected.max())


@pytest.mark.parametrize("is_map", [False, True])
def test_a_square_is_the_sum_of_ten_thousand_points(is_map):
    side = (2 * np.arange(100) - 99) / 100
    sine, table = 0.15, (1 + side[:, None] + 0.5 * side**2 if is_map else None)
    scene = nj.newton_rings(1.0, WAVELENGTH, 1e-6)
    scene = replace(scene, light=replace(scene.light, extent=nj.Extent(sine, "square", table)))
    with jax.enable_x64(True):
        image = np.asarray(nj.render(scene, CAMERA, nj.ClosedForm(table_error=1e-8)))
        thickness = np.asarray(nj.opd(parallel(scene), CAMERA)) / 2
    squares = sine**2 * (side[:, None] ** 2 + side**2).ravel()
    weights = np.full(10_000, 1e-4) if table is None else table.ravel() / table.sum()
    expected = weights @ film_of_two_beams(thickness.ravel(), squares)
    # The middles of 100 cells along a side are 1e-5 off the mean over these.
    np.testing.assert_allclose(image.ravel(), expected, atol=(1e-6 if is_map else 2e-5) * expected.max())


def test_the_sum_over_directions_of_any_bench_is_that_of_ten_thousand():
    camera, method = nj.Camera((4, 4), 0.2e-3), nj.Chebyshev(3)
    scene = nj.newton_rings(1.0, WAVELENGTH, 1e-6, screen=5e-3)
    scene = replace(scene, light=replace(scene.light, extent=nj.Extent(2e-4, "square")))

    def lit_from(tilt):
        light = replace(scene.light, tilt=tilt, extent=None)
        return nj.render(replace(scene, light=light), camera, method)

    side = 2e-4 * (2 * np.arange(100) - 99) / 100
    tilts = jnp.stack(jnp.meshgrid(side, side), axis=-1).reshape(-1, 2)
    with jax.enable_x64(True):
        expected = jax.lax.map(lit_from, tilts, batch_size=500).mean(axis=0)
        image = nj.render(scene, camera, nj.OverSource(method, 3))
    np.testing.assert_allclose(image, expected, atol=5e-6 * float(expected.max()))


@pytest.mark.parametrize("options", [{"screen": "gap"}, {"screen": "gap", "gap": 8e-6}])
def test_nodes_hold_the_sum_over_a_disc(options):
    camera, method = nj.Camera((5, 4), 0.6e-3), nj.Chebyshev(7, table_error=1e-6)
    scene = nj.newton_rings(0.1545, light="sodium", angular_radius=0.01, **options)

    def lit_from(tilt):
        light = replace(scene.light, tilt=tilt, extent=None)
        return nj.render(replace(scene, light=light), camera, method)

    # Even in the squared sine; midpoints of 25 of its steps and 40 azimuths.
    radii = 0.01 * np.sqrt((np.arange(25) + 0.5) / 25)[:, None]
    angles = 2 * np.pi * (np.arange(40) + 0.5) / 40
    tilts = jnp.stack([(radii * np.cos(angles)).ravel(), (radii * np.sin(angles)).ravel()], axis=1)
    # Radiance counts on the plane across the mean direction, light of one direction on the plane across itself.
    weights = jnp.asarray(1 / np.sqrt(1 - np.repeat(radii**2, len(angles))) / len(tilts))
    with jax.enable_x64(True):
        images = jax.lax.map(lit_from, tilts, batch_size=250)
        expected = jnp.tensordot(weights, images, 1)
        image = nj.render(scene, camera, method)
        stated = method.error(scene, camera).intensity
    error = float(jnp.abs(image - expected).max() / expected.max())
    assert error <= min(2e-5, stated)
    of_one_direction = nj.render(parallel(scene), camera, method)
    assert float(jnp.abs(of_one_direction - expected).max()) > 1e-3 * float(expected.max())


# Radius, tilt, sine, shape, size of the image [m], options: phases that differ by 8 to 120 rad over the source.
SLANTED = (
    (0.31, (0.1024, 0.0848), 6.584e-4, "square", 3.8e-3, {"screen": 0.0294}),
    (0.304, (0.0102, -0.0024), 0.02014, "disc", 0.99e-3, {"screen": 0.01504, "gap": 1.578e-5}),
    (0.294, (0.0838, 0.0095), 3.232e-3, "disc", 2.8e-3, {"screen": 0.0241, "gap": 1.875e-5, "view": "transmitted"}),
    (0.249, (0.0014, 0.0012), 0.02984, "square", 1.4e-3, {}),
)


@pytest.mark.parametrize(("radius", "tilt", "sine", "shape", "size", "options"), SLANTED)
def test_what_is_stated_of_a_slanted_source_bounds_what_its_sum_errs_by(radius, tilt, sine, shape, size, options):
    scene, camera, method = nj.newton_rings(radius, **options), nj.Camera((7, 7), size / 7), nj.Chebyshev(11)
    scene = replace(scene, light=replace(scene.light, tilt=tilt, extent=nj.Extent(sine, shape)))
    images = {order: np.asarray(nj.render(scene, camera, nj.OverSource(method, order))) for order in (1, 2, 3, 12)}
    peak = images[12].max()
    errors = {order: np.abs(image - images[12]).max() / peak for order, image in images.items()}
    for order in (1, 2, 3):
        stated = nj.OverSource(method, order).error(scene, camera).intensity
        assert errors[order] <= stated + 1e-8  # of the nodes of the images
        assert stated <= 10 * errors[order] + 2e-6  # of polynomials between directions
    assert errors[1] > 1e-5


def test_a_plan_takes_the_profile_of_the_gap_or_a_sum_over_directions_and_keeps_its_tolerance():
    for options, kind in (({}, nj.ClosedForm), ({"screen": 0.01}, nj.OverSource)):
        scene = nj.newton_rings(1.0, WAVELENGTH, 1e-6, angular_radius=2e-3, **options)
        plan = nj.plan(scene, CAMERA)
        assert isinstance(plan.method, kind)
        image = np.asarray(nj.render(scene, CAMERA))
        reference = np.asarray(nj.render(scene, CAMERA, nj.OverSource(nj.Chebyshev(9), 6)))
        assert np.abs(image - reference).max() <= 1e-3 * reference.max()
    assert "extent of the source" in str(nj.explain(scene, CAMERA))


def test_the_fringes_of_a_microscope_are_as_those_of_a_longer_wave():
    # To first order in NA²: the mean path of the wave λ / (1 - NA²/4), and the fading sin(y)/y, y = π t NA²/λ.
    aperture, gap = 0.2, 4e-6
    thickness = gap + np.linspace(0, 0.5e-6, 200)
    scene = nj.air_wedge(2.5e-3, WAVELENGTH, float(thickness.mean()), numerical_aperture=aperture)
    camera = nj.Camera((1, 200), float(np.ptp(thickness)) / 199 / np.tan(2.5e-3))
    with jax.enable_x64(True):
        image = np.asarray(nj.render(scene, camera, nj.ClosedForm()))[0]
        wide = np.asarray(nj.render(parallel(scene), camera, nj.ClosedForm()))[0]
        path = np.asarray(nj.opd(parallel(scene), camera, nj.ClosedForm()))[0]
    middle = wide.mean()  # over two periods
    fade = np.sinc(path / 2 * aperture**2 / WAVELENGTH)
    phase = 2 * np.pi * path * (1 - aperture**2 / 4) / WAVELENGTH
    expected = -np.cos(phase) * fade * np.ptp(wide) / 2
    assert np.abs(image - middle - expected).max() < 0.02 * middle


def test_derivatives_in_the_size_hold_at_0_too():
    @jax.jit
    @jax.value_and_grad
    def level(aperture):
        scene = nj.newton_rings(1.0, light="sodium", gap=2e-6, numerical_aperture=aperture)
        return nj.render(scene, nj.Camera((1, 5), 0.1e-3), nj.ClosedForm()).sum()

    with jax.enable_x64(True):
        for aperture in (0.0, 0.1):
            difference = (level(aperture + 1e-4)[0] - level(aperture - 1e-4)[0]) / 2e-4
            assert float(level(aperture)[1]) == pytest.approx(float(difference), rel=1e-4, abs=1e-9)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: nj.Extent(-0.1), "sine is -0.1"),
        (lambda: nj.Extent(0.1, "ring"), "shape is 'ring'"),
        (lambda: nj.Extent(0.1, "disc", [[1.0]]), "radiances of a disc"),
        (lambda: nj.newton_rings(1.0, angular_radius=-1e-3), "angular_radius is -0.001"),
        (lambda: nj.newton_rings(1.0, angular_radius=1e-3, numerical_aperture=0.1), "both given"),
        (lambda: nj.render(nj.newton_rings(1.0, angular_radius=1e-3), CAMERA, nj.Traced()), "OverSource"),
        (
            lambda: nj.render(nj.newton_rings(1.0, angular_radius=1e-3, screen=1.0), CAMERA, nj.Chebyshev()),
            "OverSource",
        ),
    ],
)
def test_sources_that_do_not_exist_are_refused_in_one_line(make, message):
    with pytest.raises(ValueError, match=message) as error:
        make()
    assert "\n" not in str(error.value)


def test_a_source_survives_a_file(tmp_path):
    scene = nj.newton_rings(1.0, angular_radius=0.01)
    scene = replace(scene, light=replace(scene.light, extent=nj.Extent(0.01, "square", [[1.0, 2.0]])))
    nj.save_scene(tmp_path / "a.toml", scene)
    again, _ = nj.load_scene(tmp_path / "a.toml")
    np.testing.assert_array_equal(again.light.extent.radiances, [[1.0, 2.0]])
    assert again.light.extent.shape == "square"
