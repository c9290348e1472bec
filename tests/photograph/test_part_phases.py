"""What parts do to the phase: whatever a part is made of, NumPy's derivatives are those of JAX."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from fitting.estimate import frame_on
from fitting.model import PARTS, GapModel, gap_phase, phase, warp
from fitting.model.part import AbstractPart, Flattening
from fitting.parameters import NUMBERS, TABLE, Numbers
from fitting.photo import Grid

GRID = Grid((60, 80), 1, (0, 60), (0, 80))


class Decentring(AbstractPart):
    """Brown's (1966) decentring of lens elements along x, under the name of a number that the vector has."""

    name = "decentring"
    parameters = ("distortion_fifth_order",)

    def displacements(self, ux, uy, u2):
        return {"distortion_fifth_order": (u2 + 2 * ux * ux, 2 * ux * uy)}


class Bulge(AbstractPart):
    """A share of r² that grows with r², beyond what is a disc before it."""

    name = "bulge"
    parameters = ("shear",)

    def flatten(self, r2, unit2, numbers):
        return r2 * (1 + numbers.shear * r2 / unit2)

    def flattening(self, r2, unit2, numbers):
        return Flattening(
            self.flatten(r2, unit2, numbers), 1 + 2 * numbers.shear * r2 / unit2, {"shear": r2 * r2 / unit2**2}
        )


@pytest.mark.parametrize("centre", [(0.1, -0.2), (0.9, 0.8)])
@pytest.mark.parametrize("part", [Decentring(), Bulge()])
def test_a_part_may_move_points_anywhere_and_change_any_share(monkeypatch, part, centre):
    is_warp = part.name == "decentring"
    monkeypatch.setattr(warp, "RADIAL", ("distortion",))
    monkeypatch.setattr(warp, "DISPLACING", (part,) if is_warp else ())
    for module in (gap_phase, phase):
        monkeypatch.setattr(module, "FLATTENING", (PARTS["contact"], *(() if is_warp else (part,))))
    for module in (gap_phase, warp):
        monkeypatch.setattr(module, "REACHING", (PARTS["oblique_view"],) if is_warp else ())
    if not is_warp:
        monkeypatch.setattr(warp, "STRETCHES", ())
    frame = frame_on(GRID)
    model = GapModel(frame, (0.02, 1.0))
    values = Numbers(9.0, *centre, 0.3, 0.03, 0.02, -0.04, 0.01, 0.015)
    numbers = np.array(values)
    turns, slopes = gap_phase.phase_and_slopes(model, frame.x, frame.y, numbers)
    with jax.enable_x64():
        by_jax = [
            jax.jvp(lambda n: model.phase(frame.x, frame.y, n), (jnp.asarray(numbers),), (e,))
            for e in jnp.eye(len(NUMBERS))
        ]
    np.testing.assert_allclose(turns, by_jax[0][0], rtol=1e-12)
    for name, (_, slope) in zip(NUMBERS, by_jax, strict=True):
        if name in slopes:
            np.testing.assert_allclose(slopes[name], slope, rtol=1e-9, atol=1e-9, err_msg=name)
    assert slopes[part.parameters[0]].any()


@pytest.mark.parametrize("name", [name for name, part in PARTS.items() if part.parameters])
def test_every_part_has_bounds_and_derivatives_that_are_those_of_jax(name):
    """Holds for parts to come, too: their numbers are read off the table."""
    frame, part = frame_on(GRID), PARTS[name]
    model = GapModel(frame, (0.02, 1.0))
    values = {number: 0.1 * TABLE[number].bounds[1] for number in part.parameters}
    numbers = np.array(Numbers(9.0, 0.1, -0.2, 0.3)._replace(**values))
    assert np.isfinite(list(values.values())).all()
    turns, slopes = gap_phase.phase_and_slopes(model, frame.x, frame.y, numbers)
    assert np.allclose(gap_phase.phase(model, frame.x, frame.y, numbers), turns, rtol=0, atol=1e-12)
    for number in part.parameters:
        with jax.enable_x64():
            along = jnp.eye(len(NUMBERS))[NUMBERS.index(number)]
            at = (jnp.asarray(numbers),)
            by_jax = jax.jvp(lambda n: model.phase(frame.x, frame.y, n), at, (along,))[1]
        assert np.abs(by_jax).max() > 1e-3
        np.testing.assert_allclose(slopes[number], by_jax, rtol=1e-8, atol=1e-9)
