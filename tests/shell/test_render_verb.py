"""The verb render: pictures, methods, benches, and what it says of them."""

import subprocess
import sys
from pathlib import Path

import imageio.v3 as imageio
import jax
import numpy as np
import pytest
from shell import refusal

import newtonjax as nj
from fitting.shell.cli import main


def decoded(path):
    codes = imageio.imread(path)
    if codes.dtype == np.uint16:
        return codes / 65535
    value = codes / 255
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


@pytest.mark.parametrize(("bits", "step"), [(16, 0.5 / 65535), (8, 0.6 * 2.4 / 255)])
def test_a_rendered_file_reads_back_as_linear_light(capsys, tmp_path, bits, step):
    path = tmp_path / "rings.png"
    options = f"--radius 2m --wavelength 500nm --screen 1mm --shape 48x64 --nodes 5 --bits {bits} --output {path}"
    assert main(["render", "transmitted", *options.split()]) == 0
    scene = nj.newton_rings(2.0, 500e-9, view="transmitted", screen=1e-3)
    truth = np.asarray(nj.render(scene, nj.Camera((48, 64), 5e-6), nj.Chebyshev(5)))
    assert np.abs(decoded(path) - truth / truth.max()).max() <= step * 1.001
    said = capsys.readouterr().out
    assert f"white is {truth.max():.6g} of the incident irradiance" in said
    assert "Chebyshev, 5 x 5 nodes" in said
    assert "turns" in said


def test_a_tiff_is_written_block_by_block_with_the_same_values(capsys, tmp_path, monkeypatch):
    options = ["--radius", "2m", "--screen", "1mm", "--shape", "48x64", "--nodes", "5", "--expose"]
    monkeypatch.setattr("newtonjax.verbs.row_blocks._PIXELS", 64 * 10)  # five blocks, the last of eight rows
    assert main(["render", "transmitted", *options, "--output", str(tmp_path / "rings.tif")]) == 0
    assert main(["render", "transmitted", *options, "--output", str(tmp_path / "rings.png")]) == 0
    blocks, whole = (imageio.imread(tmp_path / f"rings.{kind}") for kind in ("tif", "png"))
    assert blocks.dtype == np.uint16
    assert np.array_equal(blocks, whole)
    assert not np.array_equal(blocks[:10], blocks[10:20])
    assert not list(tmp_path.glob(".*"))
    assert "is there already" in refusal(capsys, "render", "transmitted", *options, "--output", tmp_path / "rings.tif")


def test_an_exposure_is_a_photograph_that_a_seed_repeats(capsys, tmp_path):
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        options = f"--expose --screen 1mm --seed {seed} --shape 48x64 --nodes 5 --output {tmp_path / name}.png"
        assert main(["render", "transmitted", *options.split()]) == 0
    a, b, c = (imageio.imread(tmp_path / f"{name}.png") for name in "abc")
    assert np.array_equal(a, b)
    assert not np.array_equal(a, c)
    assert "read noise of 5, seed 2" in capsys.readouterr().out


def test_a_scene_file_renders_as_its_preset_and_keeps_its_camera(capsys, tmp_path):
    scene, path = tmp_path / "scene.toml", tmp_path / "rings.png"
    nj.save_scene(scene, nj.newton_rings(2.0, 500e-9, view="transmitted", screen=1e-3), nj.Camera((48, 64), 5e-6))
    assert main(["render", str(scene), "--nodes", "5", "--output", str(path)]) == 0
    options = f"--radius 2m --wavelength 500nm --screen 1mm --shape 48x64 --nodes 5 --output {tmp_path / 'preset.png'}"
    assert main(["render", "transmitted", *options.split()]) == 0
    assert path.read_bytes() == (tmp_path / "preset.png").read_bytes()
    assert "is what the command reads" in refusal(capsys, "render", scene, "-o", png_named(scene))


def png_named(scene):
    """A name that ends in .png and is the scene file."""
    link = scene.with_suffix(".png")
    link.symlink_to(scene)
    return link


def test_a_method_that_misses_the_tolerance_is_refused(capsys, tmp_path):
    options = f"--nodes 3 --screen 1mm --tolerance 1e-9 --shape 48x64 --output {tmp_path / 'a.png'}"
    assert "is over --tolerance" in refusal(capsys, "render", "transmitted", *options.split())


def test_existing_pictures_stay_without_force(capsys, tmp_path):
    path = tmp_path / "rings.png"
    path.write_text("mine")
    assert "--force" in refusal(capsys, "render", "reflected", "--output", path)
    assert path.read_text() == "mine"


def test_the_papers_algorithm_says_its_pairs_its_error_and_the_pixels_without_any(capsys, tmp_path):
    options = "--radius 2m --wavelength 500nm --screen 100mm --shape 48x64 --method splat"
    assert main(["render", "reflected", *options.split(), "--output", str(tmp_path / "a.png")]) == 0
    said = capsys.readouterr().out
    found = nj.splat(nj.newton_rings(2.0, 500e-9, view="reflected", screen=0.1), nj.Camera((48, 64), 5e-6))
    assert f"pairs: {found.pairs.emitted} emitted, {found.pairs.paired} paired" in said
    assert f"phase error of its pairs: {found.error:.2g} turns" in said
    assert "estimated error" not in said
    assert f"{int(found.unpaired.sum())} pixels are lit by pairs further apart than epsilon" in said
    assert main(["render", "reflected", *options.split()[:-2], "--epsilon", "1mm", "-o", str(tmp_path / "b.png")]) == 0
    said = capsys.readouterr().out
    assert "Splat" in said
    assert "further apart" not in said
    assert main(["render", "reflected", *options.split(), "--beams", "R1,R2,R3", "-o", str(tmp_path / "c.png")]) == 0
    assert "the mean of the pairs of 3 beams is not the sum of their fields" in capsys.readouterr().out


def test_the_bench_of_the_options_is_that_of_the_call(capsys, tmp_path):
    options = "--radius 2m --wavelength 500nm --screen 1m --shape 48x64 --pixel-size 100um --collecting-lens 100mm"
    more = "--shield 0.2mm --polarization 30deg --beams direct,R2-R1,R3-R2"
    path = tmp_path / "rings.png"
    assert main(["render", "transmitted", *options.split(), *more.split(), "--output", str(path)]) == 0
    scene = nj.newton_rings(
        2.0, 500e-9, screen=1.0, collecting_lens=0.1, shield=0.2e-3, polarization=np.pi / 6,
        beams=["direct", "R2-R1", "R3-R2"], view="transmitted",
    )  # fmt: skip
    truth = np.asarray(nj.render(scene, nj.Camera((48, 64), 100e-6)))
    assert 0 < np.mean(truth == 0) < 1
    assert np.abs(decoded(path) - truth / truth.max()).max() <= 1e-5
    assert "not every beam reaches the whole image" in capsys.readouterr().out


def test_a_screen_of_2048_pixels_to_a_side_splats_within_a_gigabyte(tmp_path):
    """Of the whole process, Python and JAX included: its high-water mark, which Linux tells."""
    if not Path("/proc/self/status").is_file():
        pytest.skip("no /proc/self/status: this system does not tell a process's largest memory there")
    program = (
        "import re, sys; from fitting.shell.cli import main; code = main(sys.argv[1:]); "
        "sys.exit(code or re.search('VmHWM: *(.*)', open('/proc/self/status').read())[1])"
    )
    options = "--screen 0.1mm --radius 2m --wavelength 500nm --shape 2048x2048 --epsilon 0.1mm"
    arguments = ["render", "reflected", *options.split(), "--output", str(tmp_path / "a.png")]
    done = subprocess.run([sys.executable, "-c", program, *arguments], capture_output=True, text=True, check=False)
    kibibytes, unit = done.stderr.split()[-2:]
    assert unit == "kB"
    assert int(kibibytes) < 2**20
    assert "4194304" not in done.stdout  # more nodes than pixels
    assert imageio.imread(tmp_path / "a.png").shape == (2048, 2048)


@pytest.mark.parametrize(("radius", "is_said"), [("2000m", True), ("2m", False)])
def test_a_radius_of_which_no_ring_is_seen_is_doubted(capsys, tmp_path, radius, is_said):
    command = ["render", "reflected", "--radius", radius, "--shape", "64x64", "--pixel-size", "60um"]
    assert main([*command, "--output", str(tmp_path / "rings.png")]) == 0
    assert ("of a fringe lies between middle and corner, of a radius of 2000 m" in capsys.readouterr().out) == is_said


def test_colours_are_those_of_the_library(capsys, tmp_path):
    options = "reflected --light white:5500K --radius 0.2m --shape 20x30 --pixel-size 40um --colour"
    assert main(["render", *options.split(), "--output", str(tmp_path / "a.png")]) == 0
    camera = nj.Camera((20, 30), 40e-6, response=nj.cie_1931())
    xyz = np.asarray(nj.render(nj.newton_rings(0.2, light="white:5500K"), camera))
    expected = np.rint(255 * nj.to_srgb(xyz / xyz[..., 1].max()))
    np.testing.assert_allclose(imageio.imread(tmp_path / "a.png").astype(float), expected, atol=1)
    assert main(["render", *options.split(), "--expose", "--output", str(tmp_path / "b.png")]) == 2
    assert "leave out --expose" in capsys.readouterr().err


COLOUR_CAMERA = """
[newton_rings]
radius = 0.5
light = "mercury"

[camera]
shape = [40, 48]
pixel_size = 20e-6
exposure = 9e3
response = "{curves}"
mosaic = "RGGB"
full_scale = 16000.0
transfer = "srgb"
jpeg = 90

[camera.lens]
distortion = 0.05
vignette = 0.2
magnifications = [1.001, 1.0, 0.999]
"""


def test_a_photograph_of_a_colour_camera_is_that_of_the_call(capsys, tmp_path):
    curves, scene, path = tmp_path / "camera.csv", tmp_path / "bench.toml", tmp_path / "rings.png"
    curves.write_text("wavelength_nm,red,green,blue\n420,0,0,1\n500,0.1,0.6,0.3\n580,0.6,0.7,0\n660,0.8,0,0\n")
    scene.write_text(COLOUR_CAMERA.format(curves=curves))
    assert main(["render", str(scene), "--expose", "--seed", "4", "--output", str(path)]) == 0
    assert "values: 8 bits, sRGB" in capsys.readouterr().out
    bench, camera = nj.load_scene(scene)
    expected = camera.expose(nj.render(bench, camera), jax.random.key(4))
    np.testing.assert_array_equal(imageio.imread(path), expected)
    assert np.ptp(imageio.imread(path).astype(int), axis=2).max() > 20
    assert "end with .png" in refusal(capsys, "render", scene, "--expose", "--output", tmp_path / "rings.tif")
