"""Jets: every formula's tangents are JAX's, to second order, and a traced bench's fields with them."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from compilations import compilations

import newtonjax as nj
from newtonjax.fields import jet_fields, pairs, polar
from newtonjax.fields.at_points import combine
from newtonjax.numerics import Jet, jets, value_of
from newtonjax.rays import arrive_all, gather
from newtonjax.scene import Light, source_of

LEVELS = 3  # the launch plane's, then first and second derivatives
POINTS = np.array([[0.0, 1e-3, -2e-3, 0.4e-3], [0.0, -1e-3, 0.5e-3, 2e-3]])
BENCHES = {
    "reflected": nj.newton_rings(2.0, 550e-9, 0.3e-6, "reflected", screen=20e-3, light_tilt=(0.1, 0.06),
                                 plate_tilt=(1e-4, 2e-4), lens_tilt=(0.0, 1e-3)),
    "transmitted": nj.newton_rings(2.0, 550e-9, 1e-6, "transmitted", screen=20e-3),
    "contact at normal incidence": nj.newton_rings(1.0, 550e-9, 0.0, "reflected", screen="gap"),
    "flat": nj.newton_rings(np.inf, 550e-9, 0.2e-6, "reflected", screen=1e-3, light_tilt=(0.01, 0.0)),
    "equal indices": nj.newton_rings(1.0, 550e-9, 1e-6, "transmitted", lens_index=1.5, gap_index=1.5, screen=1e-3),
    "elliptic": replace(nj.newton_rings(2.0, 550e-9, 0.3e-6, "reflected", screen="gap"),
                        light=Light(550e-9, (0.01, 0.02), 0.3, 0.2, 0.7)),
    "beyond a focus": nj.newton_rings(0.02, 550e-9, 1e-6, "reflected", screen=0.2),
}  # fmt: skip


def as_jets(scene, directions):
    """Every number of a scene with a first tangent in one direction, and a second in another."""
    leaves, tree = jax.tree.flatten(scene)
    made = []
    for leaf, one, two in zip(leaves, *directions, strict=True):
        value = np.asarray(leaf, float)
        first = jets.variable(value, np.full((1, *value.shape), one), 1, LEVELS)
        made.append(first + jets.variable(np.zeros_like(value), np.full((1, *value.shape), two), 2, LEVELS))
    return jax.tree.unflatten(tree, made)


def split_off(tree):
    """The floating numbers of a tree, and a function that puts others in their place."""
    leaves, structure = jax.tree.flatten(tree)
    floats = [k for k, leaf in enumerate(leaves) if isinstance(leaf, float) or leaf.dtype.kind == "f"]

    def with_others(numbers):
        changed = dict(zip(floats, numbers, strict=True))
        return jax.tree.unflatten(structure, [changed.get(k, leaf) for k, leaf in enumerate(leaves)])

    return [leaves[k] for k in floats], with_others


@jax.jit
def expected(packed, numbers, tangents):
    """Fields and their derivatives by packed numbers, by JAX: one program for all benches."""
    _, with_others = split_off(packed)

    def fields(numbers):
        routes, setting, source, field = with_others(numbers)
        setting = setting._replace(field=jax.lax.complex(*field))
        made = combine(arrive_all(routes, setting, jnp.asarray(POINTS.T)), np.array([[0, 1]]), source)
        return jnp.stack([made.background, made.envelope[0].real, made.envelope[0].imag, made.phase[0]])

    return jax.jvp(fields, (numbers,), (tangents,))


def packed_parts(scene):
    """As `packed.pack` of one pair of beams, with the launched field as two real numbers."""
    routes, setting = gather(scene, 8)
    field = jets.asarray(setting.field)
    fields = (field.real, field.imag)
    order = np.array(pairs(scene)[0])
    routes = jax.tree.map(lambda part: part[order], routes)
    return routes, setting._replace(field=np.zeros(0)), source_of(scene.light), fields


def directions(scene):
    """Two random ones in all of its numbers at once."""
    sizes = np.array([0.1 * np.abs(np.asarray(leaf)).max() or 1e-3 for leaf in jax.tree.leaves(scene)])
    return np.random.default_rng(1).normal(size=(2, len(sizes))) * sizes


def jet_table(scene):
    """Background, envelope and phase at the points."""
    points = Jet(POINTS[:, None].reshape((1,) * LEVELS + (2, 1, -1)), LEVELS)
    made = jet_fields.fields(jet_fields.courses([scene]), points)
    assert made.arrives.all()
    return jets.stack([made.background[0], made.envelope[0].real, made.envelope[0].imag, made.phase[0]])


@pytest.mark.parametrize("name", BENCHES)
def test_fields_and_their_derivatives_are_those_of_the_traced_bench(name):
    moving = as_jets(BENCHES[name], directions(BENCHES[name]))
    numbers, _ = split_off(packed_parts(moving))
    at = [np.asarray(value_of(number), float) for number in numbers]
    tangents = [
        jets.full(number, (1, 2, 2)).parts[0, 1, 0] if isinstance(number, Jet) else np.zeros_like(value)
        for number, value in zip(numbers, at, strict=True)
    ]
    value, first = expected(packed_parts(BENCHES[name]), at, tangents)
    with compilations() as compiled:
        ours = jet_table(moving)
    assert compiled.count == 0
    # Paths of a tenth of a metre are 1e-10 wavelengths' rounding; derivatives lose as much of their size.
    np.testing.assert_allclose(ours.value, value, rtol=1e-12, atol=2e-10)
    for mine, theirs in zip(ours.parts[0, 1, 0], np.asarray(first), strict=True):
        np.testing.assert_allclose(mine, theirs, rtol=1e-8, atol=1e-9 * max(np.abs(theirs).max(), 1e-6))


@pytest.mark.parametrize("name", BENCHES)
def test_second_derivatives_are_differences_of_the_first(name):
    scene = BENCHES[name]
    one, two = directions(scene)
    leaves, tree = jax.tree.flatten(scene)

    def slope(step):
        moved = [np.asarray(leaf, float) + step * by for leaf, by in zip(leaves, two, strict=True)]
        return jet_table(as_jets(jax.tree.unflatten(tree, moved), (one, two))).parts[0, 1, 0]

    ours = jet_table(as_jets(scene, (one, two))).parts[0, 1, 1]
    near, far = ((slope(step) - slope(-step)) / (2 * step) for step in (1e-4, 2e-4))
    for mine, theirs in zip(ours, (4 * near - far) / 3, strict=True):
        np.testing.assert_allclose(mine, theirs, rtol=1e-5, atol=1e-6 * max(np.abs(theirs).max(), 1e-4))


@pytest.mark.parametrize("name", ["reflected", "elliptic"])
def test_packed_numbers_have_the_tangents_of_differences(name):
    scene = BENCHES[name]
    leaves, tree = jax.tree.flatten(scene)
    direction = np.random.default_rng(2).normal(size=len(leaves))
    numbers, _ = split_off(packed_parts(as_jets(scene, (direction, 0 * direction))))

    def at(step):
        moved = [np.asarray(leaf, float) + step * by for leaf, by in zip(leaves, direction, strict=True)]
        return split_off(packed_parts(jax.tree.unflatten(tree, moved)))[0]

    for number, more, less in zip(numbers, at(1e-6), at(-1e-6), strict=True):
        if np.isinf(more).any():  # the radius of no shield's hole
            continue
        slope = number.parts[0, 1, 0] if isinstance(number, Jet) else 0.0
        np.testing.assert_allclose(slope, (np.asarray(more) - np.asarray(less)) / 2e-6, rtol=1e-7, atol=1e-7)


def test_coefficients_are_those_of_the_polar_form():
    scene, camera = BENCHES["elliptic"], nj.Camera((40, 50), 50e-6, centre_px=(20.0, 22.0))
    points = jet_fields.node_points(camera, 9)
    made = jet_fields.fields(jet_fields.courses([scene]), Jet(points[None, :, None], 1))
    ours = jet_fields.coefficients(made).value[0]
    method = nj.Chebyshev(9)
    np.testing.assert_allclose(ours, method.coefficients(method.fields(scene, camera)), atol=1e-10)
    modulus, _ = polar(method.fields(scene, camera))
    assert np.abs(np.asarray(modulus)).max() > 0


def test_benches_side_by_side_are_those_alone():
    oblique = {"gap": 0.3e-6, "light_tilt": (0.2, 0.1), "polarization": 0.3, "screen": 1e-3}
    scenes = [nj.newton_rings(1.0, 550e-9, **oblique), nj.newton_rings(2.0, 500e-9, polarization_degree=0.4, **oblique)]
    points = Jet(np.stack([POINTS, 0.5 * POINTS], axis=1)[None], 1)
    both = jet_fields.fields(jet_fields.courses(scenes), points)
    for k, scene in enumerate(scenes):
        alone = jet_fields.fields(jet_fields.courses([scene]), points[:, k : k + 1])
        np.testing.assert_array_equal(both.phase.value[k], alone.phase.value[0])
        np.testing.assert_array_equal(both.envelope.value[k], alone.envelope.value[0])
        np.testing.assert_array_equal(both.background.value[k], alone.background.value[0])


def test_what_does_not_land_does_not_arrive():
    scene = nj.newton_rings(2e-3, 550e-9, 0.3e-6, "reflected", screen=1e-3)
    made = jet_fields.fields(jet_fields.courses([scene]), Jet(POINTS[None, :, None], 1))
    assert made.arrives[0, 0]
    assert not made.arrives.all()
    assert np.isfinite(made.background.value).all()


@pytest.mark.parametrize("name", ["sqrt", "sin", "cos", "arctan"])
def test_functions_have_jax_derivatives(name):
    def function(x, y, xp):
        return getattr(xp, name)(x * x * y + x / y) * xp.where(x > 1.0, x, y)

    at, step = (np.array([0.7, 1.3]), np.array([0.4, 0.9])), (np.array([0.3, -0.2]), np.array([0.5, 1.1]))
    x = jets.variable(at[0], step[0][None], 0, 2) + jets.variable(np.zeros(2), step[1][None], 1, 2)
    y = jets.variable(at[1], step[1][None], 0, 2)
    ours = function(x, y, jets)

    def plain(s, t):
        return function(at[0] + s * step[0] + t * step[1], at[1] + s * step[1], jnp)

    zero = jnp.zeros(())
    np.testing.assert_allclose(ours.value, plain(0.0, 0.0), rtol=1e-14)
    np.testing.assert_allclose(ours.parts[1, 0], jax.jacfwd(plain, 0)(zero, zero), rtol=1e-12)
    np.testing.assert_allclose(ours.parts[0, 1], jax.jacfwd(plain, 1)(zero, zero), rtol=1e-12)
    np.testing.assert_allclose(ours.parts[1, 1], jax.jacfwd(jax.jacfwd(plain, 0), 1)(zero, zero), rtol=1e-12)
