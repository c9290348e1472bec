"""Published tables of ring readings give their published radii."""

import numpy as np
import pytest
from ring_tables import WAVELENGTH

import fitting

# Name, arguments, radius and standard deviation [m] that the folder's README prints, and the last digit it prints.
PUBLISHED = [
    ("lens_1550mm", {"wavelength": 589e-9}, 1541.3, 4.4),
    ("oblique_22deg", {"wavelength": 547e-9, "view_angle": np.radians(22)}, 1150.0, None),
    ("lens_1000mm", {"wavelength": WAVELENGTH, "pixel_size": 1e-3 / 77.28}, 1076.0, None),
    ("repeats_rings_1_11", {"wavelength": WAVELENGTH}, 1062.4, 6.4),
]


@pytest.mark.parametrize(("name", "given", "radius", "sd"), PUBLISHED, ids=[row[0] for row in PUBLISHED])
def test_published_tables_give_their_published_radius(shared, name, given, radius, sd):
    result = fitting.rings(shared / "tables" / f"{name}.csv", **given)
    assert result.status == "ok"
    assert 1e3 * result.radius == pytest.approx(radius, abs=0.55 if radius > 1e3 else 0.5)
    if sd is not None:
        assert 1e3 * result.radius_sd == pytest.approx(sd, rel=0.015)


def test_reading_errors_as_large_as_the_rings_give_a_finite_radius_and_deviation(shared):
    result = fitting.rings(shared / "tables" / "coarse_microscope.csv", wavelength=590e-9)
    # The table's slope without its deviations is 113 +- 7 mm; its deviations allow three times as much.
    assert result.radius == pytest.approx(0.113, abs=0.007)
    assert 0.01 < result.radius_sd < 0.04


def test_a_misread_ring_is_flagged_and_not_averaged_away(shared):
    result = fitting.rings(shared / "tables" / "misread.csv", wavelength=WAVELENGTH)
    assert [bool(ring.flag) for ring in result.rings] == [False, False, True]
    assert any("misread" in text for text in result.warnings)
    # 848 +- 481 mm; three readings leave one degree of freedom, for which Student's 97.5 % quantile is 12.7.
    assert (result.status, result.radius) == ("refused", None)
    assert "below 6.96 m" in result.message
    assert "order 7 is the likeliest to be misread" in result.message


def test_diameters_in_place_of_radii_are_noticed_where_the_radius_is_roughly_known(shared):
    path, given = shared / "tables" / "radii_in_pixels.csv", {"wavelength": WAVELENGTH, "pixel_size": 33.3e-6}
    result = fitting.rings(path, pixel_size_sd=3e-6, expected_radius=0.47, **given)
    assert any("look like diameters" in text for text in result.warnings)
    right = fitting.rings(path, columns={"diameter_px": "radius_px"}, pixel_size_sd=3e-6, expected_radius=0.47, **given)
    assert not any("look like" in text for text in right.warnings)
    assert abs(right.radius - 0.47) < 2 * right.radius_sd
