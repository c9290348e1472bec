"""Spheres, planes, and where rays meet them."""

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest

import newtonjax as nj
from newtonjax.scene import Surface, frame


def rays(count=50, seed=3):
    """Origins within 5 mm of the axis at 20 mm, directions within 0.2 rad of -z."""
    rng = np.random.default_rng(seed)
    origin = np.column_stack([rng.uniform(-5e-3, 5e-3, (count, 2)), np.full(count, 20e-3)])
    direction = np.column_stack([rng.uniform(-0.2, 0.2, (count, 2)), -np.ones(count)])
    return jnp.asarray(origin), jnp.asarray(direction / np.linalg.norm(direction, axis=1, keepdims=True))


@pytest.mark.parametrize("radius", [0.03, -0.03, 2.0, -20.0, np.inf])
@pytest.mark.parametrize("tilt", [(0.0, 0.0), (0.01, -0.02)])
def test_intersection_lies_on_the_sphere_that_mpmath_draws(radius, tilt):
    origin, direction = rays()
    distance, normal, meets = jax.vmap(Surface(1 / radius, tilt=tilt).face().intersect)(origin, direction)
    assert meets.all()
    with mpmath.workdps(50):
        a, b = map(mpmath.mpf, tilt)
        up = [mpmath.cos(a) * mpmath.sin(b), -mpmath.sin(a), mpmath.cos(a) * mpmath.cos(b)]
        for o, d, t, n in zip(origin.tolist(), direction.tolist(), distance.tolist(), normal.tolist(), strict=True):
            point = [mpmath.mpf(p) + mpmath.mpf(t) * mpmath.mpf(q) for p, q in zip(o, d, strict=True)]
            c = mpmath.mpf(0) if np.isinf(radius) else 1 / mpmath.mpf(radius)
            on_axis = mpmath.fdot(up, point)
            off = c * mpmath.fdot(point, point) / 2 - on_axis  # (|p - R a|² - R²) / 2R
            # The rounding of a distance of 20 mm, 2e-18 m, by a few operations.
            assert abs(off) < 3e-17
            gradient = [u - c * p for u, p in zip(up, point, strict=True)]
            assert max(abs(g - m) for g, m in zip(gradient, n, strict=True)) < 1e-15


@pytest.mark.parametrize("radius", [0.02, 2.0, 20.0, -0.02])
def test_sag_matches_the_exact_sphere_to_the_last_digits(radius):
    r = np.array([0.0, 1e-9, 1e-6, 1e-3, 5e-3, 19.9e-3])
    with mpmath.workdps(60):
        big = mpmath.mpf(1) / mpmath.mpf(1 / radius)
        exact = [float(big - mpmath.sign(big) * mpmath.sqrt(big**2 - mpmath.mpf(float(x * x)))) for x in r]
    # Near the equator the root amplifies the rounding of its argument by 1 / (1 - c² r²) = 100.
    np.testing.assert_allclose(Surface(1 / radius).sag(jnp.asarray(r), jnp.zeros(6)), exact, rtol=1e-14, atol=0)


def test_sag_in_float32_keeps_seven_digits():
    r = jnp.asarray([1e-3, 2e-3, 5e-3], dtype=jnp.float32)
    value = Surface(0.5).sag(r, jnp.zeros_like(r))
    exact = 2 - np.sqrt(4 - np.asarray(r, dtype=np.longdouble) ** 2)
    assert value.dtype == jnp.float32
    np.testing.assert_allclose(np.asarray(value, dtype=float), exact.astype(float), rtol=5e-7)


def test_curvature_zero_is_the_limit_of_large_spheres_in_value_and_slope():
    origin, direction = rays(5)

    def distance(curvature, o, d):
        return Surface(curvature).face().intersect(o, d)[0]

    for o, d in zip(origin, direction, strict=True):
        plane, slope = jax.value_and_grad(distance)(0.0, o, d)
        assert abs(plane + o[2] / d[2]) < 1e-17
        h = 1e-3  # the distance is analytic in the curvature: the central difference errs by h² times its third order
        difference = (distance(h, o, d) - distance(-h, o, d)) / (2 * h)
        assert abs(slope - difference) < 1e-7 * abs(slope)


def test_a_ray_that_passes_the_sphere_is_told_so_and_keeps_a_finite_gradient():
    origin, direction = jnp.array([0.05, 0.0, 0.1]), jnp.array([0.0, 0.0, -1.0])

    def distance(curvature):
        length, _, meets = Surface(curvature).face().intersect(origin, direction)
        return length, meets

    (length, meets), slope = jax.value_and_grad(distance, has_aux=True)(1 / 0.03)
    assert not meets
    assert np.isfinite(length)
    assert np.isfinite(slope)


def test_frame_is_a_rotation():
    matrix = np.stack(frame((0.3, -0.7)))
    np.testing.assert_allclose(matrix @ matrix.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(matrix) > 0


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize(
    ("part", "message"),
    [
        (lambda v: Surface(0.0, (0.0, 0.0, 0.0), v), "tilt is .*; allowed: two finite angles"),
        (lambda v: Surface(0.0, v), "vertex is .*; allowed: three finite lengths"),
        (lambda v: nj.Light(5e-7, v), "light.tilt is .*; allowed: two angles"),
        (lambda v: nj.Shield(1e-3, v), "shield.vertex is .*; allowed: three lengths"),
        (lambda v: nj.CollectingLens(0.1, v), "collecting_lens.vertex is .*; allowed: three lengths"),
        (lambda v: nj.Camera((2, 2), 1e-6, v), "centre_px is .*; allowed: two finite numbers"),
        (lambda v: nj.newton_rings(1.0, lens_tilt=v), "lens_tilt is .*; allowed: two angles"),
    ],
)
@pytest.mark.parametrize("transform", [jax.jit, jax.vmap, lambda call: call], ids=["jit", "vmap", "eager"])
def test_a_vector_of_another_length_is_refused_traced_or_not(part, message, transform):
    for vector in (jnp.array([[0.1]]), jnp.zeros((1, 4)), jnp.zeros((1, 2, 5))):
        with pytest.raises(ValueError, match=message):
            transform(part)(vector if transform is jax.vmap else vector[0])


def test_vectors_of_the_right_length_are_taken_traced_and_in_batches():
    batch = jax.vmap(lambda t: Surface(0.0, (0.0, 0.0, 0.0), t))(jnp.array([[0.1, 0.2], [0.3, 0.4]]))
    again = Surface(batch.curvature, batch.vertex, batch.tilt)
    axes = jax.vmap(lambda surface: surface.face().axis)(again)
    np.testing.assert_allclose(axes[1], frame((0.3, 0.4))[2], rtol=1e-15)


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize(
    ("part", "message"),
    [
        (Surface, r"curvature is \[1.0, 2.0\]; allowed: a finite number"),
        (nj.Light, r"wavelength is \[1.0, 2.0\]; allowed: a positive length"),
        (lambda v: nj.Light(5e-7, polarization=v), r"polarization is \[1.0, 2.0\]; allowed: a finite angle"),
        (lambda v: nj.Light(5e-7, polarization=0.1, ellipticity=[0 * x for x in v]), r"ellipticity is \[0.0, 0.0\]"),
        (lambda v: nj.Light(5e-7, polarization=0.1, degree=[x / 4 for x in v]), r"degree is \[0.25, 0.5\]"),
        (lambda v: nj.Camera((2, 3), v), r"pixel_size is \[1.0, 2.0\]; allowed: a positive length"),
        (lambda v: nj.Camera((2, 3), 1e-6, exposure=v), r"exposure is \[1.0, 2.0\]"),
        (nj.Shield, r"shield.radius is \[1.0, 2.0\]"),
        (lambda v: nj.CollectingLens(v, (0.0, 0.0, 1.0)), r"collecting_lens.focal_length is \[1.0, 2.0\]"),
    ],
)
def test_a_list_is_no_number(part, message):
    with pytest.raises(ValueError, match=message):
        part([1.0, 2.0])


def test_numbers_of_light_are_pythons_own_and_batches_arrays():
    light = nj.Light(5e-7, polarization=np.float64(0.1), ellipticity=jnp.float64(0.2), degree=1)
    assert [type(x) for x in (light.polarization, light.ellipticity, light.degree)] == [float] * 3
    batch = jax.vmap(lambda angle: nj.Light(5e-7, polarization=angle))(jnp.array([0.1, 0.2]))
    again = nj.Light(batch.wavelength, batch.tilt, batch.polarization)
    np.testing.assert_array_equal(again.polarization, [0.1, 0.2])


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize("array", [np.array, jnp.array])
def test_a_complex_vector_is_refused_whoever_holds_it(array):
    with pytest.raises(ValueError, match=r"vertex is .*j.*; allowed: three finite lengths"):
        Surface(0.0, array([0.0, 0.0, 1j]))
