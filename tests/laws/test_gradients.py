"""Derivatives of images with respect to every continuous number, forward and reverse, against differences."""

from functools import cache

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from compilations import QUICKLY
from jax.flatten_util import ravel_pytree

import newtonjax as nj

VIEWS = ("transmitted", "reflected")
SHAPE = (3, 3)  # the middle pixel is the apex where the camera is centred
PRESET = {
    "wavelength": 500e-9, "gap": 0.0, "screen": 1e-3, "lens_index": 1.5, "plate_index": 1.5, "gap_index": 1.0,
    "ambient_index": 1.0, "lens_thickness": 5e-3, "plate_thickness": 5e-3, "lens_tilt": (0.0, 0.0),
    "plate_tilt": (0.0, 0.0), "light_tilt": (0.0, 0.0), "polarization": 0.3,
}  # fmt: skip
# How many numbers move the images by more than their rounding, at least.
MOVING = {
    "contact, apex, normal incidence": 40, "negative gap": 40, "plane": 20, "equal indices": 0,
    "equal glasses, liquid": 0, "general": 40,
}  # fmt: skip
# Every place a user can be on, and where formulas written carelessly divide by zero.
PLACES = {
    "contact, apex, normal incidence": {},
    "negative gap": {"gap": -0.3e-6},
    "plane": {"curvature": 0.0, "gap": 1.03e-6},
    "equal indices": {"lens_index": 1.0, "plate_index": 1.0, "gap": 1e-6},
    "equal glasses, liquid": {"gap_index": 1.5, "gap": 1e-6},
    "general": {
        "curvature": -0.7, "gap": 2e-6, "lens_tilt": (1e-3, -2e-3), "plate_tilt": (-1e-3, 5e-4), "lens_index": 1.6,
        "light_tilt": (0.02, 0.03), "gap_index": 1.2, "screen": 20e-3,
    },
}  # fmt: skip
METHODS = {"ClosedForm": nj.ClosedForm(), "Chebyshev": nj.Chebyshev(4), "Traced": nj.Traced()}
# The closed form has no light or screen of its own to turn; it refuses them where they are known.
FLAT = ("lens_tilt", "light_tilt", "screen")


def numbers(method, **place):
    """All continuous numbers of a preset and of its camera at a place, flat, and the function that rebuilds them."""
    values = {"curvature": 0.5, "pixel_size": 300e-6, "centre_px": (1.0, 1.0), **PRESET, **place}
    values = {k: jnp.asarray(v, dtype=float) for k, v in values.items()}
    if method == "ClosedForm":
        values = {k: v for k, v in values.items() if k not in FLAT}
    return ravel_pytree(values)


def scene_of(values, view, method):
    """The preset, then every leaf of the scene moved by hand, so that the preset is no bottleneck."""
    values = dict(values)
    camera = nj.Camera(SHAPE, values.pop("pixel_size"), values.pop("centre_px"))
    curvature = values.pop("curvature")
    if method == "ClosedForm":
        values["screen"] = "gap"
    scene = nj.newton_rings(1.0, view=view, **values)
    return eqx.tree_at(lambda s: s.surfaces[1].curvature, scene, curvature), camera


@cache
def kernels(view, method):
    """Compiled once for all places: many images, the forward Jacobian, and one reverse pass."""
    start, unravel = numbers(method)
    leaves = ravel_pytree(scene_of(unravel(start), view, method)[0])[0].size

    def image(flat):
        scene, camera = scene_of(unravel(flat[: start.size]), view, method)
        vector, rebuild = ravel_pytree(scene)
        return METHODS[method].image(rebuild(vector + flat[start.size :]), camera).ravel()

    names = [f"preset {k}" for k in range(start.size)] + [f"leaf {k}" for k in range(leaves)]
    reverse = jax.jit(lambda at, weight: jax.vjp(image, at)[1](weight)[0], compiler_options=QUICKLY)
    return (
        jax.jit(jax.vmap(image)),  # of some 7000 images a place: compiled in a hurry it runs four times as long
        jax.jit(jax.jacfwd(image), compiler_options=QUICKLY),
        reverse,
        names,
    )


# Central differences of eighth order (Fornberg 1988): they err by the ninth derivative times h⁸ / 630.
WEIGHTS = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])
STEPS = 5e-11 * 4.0 ** np.arange(14)  # from what shifts a wavelength to what turns a tilt
# A traced image errs by the rounding of its paths: 1e-11 turns, times 2π and an amplitude of 0.07.
ROUNDING = 5e-12


def differences(images, at):
    """Derivatives of all pixels with respect to all parameters [parameter, pixel], and by how much they may err.

    From the smallest step on, each four times the last: rounding falls as they grow, until the step reaches over the
    fringes. Of the steps before that, the two neighbouring ones that agree best leave the error.
    """
    reach = np.concatenate([np.arange(1, 5), -np.arange(1, 5)])
    found = []
    for step in STEPS:
        moved = np.asarray(at) + step * np.eye(len(at))[None] * reach[:, None, None]
        values = np.asarray(images(moved.reshape(-1, len(at)))).reshape(8, len(at), -1)
        found.append(np.tensordot(WEIGHTS, values[:4] - values[4:], 1) / step)
    found = np.array(found)
    change = np.abs(np.diff(found, axis=0)).max(axis=2) + ROUNDING / STEPS[:-1, None]
    change = np.where(np.isfinite(change), change, np.inf)
    too_wide = np.logical_or.accumulate(change > 4 * np.minimum.accumulate(change), axis=0)
    best, each = np.where(too_wide, np.inf, change).argmin(axis=0), np.arange(len(at))
    return found[best, each], change[best, each]


BENCHES = [
    ("ClosedForm", "transmitted"),
    ("ClosedForm", "reflected"),
    ("Chebyshev", "transmitted"),
    ("Traced", "reflected"),
]


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize(("method", "view"), BENCHES)
def test_derivatives_by_every_number_are_finite_and_those_of_central_differences(method, view, place):
    images, forward, reverse, names = kernels(view, method)
    flat, _ = numbers(method, **PLACES[place])
    at = jnp.concatenate([flat, jnp.zeros(len(names) - len(flat))])
    jacobian = np.asarray(forward(at)).T
    assert np.isfinite(jacobian).all()
    expected, error = differences(images, at)
    allowed = 1e-6 * np.abs(expected) + error[:, None]
    wrong = np.abs(jacobian - expected) / allowed
    assert wrong.max() < 1, [(names[k], wrong[k].max()) for k in np.flatnonzero(wrong.max(axis=1) >= 1)]
    # The differences are sharp enough to tell: to 1e-6 for most of the parameters that move the image at all.
    size = np.abs(expected).max(axis=1)
    telling = size > 1e3 * error
    assert telling.sum() >= MOVING[place] / (2 if method == "ClosedForm" else 1)
    assert (error < 1e-6 * size)[telling].sum() >= 0.7 * telling.sum()
    weight = np.random.default_rng(8).normal(size=jacobian.shape[1])
    backward = np.asarray(reverse(at, weight))
    assert np.isfinite(backward).all()
    wrong = np.abs(backward - expected @ weight) / (allowed @ np.abs(weight))
    assert wrong.max() < 1, [(names[k], wrong[k]) for k in np.flatnonzero(wrong >= 1)]


@pytest.mark.parametrize(("method", "view"), BENCHES)
def test_derivatives_are_finite_where_rays_miss_and_zero_where_all_do(method, view):
    """A sphere of 5 mm, and pixels 4 mm apart: only the middle one is reached (the closed form has all of them)."""
    _, forward, reverse, names = kernels(view, method)
    flat, _ = numbers(method, curvature=200.0, lens_index=1.9, pixel_size=4e-3, gap=1e-6)
    at = jnp.concatenate([flat, jnp.zeros(len(names) - len(flat))])
    jacobian = np.asarray(forward(at)).T
    assert np.isfinite(jacobian).all()
    assert np.isfinite(reverse(at, np.ones(9))).all()
    assert jacobian[:, 4].any()
    if method == "Traced":
        assert not np.delete(jacobian, 4, axis=1).any()


def test_derivative_by_the_radius_is_finite_up_to_the_plane_and_that_of_the_curvature():
    def image(radius):
        return nj.render(
            nj.newton_rings(radius, screen="gap", view="transmitted"), nj.Camera(SHAPE, 3e-4), method=nj.ClosedForm()
        )

    slope = jax.jit(jax.jacfwd(image), compiler_options=QUICKLY)
    assert not np.asarray(slope(np.inf)).any()
    h = 1e-3
    expected = sum(w * (image(2 + k * h) - image(2 - k * h)) for k, w in enumerate(WEIGHTS, 1)) / h
    np.testing.assert_allclose(slope(2.0), expected, rtol=1e-6, atol=1e-12)
