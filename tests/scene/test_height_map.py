"""Measured heights: SciPy's spline between them, rays that meet it, derivatives, and what is refused."""

import dataclasses

import jax
import numpy as np
import pytest
from scipy.interpolate import RectBivariateSpline
from shaped import rays

import newtonjax as nj
from newtonjax.scene import table_size

SPACING, RADIUS = 0.4e-3, 4e-3
# 21 rows and 23 columns, whose middle is the vertex.
Y, X = ((np.arange(count) - (count - 1) / 2) * SPACING for count in (21, 23))
HEIGHTS = 3e-7 * np.cos(X / 2e-3) * np.exp(Y / 5e-3)[:, None] + 1e-8 * X / 4e-3


def heights_of(**words):
    return nj.HeightMap(**{"heights": HEIGHTS, "spacing": SPACING, "radius": RADIUS, **words})


def points(count):
    return np.random.default_rng(1).uniform(-2.8e-3, 2.8e-3, (2, count))


def test_heights_between_those_given_are_those_of_scipys_cubic_spline():
    noisy = HEIGHTS + 1e-8 * np.random.default_rng(2).standard_normal(HEIGHTS.shape)
    x, y = (np.append(at, edge * SPACING) for at, edge in zip(points(200), (-11, 10), strict=True))
    # Rounding of 1e-6 m.
    np.testing.assert_allclose(
        heights_of(heights=noisy).sag(x, y), RectBivariateSpline(Y, X, noisy).ev(y, x), rtol=0, atol=3e-21
    )


def test_rays_meet_the_spline_within_its_tolerance():
    surface = nj.Surface(2.0, figure=heights_of())
    origin, direction = rays(100)
    meet = jax.jit(jax.vmap(lambda face, o, d: face.intersect(o, d), (None, 0, 0)))
    way, _, meets = meet(surface.face(table_size((surface,))), origin, direction)
    assert meets.all()
    x, y, z = (origin + np.asarray(way)[:, None] * direction).T
    np.testing.assert_allclose(z, nj.Surface(2.0).sag(x, y) + heights_of().sag(x, y), rtol=0, atol=1e-10)


def test_a_height_of_the_grid_is_differentiated():
    x, y = points(20)

    def sag(change):
        return heights_of(heights=HEIGHTS + change * np.eye(21, 23)).sag(x, y)

    slope = jax.jit(jax.jacfwd(sag))(0.0)
    np.testing.assert_allclose(slope, (sag(1e-7) - sag(-1e-7)) / 2e-7, rtol=0, atol=1e-12)


def test_a_file_of_a_scene_holds_the_heights(tmp_path):
    scene = nj.newton_rings(1.0, 500e-9)
    lens = dataclasses.replace(scene.surfaces[1], figure=heights_of(tolerance=1e-9))
    bench = dataclasses.replace(scene, surfaces=(scene.surfaces[0], lens, *scene.surfaces[2:]))
    nj.save_scene(tmp_path / "a.toml", bench)
    loaded = nj.load_scene(tmp_path / "a.toml")[0].surfaces[1].figure
    np.testing.assert_array_equal(loaded.heights, HEIGHTS)
    assert (loaded.spacing, loaded.radius, loaded.tolerance) == (SPACING, RADIUS, 1e-9)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"heights": np.zeros((3, 9))}, r"figure.heights has shape \(3, 9\); allowed: .* 4 x 4 heights or more"),
        ({"heights": np.full((21, 23), np.nan)}, "figure.heights is .*allowed: finite heights in metres on the whole"),
        ({"radius": 4.1e-3}, r"figure.radius is 0.0041 m, and the heights reach 0.004 m .* a disc within the grid"),
        ({"spacing": 0.0}, "figure.spacing is 0.0; allowed: a positive distance"),
    ],
)
@pytest.mark.usefixtures("untyped")
def test_what_is_no_map_of_heights_is_refused(words, message):
    with pytest.raises(ValueError, match=message):
        heights_of(**words)


def test_heights_that_polynomials_do_not_hold_are_refused():
    rough = 1e-7 * np.random.default_rng(3).standard_normal((101, 101))
    with pytest.raises(ValueError, match=r"64 x 64 polynomials leave .* m of the heights; allowed: 1e-10 m"):
        nj.HeightMap(rough, 1e-4, 5e-3).size()
