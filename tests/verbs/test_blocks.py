"""Images in blocks of rows, and sweeps over scenes: the same numbers as one image after the other."""

import subprocess
import sys
import textwrap
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import newtonjax as nj

PAPER = partial(nj.newton_rings, view="transmitted", screen=1e-3)
CAMERA = nj.Camera((61, 40), 60e-6, centre_px=(12.5, 70.25))


def rings(**more):
    return PAPER(2.0, 500e-9, 1e-6, light_tilt=(1e-3, 0.0), **more)


def whole(made):
    image = np.full(made.camera.shape, np.nan)
    for first, part in made:
        image[first : first + len(part)] = part
    return image


@pytest.mark.parametrize(
    ("method", "rows"),
    [
        (nj.Traced(), 32),
        *((nj.Chebyshev(7, dtype), rows) for dtype in ("float64", "float32") for rows in (1, 16, 1000)),
    ],
)
def test_blocks_are_the_rows_of_the_image(method, rows):
    image = np.asarray(nj.render(rings(), CAMERA, method))
    made = nj.blocks(rings(), CAMERA, method, rows=rows)
    np.testing.assert_allclose(whole(made), image, atol=2e-6 if method == nj.Chebyshev(7, "float32") else 1e-10)
    assert [first for first, _ in made] == list(range(0, 61, rows))  # a second time


def test_blocks_plan_as_render_does_and_keep_the_closed_form():
    focused = nj.newton_rings(2.0, 500e-9, 1e-6, screen="gap", view="transmitted")
    made = nj.blocks(focused, CAMERA, rows=20)
    assert made.method == nj.ClosedForm()
    np.testing.assert_allclose(whole(made), nj.render(focused, CAMERA, nj.ClosedForm()), atol=1e-12)
    assert isinstance(nj.blocks(rings(), CAMERA).method, nj.Chebyshev)
    with jax.enable_x64(False):
        (block,) = nj.blocks(rings(), CAMERA)
    assert block[1].dtype == np.float32


def test_blocks_refuse_what_they_cannot_do():
    with pytest.raises(ValueError, match="rows is 0; allowed: 1 or more"):
        nj.blocks(rings(), CAMERA, rows=0)
    with pytest.raises(ValueError, match="Splat pairs rays over the whole image"):
        nj.blocks(rings(), CAMERA, nj.Splat())
    small = rings(shield=0.5e-3)
    with pytest.raises(ValueError, match="does not reach the whole image"):
        list(nj.blocks(small, CAMERA, nj.Chebyshev(9)))


PEAK = """
    import resource, numpy as np, newtonjax as nj
    scene = nj.newton_rings(2.0, 500e-9, view="transmitted", screen=1e-3)
    def through(size):
        total = 0.0
        for _, part in nj.blocks(scene, nj.Camera((size, size), 5e-3 / size), nj.Chebyshev(5)):
            total += float(part.sum())
        return total / size**2, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**10
    (small, before), (large, after) = through(2048), through(16384)
    print(small, large, after - before)
"""


def test_an_image_of_268_million_pixels_takes_no_more_memory_than_its_blocks():
    said = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(PEAK)], check=True, capture_output=True, text=True
    ).stdout
    small, large, growth = map(float, said.split())
    assert large == pytest.approx(small, rel=1e-3)
    assert growth < 200  # MiB; the image has 1024 in float32


def test_a_sweep_is_one_image_after_the_other():
    radii, gaps = np.array([0.5, 1.0, 2.0, -3.0, np.inf]), np.linspace(0, 1e-6, 5)
    made = nj.sweep(PAPER, {"radius": radii, "gap": gaps, "wavelength": 550e-9}, CAMERA, batch=2)
    assert made.shape == (5, *CAMERA.shape)
    for image, radius, gap in zip(made, radii, gaps, strict=True):
        truth = nj.render(
            nj.newton_rings(radius, 550e-9, gap, view="transmitted", screen=1e-3), CAMERA, nj.Chebyshev(17)
        )
        np.testing.assert_allclose(image, truth, atol=1e-3 * float(truth.max()))


def test_a_sweep_keeps_what_is_made_of_an_image():
    def summary(image):
        return {"mean": image.mean(), "row": image[3]}

    wavelengths = np.linspace(450e-9, 650e-9, 7)
    found = nj.sweep(_bench, {"wavelength": wavelengths}, CAMERA, nj.Chebyshev(9), reduce=summary, batch=3)
    for number, wavelength in enumerate(wavelengths):
        image = nj.render(_bench(wavelength), CAMERA, nj.Chebyshev(9))
        assert float(found["mean"][number]) == pytest.approx(float(image.mean()), rel=1e-10)
        np.testing.assert_allclose(found["row"][number], image[3], atol=1e-9)


def _bench(wavelength):
    return nj.newton_rings(2.0, wavelength, view="transmitted", screen=1e-3)


def test_a_sweep_takes_the_memory_of_a_batch():
    def compiled(count):
        from newtonjax.methods.pictures import images_on_nodes

        nodes = jnp.zeros((count, 3, 9, 9))
        analysis = images_on_nodes.lower(nodes, CAMERA.shape, "float64", jnp.mean, 4).compile().memory_analysis()
        return analysis.temp_size_in_bytes

    assert compiled(4096) < compiled(8) + 4096 * 64


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"wavelength": [5e-7, 6e-7], "radius": [1.0, 2.0, 3.0]}, "lengths {'wavelength': 2, 'radius': 3}"),
        ({"wavelength": 5e-7}, "allowed: arrays of one length"),
        ({"wavelength": []}, "empty"),
        ({"radius": [1.0, 0.0]}, "radius is 0.0"),
        ({"radius": [1.0, 2.0], "gap": [[1.0]]}, "allowed: an array of one axis, or a number"),
    ],
)
def test_a_sweep_refuses_with_a_line(values, message):
    with pytest.raises(ValueError, match=message.replace("{", r"\{").replace("}", r"\}")):
        nj.sweep(PAPER, values, CAMERA)


def test_a_sweep_looks_at_every_scene():
    """Not only at those that it plans for: traced numbers are not checked, and would give an image of NaN."""
    radii = np.full(200, 2.0)
    radii[101] = 0.0
    for method in (None, nj.Chebyshev(5)):
        with pytest.raises(ValueError, match=r"scene 101 \(radius = 0\): radius is 0.0"):
            nj.sweep(PAPER, {"radius": radii}, CAMERA, method, reduce=jnp.mean)


def test_a_sweep_names_the_scene_whose_beams_do_not_arrive():
    values = {"radius": np.array([2.0, 2.0, 1e-3])}
    with pytest.raises(ValueError, match=r"scene 2 \(radius = 0.001\): Chebyshev cannot honour"):
        nj.sweep(PAPER, values, CAMERA, nj.Chebyshev(5))


@pytest.mark.parametrize("method", [nj.Traced(), nj.ClosedForm()])
def test_a_sweep_without_nodes_is_one_image_after_the_other_too(method):
    def bench(radius):
        return nj.newton_rings(radius, screen="gap", view="transmitted")

    radii = np.array([0.5, 1.0, 2.0])
    images = np.stack([nj.render(bench(radius), CAMERA, method) for radius in radii])
    np.testing.assert_array_equal(nj.sweep(bench, {"radius": radii}, CAMERA, method), images)
    means = nj.sweep(bench, {"radius": radii}, CAMERA, method, reduce=lambda image: {"mean": image.mean()})
    np.testing.assert_allclose(means["mean"], images.mean(axis=(1, 2)), rtol=1e-12)


def test_a_sweep_in_float32_gives_float32():
    with jax.enable_x64(False):
        made = nj.sweep(_bench, {"wavelength": np.array([5e-7, 6e-7])}, CAMERA, reduce=jnp.mean)
    assert made.dtype == np.float32


@pytest.mark.parametrize("method", [nj.Chebyshev(5), nj.ClosedForm()])
def test_a_sweep_counts_its_scenes_twice(method):
    steps = []
    bench = partial(nj.newton_rings, view="transmitted")
    values = {"radius": np.array([1.0, 2.0, 3.0])}
    nj.sweep(bench, values, CAMERA, method, reduce=jnp.mean, progress=lambda *step: steps.append(step))
    assert steps[:3] == [(1, 6), (2, 6), (3, 6)]
    assert steps[-1] == (6, 6)


@pytest.mark.parametrize("reduce", [int, float, np.std, "{}".format, lambda image: image.item()])
def test_what_jax_cannot_trace_is_no_reduce(reduce):
    with pytest.raises(ValueError, match=r"allowed: a function of jax\.numpy from an image to arrays") as error:
        nj.sweep(PAPER, {"radius": [1.0, 2.0]}, CAMERA, reduce=reduce)
    assert "\n" not in str(error.value)


def test_an_error_of_the_users_function_is_his_own():
    def reduce(image):
        return {}[image.shape]

    with pytest.raises(KeyError):
        nj.sweep(PAPER, {"radius": [1.0, 2.0]}, CAMERA, reduce=reduce)
