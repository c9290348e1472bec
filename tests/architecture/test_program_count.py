"""How many programs benches of all kinds need: their number does not grow with the number of benches."""

import dataclasses

import jax.numpy as jnp
import numpy as np
from compilations import compilations

import newtonjax as nj

SHAPES = ((24, 40), (31, 31), (50, 20))
# Beams by name, as many as fill one or two calls of the program of rays, with up to 8 interactions.
BEAMS = {"reflected": ["R1", "R2", "R0", "R3"], "transmitted": ["direct", "R2-R1", "R1-R0", "R3-R2"]}
STATES = ({}, {"polarization": 0.3}, {"polarization": 1.0, "ellipticity": 0.2, "degree": 0.5})


def random_bench(rng):
    """A bench of any kind: rings or a wedge, tilts, state of the light, one to four beams, lens and shield."""
    view = str(rng.choice(list(BEAMS)))
    number = int(rng.integers(1, 5))
    tilts = {name: tuple(rng.normal(0, 1e-3, 2)) for name in ("plate_tilt", "light_tilt") if rng.random() < 0.5}
    common = {
        "view": view,
        "gap": rng.uniform(0, 2e-6),
        "lens_index": rng.uniform(1.4, 1.8),
        "beams": BEAMS[view][:number],
    }
    if rng.random() < 0.3:
        scene = nj.air_wedge(rng.uniform(1e-4, 1e-3), **common, light_tilt=tilts.get("light_tilt", (0.0, 0.0)))
    else:
        beside = {"collecting_lens": 0.05, "screen": 0.5} if rng.random() < 0.3 else {"screen": rng.uniform(0, 1e-2)}
        shield = 1e-2 if rng.random() < 0.3 else None
        scene = nj.newton_rings(rng.uniform(0.2, 2), **common, **tilts, **beside, shield=shield)
    light = dataclasses.replace(scene.light, **STATES[rng.integers(3)])
    return dataclasses.replace(scene, light=light)


def test_a_hundred_benches_are_planned_and_traced_by_one_program():
    """Whatever camera they have; shapes are new ones each time."""
    rng = np.random.default_rng(5)
    nj.plan(random_bench(rng), nj.Camera((9, 9), 1e-5))
    with compilations() as compiled:
        for number in range(100):
            camera = nj.Camera((300 + number, 500 - number), 10 ** rng.uniform(-6, -5))
            nj.plan(random_bench(rng), camera, 10 ** rng.uniform(-6, -2))
    assert compiled.count == 0


def test_a_hundred_images_take_a_few_programs_a_shape():
    """Nodes: by one or more pairs of beams, and classes of nodes. A new bench of the shape then takes none."""
    rng = np.random.default_rng(6)
    benches = [(random_bench(rng), nj.Camera(SHAPES[number % 3], 1e-5)) for number in range(100)]
    methods = (nj.Chebyshev(5), nj.Chebyshev(17))
    with compilations() as compiled:
        for number, (scene, camera) in enumerate(benches):
            nj.render(scene, camera, methods[number // 3 % 2])
    assert compiled.count <= 1 + 3 * 2 * 4
    with compilations() as compiled:
        for number, (scene, camera) in enumerate(benches):
            nj.render(scene, camera, methods[number // 3 % 2])
    assert compiled.count == 0


def test_blocks_of_another_bench_take_no_program():
    rng = np.random.default_rng(7)
    camera = nj.Camera((90, 40), 1e-5)

    def go_through(scene):
        return sum(len(rows) for _, rows in nj.blocks(scene, camera, nj.Chebyshev(5), rows=20))

    go_through(random_bench(rng))
    scenes = [nj.newton_rings(radius, gap=1e-6, view="transmitted", screen=1e-3) for radius in (0.5, 1.0, 2.0)]
    go_through(scenes[0])
    with compilations() as compiled:
        assert [go_through(scene) for scene in scenes] == [90, 90, 90]
    assert compiled.count == 0


def test_a_sweep_over_another_bench_takes_no_program():
    camera = nj.Camera(SHAPES[0], 1e-5)

    def sweep(bench):
        return nj.sweep(bench, {"radius": [0.5, 1.0, 2.0]}, camera, nj.Chebyshev(5), reduce=jnp.mean, batch=2)

    sweep(nj.newton_rings)
    with compilations() as compiled:
        for gap in (1e-6, 2e-6):
            sweep(
                lambda radius, gap=gap: nj.newton_rings(
                    radius, gap=gap, view="reflected", plate_tilt=(1e-3, 0.0), screen=1e-3
                )
            )
    assert compiled.count == 0


def test_normal_equations_of_another_bench_take_one_small_program():
    """From the parameters to its numbers; those from there to the nodes, and of the pixels, serve all benches."""
    camera = nj.Camera(SHAPES[0], 1e-5)

    def solve(bench):
        return nj.normal_equations(bench, np.array([1.0, 1e-6]), camera, method=nj.Chebyshev(5))

    with compilations() as compiled:
        solve(lambda p: nj.newton_rings(p[0], gap=p[1], view="transmitted", screen=1e-3))
    # The rays, the bench's numbers, the nodes' changes, the sums; and what JAX cuts out of the vector and adds up.
    assert compiled.count <= 9
    with compilations() as compiled:
        solve(lambda p: nj.newton_rings(p[0], gap=p[1], view="reflected", plate_tilt=(1e-3, 0.0), screen=1e-3))
    assert compiled.count <= 2  # with a sum of numbers that the first bench had not
