"""A bench packed into arrays of fixed sizes has the rays that its own program would trace, and needs no program."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from compilations import compilations

import newtonjax as nj
from newtonjax.fields import at_points, packed
from newtonjax.rays import arrive_all
from newtonjax.scene import REST, node_points

CAMERA = nj.Camera((40, 50), 8e-6, centre_px=(3.0, 20.5))
POINTS = np.asarray(node_points(CAMERA, 9))
MANY_POINTS = np.tile(POINTS, (21, 1))  # more than calls of few points work through


def lit(scene, **light):
    return dataclasses.replace(scene, light=dataclasses.replace(scene.light, **light))


RINGS = nj.newton_rings(0.7, 500e-9, 1e-6, "reflected", lens_tilt=(2e-3, -1e-3), light_tilt=(0.02, 0.01), screen=1e-3)
SCENES = {
    "one beam": nj.newton_rings(0.7, beams=["R1"], view="reflected", screen=1e-3),
    "reflected, tilted": RINGS,
    "linear": lit(RINGS, polarization=0.4),
    "elliptical, partial": lit(RINGS, polarization=0.4, ellipticity=0.2, degree=0.6),
    "collecting lens, shield": nj.newton_rings(0.5, collecting_lens=0.05, screen=0.5, shield=2e-5, view="transmitted"),
    "wedge, three beams": nj.air_wedge(
        1e-3, gap=2e-6, screen=1e-3, view="transmitted", beams=["direct", "R2-R1", "R3-R2"]
    ),
    "four beams, twelve interactions": nj.newton_rings(
        0.2, beams=["R1", "R2", "R2-R1-R2", "R2-R1-R2-R1-R2"], view="reflected", plate_tilt=(1e-3, 0.0), screen=1e-3
    ),
}


@pytest.mark.parametrize("name", SCENES)
def test_packed_rays_are_those_of_the_benchs_own_program(name):
    """Phases bit for bit but for a last digit of a path here and there; envelopes, which are below 1, to rounding."""
    scene = SCENES[name]
    own = jax.tree.map(np.asarray, jax.jit(at_points.fields_at)(scene, POINTS))
    bench = packed.pack(scene)
    arrival = packed.arrivals(bench, POINTS)
    ours = packed.node_fields(bench, arrival)
    assert all(isinstance(leaf, np.ndarray) for leaf in (*ours, *arrival))
    np.testing.assert_array_equal(ours.arrives, own.arrives)
    assert np.sum(ours.phase != own.phase) <= 0.1 * own.phase.size
    assert (np.abs(ours.phase - own.phase) <= own.rounding / 4).all()  # two last digits of the longest path
    np.testing.assert_allclose(ours.rounding, own.rounding, rtol=1e-15)
    np.testing.assert_allclose(ours.envelope, own.envelope, rtol=0, atol=1e-15)
    np.testing.assert_allclose(ours.background, own.background, rtol=0, atol=1e-15)


def test_a_shield_is_seen_by_packed_rays():
    reached = packed.arrivals(packed.pack(SCENES["collecting lens, shield"]), POINTS).arrives
    assert reached.any()
    assert not reached.all()


@pytest.mark.parametrize("number", [1, 97, 98, 99, 1024, 1685, 1686])
@pytest.mark.parametrize("name", SCENES)
def test_any_number_of_points_is_worked_through_in_parts(name, number):
    """Bit for bit, by the program of few points as by that of many; behind a shield and beyond a sphere too."""
    points = np.random.default_rng(1).uniform(-2e-4, 2e-4, (2100, 2))
    points[[3, 80, 1500]] *= 1e6
    bench = packed.pack(SCENES[name])
    of_all, of_some = packed.arrivals(bench, points), packed.arrivals(bench, points[:number])
    assert of_some.path.shape == (len(SCENES[name].beams), number)
    assert "wedge" in name or not of_all.arrives[:, 3].any()
    for ours, expected in zip(of_some, of_all, strict=True):
        np.testing.assert_array_equal(ours, expected[:, :number])


def test_rests_left_out_change_nothing():
    """Bit for bit what the program that may be differentiated makes, which goes through the rests."""
    with_rests = jax.jit(arrive_all, compiler_options=packed.OPTIONS)
    points = POINTS[: packed.FEW[1]]
    for scene in SCENES.values():
        bench = packed.pack(scene)
        if bench.routes.action.shape[1] > packed.INTERACTIONS:
            continue
        routes = jax.tree.map(lambda leaf: leaf[[0, len(leaf) - 1]], bench.routes)
        assert (routes.action[:, -1] == REST).all()
        expected, ours = (rays(routes, bench.setting, points) for rays in (with_rests, packed.rays))
        jax.tree.map(np.testing.assert_array_equal, ours, expected)


def test_an_image_of_one_pixel_is_that_of_a_transformation():
    camera, method = nj.Camera((1, 1), 1e-5, centre_px=(7.0, -4.0)), nj.Chebyshev(3)
    traced = jax.jit(lambda scene: nj.render(scene, camera, method))(RINGS)
    np.testing.assert_allclose(nj.render(RINGS, camera, method), traced, rtol=1e-9)


def test_benches_of_all_kinds_share_four_programs():
    """Of few points and of many, for up to 8 interactions and for up to 16; packing compiles nothing."""
    jax.clear_caches()
    with compilations() as compiled:
        for scene in SCENES.values():
            bench = packed.pack(scene)
            for points in (MANY_POINTS, POINTS, POINTS[:1]):
                packed.node_fields(bench, packed.arrivals(bench, points))
    assert compiled.count == 4


@pytest.mark.parametrize("name", ["reflected, tilted", "wedge, three beams", "collecting lens, shield"])
def test_a_plan_and_its_image_take_one_program_of_rays(name):
    """That of few points, behind a shield too: a fresh process compiles no other one, whichever nodes it takes."""
    jax.clear_caches()
    with compilations() as compiled:
        nj.plan(SCENES[name], CAMERA)
        for nodes in (5, 17, 41):
            packed.node_arrivals(packed.pack(SCENES[name]), CAMERA, nodes)
    assert compiled.count == 1


def test_a_bench_packs_under_a_transformation_and_keeps_its_derivative():
    """The phase's derivative in the gap, through the packed arrays: two over the wavelength, on the axis."""

    def phase(gap):
        bench = packed.pack(nj.newton_rings(0.7, 500e-9, gap, "reflected", screen=1e-3))
        return packed.node_fields(bench, arrive_all(bench.routes, bench.setting, jnp.zeros((1, 2)))).phase[0, 0]

    assert float(jax.jit(jax.grad(phase))(1e-6)) == pytest.approx(2 / 500e-9, rel=1e-12)


def test_packed_rays_are_in_float64_whatever_jax_is_set_to():
    jax.config.update("jax_enable_x64", False)
    try:
        bench = packed.pack(RINGS)
        ours = packed.node_fields(bench, packed.arrivals(bench, POINTS))
    finally:
        jax.config.update("jax_enable_x64", True)
    assert ours.phase.dtype == np.float64
    np.testing.assert_array_equal(ours.phase, packed.node_fields(bench, packed.arrivals(bench, POINTS)).phase)


@pytest.mark.parametrize("points", [POINTS, MANY_POINTS], ids=["few", "many"])
def test_rays_of_known_benches_are_constants_of_a_users_program(points):
    """Their program has options of its own, which JAX refuses for one that is traced as a part of another."""

    def scaled(x):
        return x * packed.arrivals(packed.pack(RINGS), points).path.max()

    longest = packed.arrivals(packed.pack(RINGS), points).path.max()
    assert float(jax.jit(scaled)(2.0)) == pytest.approx(2 * longest, rel=1e-15)
    assert float(jax.grad(scaled)(2.0)) == pytest.approx(longest, rel=1e-15)
    np.testing.assert_allclose(jax.vmap(scaled)(jnp.arange(3.0)), np.arange(3) * longest, rtol=1e-15)
