"""Shield and collecting lens: thin-lens rays by hand, energy, edges, derivatives, and what is refused."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from compilations import QUICKLY

import newtonjax as nj
from newtonjax.rays import gather, trace

VIEWS = ("transmitted", "reflected")
FOCAL, FAR = 0.1, 1.2


def bench(view, **options):
    return nj.newton_rings(2.0, 500e-9, 0.3e-6, view, screen=FAR, collecting_lens=FOCAL, **options)


@pytest.mark.parametrize("view", VIEWS)
def test_rays_land_where_a_thin_lens_sends_them(view):
    """Ray by ray: behind a lens of focal length f the slope of a ray at height h is less by h / f."""
    scene = bench(view, light_tilt=(0.01, -0.02))
    moved = (3e-3, -2e-3, float(scene.collecting_lens.vertex[2]))
    screen = dataclasses.replace(scene.screen, vertex=(-0.02, 0.01, scene.screen.vertex[2]))
    scene = dataclasses.replace(scene, collecting_lens=nj.CollectingLens(FOCAL, moved), screen=screen)
    routes, setting = gather(scene)
    starts = jnp.asarray(np.random.default_rng(1).uniform(-3e-3, 3e-3, (50, 2)))
    for beam in (0, 1):
        route = jax.tree.map(lambda leaf, b=beam: leaf[b], routes)
        found = jax.vmap(lambda s, r=route: trace(r, setting, s)[0])(starts)
        position, direction = np.asarray(found.position), np.asarray(found.direction)
        slope = direction[:, :2] / np.abs(direction[:, 2:])
        to_lens = np.abs(moved[2] - position[:, 2:])
        height = position[:, :2] + slope * to_lens - moved[:2]
        behind = abs(screen.vertex[2] - moved[2])
        landed = height + (slope - height / FOCAL) * behind + moved[:2] - screen.vertex[:2]
        np.testing.assert_allclose(found.point, landed, atol=1e-13)


@pytest.mark.parametrize("view", VIEWS)
def test_the_lens_shows_the_gap_enlarged_and_upside_down_with_its_energy(view):
    scene = bench(view, lens_tilt=(1e-3, 2e-3))
    focus = nj.newton_rings(2.0, 500e-9, 0.3e-6, view, screen="gap", lens_tilt=(1e-3, 2e-3))
    length = abs(scene.screen.vertex[2] - focus.screen.vertex[2])
    before = (length - np.sqrt(length**2 - 4 * length * FOCAL)) / 2
    assert 1 / before + 1 / (length - before) == pytest.approx(1 / FOCAL, rel=1e-12)
    times = (length - before) / before
    shape = (60, 50)
    seen = np.asarray(nj.render(focus, nj.Camera(shape, 40e-6, (20.0, 30.0)), nj.Traced()))
    shown = np.asarray(nj.render(scene, nj.Camera(shape, 40e-6 * times, (29.0, 29.0)), nj.Traced()))
    assert np.ptp(seen) > 0.01
    # 2e-11 turns of rounding, and paths of a metre.
    np.testing.assert_allclose(shown[::-1, ::-1] * times**2, seen, atol=1e-9)


def test_every_method_honours_the_lens():
    scene, camera = bench("transmitted"), nj.Camera((40, 40), 100e-6)
    exact = np.asarray(nj.render(scene, camera, nj.Traced()))
    for method in (None, nj.Chebyshev(9)):
        assert np.abs(np.asarray(nj.render(scene, camera, method)) - exact).max() < 1e-3 * exact.max()
    # Densities of rays do not count for Splat: it shows the gap's own irradiance, not what the lens spreads it to.
    splatted = np.asarray(nj.render(scene, camera, nj.Splat()))
    assert np.abs(splatted / splatted.max() - exact / exact.max()).max() < 1e-3


def test_a_shield_darkens_what_does_not_pass_its_hole():
    """Plane plates, light along the axis: the image of the hole is the hole."""
    options = {"view": "reflected", "screen": 5e-3, "gap": 1e-6}
    camera = nj.Camera((81, 81), 25e-6)
    bare = np.asarray(nj.render(nj.newton_rings(np.inf, 500e-9, **options), camera, nj.Traced()))
    scene = nj.newton_rings(np.inf, 500e-9, **options, shield=0.7e-3)
    away = 25e-6 * np.hypot(*np.meshgrid(np.arange(81) - 40, np.arange(81) - 40))
    for method in (None, nj.Traced()):
        image = np.asarray(nj.render(scene, camera, method))
        np.testing.assert_allclose(image, np.where(away <= 0.7e-3, bare, 0.0), atol=1e-12)
    with pytest.raises(ValueError, match="does not reach the whole image"):
        nj.render(scene, camera, nj.Chebyshev())
    found = nj.splat(scene, camera)
    assert found.pairs.lost > 0
    assert not np.any(found.hits[away > 0.7e-3 + 25e-6])
    assert np.all(found.hits[away < 0.7e-3 - 25e-6])
    with pytest.raises(ValueError, match="cannot honour shield"):
        nj.render(nj.newton_rings(1.0, screen="gap", shield=1e-3, view="transmitted"), camera, nj.ClosedForm())


def test_a_shield_that_leans_cuts_an_ellipse():
    scene = nj.newton_rings(np.inf, 500e-9, 1e-6, view="transmitted", screen=1e-3)
    scene = dataclasses.replace(scene, shield=nj.Shield(0.705e-3, (0.1e-3, 0.0, -5e-3), (0.0, np.pi / 3)))
    image = np.asarray(nj.render(scene, nj.Camera((101, 101), 20e-6)))
    rows, columns = np.nonzero(image)
    assert np.ptp(rows) == 2 * 35
    assert np.ptp(columns) == 2 * 17
    assert (columns.max() + columns.min()) / 2 == 50 + 5


def test_images_are_differentiable_in_lens_and_screen_and_the_shield_has_no_slope():
    scene, camera = bench("reflected", shield=5e-3), nj.Camera((5, 6), 2e-3)

    def image(change):
        moved = eqx.tree_at(
            lambda s: (s.collecting_lens.focal_length, s.collecting_lens.vertex, s.screen.vertex, s.shield.radius),
            scene,
            (
                FOCAL + change[0],
                scene.collecting_lens.vertex + change[1:4],
                scene.screen.vertex + change[4:7],
                5e-3 + change[7],
            ),
        )
        return nj.render(moved, camera, nj.Traced())

    slope = np.asarray(jax.jit(jax.jacfwd(image), compiler_options=QUICKLY)(jnp.zeros(8)))
    images = jax.jit(jax.vmap(image), compiler_options=QUICKLY)
    step = 2e-7 * np.eye(8)
    difference = np.moveaxis(np.asarray(images(step) - images(-step)), 0, -1) / 4e-7
    assert np.all(slope[..., 7] == 0)
    for k in range(7):
        # Rounding: 1e-11 turns of an image of 1e-3, over the step.
        largest = np.abs(slope[..., k]).max()
        np.testing.assert_allclose(slope[..., k], difference[..., k], rtol=1e-5, atol=1e-5 + 1e-6 * largest)
        assert largest > 1e-5


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"collecting_lens": 0.5}, "collecting_lens is 0.5; allowed: a positive focal length of at most a quarter"),
        ({"collecting_lens": 0.1, "screen": "gap"}, "needs a screen at a distance"),
        ({"collecting_lens": -1.0}, "collecting_lens is -1"),
        ({"shield": 0.0}, "shield is 0.0; allowed: a positive radius"),
    ],
)
def test_a_bench_that_cannot_be_is_refused(options, message):
    with pytest.raises(ValueError, match=message):
        nj.newton_rings(**{"view": "transmitted", "screen": 1.0, **options})


@pytest.mark.parametrize("z", [-1.0, -1.0 + 0.1, -2.0])
def test_a_lens_that_images_no_plane_on_the_screen_is_refused(z):
    scene = nj.newton_rings(screen=0.995, view="transmitted")
    with pytest.raises(ValueError, match="allowed: a positive distance other than the focal length"):
        dataclasses.replace(scene, collecting_lens=nj.CollectingLens(0.1, (0.0, 0.0, z)))


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize(("place", "message"), [(-1e-3, "inside of the bench"), (2.0, "beyond screen or collecting")])
def test_a_shield_that_the_light_does_not_pass_on_its_way_is_refused(view, place, message):
    way = 1 if view == "reflected" else -1
    for scene in (nj.newton_rings(view=view, screen=0.5), nj.newton_rings(view=view, screen=0.5, collecting_lens=0.1)):
        with pytest.raises(ValueError, match=f"shield stands .* {message}"):
            dataclasses.replace(scene, shield=nj.Shield(1e-3, (0.0, 0.0, way * (5e-3 + place))))


def test_a_hole_whose_edge_runs_between_nodes_and_corners_is_seen():
    scene = nj.newton_rings(2.0, 500e-9, screen="gap", shield=2.89e-3, view="transmitted")
    camera = nj.Camera((1024, 1024), 4e-6)
    assert isinstance(nj.plan(scene, camera).method, nj.Traced)
    with pytest.raises(ValueError, match="does not reach the whole image"):
        nj.render(scene, camera, nj.Chebyshev(5))


def test_splat_shows_a_screen_that_touches_the_glass():
    scene, camera = nj.newton_rings(2.0, 500e-9, view="reflected", screen=0.0), nj.Camera((33, 33), 5e-6)
    found = nj.splat(scene, camera)
    exact = np.asarray(nj.render(scene, camera, nj.Traced()))
    # One ray a pixel, up to half a pixel from its middle: the intensity there grows as r⁴, by 2 / 16 of it.
    assert np.abs(found.image - exact).max() < 0.15 * exact.max()
    assert found.error < 1e-3
