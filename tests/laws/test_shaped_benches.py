"""Laws of optics on benches whose lens is no sphere: every kind by one program, tilted and decentred."""

import dataclasses
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import oracles
import pytest
from compilations import QUICKLY
from mpmath import mpf
from shaped import FIGURE, KINDS, NOLL, shape, zernike

import newtonjax as nj
from newtonjax.fields import arrivals, pack, path_difference
from newtonjax.rays import carry_field, gather, trace
from newtonjax.rays.tube import shoot
from newtonjax.scene import REFLECT, frame, itinerary

WAVELENGTH = 500e-9
POINTS = np.array([[0.0, 0.0], [1.6e-3, -1.8e-3]])
LEANING = {"lens_tilt": (3e-3, -5e-3), "plate_tilt": (-2e-3, 4e-3), "light_tilt": (0.02, -0.03)}
VERTEX = (3e-4, -2e-4, 20e-6)
# The paths are some 30 mm long, of which a double rounds off 7e-12 turns at every operation.
TURNS = 1e-9


def bench(kind, view="reflected"):
    """The bench, and its faces at 50 digits."""
    words = {"gap": 20e-6, "screen": 3e-3, "view": view, **LEANING}
    scene = nj.newton_rings(0.1, WAVELENGTH, **words)
    drawn = shape(kind, VERTEX, LEANING["lens_tilt"])
    faces = list(scene.surfaces)
    faces[1] = drawn.ours()
    exact = oracles.rings(radius=0.1, **words)
    exact.faces[1] = drawn
    return dataclasses.replace(scene, surfaces=tuple(faces)), exact


@pytest.mark.parametrize(("kind", "view"), [*((kind, "reflected") for kind in KINDS), ("all", "transmitted")])
def test_path_differences_are_exact_to_1e_9_turns(kind, view, record_property):
    scene, exact = bench(kind, view)
    packed = pack(scene)
    ours, arrives = path_difference(arrivals(packed, POINTS), packed.pairs)
    assert arrives.all()
    words = {"transmitted": oracles.TRANSMITTED, "reflected": oracles.REFLECTED}[view]
    theirs = [float(exact.opd(words, x, y)) for x, y in POINTS.tolist()]
    error = np.abs(ours - theirs).max() / WAVELENGTH
    record_property("turns", float(error))
    assert error < TURNS


def test_both_faces_of_a_gap_may_have_a_shape():
    scene, exact = bench("all")
    drawn = shape("toroid", (-1e-4, 2e-4, 0.0), LEANING["plate_tilt"])
    scene = dataclasses.replace(scene, surfaces=(*scene.surfaces[:2], drawn.ours(), scene.surfaces[3]))
    exact.faces[2] = drawn
    packed = pack(scene)
    ours, arrives = path_difference(arrivals(packed, POINTS), packed.pairs)
    assert arrives.all()
    theirs = [float(exact.opd(oracles.REFLECTED, x, y)) for x, y in POINTS.tolist()]
    assert np.abs(ours - theirs).max() / WAVELENGTH < TURNS


@partial(jax.jit, compiler_options=QUICKLY)
def follow(routes, setting, starts):
    """Landings, legs, and slopes of tubes."""

    def one_ray(route, start):
        landing, legs = trace(route, setting, start)
        return landing, legs, jnp.stack(shoot(route, setting, start).slope)

    return jax.vmap(jax.vmap(one_ray, (None, 0)), (0, None))(routes, starts)


STARTS = np.random.default_rng(3).uniform(-2e-3, 2e-3, (4, 2))


@pytest.mark.parametrize("kind", KINDS)
def test_the_slope_of_a_tube_is_that_of_its_neighbours(kind):
    bundle = gather(bench(kind)[0], 8)
    landing, _, slope = follow(*bundle, STARTS)
    assert np.all(landing.alive)
    h = 1e-6  # the landing's rounding over it is 1e-12, its square times the third derivative as small
    for axis in range(2):
        ends = [follow(*bundle, STARTS + sign * h * np.eye(2)[axis])[0].point for sign in (1, -1)]
        np.testing.assert_allclose(slope[..., axis], (ends[0] - ends[1]) / (2 * h), rtol=0, atol=2e-9)


@partial(jax.jit, compiler_options=QUICKLY)
def fluxes(routes, setting, legs):
    """Of each beam behind its first and its second interaction, summed over both components."""

    def of(route, legs, count):
        route, legs = jax.tree.map(lambda leaf: leaf[:count], (route, legs))
        return (jnp.abs(carry_field(route, setting, legs)) ** 2).sum()

    both = [jax.vmap(jax.vmap(lambda r, g, n=n: of(r, g, n), (None, 0)))(routes, legs) for n in (1, 2)]
    return jnp.stack(both)


@pytest.mark.parametrize("kind", KINDS)
def test_what_a_shape_reflects_and_what_it_passes_on_is_what_came(kind):
    """The square of a field is its tube's flux. At the lens's face one beam is reflected, the other goes through."""
    routes, setting = gather(bench(kind)[0], 8)
    _, legs, *_ = follow(routes, setting, STARTS)
    came, (reflected, passed) = fluxes(routes, setting, legs)
    np.testing.assert_allclose(reflected + passed, came[0], rtol=1e-14)
    assert (reflected > 0.01 * passed).all()


@pytest.mark.parametrize("view", ["reflected", "transmitted"])
def test_a_figure_changes_a_path_as_fermat_says(view):
    """By Σ (n₁ d_in - n₂ d_out)·z Z_j(hit), over the meetings with it; to first order the ray may stay as it is."""
    scene, _ = bench("zernike", view)

    def paths(coefficients):
        changed = eqx.tree_at(lambda s: s.surfaces[1].figure.coefficients, scene, coefficients)
        return arrivals(pack(changed), POINTS).path

    h = 3e-9  # the paths' rounding over it is 3e-9, its square times the third derivative 1e-8
    units = h * np.eye(len(FIGURE))
    slope = np.stack([(paths(FIGURE + unit) - paths(FIGURE - unit)) / (2 * h) for unit in units])
    starts = arrivals(pack(scene), POINTS).start
    routes, setting = gather(scene, 8)
    lens, count = scene.surfaces[1], len(FIGURE)
    axes = np.stack(frame(lens.tilt))
    for beam, word in enumerate(scene.beams):
        rays = follow(routes, setting, np.concatenate([starts[beam]] * 2))
        landing, legs, *_ = jax.tree.map(lambda leaf, beam=beam: np.asarray(leaf)[beam], rays)
        path, by_hand = itinerary(word, 4), np.zeros((len(STARTS), count))
        outward = np.concatenate([legs.direction[:, 1:], landing.direction[:, None]], axis=1)
        for k, (met, action) in enumerate(zip(path.surface, path.action, strict=True)):
            if met != 1:
                continue
            n1 = scene.media[path.before[k]]
            n2 = n1 if action == REFLECT else scene.media[path.beyond[k]]
            hit = legs.position[:, k] + legs.length[:, k, None] * legs.direction[:, k] - lens.vertex
            x, y = hit @ axes[0], hit @ axes[1]
            change = (n1 * legs.direction[:, k] - n2 * outward[:, k]) @ axes[2]
            rho, theta = np.hypot(x, y) / lens.figure.radius, np.arctan2(y, x)
            for j in range(count):
                terms = [float(zernike(*NOLL[j], mpf(a), mpf(b))) for a, b in zip(rho, theta, strict=True)]
                by_hand[:, j] += change * terms
        np.testing.assert_allclose(slope[:, beam].T, by_hand[: len(POINTS)], rtol=0, atol=3e-8)


def turned(face):
    """A face rotated with its bench by half a turn about x: y and z change their sign."""
    flip = np.array([1.0, -1.0, -1.0])
    words = {
        "conic": face.conic,
        "asphere": None if face.asphere is None else -face.asphere,
        "odd_asphere": None if face.odd_asphere is None else -face.odd_asphere,
        "curvature_across": None if face.curvature_across is None else -face.curvature_across,
        "axis": None if face.axis is None else -face.axis,
    }
    if face.figure is not None:  # sines are odd in y
        signs = np.array([1.0 if m < 0 else -1.0 for _, m in NOLL])
        words["figure"] = nj.Zernike(signs * face.figure.coefficients, face.figure.radius)
    return nj.Surface(-face.curvature, face.vertex * flip, (face.tilt[0], -face.tilt[1]), **words)


@pytest.mark.parametrize("kind", KINDS)
def test_light_sent_backwards_retraces_its_path(kind):
    scene, _ = bench(kind, "transmitted")
    landing = jax.tree.map(lambda leaf: np.asarray(leaf)[1], follow(*gather(scene, 8), STARTS)[0])
    flip, at = np.array([1.0, -1.0, -1.0]), 2
    x, y, z = landing.direction[at] * flip  # light along -z, turned
    back = [" ".join(f"{token[0]}{3 - int(token[1])}" for token in reversed(w.split())) for w in scene.beams]
    reverse = nj.Scene(
        tuple(turned(face) for face in reversed(scene.surfaces)),
        scene.media[::-1],
        nj.Light(WAVELENGTH, (np.arcsin(-y), np.arctan2(x, z))),
        turned(nj.Surface(0.0, scene.surfaces[0].vertex, scene.light.tilt)),
        tuple(back),
    )
    there = landing.position[at] + landing.length[at] * landing.direction[at]
    offset = np.stack(frame(reverse.light.tilt)) @ (there * flip - reverse.surfaces[0].vertex)
    again = follow(*gather(reverse, 8), np.broadcast_to(offset[:2], STARTS.shape))[0]
    # A screen turned over has its y axis reversed. Rounding of positions of some 10 mm.
    np.testing.assert_allclose(again.point[1, 0], STARTS[at] * [1, -1], atol=1e-16)
    # The reversed light counts from a plane that the landing point stands offset[2] before; 40 roundings of 16 mm.
    assert abs(again.path[1, 0] + offset[2] - landing.path[at]) < 8e-17
