"""Steps on the phase of the fringes alone, from wherever they start."""

from types import SimpleNamespace

import numpy as np
import pytest

from fitting.estimate import Problem
from fitting.parameters import NUMBERS
from fitting.photograph.phase_map import Target

CENTRE = NUMBERS.index("centre_x")


def _problem(slope):
    """A phase that is `slope` times the centre's place, at three places, and that no prior holds."""

    def slopes_at(x, _y, numbers):
        slopes = dict.fromkeys(NUMBERS, np.zeros(len(x)))
        return slope * numbers[CENTRE] * np.ones(len(x)), slopes | {"centre_x": np.full(len(x), slope)}

    nothing = np.zeros(len(NUMBERS))

    class Line(Problem):
        phase = SimpleNamespace(slopes_at=slopes_at)
        moving = np.arange(len(NUMBERS)) == CENTRE
        pull = (nothing, nothing)

    return object.__new__(Line)


def _target(turns):
    target = object.__new__(Target)
    target.negligible, target.root = 1e-12, 1.0
    target.x = target.y = np.arange(3.0)
    target.turns = np.full(3, turns)
    return target


def test_the_numbers_that_make_a_phase_are_reached():
    end = _target(0.6).nearest(_problem(2.0), np.zeros(len(NUMBERS)), {})
    assert end.numbers[CENTRE] == pytest.approx(0.3)
    assert end.cost == pytest.approx(0.0, abs=1e-20)


@pytest.mark.parametrize("slope", [np.nan, np.inf, 1e200])
def test_a_start_where_the_phase_has_no_slope_ends_there(slope):
    start = np.zeros(len(NUMBERS))
    end = _target(0.6).nearest(_problem(slope), start, {})
    assert np.array_equal(end.numbers, start)
