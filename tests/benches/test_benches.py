"""The ready benches."""

import jax
import numpy as np
import pytest

import newtonjax as nj


def by_hand():
    """The contract's bench, surface by surface, with numbers worked out on paper."""
    return nj.Scene(
        surfaces=(
            nj.Surface(0.0, (0.0, 0.0, 2e-6 + 5e-3)),
            nj.Surface(0.5, (0.0, 0.0, 2e-6)),
            nj.Surface(),
            nj.Surface(0.0, (0.0, 0.0, -5e-3)),
        ),
        media=(1.0, 1.5, 1.0, 1.5, 1.0),
        light=nj.Light(500e-9),
        screen=nj.Surface(0.0, (0.0, 0.0, -6e-3)),
        beams=("T0 T1 T2 T3", "T0 T1 R2 R1 T2 T3"),
    )


def test_a_scene_built_by_hand_from_surfaces_equals_the_preset():
    preset = nj.newton_rings(2.0, 500e-9, 2e-6, view="transmitted", screen=1e-3)
    assert jax.tree.structure(preset) == jax.tree.structure(by_hand())
    for one, other in zip(jax.tree.leaves(preset), jax.tree.leaves(by_hand()), strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_microscope_on_the_gap_focuses_where_the_glass_shows_it():
    """Through a plate of thickness d a point is seen at d / n from the plate's far face."""
    through_plate = nj.newton_rings(2.0, screen="gap", plate_thickness=6e-3, plate_index=1.6, view="transmitted")
    assert abs(through_plate.screen.vertex[2] - (-6e-3 + 6e-3 / 1.6)) < 1e-18
    through_lens = nj.newton_rings(2.0, screen="gap", view="reflected", lens_thickness=4e-3)
    assert abs(through_lens.screen.vertex[2] - (4e-3 - 4e-3 / 1.5)) < 1e-18


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"radius": 0.0}, "radius is 0.0; allowed: a non-zero radius"),
        ({"radius": float("nan")}, "radius is nan; allowed: a non-zero radius"),
        ({"wavelength": 0.0}, "wavelength is 0.0; allowed: a positive length"),
        ({"gap": float("inf")}, "gap is inf; allowed: a finite height"),
        ({"lens_thickness": 0.0}, "lens_thickness is 0.0; allowed: a positive thickness"),
        ({"plate_thickness": -1.0}, "plate_thickness is -1.0; allowed: a positive thickness"),
        ({"screen": "near"}, "screen is 'near'; allowed: a distance in metres, or 'gap'"),
        ({"screen": True}, "screen is True; allowed: a distance"),
        ({"wavelength": None}, "wavelength is None; allowed: a positive length"),
        (
            {"polarization_degree": 2.0, "polarization": 0.0},
            "polarization_degree is 2.0; allowed: a number from 0 to 1",
        ),
        ({"beams": "R1"}, "beams is 'R1'; allowed: a sequence of names"),
        ({"light_tilt": 0.1}, "light_tilt is 0.1; allowed: two angles"),
        ({"view": "above"}, "view is 'above'; allowed: 'transmitted' or 'reflected'"),
        ({"radius": 1e-6}, r"radius is 1e-06; allowed: a non-zero radius, 10 um to 100 km"),
        ({"radius": -2e5}, r"radius is -200000.0; allowed: a non-zero radius, 10 um to 100 km"),
        ({"radius": [1.0, 2.0]}, r"radius is \[1.0, 2.0\]; allowed: a non-zero radius"),
        ({"radius": np.array([1.0, 2.0])}, r"radius is array\(\[1., 2.\]\); allowed: one number; vmap over several"),
        ({"lens_tilt": np.zeros((2, 3))}, "lens_tilt is array.*; allowed: two angles in radians"),
        ({"lens_tilt": ((0.1, 0.2), (0.1, 0.2))}, "lens_tilt is .*; allowed: two angles in radians"),
        ({"wavelength": 589.3}, "wavelength is 589.3; allowed: a positive length, 10 nm to 1 mm"),
        ({"lens_index": 1 + 0.1j}, r"lens_index is \(1\+0.1j\); allowed: a positive refractive index, 0.1 to 10"),
        ({"lens_tilt": (45, 0)}, r"lens_tilt is \(45, 0\); allowed: two angles .* below 45 degrees"),
        ({"lens_index": -1.5}, "lens_index is -1.5; allowed: a positive refractive index"),
    ],
)
@pytest.mark.usefixtures("untyped")
def test_a_bench_that_cannot_be_is_refused_with_field_value_and_allowed(given, message):
    with pytest.raises(ValueError, match=message):
        nj.newton_rings(**given)


def test_stacks_of_the_wrong_size_are_refused_with_the_counts():
    with pytest.raises(ValueError, match="media has 2 refractive indices for 2 surfaces"):
        nj.Scene((nj.Surface(), nj.Surface()), (1.0, 1.5), nj.Light(5e-7), nj.Surface(), ("T0 T1",))
    with pytest.raises(ValueError, match=r"screen.curvature is 0.1; allowed: 0"):
        nj.Scene((nj.Surface(),), (1.0, 1.5), nj.Light(5e-7), nj.Surface(0.1), ("T0",))


def test_a_traced_vector_is_no_number_of_a_bench():
    with pytest.raises(ValueError, match=r"radius is .*; allowed: one number; vmap over several"):
        jax.jit(nj.newton_rings)(np.array([1.0, 2.0]))


@pytest.mark.usefixtures("untyped")
def test_surfaces_in_a_list_become_a_tuple():
    scene = by_hand()
    listed = nj.Scene(list(scene.surfaces), scene.media, scene.light, scene.screen, scene.beams)
    assert isinstance(listed.surfaces, tuple)
    assert jax.tree.structure(listed) == jax.tree.structure(scene)


def test_benches_take_traced_numbers_and_batch():
    batch = jax.vmap(
        lambda r: nj.newton_rings(r, gap=1e-7 * r, lens_tilt=(1e-3 * r, 0.0), view="transmitted", screen=1e-3)
    )(np.array([1.0, 2.0]))
    np.testing.assert_array_equal(batch.surfaces[1].curvature, [1.0, 0.5])
    single = nj.newton_rings(2.0, gap=2e-7, lens_tilt=(2e-3, 0.0), view="transmitted", screen=1e-3)
    for one, many in zip(jax.tree.leaves(single), jax.tree.leaves(batch), strict=True):
        np.testing.assert_allclose(np.asarray(many)[1] if np.ndim(many) > np.ndim(one) else many, one, rtol=1e-15)
