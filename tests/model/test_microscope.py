"""What a microscope that looks at the gap adds to 2 n t: rays of the simulator, formula, derivatives, trips."""

from dataclasses import replace
from itertools import pairwise

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from rings_data import WAVELENGTH, added_path

import fitting
import newtonjax as nj
from fitting.estimate import frame_on
from fitting.model import GapModel, Microscope, gap_phase, microscope, microscope_on, plate_curvature, sphere_of
from fitting.parameters import NUMBERS, Numbers, checked_plate, quantities
from fitting.photo import Grid

# Radius, orders at the last point, gap at the apex, and indices of lens, gap and plate.
BENCHES = [
    (1.0, 15, 0.0, 1.5, 1.0, 1.5),
    (0.1, 38, 2e-6, 1.7, 1.33, 1.5),
    (0.05, 40, 3e-6, 1.45, 1.33, 1.8),
    (0.02, 50, 5e-6, 1.5, 1.0, 1.5),
    (5e-3, 50, 0.0, 1.5, 1.0, 1.5),
    (20.0, 30, 1e-6, 1.6, 1.0, 1.7),
]
FRAME = frame_on(Grid((60, 80), 1, (0, 60), (0, 80)))
UNIT = FRAME.unit
GIVEN = {"wavelength": WAVELENGTH, "pixel_size": 30e-6, "radius": 0.03, "gap_index": 1.0}
ORDERS = GIVEN["pixel_size"] ** 2 / (GIVEN["radius"] * WAVELENGTH)


def curved(bench, plate_radius):
    upper, sphere, plate, lower = bench.surfaces
    return replace(bench, surfaces=(upper, sphere, replace(plate, curvature=-1 / plate_radius), lower))


def view_of(bench, radius, index, plate_radius, glass, other):
    return microscope.View(radius, plate_radius, index, bench.view == "reflected", glass, other)


@pytest.mark.parametrize("view", ["reflected", "transmitted"])
def test_the_bench_that_is_traced_is_the_ready_one(view):
    bench = nj.newton_rings(0.2, WAVELENGTH, 3e-6, view)
    traced = microscope.View(0.2, np.inf, 1.0, view == "reflected")
    faces = [(surface.curvature, surface.vertex[2]) for surface in (*bench.surfaces, bench.screen)]
    assert np.array(traced.faces(3e-6)) == pytest.approx(np.array(faces, float), rel=1e-12)
    assert (traced.lens_index, traced.gap_index, traced.plate_index) == tuple(bench.media[1:4])
    words = [" ".join(word.replace("T", "").replace("R", "").split()) for word in bench.beams]
    met = [" ".join(str(face) for face in faces_of(way)) for way in traced.ways()]
    assert met == words


def faces_of(way):
    """The faces that rays meet on their way through media."""
    down = True
    for before, beyond in pairwise(way):
        yield before if down else before - 1
        down = down if before != beyond else not down


@pytest.mark.parametrize("curvature", [0.0, 0.8, -0.4], ids=["flat", "bulging", "hollow"])
@pytest.mark.parametrize("view", ["reflected", "transmitted"])
@pytest.mark.parametrize(("radius", "orders", "gap", "lens", "index", "plate"), BENCHES)
def test_path_difference_is_that_of_the_simulators_rays(radius, orders, gap, lens, index, plate, view, curvature):
    """To a millionth of a turn, which is what rays in double precision leave of paths of 20 mm; `curvature`: of 1/R."""
    plate_radius = radius / curvature if curvature else np.inf
    glasses = {"lens_index": lens, "plate_index": plate, "gap_index": index}
    bench = curved(nj.newton_rings(1 / (1 / radius - 1 / plate_radius), WAVELENGTH, gap, view, **glasses), plate_radius)
    r = np.linspace(0, np.sqrt(orders * radius * WAVELENGTH / index), 9)
    path = microscope.path_difference(view_of(bench, radius, index, plate_radius, lens, plate), gap, r)
    camera = nj.Camera((1, 17), r[-1] / 8)
    traced = np.asarray(nj.opd(bench, camera, nj.Traced()))[0, 8:]
    assert path == pytest.approx(traced, abs=1e-6 * WAVELENGTH)


@pytest.mark.parametrize("view", ["reflected", "transmitted"])
@pytest.mark.parametrize(("radius", "orders", "gap", "lens", "index"), [bench[:5] for bench in BENCHES])
def test_what_is_added_is_the_formula_to_fourth_order(radius, orders, gap, lens, index, view):
    """The rest is of sixth order: it grows with the cube of (r/R)² where the faces touch."""
    seen = microscope.View(radius, np.inf, index, view == "reflected", lens, lens)
    steepness = orders * WAVELENGTH / index / radius
    rest = []
    for w in (steepness / 4, steepness):
        r2 = w * radius**2
        sag = r2 / radius / (1 + np.sqrt(1 - w))
        path = np.diff(microscope.path_difference(seen, gap, np.array([0.0, np.sqrt(r2)])))[0]
        formula = added_path(w, gap + sag, gap, view, index, lens)
        added = path - 2 * index * sag
        assert added == pytest.approx(formula, rel=0.1)
        rest.append(abs(added - formula))
    if gap == 0.0:
        assert rest[0] < rest[1] / 40 + 1e-10 * WAVELENGTH


@pytest.mark.parametrize("view", ["reflected", "transmitted"])
@pytest.mark.parametrize(
    ("unknown", "plate_radius"),
    [("radius", None), ("radius", -0.05), ("pixel_size", None), ("wavelength", None), ("gap_index", None)],
)
def test_phase_and_derivatives_are_those_of_jax_and_of_differences(unknown, plate_radius, view):
    given = {name: None if name == unknown else value for name, value in GIVEN.items()}
    known = replace(quantities(given, dict.fromkeys(given), ()), plate=checked_plate(plate_radius, None))
    at_start = Numbers(ORDERS * UNIT**2, 0.1, -0.2, 0.6)
    side = Microscope(touching=0.5 if view == "reflected" else 0.0)
    seen = microscope_on(known, at_start, FRAME, side)
    model = GapModel(FRAME, sphere_of(known, ORDERS), plate_curvature(known), seen)
    values = Numbers(1.003 * ORDERS * UNIT**2, 0.1, -0.2, 0.62, 0.1, -0.05, 0.02, 0.03, 0.01)
    numbers, x, y = np.array(values), FRAME.x, FRAME.y
    turns, slopes = gap_phase.phase_and_slopes(model, x, y, numbers)
    plain = gap_phase.phase(replace(model, microscope=Microscope()), x, y, numbers)
    assert np.abs(turns - plain).max() > 1e-3
    assert gap_phase.phase(model, x, y, numbers) == pytest.approx(turns, abs=1e-11)
    with jax.enable_x64():
        of_jax = jax.jit(lambda n: model.phase(x, y, n))
        assert turns == pytest.approx(np.asarray(of_jax(jnp.asarray(numbers))), abs=1e-11)
        jacobian = np.asarray(jax.jit(jax.jacfwd(lambda n: model.phase(x, y, n)))(jnp.asarray(numbers)))
    for name, column, unit in zip(NUMBERS, jacobian.T, np.eye(len(NUMBERS)), strict=True):
        assert slopes[name] == pytest.approx(column, abs=1e-8 * np.abs(column).max()), name
        step = 1e-5 * unit
        both = (gap_phase.phase(model, x, y, numbers + sign * step) for sign in (1, -1))
        assert np.subtract(*both) / 2e-5 == pytest.approx(column, abs=1e-6 * np.abs(column).max() + 1e-8), name


@pytest.mark.parametrize("unknown", ["radius", "gap_index"])
def test_the_view_follows_the_number_that_is_measured(unknown):
    """Traced a thousandth away, it is that traced at the number to 1e-5 of it."""
    known = quantities({name: None if name == unknown else v for name, v in GIVEN.items()}, dict.fromkeys(GIVEN), ())
    at_number, at_start = (Numbers(factor * ORDERS * UNIT**2, 0.0, 0.0, 0.5) for factor in (1.0, 1.001))
    side, added = Microscope(touching=0.5), []
    for numbers in (at_number, at_start):
        seen = microscope_on(known, numbers, FRAME, side)
        model = GapModel(FRAME, sphere_of(known, ORDERS), 0.0, seen)
        plain = replace(model, microscope=side)
        phases = (gap_phase.phase(at, FRAME.x, FRAME.y, np.array(at_number)) for at in (model, plain))
        added.append(np.subtract(*phases))
    assert added[1] == pytest.approx(added[0], abs=2e-5 * np.abs(added[0]).max())


@pytest.mark.parametrize("view", ["reflected", "transmitted"])
@pytest.mark.parametrize(("radius", "gap"), [(6e-3, 0.7e-6), (0.09, 4.3e-6), (2.0, 2.2e-6), (60.0, 4.9e-6)])
def test_the_default_round_trip_closes(radius, gap, view):
    """Within three standard deviations; with the gap held and a traced picture, to 1e-6 (issue: 3e-6 to 4e-4 off)."""
    pixel_size = np.sqrt(20 * radius * WAVELENGTH) / 180
    camera = nj.Camera((256, 256), pixel_size, centre_px=(131.0, 120.0))
    bench, given = nj.newton_rings(radius, WAVELENGTH, gap, view), {"wavelength": WAVELENGTH, "view": view}
    result = fitting.fit(nj.render(bench, camera), pixel_size=pixel_size, **given)
    assert abs(result.radius - radius) < 3 * result.radius_sd
    traced = nj.render(bench, camera, nj.Chebyshev(33))
    held = fitting.fit(traced, pixel_size=pixel_size, fixed={"gap": gap}, **given)
    assert held.radius == pytest.approx(radius, rel=1e-6)
    assert "whole waves of the gap" in dict(result.budget)
    assert "whole waves of the gap" not in dict(held.budget)
