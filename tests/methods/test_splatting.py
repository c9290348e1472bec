"""The paper's algorithm: its pairs, its books, its error, and where it ends."""

import dataclasses
import warnings
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from compilations import QUICKLY

import newtonjax as nj
from newtonjax.fields import arrivals_at, opd_at
from newtonjax.methods.wavelets import pair_error, wavelet_opd
from newtonjax.rays import gather, trace

compiled = partial(jax.jit, compiler_options=QUICKLY)

CAMERA = nj.Camera((48, 40), 5e-6, centre_px=(15.0, 20.0))
VIEWS = ("transmitted", "reflected")


def books_balance(found):
    assert found.pairs.emitted == found.source.nodes[0] * found.source.nodes[1]
    assert found.pairs.emitted == sum(found.pairs[1:])
    assert int(found.hits.sum()) == found.pairs.paired


@pytest.mark.parametrize("view", VIEWS)
def test_no_lit_pixel_is_left_empty_and_the_books_balance(view):
    found = nj.splat(nj.newton_rings(2.0, 500e-9, view=view, screen=1e-3), CAMERA)
    assert int(found.hits.min()) >= 1
    assert not found.unpaired.any()
    assert (found.pairs.apart, found.pairs.lost) == (0, 0)
    books_balance(found)


@pytest.mark.parametrize("view", VIEWS)
def test_finer_sources_come_to_the_mean_over_each_pixel(view):
    # The gap's fringes over one pixel, averaged; rays' densities do not count, and are even to 1e-3 here.
    scene = nj.newton_rings(0.05, 500e-9, view=view, screen="gap")
    found = nj.splat(scene, CAMERA, nj.Splat(step=0.5e-6))
    fine = nj.Camera((48 * 8, 40 * 8), 5e-6 / 8, centre_px=(15.0 * 8 + 3.5, 20.0 * 8 + 3.5))
    mean = np.asarray(nj.render(scene, fine, nj.Traced())).reshape(48, 8, 40, 8).mean(axis=(1, 3))
    # Ten by ten rays a pixel, whose places in it shift from one to the next: a tenth of a fringe's change over it.
    assert np.abs(np.asarray(found.image) - mean).max() < 0.03 * mean.max()


def separations(scene, starts):
    """Landing points of a scene's two beams [2, n, 2] and the wavelets' path difference, for launch points."""
    routes, setting = gather(scene)

    def node(start):
        one, two = (trace(jax.tree.map(lambda leaf, b=b: leaf[b], routes), setting, start)[0] for b in (0, 1))
        return jnp.stack([one.point, two.point]), wavelet_opd(setting, one, two)

    return jax.vmap(node)(starts)


@compiled
def predicted(scene, starts):
    """Second order of the wavelets' error and the separation [m]."""
    routes, setting = gather(scene)
    one, two = (jax.tree.map(lambda leaf, b=b: leaf[b], routes) for b in (0, 1))
    pair = jax.vmap(pair_error, (None, None, None, 0))(one, two, setting, starts)
    return pair.error, pair.separation


def test_error_of_the_wavelets_is_the_predicted_second_order_one_on_random_benches():
    random = np.random.default_rng(7)
    worst = 0.0
    for bench in range(20):
        radius = 10 ** random.uniform(-1, 1)
        scene = nj.newton_rings(
            radius, 500e-9, random.uniform(0, 5e-6), VIEWS[bench % 2], screen=10 ** random.uniform(-3, -1),
            lens_tilt=tuple(random.uniform(-1e-3, 1e-3, 2)), plate_tilt=tuple(random.uniform(-1e-3, 1e-3, 2)),
            light_tilt=tuple(random.uniform(-1e-3, 1e-3, 2)),
        )  # fmt: skip
        starts = jnp.asarray(random.uniform(-1, 1, (40, 2)) * min(2e-3, radius / 100))
        points, wavelet = compiled(separations)(scene, starts)
        exact, arrives = compiled(opd_at)(scene, points.mean(axis=1))
        assert arrives.all()
        # The scene's order of beams is that of the words; the path difference's is by gap crossings: the same here.
        error = np.abs(np.asarray(wavelet - exact))
        bound, apart = map(np.asarray, predicted(scene, starts))
        # Third order: (separation / distance of the screen)^3 times the slope, at most a tenth; 2e-15 m is rounding.
        assert np.all(error <= 1.1 * bound + 2e-14)
        worst = max(worst, float((error / apart**2).max()))
        assert np.median(np.abs(error - bound)) <= 0.1 * np.median(bound) + 1e-14
    assert worst > 0


def test_uncorrected_paths_err_by_the_first_order():
    scene = nj.newton_rings(2.0, 500e-9, view="reflected", screen=1e-2)
    camera = nj.Camera((5, 100), 5e-6, centre_px=(0.0, 2.0))
    wide = {"step": 2.5e-6, "epsilon": 1e-3}
    exact = np.asarray(nj.render(scene, camera, nj.Traced()))
    errors = {
        path: np.abs(np.asarray(nj.splat(scene, camera, nj.Splat(path=path, **wide)).image) - exact).max()
        for path in ("wavelet", "raw")
    }
    assert errors["wavelet"] < 0.1 * exact.max()
    # The rays of a node land up to 7 um apart where their slopes differ by 6e-4: 4e-9 m, and each is at its own place.
    assert errors["raw"] > errors["wavelet"]


def test_pixels_whose_pairs_land_too_far_apart_are_reported():
    scene = nj.newton_rings(2.0, 500e-9, view="reflected", screen=1e-1)
    camera = nj.Camera((9, 60), 5e-6, centre_px=(0.0, 4.0))
    found = nj.splat(scene, camera)
    books_balance(found)
    radius = np.hypot(*np.meshgrid(np.arange(60.0), np.arange(9.0) - 4))
    # The boundary: 0.07 mm, 14 pixels.
    assert not found.unpaired[radius < 12].any()
    assert found.unpaired[radius > 15].all()
    with pytest.warns(UserWarning, match="epsilon"):
        nj.render(scene, camera, nj.Splat())
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        nj.render(scene, camera, nj.Splat(epsilon=1e-3))


def test_the_original_variant_drops_pairs_across_pixel_borders():
    scene = nj.newton_rings(2.0, 500e-9, view="reflected", screen=5e-3)
    camera = nj.Camera((20, 60), 5e-6, centre_px=(0.0, 10.0))
    both = {p: nj.splat(scene, camera, nj.Splat(step=2.5e-6, pairing=p)) for p in ("midpoint", "pixel")}
    for found in both.values():
        books_balance(found)
    assert both["pixel"].pairs.paired < both["midpoint"].pairs.paired
    assert both["pixel"].pairs.emitted == both["midpoint"].pairs.emitted


def test_rays_that_miss_the_lens_are_lost_and_their_pixels_dark():
    scene = nj.newton_rings(1e-4, 500e-9, view="reflected", lens_thickness=2e-4, screen=1e-5)
    found = nj.splat(scene, nj.Camera((40, 40), 10e-6), nj.Splat(step=2e-6, epsilon=1.0))
    books_balance(found)
    assert found.pairs.lost > 0


def test_derivatives_are_those_of_differences_while_pairs_stay_in_their_pixels():
    scene, method = nj.newton_rings(2.0, 500e-9, 1e-7, "reflected", screen=1e-3), nj.Splat(step=5e-6)
    source = nj.splat(scene, CAMERA, method).source

    def image(change):
        moved = eqx.tree_at(lambda s: s.surfaces[1].curvature, scene, 0.5 * (1 + change[0]))
        moved = eqx.tree_at(lambda s: s.light.wavelength, moved, 500e-9 * (1 + change[1]))
        return nj.spread(moved, CAMERA, method, source)[0]

    zero, step, at = jnp.zeros(2), 2e-5, compiled(image)
    slope = compiled(jax.jacfwd(image))(zero)
    weights = jnp.asarray(np.random.default_rng(0).random(CAMERA.shape))
    back = compiled(jax.grad(lambda change: jnp.sum(weights * image(change))))(zero)
    for k in range(2):
        move = step * jnp.eye(2)[k]
        difference = (at(move) - at(-move)) / (2 * step)
        # The rounding of the paths, 2e-11 turns, over the step: 3e-7 of an intensity of 0.1.
        assert np.abs(np.asarray(slope[..., k] - difference)).max() < 5e-7
        assert np.abs(np.asarray(difference)).max() > 3e-3
        assert float(back[k]) == pytest.approx(float(jnp.sum(weights * slope[..., k])), rel=1e-9)


def test_polarized_components_sum_as_intensities():
    images = [
        nj.splat(
            nj.newton_rings(2.0, 500e-9, polarization=angle, view="transmitted", screen=1e-3),
            CAMERA,
            nj.Splat(step=5e-6),
        ).image
        for angle in (None, 0.3, 0.3 + np.pi / 2)
    ]
    assert np.abs(np.asarray(images[0] - (images[1] + images[2]) / 2)).max() < 1e-12


def test_a_budget_and_what_cannot_be_honoured_are_said():
    scene = nj.newton_rings(2.0, 500e-9, view="transmitted", screen=1e-3)
    with pytest.raises(ValueError, match="budget of 100"):
        nj.splat(scene, CAMERA, nj.Splat(budget=100))
    with pytest.raises(ValueError, match="one beam"):
        nj.splat(nj.newton_rings(beams=["T0 T1 T2 T3"], view="transmitted", screen=1e-3), CAMERA)
    with pytest.raises(ValueError, match="traced"):
        jax.jit(lambda s: nj.render(s, CAMERA, nj.Splat()))(scene)
    with pytest.raises(ValueError, match="path difference"):
        nj.opd(scene, CAMERA, nj.Splat())
    for wrong in ({"step": 0.0}, {"epsilon": -1.0}, {"pairing": "x"}, {"path": "x"}):
        with pytest.raises(ValueError, match="allowed"):
            nj.Splat(**wrong)


def test_a_hole_in_the_frame_is_filled_to_its_edge():
    for radius in (3e-4, 5e-4):
        scene, camera = (
            nj.newton_rings(2.0, 500e-9, screen=1e-3, shield=radius, view="transmitted"),
            nj.Camera((120, 120), 1e-5),
        )
        found = nj.splat(scene, camera)
        lit = np.asarray(nj.render(scene, camera, nj.Traced())) > 0.5
        assert not np.any(found.hits[lit] == 0)
    small = dataclasses.replace(scene, shield=nj.Shield(5e-5, (1e-4, 1e-4, -5e-3)))
    assert nj.splat(small, camera).pairs.paired > 50


BAD = [
    (
        nj.newton_rings(-2.0, 500e-9, 1e-5, screen=1.0, view="transmitted"),
        nj.Camera((60, 60), 20e-6),
        {"epsilon": 1e-2},
    ),
    (nj.newton_rings(2.0, 500e-9, view="reflected", screen=1e-2), nj.Camera((60, 60), 20e-6), {"path": "raw"}),
    (nj.newton_rings(2.0, 500e-9, view="reflected", screen=3.0), nj.Camera((60, 60), 20e-6), {"epsilon": 1e-2}),
]


@pytest.mark.parametrize(("scene", "camera", "options"), BAD)
def test_the_stated_error_is_the_largest_of_all_pairs(scene, camera, options):
    """Against every pair of an even grid of nodes whose midpoint falls into the frame."""
    options = {"epsilon": 1e-2, **options}
    found = nj.splat(scene, camera, nj.Splat(step=100e-6, **options))
    width = (np.array(found.source.nodes) - 1) / 2 * found.source.step
    starts = np.stack(np.meshgrid(*(np.linspace(-w, w, 41) for w in width)), axis=-1).reshape(-1, 2)
    points, opd = compiled(separations)(scene, jnp.asarray(starts))
    if options.get("path") == "raw":
        opd = compiled(raw_difference)(scene, jnp.asarray(starts))
    middle = points.mean(axis=1)
    beams = compiled(arrivals_at)(scene, middle)
    wrong = np.abs(opd - beams.path[1] + beams.path[0]) / 500e-9
    wrong = wrong + np.abs(beams.quarter_turns[1] - beams.quarter_turns[0]) / 4
    inside = np.abs(np.asarray(middle)).max(axis=1) <= 30 * 20e-6
    worst = float(np.where(inside & np.asarray(beams.arrives.all(axis=0)), wrong, 0).max())
    assert worst <= found.error * 1.001
    assert found.error < 1.3 * worst + 0.26


def raw_difference(scene, starts):
    routes, setting = gather(scene)

    def node(start):
        one, two = (trace(jax.tree.map(lambda leaf, b=b: leaf[b], routes), setting, start)[0] for b in (0, 1))
        return two.path - one.path

    return jax.vmap(node)(starts)


def test_an_error_that_cannot_be_known_is_infinite():
    # A focus of one beam on the screen: most midpoints have no ray of it.
    scene = nj.newton_rings(2.0, 500e-9, view="reflected", screen=0.6633)
    assert nj.splat(scene, nj.Camera((60, 60), 20e-6), nj.Splat(step=100e-6, epsilon=1e-2)).error > 0.2
    one = nj.Splat(pairing="pixel", epsilon=1e-8, step=2e-5)
    scene = nj.newton_rings(2.0, 500e-9, view="reflected", screen=1e-2)
    assert nj.splat(scene, nj.Camera((60, 60), 20e-6), one).error > 3e-5
