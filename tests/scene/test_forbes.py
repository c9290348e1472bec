"""Forbes' polynomials: their laws, where rays meet them at 50 digits, their files."""

import dataclasses

import jax
import mpmath
import numpy as np
import pytest
from mpmath import mpf
from shaped import Shape, rays

import newtonjax as nj
from newtonjax.scene import table_size

TERMS, DISC, CURVATURE = (2e-6, -1e-6, 4e-7), 5e-3, 10.0
# On a sphere or conic of 0.1 m.
FIGURES = {"con": nj.Forbes(TERMS, DISC), "bfs": nj.Forbes(TERMS, DISC, "bfs", CURVATURE)}


def published(kind, x, y):
    """The first three, as they are printed: Forbes (2007), Opt. Express 15, 5218."""
    r2 = x * x + y * y
    t, root = r2 / mpf(DISC) ** 2, mpmath.sqrt
    if kind == "con":
        values = (1, -(5 - 6 * t), 15 - 14 * t * (3 - 2 * t))
        return t * t * mpmath.fdot(map(mpf, TERMS), values)
    values = (1, (13 - 16 * t) / root(19), root(mpf(2) / 95) * (29 - 4 * t * (25 - 19 * t)))
    return t * (1 - t) / root(1 - CURVATURE**2 * r2) * mpmath.fdot(map(mpf, TERMS), values)


@pytest.mark.parametrize("kind", FIGURES)
def test_rays_meet_the_surface_that_mpmath_draws_of_the_published_polynomials(kind):
    vertex, tilt = (2e-4, -3e-4, 1e-4), (0.01, -0.02)
    drawn = Shape(CURVATURE, [mpf(v) for v in vertex], tilt, own=lambda x, y: published(kind, x, y))
    ours = nj.Surface(CURVATURE, vertex, tilt, figure=FIGURES[kind])
    origin, direction = rays()
    face = ours.face(table_size((ours,)))
    distance, _, meets = jax.jit(jax.vmap(lambda o, d: face.intersect(o, d)))(origin, direction)
    assert meets.all()
    with mpmath.workdps(50):
        for o, d, way in zip(origin.tolist(), direction.tolist(), distance.tolist(), strict=True):
            exact, _ = drawn.meet([mpf(p) for p in o], [mpf(p) for p in d])
            assert abs(exact - way) < 3e-17


def test_slopes_of_the_second_kind_are_orthonormal():
    """Over the angle whose sine is u: the quadrature is exact for products of slopes of 20 terms."""
    angle = (np.arange(64) + 0.5) * np.pi / 128
    u, step, on_axis = np.sin(angle), 1e-6, np.zeros(64)
    units = [nj.Forbes(row, 1.0, "bfs") for row in np.eye(20)]
    slopes = np.stack([(unit.sag(u + step, on_axis) - unit.sag(u - step, on_axis)) / (2 * step) for unit in units])
    np.testing.assert_allclose(slopes @ slopes.T / 64, np.eye(20), atol=1e-7)


def test_the_first_kind_is_orthogonal_over_the_conic():
    """Jacobi's polynomials of (0, 4): the integral of t⁴ times a square is 1/(2 m + 5), of other products 0."""
    at, weight = np.polynomial.legendre.leggauss(40)
    t = (1 + at) / 2
    terms = np.stack([nj.Forbes(row, 1.0).sag(np.sqrt(t), np.zeros(40)) for row in np.eye(20)])
    products = (terms * weight / 2) @ terms.T
    np.testing.assert_allclose(products, np.diag(1 / (2 * np.arange(20) + 5)), atol=1e-12)


@pytest.mark.parametrize("kind", FIGURES)
def test_a_file_holds_them(kind, tmp_path):
    scene = nj.newton_rings(1 / CURVATURE, 550e-9, screen=1e-3)
    lens = dataclasses.replace(scene.surfaces[1], figure=FIGURES[kind])
    scene = dataclasses.replace(scene, surfaces=(scene.surfaces[0], lens, *scene.surfaces[2:]))
    nj.save_scene(tmp_path / "scene.toml", scene)
    figure = nj.load_scene(tmp_path / "scene.toml")[0].surfaces[1].figure
    assert isinstance(figure, nj.Forbes)
    assert (figure.kind, float(figure.curvature), float(figure.radius)) == (kind, CURVATURE * (kind == "bfs"), DISC)
    np.testing.assert_array_equal(figure.coefficients, TERMS)


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize(
    ("words", "message"),
    [
        (((), 1e-3), "forbes is .*; allowed: 1 to 20 heights in metres"),
        (((1e-6,), 0.0), "forbes radius is 0.0; allowed: a positive radius"),
        (((1e-6,), 1e-3, "2d"), "forbes kind is '2d'; allowed: 'con' or 'bfs'"),
        (((1e-6,), 1e-3, "con", 1.0), "forbes curvature goes with kind='bfs'"),
        (((1e-6,), 1e-3, "bfs", 900.0), "forbes curvature is 900.0 1/m; allowed: up to 707.1 1/m"),
    ],
)
def test_what_is_none_is_refused(words, message):
    with pytest.raises(ValueError, match=message):
        nj.Forbes(*words)
