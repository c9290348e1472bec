"""Scenes and cameras in TOML files."""

import jax
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import newtonjax as nj

BY_HAND = """media = [1.0, 1.5, 1.0]
beams = ['R0', 'T0 R1 T0']
[[surfaces]]
[[surfaces]]
curvature = 2.0
[screen]
[light]
wavelength = 5e-7
"""


def assert_same(one, other):
    """The same tree, and every number the same to the last bit."""
    assert jax.tree.structure(one) == jax.tree.structure(other)
    for a, b in zip(jax.tree.leaves(one), jax.tree.leaves(other), strict=True):
        np.testing.assert_array_equal(a, b)
        np.testing.assert_array_equal(np.signbit(a), np.signbit(b))


def assert_round_trip(path, scene, camera=None):
    path.unlink(missing_ok=True)
    nj.save_scene(path, scene, camera)
    back, its_camera = nj.load_scene(path)
    assert_same(back, scene)
    assert_same(its_camera, camera)


@pytest.mark.parametrize("view", ["transmitted", "reflected"])
@pytest.mark.parametrize("polarization", [None, 0.1 + 0.2])
def test_presets_come_back_from_their_files_to_the_last_bit(tmp_path, view, polarization):
    scene = nj.newton_rings(
        1 / 3, 589.3e-9, 1e-7 / 3, view, lens_tilt=(0.1 / 3, -1e-300), polarization=polarization, screen="gap"
    )
    assert_round_trip(tmp_path / "scene.toml", scene, nj.Camera((3, 4), 1e-6 / 7, (0.1, -2e9), bits=12))
    assert_round_trip(tmp_path / "wedge.toml", nj.air_wedge(1e-4 / 3, view=view))
    scene = nj.newton_rings(1 / 3, view=view, screen=4 / 3, shield=1e-3 / 3, collecting_lens=0.1 / 3)
    assert_round_trip(tmp_path / "lens.toml", scene)
    (tmp_path / "bench.toml").write_text(
        f'[newton_rings]\nradius = {1 / 3}\nview = "{view}"\nscreen = {4 / 3}\nshield = {1e-3 / 3}\n'
        f"collecting_lens = {0.1 / 3}\n"
    )
    assert_same(nj.load_scene(tmp_path / "bench.toml")[0], scene)


FLOATS = st.floats(allow_nan=False, allow_infinity=False)
POSITIVE = st.floats(1e-12, 1e12)
WAVELENGTHS = st.floats(1e-8, 1e-3)
TWO, THREE = st.tuples(FLOATS, FLOATS), st.tuples(FLOATS, FLOATS, FLOATS)
FROM_ABOVE = st.tuples(st.floats(-1.57, 1.57), st.floats(-1.57, 1.57))
SURFACES = st.tuples(FLOATS, THREE, TWO)
CAMERAS = st.tuples(
    st.tuples(st.integers(1, 9), st.integers(1, 9)),
    POSITIVE,
    st.none() | TWO,
    POSITIVE,
    POSITIVE,
    st.floats(0, 1e6),
    st.integers(8, 16),
)


@given(
    surfaces=st.tuples(SURFACES, SURFACES),
    media=st.tuples(POSITIVE, POSITIVE, POSITIVE),
    light=st.tuples(WAVELENGTHS, FROM_ABOVE, st.none())
    | st.tuples(WAVELENGTHS, FROM_ABOVE, FLOATS, st.none() | st.floats(-0.785, 0.785), st.none() | st.floats(0, 1)),
    screen=st.tuples(st.just(0.0), THREE, TWO),
    beams=st.sampled_from([("T0 T1",), ("T0 T1", "T0 R1 R0 T1"), ("R0",)]),
    camera=st.none() | CAMERAS,
)
def test_every_scene_and_camera_comes_back_to_the_last_bit(
    tmp_path_factory, surfaces, media, light, screen, beams, camera
):
    scene = nj.Scene(tuple(nj.Surface(*s) for s in surfaces), media, nj.Light(*light), nj.Surface(*screen), beams)
    path = tmp_path_factory.getbasetemp() / "any.toml"
    assert_round_trip(path, scene, None if camera is None else nj.Camera(*camera))


def test_a_ready_bench_in_a_file_is_the_one_that_the_call_makes(tmp_path):
    path = tmp_path / "rings.toml"
    path.write_text(
        '[newton_rings]\nradius = 2\nview = "reflected"\nscreen = "gap"\nlens_tilt = [1e-3, 0]\n'
        "[camera]\nshape = [3, 4]\npixel_size = 5e-6\n"
    )
    scene, camera = nj.load_scene(path)
    assert_same(scene, nj.newton_rings(2.0, view="reflected", screen="gap", lens_tilt=(1e-3, 0.0)))
    assert_same(camera, nj.Camera((3, 4), 5e-6))


@pytest.mark.parametrize(
    ("text", "messages"),
    [
        ("[newton_rings]\nwavelength = -5e-7", ["wavelength is -5e-07; allowed: a positive length"]),
        ("[newton_rings]\nradius = 0.0", ["radius is 0.0", "allowed: a non-zero radius"]),
        ("[newton_rings]\nradius = 2e6", ["radius is 2000000.0", "allowed: a non-zero radius, 10 um to 100 km"]),
        ("[newton_rings]\nview = 'sideways'", ["view is 'sideways'", "'transmitted' or 'reflected'"]),
        ("[newton_rings]\nscreen = 'far'", ["screen is 'far'", "a distance in metres, or 'gap'"]),
        (
            "[newton_rings]\nradios = 1.0",
            ["[newton_rings]", "unknown field `radios`; it takes radius, wavelength, gap"],
        ),
        ("[newton_rings]\nradius = '2 m'", ["newton_rings.radius is '2 m'; allowed: `float`, got `str`"]),
        ("[newton_rings]\nlens_tilt = [1.0]", ["newton_rings.lens_tilt is [1.0]; allowed: `array` of length 2"]),
        ("[air_wedge]\nwedge_angle = 2.0", ["angle is 2.0", "below 45 degrees"]),
        (
            "[newton_rings]\n[camera]\nshape = [0, 4]\npixel_size = 1e-6",
            ["shape is (0, 4)", "both at least 1"],
        ),
        (
            "[newton_rings]\n[camera]\nshape = [4, 4]",
            ["[camera]", "missing required field `pixel_size`; it takes shape, pixel_size"],
        ),
        ("[newton_rings]\n[air_wedge]", ["newton_rings, air_wedge", "one of [newton_rings], [air_wedge], or"]),
        ("[newton_ring]", ["unknown field `newton_ring`; it takes newton_rings, air_wedge, surfaces"]),
        ("[newton_rings]\nbeams = ['T0', 3]", ["newton_rings.beams[1] is 3; allowed: `str`"]),
        ("[camera]\nshape = [4, 4]\npixel_size = 1e-6", ["neither", "one of [newton_rings]"]),
        ("beams = ['R0']\nmedia = [1.0, 1.5]", ["missing; a scene by hand takes surfaces, media, beams"]),
        ("radius = = 2", ["Invalid value"]),
        (
            "[newton_rings]\n[camera]\nshape = [4, 4]\npixel_size = -1.0",
            ["[camera] pixel_size is -1.0; allowed: a positive length"],
        ),
        (
            BY_HAND.replace("curvature = 2.0", "curvature = nan"),
            ["surfaces[1] curvature is nan; allowed: a finite number"],
        ),
        (
            BY_HAND.replace("curvature = 2.0", "curvatur = 2.0"),
            ["surfaces[1] Object contains unknown field `curvatur`; it takes curvature, vertex, tilt"],
        ),
        (BY_HAND + "tilt = [0.0, 9.0]", ["[light] tilt is array([0., 9.]); allowed: angles whose light"]),
        (
            BY_HAND + "[shield]\nradius = 0.0",
            ["[shield] radius is 0.0; allowed: a positive radius"],
        ),
        ('[newton_rings]\n"x - at `$.a`" = 1', ["[newton_rings]", "unknown field `x - at `$.a``; it takes radius"]),
        ('"x - at `$.a`" = 1', ["[file]", "unknown field `x - at `$.a``; it takes newton_rings"]),
    ],
)
def test_a_bad_file_is_refused_with_its_name_the_field_and_what_is_allowed(tmp_path, text, messages):
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(ValueError, match=r"bad\.toml: ") as refusal:
        nj.load_scene(path)
    for message in messages:
        assert message in str(refusal.value)


@pytest.mark.parametrize("text", [f"[newton_rings]\nradius = '{'a' * 5000}'", f"[newton_rings]\n{'a' * 5000} = 1"])
def test_a_long_value_is_not_echoed_whole(tmp_path, text):
    (tmp_path / "long.toml").write_text(text)
    with pytest.raises(ValueError, match=r"a\.\.\.") as refusal:
        nj.load_scene(tmp_path / "long.toml")
    assert len(str(refusal.value)) < 700


@pytest.mark.parametrize("text", ["[newton_rings]\nradius = nan", "[newton_rings]\nwavelength = inf"])
def test_numbers_that_no_bench_has_are_refused(tmp_path, text):
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(ValueError, match="allowed"):
        nj.load_scene(path)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"nowhere\.toml is not a file"):
        nj.load_scene(tmp_path / "nowhere.toml")


def test_an_existing_file_is_not_overwritten(tmp_path):
    path = tmp_path / "scene.toml"
    nj.save_scene(path, nj.newton_rings(view="transmitted", screen=1e-3))
    before = path.read_text()
    with pytest.raises(FileExistsError):
        nj.save_scene(path, nj.newton_rings(2.0, view="transmitted", screen=1e-3))
    assert path.read_text() == before
    nj.save_scene(path, nj.newton_rings(3.0), force=True)
    assert nj.load_scene(path)[0].surfaces[1].curvature == pytest.approx(1 / 3, rel=1e-15)


def test_a_byte_order_mark_is_no_part_of_a_file(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text("[newton_rings]\nradius = 2.0\n", encoding="utf-8-sig")
    assert nj.load_scene(path)[0].surfaces[1].curvature == 0.5


def test_what_is_not_one_scene_leaves_no_file(tmp_path):
    path = tmp_path / "scene.toml"
    batch = jax.vmap(nj.newton_rings)(np.array([1.0, 2.0]))
    with pytest.raises(ValueError, match=r"is \(0.0, 0.0\); allowed: .*\(a file holds one scene, not a batch\)$"):
        nj.save_scene(path, batch)
    cameras = jax.vmap(lambda size: nj.Camera((2, 2), size))(np.array([1e-6, 2e-6]))
    with pytest.raises(ValueError, match=r"camera.pixel_size is \(1e-06, 2e-06\); allowed: `float`"):
        nj.save_scene(path, nj.newton_rings(), cameras)
    with pytest.raises(
        ValueError, match="a file of a scene needs numbers, but the scene or the camera is being traced"
    ):
        jax.jit(lambda radius: nj.save_scene(path, nj.newton_rings(radius)))(1.0)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("untyped")
def test_what_is_no_scene_leaves_no_file(tmp_path):
    for scene, camera in ((0, None), (nj.newton_rings(1.0), 3)):
        with pytest.raises(ValueError, match=r"(scene is 0; allowed: a Scene|camera is 3; allowed: a Camera)$"):
            nj.save_scene(tmp_path / "scene.toml", scene, camera)
    assert list(tmp_path.iterdir()) == []


def test_surfaces_that_are_no_spheres_come_back_from_their_files(tmp_path):
    words = {"zernike": (0.0, 1e-8, 3e-8 / 7), "zernike_radius": 5e-3, "plate_radius": -2.0}
    for more in ({"conic": -1 / 3, "asphere": (2e2 / 3,)}, {"radius_across": 1.9, "axis": 0.1, "odd_asphere": (0.3,)}):
        scene = nj.newton_rings(2.0, **words, **more)
        assert_round_trip(tmp_path / "scene.toml", scene)
        lines = [f"{name} = {list(v) if isinstance(v, tuple) else v}" for name, v in (words | more).items()]
        (tmp_path / "bench.toml").write_text("\n".join(["[newton_rings]", "radius = 2.0", *lines]))
        assert_same(nj.load_scene(tmp_path / "bench.toml")[0], scene)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("conic = -1.0\nradius_across = 1.0", "conic and curvature_across are both given; allowed: one of them"),
        ("axis = 0.1", "axis is given without curvature_across"),
        ("zernike = [1e-8]", "one is given without the other"),
        ("zernike = []\nzernike_radius = 5e-3", r"zernike is .*; allowed: 1 to 136 heights in metres, piston first"),
        ("zernike = [1e-8]\nzernike_radius = -1.0", "zernike_radius is -1.0; allowed: a positive radius"),
        ("asphere = [1.0, nan]", "asphere is .*; allowed: 1 to 8 finite coefficients"),
        (f"asphere = {[1.0] * 9}", "asphere is .*; allowed: 1 to 8 finite coefficients"),
        ("radius_across = 0.0", "radius_across is 0.0; allowed: a non-zero radius"),
    ],
)
def test_a_shape_that_none_is_is_refused(tmp_path, line, message):
    (tmp_path / "bad.toml").write_text(f"[newton_rings]\n{line}\n")
    with pytest.raises(ValueError, match=message):
        nj.load_scene(tmp_path / "bad.toml")
