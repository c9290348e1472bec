"""Figures: Zernike and Chebyshev polynomials, a user's own height, and what lies beyond their domain."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from compilations import QUICKLY

import newtonjax as nj
from newtonjax.fields import arrivals, opd_at, pack
from newtonjax.scene import table_size

CAMERA = nj.Camera((24, 32), 100e-6)


class Ripple(nj.AbstractFigure):
    radius: float
    height: float

    def sag(self, x, y):
        return self.height * jnp.cos(2 * jnp.pi * x / 6e-3) * jnp.exp(y / 6e-3)


class Kink(nj.AbstractFigure):
    radius: float

    def sag(self, x, y):
        return 1e-5 * abs(x + y)


def bench(figure, **words):
    scene = nj.newton_rings(1.0, 500e-9, **{"screen": 1e-3, **words})
    lens = dataclasses.replace(scene.surfaces[1], figure=figure)
    return dataclasses.replace(scene, surfaces=(scene.surfaces[0], lens, *scene.surfaces[2:]))


@pytest.mark.parametrize("order", ["noll", "ansi"])
def test_zernike_polynomials_are_orthonormal_on_their_disc(order):
    """Averaged by a polar quadrature that is exact for their products: means of r^n, and of cosines over 32 angles."""
    at, weight = np.polynomial.legendre.leggauss(12)
    rho, theta = np.sqrt((1 + at) / 2), 2 * np.pi * np.arange(32) / 32
    x, y = (np.outer(rho, f(theta)).ravel() for f in (np.cos, np.sin))
    units = [nj.Zernike(row, 1.0, order) for row in np.eye(45)]
    terms = np.stack([figure.sag(x, y) for figure in units])
    np.testing.assert_allclose((terms * np.repeat(weight / 64, 32)) @ terms.T, np.eye(45), atol=1e-12)


def test_a_height_of_the_users_own_is_the_surface():
    figure = Ripple(4e-3, 1e-7)
    surface = nj.Surface(1.0, figure=figure)
    x, y = np.random.default_rng(1).uniform(-2.8e-3, 2.8e-3, (2, 50))
    np.testing.assert_allclose(surface.sag(x, y) - nj.Surface(1.0).sag(x, y), figure.sag(x, y), rtol=0, atol=3e-19)


def test_images_by_nodes_are_those_of_rays_at_every_pixel():
    scene = bench(Ripple(4e-3, 1e-7))
    exact = nj.render(scene, CAMERA, nj.Traced())
    assert isinstance(nj.plan(scene, CAMERA).method, nj.Chebyshev)
    assert np.abs(nj.render(scene, CAMERA) - exact).max() < 1e-3 * exact.max()


def test_a_height_of_the_users_own_is_differentiated_under_jit():
    points = np.array([[1e-3, -5e-4]])

    def path(height):
        return opd_at(bench(Ripple(4e-3, height)), points)[0][0]

    def push(height):
        return jax.jvp(path, (height,), (1.0,))

    _, slope = jax.jit(push, compiler_options=QUICKLY)(1e-7)
    ends = [arrivals(pack(bench(Ripple(4e-3, 1e-7 + h))), points).path[:, 0] for h in (1e-9, -1e-9)]
    # Rounding of 1e-17 m over 2e-9 m.
    assert slope == pytest.approx(((ends[0] - ends[1]) / 2e-9)[1] - ((ends[0] - ends[1]) / 2e-9)[0], abs=1e-7)


def test_a_height_that_is_not_smooth_is_refused():
    with pytest.raises(ValueError, match=r"Kink.sag is not smooth: 64 x 64 .* allowed: a smooth function"):
        nj.render(bench(Kink(4e-3)), CAMERA)


def test_beyond_its_disc_a_surface_ends_and_the_image_is_dark():
    scene = bench(nj.Zernike((0.0, 0.0, 0.0, 5e-8), 1e-3))
    plan = nj.plan(scene, CAMERA)
    assert isinstance(plan.method, nj.Traced)
    with pytest.warns(UserWarning, match=r"surfaces\[1\] ends 1 mm from its vertex, where its Zernike ends"):
        image = np.asarray(nj.render(scene, CAMERA))
    x, y = CAMERA.axes()
    r = np.hypot(x[None], y[:, None])
    # At 1 mm of screen a ray is some 5 um aside of where it met the lens.
    assert (image[r > 1.02e-3] == 0).all()
    assert (image[r < 0.98e-3] > 0).all()
    with (
        pytest.warns(UserWarning, match="ends 1 mm from its vertex"),
        pytest.raises(ValueError, match=r"cannot honour a beam that does not reach the whole image .* or its disc"),
    ):
        nj.render(scene, CAMERA, nj.Chebyshev(9))


def test_chebyshev_and_zernike_of_the_same_height_are_the_same_surface():
    # 2 r² - 1 = T_2(x) / 1 + T_2(y) / 1 + 1 on the unit disc, times sqrt(3) for rms 1.
    table = np.zeros((3, 3))
    table[0, 0], table[0, 2], table[2, 0] = np.sqrt(3) * np.array([1.0, 1.0, 1.0])
    ours, theirs = (
        nj.Surface(1.0, figure=figure)
        for figure in (nj.ChebyshevFigure(1e-7 * table, 4e-3), nj.Zernike((0, 0, 0, 1e-7), 4e-3))
    )
    x, y = np.random.default_rng(1).uniform(-2.8e-3, 2.8e-3, (2, 50))
    np.testing.assert_allclose(ours.sag(x, y), theirs.sag(x, y), rtol=0, atol=1e-20)
    assert table_size((ours,)) == table_size((theirs,)) == 8


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize(
    ("figure", "message"),
    [
        (lambda: nj.Zernike((), 1e-3), "zernike is .*; allowed: 1 to 136 heights in metres, piston first"),
        (lambda: nj.Zernike((0.0,) * 137, 1e-3), "zernike is .*; allowed: 1 to 136 heights"),
        (lambda: nj.Zernike((1e-8,), 0.0), "zernike_radius is 0.0; allowed: a positive radius"),
        (lambda: nj.Zernike((1e-8,), 1e-3, "fringe"), "zernike_order is 'fringe'; allowed: 'noll' or 'ansi'"),
        (lambda: nj.ChebyshevFigure((1e-8,), 1e-3), r"figure.coefficients is .*; allowed: a table \[in y, in x\]"),
        (lambda: nj.Surface(figure=1), "figure is 1; allowed: a figure such as Zernike, or None"),
    ],
)
def test_what_is_no_figure_is_refused(figure, message):
    with pytest.raises(ValueError, match=message):
        figure()
