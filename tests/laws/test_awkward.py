"""What once led to a confident wrong radius, to a wrong refusal, or to an error that did not help."""

import subprocess
import sys
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from compilations import QUICKLY
from rings_data import WAVELENGTH, coordinates, rings
from scipy import ndimage

import fitting
import newtonjax as nj
from fitting.parameters import output
from fitting.photo import find_rings, read
from fitting.shell import quantities
from newtonjax.fields import fields_at

GIVEN = {"wavelength": WAVELENGTH, "pixel_size": 5e-6}


def deviations(result, radius):
    """By how many of its standard deviations a radius is off."""
    assert result.status == "ok", result.message
    return abs(result.radius - radius) / result.radius_sd


@pytest.mark.parametrize(("exposure", "bits"), [(1.3, 8), (2.0, 12), (3.0, 8), (3.0, 16)])
def test_overexposure_finds_no_harmonic_of_the_rings(exposure, bits):
    light = np.clip((rings(0.3, noise=0.02) * 0.9 + 0.05) * exposure, 0, 1)
    top = 2**bits - 1
    image = np.round(light * top).astype(np.uint8 if bits == 8 else np.uint16)
    result = fitting.fit(image, transfer="linear", **GIVEN)
    assert deviations(result, 0.3) < 4
    assert any("saturated" in text for text in result.warnings)


@pytest.mark.parametrize("orders", [1.5, 2.0, 3.0])
@pytest.mark.parametrize("phase", [0.0, 0.3])
def test_a_few_fringes_are_not_taken_for_the_light_behind_them(orders, phase):
    shape, centre = (256, 256), (204.0, 153.0)
    scale = orders / np.ptp(coordinates(shape, centre))
    radius = 25e-12 / (scale * WAVELENGTH)
    image = rings(radius, centre=centre, gap=phase * WAVELENGTH / 2, noise=0.02)
    assert deviations(fitting.fit(image, **GIVEN), radius) < 4


def _bright_things():
    y, x = np.mgrid[:200, :200]
    r = np.hypot(x - 90, y - 115)
    random = np.random.default_rng(3)
    noise = 0.005 * random.normal(size=r.shape)
    return {
        "lamp": np.clip(1.5 * np.exp(-(r**2) / 2 / 45**2) + noise, 0, 1),
        "spot": np.exp(-(r**2) / 2 / 30**2) + noise,
        "disc": 1 / (1 + np.exp((r - 60) / 4)) + noise,
        "one ring": np.exp(-((r - 55) ** 2) / 2 / 8**2) + noise,
        "cloud": ndimage.gaussian_filter(random.normal(size=r.shape), 20) * 50 + noise,
        "ramp": x / 200 + noise,
    }


@pytest.mark.parametrize("name", sorted(_bright_things()))
def test_what_is_bright_but_no_ring_system_gives_no_radius(name):
    result = fitting.fit(_bright_things()[name], **GIVEN)
    assert result.status in ("refused", "not-converged")
    assert result.radius is None


@pytest.mark.parametrize(
    ("offset", "period"), [((0.8, 0.0), 4), ((4.0, 0.0), 6), ((1.5, 0.5), 3), ((0.8, 0.0), 2.5), ((0.0, 0.0), 2.5)]
)
def test_fringes_finer_than_the_coarse_image_are_found(offset, period):
    shape = (512, 512)
    centre = tuple((1 + 2 * part) * 255.5 for part in offset)
    far = np.hypot(*(max(c, 511 - c) for c in centre))
    scale = 1 / (2 * far * period)
    random = np.random.default_rng(0)
    image = 0.5 + 0.5 * np.cos(2 * np.pi * scale * coordinates(shape, centre)) + 0.05 * random.normal(size=shape)
    found = find_rings(read(image))
    assert found.match > 0.3
    assert found.scale == pytest.approx(scale, rel=0.05)


@pytest.mark.parametrize(("count", "value"), [(1, 1000.0), (20, 65.0), (1, -1000.0)])
def test_hot_and_dead_pixels_cost_nothing(count, value):
    image = rings(0.3, noise=0.02)
    plain = fitting.fit(image, **GIVEN)
    at = np.random.default_rng(1).integers(0, 256, (2, count))
    image[at[0], at[1]] = value
    result = fitting.fit(image, **GIVEN)
    assert deviations(result, 0.3) < 4
    assert result.radius_sd == pytest.approx(plain.radius_sd, rel=0.02)


def test_colours_of_sixteen_bits_keep_their_bits(tmp_path):
    import png
    import tifffile

    grey = np.round(np.clip(rings(0.3, noise=0.01) * 0.8 + 0.1, 0, 1) * 65535).astype(np.uint16)
    colours = np.stack([grey, grey // 2, grey // 4], axis=-1)
    with (tmp_path / "deep.png").open("wb") as file:
        png.Writer(256, 256, greyscale=False, bitdepth=16).write(file, colours.reshape(256, -1).tolist())
    tifffile.imwrite(tmp_path / "deep.tif", colours, photometric="rgb")
    for name in ("deep.png", "deep.tif"):
        photograph = read(tmp_path / name)
        assert photograph.transfer == "linear"
        assert photograph.channel == "red"
        scale = np.percentile(grey / 65535, 99.5)
        assert np.abs(photograph.image - grey / 65535 / scale).max() < 1e-9


def test_transparent_and_masked_pixels_are_left_out():
    codes = np.round(rings(0.3) * 200).astype(np.uint8)
    clear = np.dstack([codes, codes, codes, np.full_like(codes, 255)])
    clear[:, 200:, :] = 0
    assert not read(clear).mask[:, 200:].any()
    masked = np.ma.MaskedArray(rings(0.3), mask=np.zeros((256, 256), bool))
    masked.mask[:, 200:] = True
    assert not read(masked).mask[:, 200:].any()
    assert read(masked).mask[:, :200].all()


def test_wide_integers_are_read_by_their_values():
    codes = np.round(rings(0.3, noise=0.01).clip(0, 1) * 255)
    assert fitting.fit(codes.astype(np.int64), **GIVEN).radius == fitting.fit(codes.astype(np.uint8), **GIVEN).radius


# Of types that the annotations forbid: run as users run it, without the suite's type checks.
NONSENSE = """
import numpy as np, fitting
import newtonjax as nj
from rings_data import rings
nan = float("nan")
good = {"wavelength": 589.3e-9, "pixel_size": 5e-6}
for wrong in (
    {"wavelength": 589.3}, {"wavelength": "sodum"}, {"pixel_size": 10}, {"pixel_size": "10um"},
    {"pixel_size": np.array([1e-5, 2e-5])}, {"fixed": {"gap": np.nan}}, {"fixed": {"gap": "0nm"}},
    {"fixed": {"centre_px": 5}}, {"fixed": {"centre_px": (1.0,)}}, {"fixed": ("gap",)},
    {"start": {"radius": 0, "centre_px": (1, 1)}}, {"start": {"radius": 1.0, "centre_px": (1, np.nan)}},
    {"wavelength": None, "wavelength_sd": 1e-9}, {"wavelength_sd": "1nm"}, {"free": "gap"},
):
    try:
        fitting.fit(rings(0.3), **{**good, **wrong})
    except ValueError as error:
        assert "\\n" not in str(error), error
        print(error)
    else:
        raise SystemExit(f"{wrong} was taken")
for wrong in ({"lens_tilt": (nan, 0.0)}, {"light_tilt": (1.0, 2.0, 3.0)}, {"plate_tilt": 0.1}, {"polarization": nan}):
    try:
        nj.newton_rings(**wrong)
    except ValueError as error:
        assert "allowed" in str(error), error
        print(error)
    else:
        raise SystemExit(f"{wrong} was taken")
"""


def test_arguments_that_mean_nothing_are_refused_in_one_line():
    folder = Path(__file__).parents[1]
    command = [sys.executable, "-c", NONSENSE]
    done = subprocess.run(command, capture_output=True, text=True, cwd=folder, timeout=300, check=False)
    assert done.returncode == 0, done.stderr + done.stdout
    assert len(done.stdout.splitlines()) == 15 + 4


def test_a_lens_smaller_than_its_field_blames_the_units():
    result = fitting.fit(rings(0.3, noise=0.02), wavelength=589.3e-6, pixel_size=5e-6)
    assert result.status == "refused"
    assert "units" in result.message


def test_saturated_through_and_through_is_refused_like_black():
    for image in (np.full((64, 64), 255, np.uint8), np.zeros((64, 64), np.uint8), np.full((64, 64), np.nan)):
        assert fitting.fit(image, **GIVEN).status == "refused"


def test_what_is_held_is_reported_as_it_was_given():
    image = rings(0.3, gap=1.234e-6, noise=0.02)
    held = fitting.fit(image, fixed={"gap": 1.234e-6}, **GIVEN)
    assert held.gap == 1.234e-6
    assert held.parameters["gap"] == fitting.Parameter(1.234e-6, None, True, "gap", "m")
    assert held.names == ("radius", "centre_x_px", "centre_y_px")
    assert np.linalg.matrix_rank(held.covariance) == 3
    assert deviations(held, 0.3) < 4
    centre = fitting.fit(image, fixed={"centre_px": (130.0, 120.0)}, **GIVEN)
    assert centre.names == ("radius", "gap")
    assert centre.parameters["centre_x_px"].fixed


def test_a_held_centre_outside_of_the_frame_keeps_the_gap():
    image = rings(0.3, centre=(400.0, 90.0), gap=-60e-9, noise=0.02)
    free = fitting.fit(image, **GIVEN)
    held = fitting.fit(image, fixed={"centre_px": (400.0, 90.0)}, **GIVEN)
    assert abs(held.gap + 60e-9) < 5 * held.parameters["gap"].sd
    assert abs(free.gap + 60e-9) < 5 * free.parameters["gap"].sd


def test_a_gap_that_contradicts_the_view_is_warned_of():
    result = fitting.fit(rings(0.3, noise=0.02), fixed={"gap": WAVELENGTH / 4}, **GIVEN)
    assert any("check gap and view" in text for text in result.warnings)


@pytest.mark.parametrize(
    ("name", "unknown"), [("pixel_size", "radius"), ("radius", "wavelength"), ("gap_index", "radius")]
)
def test_budget_of_a_steep_sphere_is_that_of_refitting(name, unknown):
    truth = {"radius": 0.9e-3, "wavelength": WAVELENGTH, "pixel_size": 1e-6, "gap_index": 1.0}
    image = rings(truth["radius"], truth["pixel_size"], noise=0.01, microscope=False)
    given = {key: value for key, value in truth.items() if key != unknown}
    # A sphere that does not go with the pixel size calls for a distortion: with the same parts all three times.
    given["parts"] = {"distortion": False}
    result = fitting.fit(image, **given, **{f"{name}_sd": 1e-3 * truth[name]})
    both = [
        fitting.fit(image, **{**given, name: truth[name] * (1 + sign * 1e-3)}).parameters[unknown].value
        for sign in (1, -1)
    ]
    assert dict(result.budget)[name] == pytest.approx(abs(both[0] - both[1]) / 2, rel=1e-3)


@pytest.mark.parametrize("fixed", [{}, {"gap": 0.0}])
def test_a_tilted_bench_keeps_to_its_own_gap(fixed):
    scene = nj.newton_rings(1.0, WAVELENGTH, view="transmitted", screen=0.1, light_tilt=(0.05, 0.02))
    image = np.asarray(nj.render(scene, nj.Camera((256, 256), 10e-6, centre_px=(134.0, 123.0)), nj.Chebyshev(17)))
    image = (image - image.min()) / np.ptp(image) + 0.01 * np.random.default_rng(0).normal(size=image.shape)
    result = fitting.fit(image, scene=scene, pixel_size=10e-6, fixed=fixed)
    assert deviations(result, 1.0) < 4
    assert abs(result.gap) < 5e-9


def test_a_bench_that_does_not_make_the_fringes_is_refused():
    scene = nj.newton_rings(0.3, WAVELENGTH, view="reflected", screen=0.03)
    image = np.asarray(nj.render(scene, nj.Camera((256, 256), 5e-6), nj.Chebyshev(17)))
    image = (image - image.min()) / np.ptp(image) + 0.01 * np.random.default_rng(0).normal(size=image.shape)
    result = fitting.fit(image, scene=scene, pixel_size=5e-6, fixed={"centre_px": (60.0, 60.0)})
    assert result.status in ("refused", "not-converged")
    assert result.radius is None


def test_a_noiseless_image_claims_no_more_than_rounding_allows():
    """What the bench's glass and whole waves in the gap leave uncertain is far above that, and rows of its own."""
    result = fitting.fit(rings(0.3), **GIVEN)
    assert abs(result.radius / 0.3 - 1) < 1e-9
    assert 0 < result.radius_sd_noise / 0.3 < 1e-9


def test_second_derivatives_hold_where_a_component_of_the_field_vanishes():
    scene = nj.newton_rings(0.1, WAVELENGTH, 3e-7, "reflected", screen=1e-3)

    def background(tilt):
        tilted = eqx.tree_at(lambda s: s.light.tilt, scene, jnp.stack([jnp.zeros_like(tilt), tilt]))
        return fields_at(tilted, jnp.zeros((1, 2))).background[0]

    slope, step = jax.jit(jax.jacfwd(background), compiler_options=QUICKLY), 1e-5
    second = float(jax.jit(jax.jacfwd(jax.jacfwd(background)), compiler_options=QUICKLY)(0.0))
    assert second == pytest.approx(float(slope(step) - slope(-step)) / (2 * step), rel=1e-4)


def test_a_link_keeps_pointing_and_its_target_gets_the_answer(tmp_path):
    (tmp_path / "target.json").write_text("old")
    link = tmp_path / "link.json"
    link.symlink_to(tmp_path / "target.json")
    output.write(link, "new", force=True)
    assert link.is_symlink()
    assert (tmp_path / "target.json").read_text() == "new"
    dangling = tmp_path / "dangling.json"
    dangling.symlink_to(tmp_path / "nowhere.json")
    with pytest.raises(FileExistsError, match="--force"):
        output.check_free([dangling], force=False)


def test_devices_and_one_file_for_two_answers_are_refused(tmp_path):
    with pytest.raises(ValueError, match="not a regular file"):
        output.check_free([Path("/dev/null")], force=True)
    with pytest.raises(ValueError, match="two answers"):
        output.check_free([tmp_path / "a.json", tmp_path / "a.json"], force=False)


@pytest.mark.parametrize("text", ["10px", "3pel", "4dot"])
def test_a_pixel_is_no_unit_of_length(text):
    with pytest.raises(ValueError, match="no unit of length"):
        quantities.length(text)
