"""Fisher's information against central differences over all pixels, closed forms, and what cannot be told."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from compilations import compilations
from scipy.stats import norm, poisson

import newtonjax as nj
from fitting import information, sensitivity
from fitting.parameters import knobs
from fitting.studies import derivative_images
from fitting.studies.electrons import variance

CAMERA = nj.Camera((96, 80), 60e-6, centre_px=(30.0, 51.5), exposure=8000.0, full_well=20_000.0, bits=10)
FREE = ("radius", "gap", "centre_x", "centre_y", "exposure", "contrast", "stray")
STEPS = {"radius": 1e-6, "gap": 1e-5, "centre_x": 1e-3, "centre_y": 1e-3, "exposure": 1e-4, "wavelength": 1e-7,
         "pixel_size": 1e-7, "screen": 1e-3, "lens_index": 1e-5, "gap_index": 1e-7, "plate_index": 1e-5,
         "light_tilt_x": 1e-4, "light_tilt_y": 1e-4, "plate_tilt_x": 1e-4, "plate_tilt_y": 1e-4}  # fmt: skip


def bench(**more):
    numbers = {"gap": 0.3e-6, "screen": 3e-3, "light_tilt": (1e-3, 2e-4), **more}
    return nj.newton_rings(2.0, 550e-9, view="reflected", **{"screen": 1e-3, **numbers})


def by_differences(scene, camera, names, steps=STEPS):
    """Σ (∂μ/∂θ)(∂μ/∂θ)ᵀ / σ² in the numbers' own units, by fourth-order differences of traced images."""
    known = knobs(scene, camera)

    def electrons(name, factor):
        step = factor * steps[name] * known[name].scale
        at_scene, at_camera = known[name].move(scene, camera, step)
        return np.asarray(nj.render(at_scene, at_camera, nj.Chebyshev(17))) * float(at_camera.exposure)

    columns = []
    for name in names:
        near, far = (electrons(name, k) - electrons(name, -k) for k in (1, 2))
        columns.append(((8 * near - far) / (12 * steps[name] * known[name].scale)).ravel())
    mean = np.asarray(nj.render(scene, camera, nj.Chebyshev(17))).ravel() * float(camera.exposure)
    code = float(camera.full_well) / (2**camera.bits - 1)
    variance = mean + float(camera.read_noise) ** 2 + code**2 / 12
    slopes = np.stack(columns, axis=1)
    return slopes.T @ (slopes / variance[:, None])


def test_the_matrix_is_that_of_central_differences_for_every_number():
    names = tuple(STEPS)
    found = information(bench(), CAMERA, free=names)
    exact = by_differences(bench(), CAMERA, names)
    size = np.sqrt(np.diag(exact))
    # Differences of the tilts of the light lose some digits: they turn the whole bench's paths.
    allowed = np.array([1e-5 if "tilt" in name else 1e-6 for name in names])
    wrong = np.abs(found.matrix - exact) / np.outer(size, size)
    assert np.all(wrong <= np.maximum.outer(allowed, allowed)), dict(zip(names, wrong.max(axis=0), strict=True))


def test_the_conic_constant_of_a_steep_lens_is_told_as_central_differences_say():
    names, scene = ("radius", "gap", "conic"), nj.newton_rings(0.1, 550e-9, gap=0.3e-6, screen=1e-3, conic=-1.0)
    steps = {"radius": 1e-8, "gap": 1e-4, "conic": 1e-3}
    fisher, exact = information(scene, CAMERA, free=names).matrix, by_differences(scene, CAMERA, names, steps)
    size = np.sqrt(np.diag(exact))
    np.testing.assert_allclose(fisher / np.outer(size, size), exact / np.outer(size, size), rtol=0, atol=1e-5)
    gentle = nj.newton_rings(1.0, 550e-9, gap=0.3e-6, screen=1e-3, conic=-1.0)
    assert information(gentle, CAMERA, free=names).sd("conic") > 100 * information(scene, CAMERA, free=names).sd(
        "conic"
    )


@pytest.mark.parametrize(
    ("words", "steps"),
    [
        ({"asphere": (20.0, 1e5)}, {"asphere": 1e-3}),
        ({"radius_across": 0.11, "axis": 0.3}, {"radius_across": 1e-8, "astigmatism_axis": 1e-5}),
    ],
)
def test_terms_and_radii_of_a_shape_are_told_as_central_differences_say(words, steps):
    scene = nj.newton_rings(0.1, 550e-9, gap=0.3e-6, screen=1e-3, **words)
    steps = {"radius": 1e-8, "gap": 1e-4} | steps
    fisher = information(scene, CAMERA, free=tuple(steps)).matrix
    exact = by_differences(scene, CAMERA, tuple(steps), steps)
    size = np.sqrt(np.diag(exact))
    np.testing.assert_allclose(fisher / np.outer(size, size), exact / np.outer(size, size), rtol=0, atol=1e-5)


def test_bounds_are_those_of_the_inverse_of_central_differences():
    names = ("radius", "gap", "centre_x", "centre_y", "exposure")
    found, exact = information(bench(), CAMERA, free=names), by_differences(bench(), CAMERA, names)
    bounds = np.sqrt(np.diag(np.linalg.inv(exact)))
    np.testing.assert_allclose([found.sd(name) for name in names], bounds, rtol=1e-6)
    np.testing.assert_allclose([found.sd_if_all_known(name) for name in names], np.diag(exact) ** -0.5, rtol=1e-6)


@pytest.mark.parametrize("axis", [0, 1])
def test_the_plate_turns_as_a_whole(axis):
    """As the bench's own `plate_tilt`, both faces of it."""
    tilt = (2e-3, 0.0) if axis == 0 else (0.0, 2e-3)
    turned, _ = knobs(bench(), CAMERA)[f"plate_tilt_{'xy'[axis]}"].move(bench(), CAMERA, 2e-3)
    for one, other in zip(turned.surfaces, bench(plate_tilt=tilt).surfaces, strict=True):
        np.testing.assert_allclose(one.vertex, other.vertex, atol=1e-17)
        np.testing.assert_allclose(one.tilt, other.tilt, atol=1e-17)


def test_the_bound_of_a_bright_even_image_is_the_closed_form():
    """The mean of n pixels of variance σ² is known to σ / sqrt n; saturated pixels tell nothing."""
    even = nj.newton_rings(np.inf, 550e-9, 0.1e-6, screen="gap", view="transmitted")
    level = float(nj.render(even, CAMERA)[0, 0])
    found = information(even, CAMERA, free=("exposure",))
    mean, code = 8000 * level, 20_000 / 1023
    exact = 8000 * np.sqrt(mean + 25 + code**2 / 12) / mean / np.sqrt(96 * 80)
    assert found.sd("exposure") == pytest.approx(exact, rel=1e-9)
    assert information(even, CAMERA, free=("stray",), noise=0.1).sd("stray") == pytest.approx(
        0.1 / np.sqrt(96 * 80), rel=1e-9
    )
    bright = nj.Camera((96, 80), 60e-6, exposure=1e5, full_well=20_000.0)
    assert information(even, bright, free=("exposure",)).sd("exposure") == np.inf


def test_the_bound_is_that_of_a_formula_of_its_own():
    """As in `scatter.py`: gap formula, even noise, six unknowns. The bench's amplitudes vary a little."""
    pixel, count = 20e-6, 128
    y, x = np.mgrid[:count, :count] - (count - 1) / 2

    def image(radius, x0, y0, gap, background, contrast):
        r2 = ((x - x0) ** 2 + (y - y0) ** 2) * pixel**2
        thickness = gap + r2 / radius / (1 + np.sqrt(1 - r2 / radius**2))
        return (background - contrast * np.cos(4 * np.pi * thickness / 589.3e-9)).ravel()

    truth, steps = np.array([1.0, 3.3, -8.7, 0.0, 0.5, 0.5]), np.array([1e-6, 1e-3, 1e-3, 1e-11, 1e-3, 1e-3])
    slopes = np.stack([(image(*(truth + m)) - image(*(truth - m))) / (2 * m.max()) for m in np.diag(steps)], axis=1)
    size = np.linalg.norm(slopes, axis=0)
    exact = 0.05 * np.sqrt(np.linalg.inv((slopes / size).T @ (slopes / size))[0, 0]) / size[0]
    focused = nj.newton_rings(1.0, 589.3e-9, 0.0, "reflected", screen="gap")
    camera = nj.Camera((count, count), pixel, centre_px=(63.5 + 3.3, 63.5 - 8.7))
    peak = float(nj.render(focused, camera).max())
    found = information(
        focused, camera, free=("radius", "centre_x", "centre_y", "gap", "stray", "contrast"), noise=0.05 * peak
    )
    assert found.sd("radius") == pytest.approx(exact, rel=2e-3)


def test_what_is_not_told_is_said_in_words():
    focused = bench(screen="gap", light_tilt=(0.0, 0.0))
    pair = information(focused, CAMERA, free=("radius", "pixel_size", "gap", "centre_x", "centre_y"))
    assert pair.undetermined == ("radius and pixel_size: only pixel_size^2 / radius is measured",)
    assert pair.sd("radius") > 1000 * pair.sd_if_all_known("radius")
    touching = bench(screen="gap", light_tilt=(0.0, 0.0), gap=0.0)
    three = information(
        touching, CAMERA, free=("radius", "wavelength", "pixel_size", "gap", "exposure", "contrast", "stray")
    )
    text = " / ".join(three.undetermined)
    assert "radius, wavelength and pixel_size: only pixel_size^2 / (radius wavelength) is measured" in text
    assert "exposure, contrast and stray: the image does not change with" in text
    known = three.with_sd(pixel_size=0.0, wavelength=1e-12, exposure=1.0)
    assert known.undetermined == ()
    assert "radius" in str(known)
    # δR/R = 2 δs/s and -δλ/λ: what is given is what is known.
    spread = three.with_sd(pixel_size=0.01 * 60e-6, wavelength=0.0, exposure=0.0).sd("radius")
    assert spread == pytest.approx(2.0 * 0.02, rel=1e-3)
    spread = three.with_sd(pixel_size=0.0, wavelength=5.5e-9, exposure=0.0).sd("radius")
    assert spread == pytest.approx(2.0 * 0.01, rel=2e-2)


def test_priors_and_knowledge_only_help():
    found = information(bench(), CAMERA, free=FREE, sd={"exposure": 8.0})
    bought = found.sd_if_known("radius")
    assert set(bought) == set(FREE) - {"radius"}
    assert all(
        found.sd_if_all_known("radius") <= sd * (1 + 1e-9) <= found.sd("radius") * (1 + 2e-9) for sd in bought.values()
    )
    assert min(bought, key=bought.get) == "gap"
    held = found.with_sd(gap=0.0)
    assert held.sd("gap") == 0
    assert held.sd("radius") == pytest.approx(bought["gap"], rel=1e-9)
    exact = np.linalg.inv(found.matrix / np.outer(*[np.sqrt(np.diag(found.matrix))] * 2) + np.diag(
        [1 / (8.0**2 * found.matrix[k, k]) if name == "exposure" else 0.0 for k, name in enumerate(FREE)]))  # fmt: skip
    assert found.sd("radius") == pytest.approx(np.sqrt(exact[0, 0] / found.matrix[0, 0]), rel=1e-6)


def test_a_number_that_changes_nothing_is_infinite():
    wedge = nj.air_wedge(1e-3, 550e-9, 1e-6, screen="gap")
    found = information(wedge, CAMERA, free=("gap", "centre_y"))
    assert found.sd("centre_y") == np.inf
    assert found.undetermined == ("centre_y: the image does not change with it",)


@pytest.mark.parametrize(
    ("free", "message"),
    [
        (("radius", "colour"), "'colour' is not a number of this scene; allowed"),
        (("gap", "gap"), "at most once"),
        ((), "no number is named"),
    ],
)
def test_unknown_numbers_are_refused(free, message):
    with pytest.raises(ValueError, match=message):
        information(bench(), CAMERA, free=free)


def test_refusals_of_what_has_no_information():
    with pytest.raises(ValueError, match="does not reach the whole image"):
        information(bench(shield=1e-3), CAMERA)
    found = information(bench(), CAMERA, free=("radius", "gap"))
    with pytest.raises(ValueError, match="'pixel_size' is not free"):
        found.with_sd(pixel_size=1.0)
    with pytest.raises(ValueError, match="zero, a positive number"):
        found.with_sd(gap=-1.0)
    with pytest.raises(ValueError, match="follows the beams"):
        information(nj.newton_rings(1.0, beams=["T0 T1 T2 T3"], view="transmitted", screen=1e-3), CAMERA)


def told_by_codes(mean: float, read: float, code: float) -> float:
    """Fisher's information on a mean [photoelectrons] in its code: of a Poisson and a normal number, rounded."""
    counts = np.arange(int(mean + 12 * np.sqrt(mean) + 40))
    chance = poisson.pmf(counts, mean)
    slope = poisson.pmf(counts - 1, mean) - chance
    edges = (np.arange(1, int((counts[-1] + 8 * read) / code) + 3) - 0.5) * code  # code 0 is all below the first
    below = np.pad(norm.cdf((edges - counts[:, None]) / read), ((0, 0), (1, 1)), constant_values=(0, 1))
    within = np.diff(below, axis=1)
    probability, by_mean = chance @ within, slope @ within
    there = probability > 1e-300
    return float(np.sum(by_mean[there] ** 2 / probability[there]))


@pytest.mark.parametrize(("brightest", "most"), [(0.7, 0.6), (1, 0.35), (3, 0.105), (34, 0.011)])
@pytest.mark.parametrize("contrast", [0.5, 0.9, 1.0])
def test_bounds_of_dim_fringes_are_safe_and_this_much_too_large(brightest, most, contrast):
    """Against the exact sum over codes, for the phase of a fringe."""
    camera = nj.Camera((1, 1), 1e-6)
    code, angle = camera.full_well / (2**camera.bits - 1), (np.arange(64) + 0.5) / 64 * np.pi
    mean = brightest * code * (1 + contrast * np.cos(angle)) / (1 + contrast)
    exact = np.array([told_by_codes(one, camera.read_noise, code) for one in mean])
    ours = 1 / np.asarray(variance(jnp.asarray(mean[None]), camera))[0]
    over = np.sqrt(np.sum(np.sin(angle) ** 2 * exact) / np.sum(np.sin(angle) ** 2 * ours)) - 1
    assert -1e-3 <= over <= most


def test_nothing_of_it_needs_x64_to_be_set():
    with jax.enable_x64(False):
        single = information(bench(), CAMERA, free=("radius", "gap")).sd("radius")
    assert single == pytest.approx(information(bench(), CAMERA, free=("radius", "gap")).sd("radius"), rel=1e-12)


def test_other_names_scenes_and_shapes_compile_nothing():
    scenes = [
        bench(),
        nj.newton_rings(1.0, 589e-9, 0.1e-6, "transmitted", screen="gap"),
        nj.air_wedge(1e-3, screen="gap"),
    ]
    with compilations() as compiled:
        for scene, shape in zip(scenes, [(30, 40), (64, 50), (41, 41)], strict=True):
            camera = nj.Camera(shape, 50e-6)
            for names in (("gap", "exposure"), ("wavelength", "light_tilt_x", "stray"), tuple(knobs(scene, camera))):
                information(scene, camera, free=names)
        sensitivity(scenes[0], nj.Camera((33, 35), 50e-6), target="gap", free=("radius", "exposure"))
        derivative_images(scenes[1], nj.Camera((20, 30), 50e-6), ("radius", "lens_index"))
    assert compiled.count == 0
