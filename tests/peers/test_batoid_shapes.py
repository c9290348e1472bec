"""Batoid's surfaces of the same kinds: heights, normals and where rays meet them."""

import jax
import numpy as np
import pytest
from scipy.interpolate import RectBivariateSpline
from shaped import ASPHERE, FIGURE, rays

import newtonjax as nj
from newtonjax.scene import table_size

RADIUS, DISC = 0.1, 5e-3


def with_zernike(batoid, base):
    return batoid.Sum([base, batoid.Zernike([0.0, *FIGURE], R_outer=DISC)])


# By kind: our words, and batoid's surface.
KINDS = {
    "Quadric": ({"conic": -1.7}, lambda b: b.Quadric(RADIUS, -1.7)),
    "Asphere": ({"conic": 0.3, "asphere": ASPHERE}, lambda b: b.Asphere(RADIUS, 0.3, list(ASPHERE))),
    "Zernike": (
        {"conic": -0.5, "asphere": ASPHERE, "figure": nj.Zernike(FIGURE, DISC)},
        lambda b: with_zernike(b, b.Asphere(RADIUS, -0.5, list(ASPHERE))),
    ),
}
meet = jax.jit(jax.vmap(lambda face, o, d: face.intersect(o, d), (None, 0, 0)))


@pytest.mark.parametrize("kind", KINDS)
def test_batoid_has_the_same_height_normal_and_intersection(kind):
    batoid = pytest.importorskip("batoid", reason="batoid is not installed (extra 'peers')")
    words, of_batoid = KINDS[kind]
    ours, theirs = nj.Surface(1 / RADIUS, **words), of_batoid(batoid)
    origin, direction = rays(500)
    bundle = batoid.RayVector(*origin.T.copy(), *direction.T.copy())
    distance, normal, meets = meet(ours.face(table_size((ours,))), origin, direction)
    assert meets.all()
    theirs.intersect(bundle, coordSys=batoid.CoordSys())
    at = origin + np.asarray(distance)[:, None] * direction
    # Rounding of a distance of 20 mm, 3e-18 m, by some operations of either program.
    np.testing.assert_allclose(at, bundle.r, rtol=0, atol=2e-16)
    x, y = at[:, 0].copy(), at[:, 1].copy()
    np.testing.assert_allclose(ours.sag(x, y), theirs.sag(x, y), rtol=0, atol=1e-17)
    np.testing.assert_allclose(normal, theirs.normal(x, y), rtol=0, atol=1e-13)


def test_batoids_bicubic_of_the_same_slopes_is_the_height_map():
    batoid = pytest.importorskip("batoid", reason="batoid is not installed (extra 'peers')")
    at = np.linspace(-DISC, DISC, 31)
    heights = 2e-7 * np.cos(at / 2e-3) * np.exp(at / 5e-3)[:, None]
    spline = RectBivariateSpline(at, at, heights)
    # Given the spline's slopes at its knots, cubics between them are that spline.
    slopes = [spline(at, at, dx=by_y, dy=by_x) for by_y, by_x in ((0, 1), (1, 0), (1, 1))]
    theirs = batoid.Bicubic(at, at, heights, *slopes)
    figure = nj.HeightMap(heights, at[1] - at[0], DISC)
    x, y = np.random.default_rng(1).uniform(-3.5e-3, 3.5e-3, (2, 200))
    np.testing.assert_allclose(figure.sag(x, y), theirs.sag(x, y), rtol=0, atol=1e-20)
    ours, origin, direction = nj.Surface(figure=figure), *rays(200)
    distance, _, meets = meet(ours.face(table_size((ours,))), origin, direction)
    bundle = batoid.RayVector(*origin.T.copy(), *direction.T.copy())
    theirs.intersect(bundle, coordSys=batoid.CoordSys())
    assert meets.all()
    # What rays may miss of a map of heights.
    np.testing.assert_allclose(origin + np.asarray(distance)[:, None] * direction, bundle.r, rtol=0, atol=1e-10)
