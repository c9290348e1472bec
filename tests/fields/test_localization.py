"""The plane where fringes are localized, against plane geometry."""

import numpy as np
import pytest

import newtonjax as nj


def test_the_gaps_fringes_of_a_wedge_are_localized_in_the_image_of_its_gap():
    """Head-on, the inner faces' rays meet a paraxial image depth below the upper plate's face."""
    wedge = nj.air_wedge(1e-5, gap=0.0, lens_index=1.5, plate_index=1.5)
    # d - d/n = 5 mm / 3, seen from above; to first order in the angle.
    assert nj.meeting_height(wedge, "R1", "R2") == pytest.approx(5e-3 / 3, rel=1e-4)


@pytest.mark.parametrize("tilt", [0.02, -0.03, 0.3])
def test_oblique_light_moves_the_meeting_of_outer_and_inner_faces_out(tilt):
    """Rays of faces 0 and 2 leave 2 d tan(t') cos(t) apart and turn towards each other by twice the angle."""
    angle, d = 1e-5, 5e-3
    wedge = nj.air_wedge(angle, light_tilt=(0.0, tilt))
    inside = np.arcsin(np.sin(tilt) / 1.5)
    # The parting on the plate is s = 2 d tan(t'); a turn by 2 α of the surface moves a ray at height h by 2 α h / cos².
    height = d + 2 * d * np.tan(inside) * np.cos(tilt) ** 2 / (2 * angle)
    for pair in (("R0", "R2"), ("R1", "R3")):
        assert nj.meeting_height(wedge, *pair) == pytest.approx(height, rel=1e-2)


def test_faces_of_one_plate_meet_at_infinity():
    assert np.isinf(nj.meeting_height(nj.air_wedge(1e-4), "R0", "R1"))
    assert np.isinf(nj.meeting_height(nj.air_wedge(1e-4), "R2", "R3"))


def test_rings_are_localized_where_their_rays_cross():
    """Reflected: slopes 2 n r/R and 2 (n - 1) r/R, from the same r on the face: they meet in the gap's image."""
    assert nj.meeting_height(
        nj.newton_rings(2.0, view="reflected", screen=1e-3), "R1", "R2", (1e-4, 0.0)
    ) == pytest.approx(5e-3 - 5e-3 / 1.5, rel=1e-3)


def test_what_cannot_meet_is_refused():
    with pytest.raises(ValueError, match="is unknown"):
        nj.meeting_height(nj.air_wedge(), "R0", "R8")
    with pytest.raises(ValueError, match="both sides"):
        nj.meeting_height(nj.air_wedge(), "R0", "direct")
    with pytest.raises(ValueError, match="do not both leave"):
        nj.meeting_height(nj.newton_rings(1e-3, view="transmitted", screen=1e-3), "R1", "R2", (2e-3, 0.0))
