"""Refractive indices of named matter against the catalogues' own figures, and names wherever an index is taken."""

import jax
import numpy as np
import pytest

import newtonjax as nj

D_LINE, F_LINE, C_LINE = 587.5618e-9, 486.1327e-9, 656.2725e-9


@pytest.mark.parametrize(
    ("name", "index", "tolerance"),
    [
        ("N-BK7", 1.51680, 5e-6), ("N-K5", 1.52249, 5e-6), ("N-BAF10", 1.67003, 5e-6), ("F2", 1.62004, 5e-6),
        ("SF10", 1.72825, 3e-5), ("N-SF11", 1.78472, 5e-6), ("fused silica", 1.45846, 5e-6), ("CaF2", 1.43385, 5e-6),
        ("MgF2", 1.37774, 1e-5), ("sapphire", 1.76817, 5e-6), ("water", 1.33341, 1e-5), ("air", 1.000277, 5e-7),
    ],
)  # fmt: skip
def test_indices_at_the_helium_line_are_those_of_the_catalogues(name, index, tolerance):
    assert nj.refractive_index(name, D_LINE) == pytest.approx(index, abs=tolerance)


@pytest.mark.parametrize(("name", "abbe"), [("N-BK7", 64.17), ("SF10", 28.53), ("F2", 36.37), ("fused silica", 67.82)])
def test_abbe_numbers_are_those_of_the_catalogues(name, abbe):
    spread = nj.refractive_index(name, F_LINE) - nj.refractive_index(name, C_LINE)
    assert (nj.refractive_index(name, D_LINE) - 1) / spread == pytest.approx(abbe, abs=0.02)


def test_the_oil_of_microscopes_is_that_of_the_standard():
    green, blue, red = (nj.refractive_index("immersion oil", at) for at in (546.074e-9, 479.991e-9, 643.847e-9))
    assert green == pytest.approx(1.518, abs=1e-5)
    assert (green - 1) / (blue - red) == pytest.approx(44, abs=0.05)


def test_names_stand_wherever_an_index_does(tmp_path):
    scene = nj.newton_rings(1.0, light="sodium", lens_index="n-bk7", gap_index="water", plate_index="Fused Silica")
    at = scene.wavelength
    expected = [1.0, *(nj.refractive_index(name, at) for name in ("N-BK7", "water", "fused silica")), 1.0]
    np.testing.assert_array_equal(scene.media, expected)
    (tmp_path / "a.toml").write_text('[air_wedge]\nlens_index = "SF10"\nambient_index = "air"\n')
    wedge, _ = nj.load_scene(tmp_path / "a.toml")
    # In air of its own index all indices are absolute.
    assert wedge.media[1] == pytest.approx(nj.refractive_index("SF10", 589.3e-9) * wedge.media[0])
    coated = nj.newton_rings(1.0, 500e-9, plate_coating="MgF2:91nm")
    assert coated.all_orders.lower.indices[0] == nj.refractive_index("MgF2", 500e-9)


def test_an_index_has_a_derivative_in_the_wavelength():
    with jax.enable_x64(True):
        slope = jax.grad(lambda at: nj.refractive_index("N-BK7", at))(D_LINE)
    difference = nj.refractive_index("N-BK7", D_LINE + 1e-10) - nj.refractive_index("N-BK7", D_LINE - 1e-10)
    assert float(slope) == pytest.approx(difference / 2e-10, rel=1e-5)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: nj.newton_rings(1.0, lens_index="BK8"), "lens_index: matter 'BK8' is not known; nearest: N-BK7"),
        (lambda: nj.refractive_index("N-BK7", -1.0), "wavelength is -1.0"),
        (lambda: nj.refractive_index("N-BK7", 70e-9), "N-BK7 is 7e-08; allowed: 0.3 to 2.5 um"),
        (lambda: nj.newton_rings(1.0, 1.55e-6, gap_index="water"), "water is 1.55e-06; allowed: 0.182 to 1.129 um"),
    ],
)
def test_what_has_no_index_is_refused_in_one_line(make, message):
    with pytest.raises(ValueError, match=message) as error:
        make()
    assert "\n" not in str(error.value)
