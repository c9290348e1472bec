"""The rings that are expected of given numbers: those of the closed form, and of a fit that has them."""

import numpy as np
import pytest

from fitting.photograph import expected_rings


def radii(lines, centre):
    return np.array([np.hypot(*(line - centre).T).mean() for line in lines])


@pytest.mark.parametrize(("view", "first"), [("reflected", 1.0), ("transmitted", 0.5)])
@pytest.mark.parametrize("turns", [0.0, 0.25])
def test_dark_rings_are_where_the_path_has_whole_waves_or_half_of_one_more(view, first, turns):
    centre, scale = (330.0, 225.0), 1e-4
    lines = expected_rings((480, 640), centre, scale, gap_turns=turns, view=view)
    inside = [line for line in lines if np.allclose(line[0], line[-1])]
    exact = np.sqrt((first + np.arange(5) - turns) / scale)
    # Between points of a grid the square of the radius is interpolated by straight lines.
    assert radii(inside[: len(exact)], centre) == pytest.approx(exact, rel=5e-4)


def test_a_stretch_makes_ellipses_whose_axes_differ_by_its_exponential():
    (line, *_) = expected_rings((480, 640), (320.0, 240.0), 1e-4, gap_turns=-0.5, numbers={"stretch": 0.1})
    across, down = np.ptp(line, axis=0)
    assert down / across == pytest.approx(np.exp(0.1), rel=2e-3)


def test_rings_too_fine_for_the_grid_are_left_out():
    assert expected_rings((480, 640), (320.0, 240.0), 1.0) == []
    assert len(expected_rings((480, 640), (-2000.0, 240.0), 1e-5)) <= 40
