"""Surfaces that are no spheres, where rays meet them, and their derivatives."""

from functools import partial

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest
from compilations import QUICKLY
from mpmath import mpf
from shaped import KINDS, rays, shape
from shaped import Shape as Drawn

import newtonjax as nj
from newtonjax.scene import table_size


def face(surface):
    return surface.face(table_size((surface,)))


meet = jax.jit(jax.vmap(lambda face, o, d: face.intersect(o, d), (None, 0, 0)))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("tilt", [(0.0, 0.0), (0.01, -0.02)])
def test_rays_meet_the_surface_that_mpmath_draws(kind, tilt):
    drawn = shape(kind, (2e-4, -3e-4, 1e-4), tilt)
    origin, direction = rays()
    distance, normal, meets = meet(face(drawn.ours()), origin, direction)
    assert meets.all()
    with mpmath.workdps(50):
        for o, d, way, n in zip(*(a.tolist() for a in (origin, direction, distance, normal)), strict=True):
            exact, exact_normal = drawn.meet([mpf(p) for p in o], [mpf(p) for p in d])
            # The rounding of a distance of 20 mm, 2e-18 m, by a few operations.
            assert abs(exact - way) < 3e-17
            assert max(abs(a - b) for a, b in zip(exact_normal, n, strict=True)) < 2e-15


@pytest.mark.parametrize("kind", KINDS)
def test_the_height_is_that_of_mpmath(kind):
    drawn = shape(kind)
    x, y = np.random.default_rng(2).uniform(-3e-3, 3e-3, (2, 30))
    with mpmath.workdps(50):
        exact = [float(drawn.sag(mpf(a), mpf(b))) for a, b in zip(x.tolist(), y.tolist(), strict=True)]
    np.testing.assert_allclose(drawn.ours().sag(x, y), exact, rtol=1e-13, atol=1e-20)


# Terms of a surface as a vector, in the units of `SCALES`; what a toroid has instead of a conic constant.
TERMS = (
    "curvature",
    "conic",
    "asphere",
    "asphere",
    "odd_asphere",
    "zernike",
    "zernike",
    "zernike",
    "zernike",
    "zernike",
)
TORIC = ("curvature", "curvature_across", "axis", "asphere", "odd_asphere")
SCALES = {"asphere": 1e3, "zernike": 1e-6}
RADIUS = 5e-3
# A ray down the axis, an oblique one through the vertex, one off the axis, one oblique anywhere.
RAYS = [((0, 0), (0, 0)), ((0, 0), (0.1, -0.05)), ((1e-3, -2e-3), (0, 0)), ((-2e-3, 1e-3), (0.05, 0.1))]
CASES = {
    "a sphere": (TERMS, (10.0, *[0.0] * 9)),
    "a plane": (TERMS, (0.0,) * 10),
    "everything": (TERMS, (10.0, -1.3, 0.2, -30.0, 0.3, 0.0, 0.02, -0.03, 0.1, 0.2)),
    "a toroid of equal curvatures": (TORIC, (10.0, 10.0, 0.3, 0.0, 0.0)),
    "a cylinder": (TORIC, (0.0, 5.0, 0.3, 0.2, 0.1)),
    "a toroid": (TORIC, (8.0, 5.0, 0.3, 0.2, 0.1)),
}


def words_of(names, numbers):
    """The numbers of `Surface` by name; terms of one name in their order."""
    words = {}
    for name, number in zip(names, numbers, strict=True):
        words.setdefault(name, []).append(number * SCALES.get(name, 1.0))
    return {name: v if name in ("asphere", "odd_asphere", "zernike") else v[0] for name, v in words.items()}


def surface_of(names, numbers):
    words = words_of(names, numbers)
    figure = nj.Zernike(jnp.stack(words.pop("zernike")), RADIUS) if "zernike" in words else None
    terms = {name: jnp.stack(words.pop(name)) for name in ("asphere", "odd_asphere")}
    return nj.Surface(**words, **terms, figure=figure)


def distance(names, numbers, position, direction):
    return face(surface_of(names, numbers)).intersect(position, direction)[0]


def launched(ray):
    (x, y), (dx, dy) = ray
    direction = np.array([dx, dy, -1.0]) / np.sqrt(1 + dx * dx + dy * dy)
    return np.array([x, y, 0.0]) - 4e-3 * direction, direction


def gradient_twice(names, numbers, position, direction):
    gradient = jax.grad(distance, 1)(names, numbers, position, direction)
    return gradient, gradient


# By reverse differentiation, and forward over reverse.
derivatives = {
    names: jax.jit(
        jax.vmap(jax.jacfwd(partial(gradient_twice, names), has_aux=True), (None, 0, 0)), compiler_options=QUICKLY
    )
    for names in (TERMS, TORIC)
}


def exact_derivatives(names, numbers, position, direction):
    """By central differences of 1e-15 at 50 digits."""

    def drawn_distance(numbers):
        words = words_of(names, numbers)
        drawn = Drawn(vertex=[mpf(0)] * 3, radius=RADIUS, **words)
        return drawn.meet([mpf(p) for p in position.tolist()], [mpf(p) for p in direction.tolist()])[0]

    h, gradient = mpf("1e-15"), []
    numbers = [mpf(number) for number in numbers]
    for k in range(len(numbers)):
        ends = [[*numbers[:k], numbers[k] + sign * h, *numbers[k + 1 :]] for sign in (1, -1)]
        gradient.append((drawn_distance(ends[0]) - drawn_distance(ends[1])) / (2 * h))
    return np.array([float(g) for g in gradient])


@pytest.mark.parametrize("case", CASES)
def test_the_distance_has_the_derivatives_of_mpmath_by_every_number(case):
    names, numbers = CASES[case]
    numbers = np.array(numbers)
    position, direction = map(np.array, zip(*map(launched, RAYS), strict=True))
    hessian, gradient = derivatives[names](numbers, position, direction)
    assert np.isfinite(hessian).all()
    np.testing.assert_allclose(hessian, np.swapaxes(hessian, 1, 2), rtol=1e-9, atol=1e-18)
    with mpmath.workdps(50):
        exact = [exact_derivatives(names, numbers.tolist(), *ray) for ray in zip(position, direction, strict=True)]
    np.testing.assert_allclose(gradient, exact, rtol=1e-11, atol=1e-18)
