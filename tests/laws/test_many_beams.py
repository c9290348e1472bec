"""All orders in a gap, coated or not, against Airy's formula and the tmm package; energy; derivatives."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tmm import coh_tmm

import newtonjax as nj
from newtonjax.fields import airy_of, airy_pixels
from newtonjax.scene import channels_of, face_amplitudes

CAMERA = nj.Camera((5, 6), 0.2e-3)
LENS, PLATE, GAP = 1.52, 1.6, 1.33
# On lens and plate: bare, dielectric and absorbing layers, and both; thicknesses [nm] and indices from the glass.
STACKS = [
    ((), ()),
    ((), ((100, 1.38),)),
    (((80, 2.3),), ()),
    (((80, 2.3), (120, 1.46)), ((50, 1.9), (107, 1.38), (61, 2.2))),
    (((15, 0.05 + 3.1j),), ()),
    ((), ((30, 1.4 + 7.2j), (40, 1.5))),
    (((15, 0.05 + 3.1j),), ((25, 0.05 + 3.1j),)),
    (((300, 4.1 + 0.04j),), ((5, 2.9 + 3.0j), (90, 2.1))),
    (((64, 2.3), (107, 1.38)) * 3, ((64, 2.3), (107, 1.38)) * 3),
    (((0, 2.0), (30, GAP)), ((50, PLATE),)),
]


def coating_of(layers):
    if not layers:
        return None
    thicknesses, indices = zip(*layers, strict=True)
    numbers = np.array(indices, complex)
    return nj.Coating(np.array(thicknesses) * 1e-9, numbers.real, numbers.imag if numbers.imag.any() else None)


def bench(above, below, view="reflected", **options):
    return nj.newton_rings(
        1.0, 500e-9, 1e-6, view, lens_index=LENS, plate_index=PLATE, gap_index=GAP, beams="all",
        lens_coating=coating_of(above), plate_coating=coating_of(below), **options,
    )  # fmt: skip


def peer(above, below, thickness, polarization="s", sine=0.0):
    """Reflected and transmitted shares of the whole stack from glass to glass, in tmm (Byrnes 2016)."""
    indices = [LENS, *(n for _, n in above), GAP, *(n for _, n in reversed(below)), PLATE]
    lengths = [np.inf, *(d for d, _ in above), thickness * 1e9, *(d for d, _ in reversed(below)), np.inf]
    stack = coh_tmm(polarization, indices, lengths, np.arcsin(sine / LENS), 500)
    return stack["R"], stack["T"]


@pytest.mark.parametrize("view", ["reflected", "transmitted"])
def test_images_of_ten_stacks_are_those_of_tmm(view):
    with jax.enable_x64(True):
        for above, below in STACKS:
            scene = bench(above, below, view)
            image = np.asarray(nj.render(scene, CAMERA))
            thickness = np.asarray(nj.opd(scene, CAMERA)) / 2 / GAP
            for pixel in ((0, 0), (2, 3)):
                reflected, passed = peer(above, below, thickness[pixel])
                into, out = (4 * n / (n + 1) ** 2 for n in (LENS, PLATE))  # the outer faces
                expected = into * into * reflected if view == "reflected" else into * passed * out
                assert image[pixel] == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(("above", "below"), STACKS)
def test_oblique_light_of_both_polarizations_is_that_of_tmm(above, below):
    sine, thickness = 0.7, 1.23e-6
    turns = 2 * GAP * thickness / 500e-9 * np.sqrt(1 - (sine / GAP) ** 2)
    shares = []
    for view in ("reflected", "transmitted"):
        scene = bench(above, below, view, ambient_index=LENS)  # no outer faces
        scene = nj.Scene(scene.surfaces, (LENS, LENS, GAP, PLATE, PLATE), scene.light, scene.screen, scene.beams,
                         all_orders=scene.all_orders)  # fmt: skip
        airy = airy_of(scene, np.array(500e-9), np.array(sine**2))
        shares.append(airy_pixels(airy.parts(), np.cos(2 * np.pi * turns), np.sin(2 * np.pi * turns)))
    for k, polarization in enumerate("sp"):
        expected = peer(above, below, thickness, polarization, sine)
        np.testing.assert_allclose([shares[0][k], shares[1][k]], expected, atol=1e-9)


def test_mirrors_are_airys_and_no_energy_is_lost_over_all_orders():
    reflectance, turns = 0.9, np.linspace(0, 1, 7)
    mirror = nj.Coating(reflectance=reflectance, phase=0.4)
    shares = []
    for view in ("transmitted", "reflected"):
        scene = nj.newton_rings(1.0, 500e-9, view=view, lens_index=1.0, plate_index=1.0, lens_coating=mirror,
                                plate_coating=mirror)  # fmt: skip
        airy = airy_of(scene, np.array(500e-9), np.array(0.0))
        parts = tuple(part[0] for part in airy.parts())
        shares.append(airy_pixels(parts, np.cos(2 * np.pi * turns), np.sin(2 * np.pi * turns)))
    phase = np.pi * turns + 0.4
    finesse = 4 * reflectance / (1 - reflectance) ** 2
    np.testing.assert_allclose(shares[0], 1 / (1 + finesse * np.sin(phase) ** 2), atol=1e-12)
    np.testing.assert_allclose(sum(shares), 1.0, atol=1e-12)


@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float32, 1e-3), (np.float64, 1e-12)])
def test_peaks_of_good_mirrors_do_not_cancel(dtype, tolerance):
    """Transmitted: T² / |1 - R e^{iφ}|² = 1 / (1 + F sin² φ/2), F = 4R / T² (Born and Wolf, section 7.6.1)."""
    reflectance = 1 - 2.0**-10
    phase = np.array([0.0, 1e-4, 1e-3, 1e-2, 1.0])
    level = (1 - reflectance) / (1 + reflectance)
    parts = tuple(dtype(part) for part in (level, level * reflectance, 0.0, reflectance, 0.0))
    image = airy_pixels(parts, np.cos(phase).astype(dtype), np.sin(phase).astype(dtype))
    finesse = 4 * reflectance / (1 - reflectance) ** 2
    np.testing.assert_allclose(image, 1 / (1 + finesse * np.sin(phase / 2) ** 2), rtol=tolerance)


def test_what_absorbs_takes_what_is_neither_reflected_nor_passed():
    above, below = STACKS[6]
    for (layers, glass), toward in zip(((above, LENS), (below, PLATE)), (1, -1), strict=True):
        face = face_amplitudes(coating_of(layers), glass, GAP, np.array(500e-9), np.array(0.09))
        absorbed = 1 - np.abs(face.outside) ** 2 - face.transmittance
        stack = [glass, *(n for _, n in layers), GAP]
        expected = coh_tmm("s", stack, [np.inf, *(d for d, _ in layers), np.inf], np.arcsin(0.3 / glass), 500)
        assert absorbed[0] == pytest.approx(1 - expected["R"] - expected["T"], abs=1e-12)
        assert absorbed.min() > 0.01 * toward * toward


def test_the_orders_of_lines_with_widths_fade_each_by_its_own_path():
    words, coated = "500nm/2nm", {"lens_coating": "mirror:50%", "plate_coating": "mirror:50%"}
    scene, camera = nj.newton_rings(0.1, light=words, gap=4e-6, **coated), nj.Camera((1, 60), 20e-6)
    image = np.asarray(nj.render(scene, camera, nj.ClosedForm()))
    # The sum over the line's profile, of which each part is sharp.
    middle, fwhm = 1 / 500e-9, 2e-9 / 500e-9**2
    offsets = np.linspace(-2, 2, 801)
    weights = np.exp(-4 * np.log(2) * offsets**2)
    parts = nj.Spectrum(1 / (middle + offsets * fwhm), weights)
    sharp = np.asarray(nj.render(nj.newton_rings(0.1, light=parts, gap=4e-6, **coated), camera, nj.ClosedForm()))
    np.testing.assert_allclose(image, sharp, atol=2e-4)
    line = nj.render(nj.newton_rings(0.1, 500e-9, 4e-6, **coated), camera, nj.ClosedForm())
    assert np.ptp(image) < 0.95 * np.ptp(np.asarray(line))


@jax.jit
@jax.value_and_grad
def level_of_coated(numbers):
    """Of a small image; thickness [nm] and index of a layer on the plate."""
    coated = nj.Coating(numbers[:1] * 1e-9, numbers[1:])
    scene = nj.newton_rings(1.0, 500e-9, 80e-9, plate_coating=coated)
    return nj.render(scene, nj.Camera((1, 5), 0.2e-3), nj.ClosedForm()).sum()


@jax.jit
@jax.value_and_grad
def reflected_obliquely(index):
    face = face_amplitudes(nj.Coating((50e-9,), (index,)), 1.5, 1.33, np.array(500e-9), np.array(1.44))
    return jnp.abs(face.outside[1]) ** 2


@pytest.mark.parametrize("thickness", [0.0, 30.0])
@pytest.mark.parametrize("index", [1.0, 1.5, 2.0])
def test_derivatives_in_thickness_and_index_hold_where_layers_vanish(thickness, index):
    # 1.0 is the gap's index, 1.5 the plate's.
    with jax.enable_x64(True):
        numbers = np.array([thickness, index])
        slopes = np.asarray(level_of_coated(numbers)[1])
        for k, step in enumerate((1.0, 1e-4)):
            change = step * np.eye(2)[k]
            difference = level_of_coated(numbers + change)[0] - level_of_coated(numbers - change)[0]
            assert slopes[k] == pytest.approx(float(difference) / (2 * step), rel=1e-3, abs=1e-6)


def test_a_layer_at_its_critical_angle_has_derivatives():
    with jax.enable_x64(True):
        slope = reflected_obliquely(1.2)[1]
        difference = (reflected_obliquely(1.2 + 1e-5)[0] - reflected_obliquely(1.2 - 1e-5)[0]) / 2e-5
    assert float(slope) == pytest.approx(float(difference), rel=1e-6)


def test_traced_images_of_a_few_lines_are_the_eager_ones():
    scene = nj.newton_rings(0.2, light="mercury", gap=1e-6, plate_coating="2.3:64nm")
    eager = np.asarray(nj.render(scene, CAMERA))
    with jax.enable_x64(True):
        traced = jax.jit(lambda s: nj.render(s, CAMERA, nj.ClosedForm()))(scene)
    np.testing.assert_allclose(eager, traced, atol=2e-6)
    assert len(channels_of(scene.light, None).lines.ratios) > 1


MIRRORS = nj.Camera((1, 24), 20e-6)


def between_mirrors(reflectance, spectrum):
    mirror = nj.Coating(reflectance=reflectance)
    return nj.newton_rings(
        0.1, light=spectrum, gap=4e-6, view="transmitted", beams="all", lens_coating=mirror, plate_coating=mirror
    )


@jax.jit
@jax.value_and_grad
def seen_between_mirrors(reflectance, spectrum, weights):
    return (nj.render(between_mirrors(reflectance, spectrum), MIRRORS, nj.ClosedForm()) * weights).sum()


@pytest.mark.parametrize("shape", ["gaussian", "lorentzian"])
def test_traced_mirrors_are_the_sum_over_all_harmonics(shape):
    spectrum = nj.Spectrum((500e-9, 501e-9), (2.0, 1.0), **{shape: (0.02e-9, 0.03e-9)})
    weights, orders = np.random.default_rng(1).normal(size=(1, 24)), np.arange(1, 4000)[:, None, None]
    with jax.enable_x64(True):
        bare = nj.newton_rings(0.1, light=spectrum, gap=4e-6, view="transmitted")
        lines = channels_of(bare.light, None).lines
        turns = np.asarray(nj.opd(bare, MIRRORS)).ravel() / float(bare.wavelength)
        faded = np.stack([lines.fading(m * turns) for m in orders.ravel()])
        waves = faded * np.cos(2 * np.pi * orders * np.asarray(lines.ratios)[:, None] * turns)
        outside = float(nj.render(between_mirrors(0.0, spectrum), MIRRORS, nj.ClosedForm()).max())

        for reflectance in (0.5, 0.95, 0.99):
            # Born and Wolf, section 7.6.1, with each harmonic faded over its own path; glass and air share the rest.
            powers = np.stack([reflectance**orders, orders * reflectance ** (orders - 1.0)])
            sums = 2 * (powers * waves).sum(axis=1) + np.array([1.0, 0.0])[:, None, None]
            passed, slope = weights[0] @ (lines.shares @ sums).T
            peak = (1 - reflectance) / (1 + reflectance)
            expected = outside * np.array([passed * peak, slope * peak - 2 * passed / (1 + reflectance) ** 2])
            np.testing.assert_allclose(
                seen_between_mirrors(reflectance, spectrum, weights), expected, rtol=1e-6, atol=1e-6 * outside
            )


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"lens_coating": "1.38"}, "is no layer"),
        ({"lens_coating": "mirror:110%"}, "reflectance"),
        ({"plate_coating": "mirror:most"}, "is no reflectance"),
        ({"plate_coating": 3}, "plate_coating is 3"),
        ({"plate_coating": "1.38:107nm", "beams": ("R1", "R2")}, "beams with a coating"),
    ],
)
def test_coatings_that_do_not_exist_are_refused_in_one_line(options, message):
    with pytest.raises(ValueError, match=message) as error:
        nj.newton_rings(1.0, **options)
    assert "\n" not in str(error.value)


def test_what_no_closed_form_has_is_refused():
    coated = {"plate_coating": "2.3:64nm"}
    with pytest.raises(ValueError, match="all orders"):
        nj.render(nj.newton_rings(1.0, **coated), CAMERA, nj.Traced())
    with pytest.raises(ValueError, match="ClosedForm cannot honour"):
        nj.render(nj.newton_rings(1.0, screen=0.01, **coated), CAMERA)
    with pytest.raises(ValueError, match="errs by"):  # fringes that bend within the square of a pixel
        nj.render(nj.newton_rings(1.0, **coated), nj.Camera((5, 6), 0.2e-3, aperture=1.0, blur=1.0))


def test_coatings_survive_a_file_and_are_explained(tmp_path):
    (tmp_path / "a.toml").write_text('[newton_rings]\nbeams = "all"\nplate_coating = "1.46:20nm, 0.05+3.1i:30nm"\n')
    scene, _ = nj.load_scene(tmp_path / "a.toml")
    nj.save_scene(tmp_path / "b.toml", scene)
    again, _ = nj.load_scene(tmp_path / "b.toml")
    np.testing.assert_array_equal(again.all_orders.lower.extinctions, [0.0, 3.1])
    assert jax.tree.structure(again) == jax.tree.structure(scene)
    assert "all orders" in str(nj.explain(scene, CAMERA))
