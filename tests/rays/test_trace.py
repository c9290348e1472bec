"""The tracer against a trace at 50 digits that shares no code with it."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import oracles
import pytest

import newtonjax as nj
from newtonjax.fields import opd_at
from newtonjax.rays import gather, trace
from newtonjax.rays.tube import shoot

WAVELENGTH = 500e-9
POINTS = np.array([[0.0, 0.0], [2.5e-3, 0.0], [0.0, -1.7e-3], [1.9e-3, 2.2e-3], [-1e-6, 3e-6]])
LEANING = {"lens_tilt": (3e-3, -5e-3), "plate_tilt": (-2e-3, 4e-3), "light_tilt": (0.02, -0.03)}
BENCHES = {
    "contact": {},
    "gap": {"gap": 12.3e-6},
    "negative gap": {"gap": -0.4e-6},
    "screen at 80 mm": {"screen": 80e-3},
    "focused on the gap": {"screen": "gap"},
    "small sphere": {"radius": 0.1, "screen": "gap", "gap": 1e-6},
    "concave": {"radius": -3.0, "gap": 20e-6},
    "lens tilted": {"lens_tilt": LEANING["lens_tilt"]},
    "plate tilted": {"plate_tilt": LEANING["plate_tilt"], "gap": 5e-6},
    "light tilted": {"light_tilt": LEANING["light_tilt"], "screen": 10e-3},
    "all tilted, 80 mm": {**LEANING, "screen": 80e-3, "gap": 1e-6},
    "liquid, unlike glasses": {"gap_index": 1.33, "lens_index": 1.62, "plate_index": 1.46, "ambient_index": 1.00027},
}
WORDS = {"transmitted": oracles.TRANSMITTED, "reflected": oracles.REFLECTED}
# The paths are up to 100 mm long, of which a double rounds off 2e-11 turns at every operation.
TURNS = 1e-9

opds = jax.jit(jax.vmap(opd_at))


def stack(scenes):
    return jax.tree.map(lambda *leaves: jnp.stack([jnp.asarray(leaf, dtype=float) for leaf in leaves]), *scenes)


def largest_difference(scenes, benches, words, points=POINTS):
    """Largest error [turns] of the scenes' path differences; the scenes are padded to one batch size."""
    padding = 12 - len(scenes)
    batch = stack([*scenes, *scenes[:1] * padding])
    ours, arrives = (np.asarray(a) for a in opds(batch, jnp.broadcast_to(points, (12, *points.shape))))
    assert arrives.all()
    exact = [[float(bench.opd(words, x, y)) for x, y in points.tolist()] for bench in benches]
    return np.abs(ours[: len(scenes)] - np.array(exact)).max() / WAVELENGTH


@pytest.mark.parametrize("view", WORDS)
def test_path_difference_of_the_rings_is_exact_to_1e_9_turns(view, record_property):
    scenes = [
        nj.newton_rings(wavelength=WAVELENGTH, **{"radius": 2.0, "screen": 1e-3, **b}, view=view)
        for b in BENCHES.values()
    ]
    error = largest_difference(scenes, [oracles.rings(view, **bench) for bench in BENCHES.values()], WORDS[view])
    record_property("turns", float(error))
    assert error < TURNS


@pytest.mark.parametrize("view", WORDS)
def test_path_difference_stays_exact_with_each_surface_tilted_alone(view, record_property):
    tilt = (4e-3, -7e-3)
    scene = nj.newton_rings(2.0, WAVELENGTH, gap=3e-6, view=view, screen=20e-3)
    places = [lambda s, k=k: s.surfaces[k].tilt for k in range(4)] + [lambda s: s.screen.tilt]
    scenes = [eqx.tree_at(place, scene, np.array(tilt)) for place in places]
    benches = [oracles.rings(view, gap=3e-6, screen=20e-3) for _ in places]
    for k in range(4):
        benches[k].faces[k].tilt = tilt
    benches[4].screen.tilt = tilt
    error = largest_difference(scenes, benches, WORDS[view])
    record_property("turns", float(error))
    assert error < TURNS


@pytest.mark.parametrize("view", WORDS)
def test_path_difference_of_the_wedge_is_exact_to_1e_9_turns(view, record_property):
    angles = [1e-4, -3e-3, 0.02]
    more = [
        {"screen": "gap"},
        {"screen": 30e-3, "gap": 4e-6},
        {"light_tilt": (0.01, 0.02), "gap": 80e-6, "screen": 1e-3},
    ]
    scenes = [nj.air_wedge(a, WAVELENGTH, view=view, **m) for a, m in zip(angles, more, strict=True)]
    benches = [
        oracles.rings(view, radius=float("inf"), lens_tilt=(0.0, -a), **m) for a, m in zip(angles, more, strict=True)
    ]
    error = largest_difference(scenes, benches, WORDS[view])
    record_property("turns", float(error))
    assert error < TURNS


def test_the_paths_of_the_longest_bench_are_near_100_mm():
    bench = oracles.rings("reflected", screen=80e-3)
    near = dataclasses.replace(bench, launch=[0, 0, oracles.mpf("5e-3")])
    assert 0.09 < near.path(oracles.REFLECTED[1], 0.0, 0.0) < 0.1


@pytest.mark.parametrize("view", ["reflected", "transmitted"])
def test_the_slope_of_a_tube_is_the_automatic_derivative_of_its_ray(view):
    """Whatever is tilted, through a collecting lens, for words with rests and up to four reflections."""
    names = {"reflected": ["R1", "R2", "R2-R1-R2"], "transmitted": ["direct", "R2-R1", "R2-R1-R2-R1"]}[view]
    scene = nj.newton_rings(
        0.3, 500e-9, 1e-6, view, lens_tilt=(2e-2, -1e-2), plate_tilt=(1e-2, 3e-2), light_tilt=(0.03, 0.1), beams=names,
        collecting_lens=0.05, screen=0.5,
    )  # fmt: skip
    routes, setting = gather(scene, 16)
    starts = jnp.asarray(np.random.default_rng(3).uniform(-3e-3, 3e-3, (20, 2)))

    def both(route, start):
        by_hand = jnp.stack(shoot(route, setting, start).slope)
        return by_hand, jax.jacfwd(lambda start: trace(route, setting, start)[0].point)(start)

    ours, automatic = jax.jit(jax.vmap(jax.vmap(both, (None, 0)), (0, None)))(routes, starts)
    size = np.abs(automatic).max(axis=(-2, -1), keepdims=True)
    np.testing.assert_allclose(ours / size, automatic / size, rtol=0, atol=1e-13)
