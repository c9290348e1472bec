"""The solve on reduced photographs: against sums over every pixel in float64."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.polynomial.chebyshev import chebvander
from rings_data import coordinates

from fitting.estimate import CONTRAST, Prior, Problem, bends, frame_on, fringe_sums, fused, normal_matrix, solve
from fitting.estimate.block_phases import GapFringes
from fitting.estimate.fringe_sums import image_of
from fitting.estimate.optimum import choose_degrees
from fitting.model import BACKGROUND, GapModel, as_arrays, degrees, gap_phase
from fitting.parameters import NUMBERS, Numbers
from fitting.photo import Grid, Photograph, block_size, reduce
from fitting.photo.codes import Codes, Curve

COMMON = ("curvature", "centre_x", "centre_y", "phase")
SHAPE, NOISE = (150, 192), 0.05


def with_parts(*common, **parts):
    """A vector of all numbers: the four of every fit, and those of parts by name."""
    return np.array(Numbers(*common)._replace(**parts))


TRUTH = with_parts(7.0, 0.12, -0.08, 0.3)
VIEWED = with_parts(*TRUTH[:4], stretch=0.03, shear=-0.02, distortion=0.04)


def picture(shape, numbers, noise, seed=0):
    """Rings on a sloping background, with a contrast that falls to one side."""
    y, x = np.meshgrid(*(np.linspace(-1, 1, n) for n in shape), indexing="ij")
    rows, columns = np.mgrid[: shape[0], : shape[1]].astype(float)
    turns = gap_phase.phase(GapModel(frame_of(shape), (0.0, 1.0)), columns, rows, numbers)
    clean = 0.5 + 0.1 * x + (0.3 - 0.05 * y) * np.cos(2 * np.pi * turns)
    return clean + noise * np.random.default_rng(seed).normal(size=shape)


def frame_of(shape):
    """The nodes of a whole frame."""
    return frame_on(Grid(shape, 1, (0, shape[0]), (0, shape[1])))


def photograph(image, mask=None):
    mask = np.ones(image.shape, bool) if mask is None else mask
    return Photograph(Codes(image, Curve(1.0, 1.0)), mask, mask, "grey", "linear")


def problem_on(reduced, **given):
    given = {"free": COMMON, "degrees": (2, 2)} | given
    return Problem(GapFringes(GapModel(frame_on(reduced.grid, TRUTH), (0.0, 1.0))), **given)


def at_every_pixel(image, weights, problem, reduced, start):
    """Gauss and Newton's optimum in float64 over all pixels: numbers and normal matrix, the solver's unknowns."""
    grid, moving = reduced.grid, np.flatnonzero(problem.moving)
    model = GapModel(frame_on(grid), (0.0, 1.0))
    rows, columns = np.mgrid[: image.shape[0], : image.shape[1]].astype(float)
    along = [chebvander(grid.scaled(at, axis), 6) for axis, at in enumerate((rows, columns))]

    def shapes(most, degree):
        kept = degrees(most)[degrees(most).sum(axis=1) <= degree]
        return np.stack([along[0][..., j] * along[1][..., i] for j, i in kept], axis=-1).reshape(image.size, -1)

    low, high = shapes(BACKGROUND, problem.degrees[0]), shapes(CONTRAST, problem.degrees[1])
    numbers, root, step = start.copy(), np.sqrt(weights.ravel()), np.ones(1)
    jacobian, left = np.zeros((0, 0)), np.zeros(0)
    for _ in range(20):
        turns, slopes = gap_phase.phase_and_slopes(model, columns, rows, numbers)
        cosine, sine = np.cos(2 * np.pi * turns).ravel(), np.sin(2 * np.pi * turns).ravel()
        linear = np.concatenate([low, high * cosine[:, None]], axis=1)
        coefficients = np.linalg.lstsq(linear * root[:, None], (image.ravel()) * root, rcond=None)[0]
        swing = -2 * np.pi * (high @ coefficients[low.shape[1] :]) * sine
        tails = np.stack([np.broadcast_to(slopes[NUMBERS[k]], image.shape).ravel() * swing for k in moving], axis=1)
        jacobian = np.concatenate([tails, linear], axis=1) * root[:, None]
        left = (image.ravel() - linear @ coefficients) * root
        step = np.linalg.lstsq(jacobian, left, rcond=None)[0][: len(moving)]
        numbers[moving] += step
        if np.abs(step).max() < 1e-12:
            break
    return numbers, jacobian.T @ jacobian, float(left @ left)


def test_gap_phase_in_numpy_is_that_of_the_model_and_its_slopes_are_its_derivatives():
    frame = frame_of((480, 640))
    x, y = jnp.asarray(frame.x), jnp.asarray(frame.y)
    of = jax.jit(lambda model, free: model.phase(x, y, free))
    derivatives = jax.jit(jax.jacfwd(lambda free, model: model.phase(x, y, free)))
    for factor, power, plate in ((0, 1, 0.0), (8, 1, 0.0), (9e-4, 0, 0.0), (0.06, 0.5, 0.0), (8, 1, 3e-4)):
        model = GapModel(frame, (float(factor), float(power)), plate)
        for numbers in (
            with_parts(20, 0.1, -0.2, 0.3, stretch=0.1, shear=-0.2, distortion=0.05, contact=0.03, coma_x=0.2),
            with_parts(20, 1.1, -0.2, 0.3, distortion=-0.05, distortion_fifth_order=0.01, axis_x=0.05, axis_y=-0.2),
            with_parts(20, 0.3, 0.2, 0.3, stretch=0.1, shear=0.1, contact=-0.01, trefoil_y=0.1, tetrafoil_x=0.1),
        ):
            phase, slopes = gap_phase.phase_and_slopes(model, frame.x, frame.y, numbers)
            assert phase == pytest.approx(np.asarray(of(as_arrays(model), jnp.asarray(numbers))), abs=1e-9)
            assert gap_phase.phase(model, frame.x, frame.y, numbers) == pytest.approx(phase, abs=1e-12)
            wanted = np.asarray(derivatives(jnp.asarray(numbers), as_arrays(model)))
            for name, column in Numbers(*wanted.T)._asdict().items():
                # The model's view is a series that leaves 1e-9 of the derivative.
                assert slopes[name] == pytest.approx(column, abs=1e-8 * np.abs(column).max()), name


@pytest.mark.parametrize(("numbers", "free"), [(TRUTH, COMMON), (VIEWED, (*COMMON, "stretch", "shear", "distortion"))])
def test_solution_is_the_optimum_over_all_pixels(numbers, free):
    """In single precision to a thousandth of a standard deviation; the normal matrix to 1e-5 of its diagonal."""
    image = picture(SHAPE, numbers, NOISE)
    weights = (np.random.default_rng(1).random(SHAPE) > 0.2).astype(float)
    reduced = reduce(photograph(image, weights > 0), 1)
    problem = problem_on(reduced, free=free)
    start = numbers * (1 + 0.02 * (np.arange(len(NUMBERS)) < 3))
    solution = solve(problem, reduced, start)
    wanted, matrix, chi2 = at_every_pixel(image, weights, problem, reduced, start)
    here = normal_matrix(solution)
    sds = np.sqrt(np.diag(here.covariance(NOISE**2)))[: len(NUMBERS)]
    moving = problem.moving
    assert solution.converged
    assert (np.abs(solution.numbers - wanted)[moving] < 1e-3 * sds[moving]).all()
    assert solution.chi2 == pytest.approx(chi2, rel=1e-5)
    size = np.sqrt(np.diag(matrix))
    assert np.abs((here.block(here.active) - matrix) / np.outer(size, size)).max() < 1e-5


def test_blocks_as_wide_as_the_finest_fringe_allows_lose_little():
    """Means keep all but 1 % of what the pixels say: both estimates differ by a tenth of their deviation, at random."""
    shape = (512, 512)
    image = picture(shape, TRUTH, 0.02)
    block = block_size(2 * 7.0 / frame_of(shape).unit * 1.15)
    assert block > 1
    reduced, whole = (reduce(photograph(image), size) for size in (block, 1))
    blocks, pixels = (solve(problem_on(one), one, TRUTH) for one in (reduced, whole))
    sds = [np.sqrt(np.diag(normal_matrix(one).covariance(one.chi2 / one.weight)))[:4] for one in (blocks, pixels)]
    assert (np.abs(blocks.numbers - pixels.numbers)[:4] < 0.2 * sds[1]).all()
    assert sds[0] == pytest.approx(sds[1], rel=0.02)


def test_means_over_blocks_bias_neither_curvature_nor_phase():
    """Without noise, 7 turns in 300 pixels, blocks of 2: a fiftieth of what noise of 2 % would do."""
    image = picture((300, 300), TRUTH, 0.0)
    reduced = reduce(photograph(image), 2)
    solution = solve(problem_on(reduced, degrees=(6, 4)), reduced, TRUTH)
    sds = 0.02 / 2 * np.sqrt(np.diag(normal_matrix(solution).covariance(1.0)))
    assert (np.abs(solution.numbers - TRUTH)[[0, 3]] < 0.02 * sds[[0, 3]]).all()


def test_fused_pass_gives_the_residuals_and_the_moments_with_their_weights():
    image = picture(SHAPE, TRUTH, NOISE)
    image[20:30, 40:60] = 2.0
    reduced = reduce(photograph(image), 1)
    solution = solve(problem_on(reduced), reduced, TRUTH)
    grid = reduced.grid
    fitted = image_of(solution.point.background, solution.point.modulus)
    found, left = fused(reduced, solution.fields.phase, fitted, 0.06)
    turns = gap_phase.phase(GapModel(frame_on(grid), (0.0, 1.0)), grid.x[None], grid.y[:, None], solution.numbers)
    background, contrast = fitted
    smooth = grid.along_y[:, :7] @ background @ grid.along_x[:, :7].T
    swing = grid.along_y[:, :17] @ contrast @ grid.along_x[:, :17].T
    residual = reduced.light - smooth - swing * np.cos(2 * np.pi * turns)
    weights = np.clip(1 - (residual / 0.36) ** 2, 0, None) ** 2
    assert np.abs(left.value - residual).max() < 1e-5
    assert np.abs(left.weights - weights).max() < 1e-4
    assert left.square == pytest.approx((weights * residual**2).sum(), rel=1e-4)
    again = fringe_sums.sums(replace(reduced, weights=left.weights), solution.fields.phase)
    assert np.abs(found.table - again.table).max() < 1e-3 * np.abs(again.table).max() * 1e-2
    assert (left.weights[22:28, 42:58] == 0).all()


@pytest.mark.parametrize("size", [1e120, 1e160])
def test_a_start_that_nothing_bears_ends_without_a_warning(size):
    image = picture(SHAPE, TRUTH, NOISE)
    reduced = reduce(photograph(image), 1)
    start = with_parts(*TRUTH[:4], distortion=size, distortion_fifth_order=-size)
    problem = problem_on(reduced, free=(*COMMON, "distortion", "distortion_fifth_order"))
    assert not solve(problem, reduced, start).converged


def test_a_prior_pulls_as_far_as_the_image_lets_it():
    """Two normal estimates of one number: their mean, weighted by their precisions."""
    image = picture(SHAPE, TRUTH, NOISE)
    reduced = reduce(photograph(image), 1)
    free = solve(problem_on(reduced), reduced, TRUTH)
    sd = normal_matrix(free).deviation("phase", NOISE**2)
    wanted = free["phase"] + 3 * sd
    held = problem_on(reduced, prior=Prior({"phase": (wanted, sd)}, NOISE**2))
    pulled = solve(held, reduced, TRUTH)
    assert pulled["phase"] == pytest.approx(free["phase"] + 1.5 * sd, abs=0.01 * sd)
    assert normal_matrix(pulled).deviation("phase", NOISE**2) == pytest.approx(sd / np.sqrt(2), rel=1e-3)


def test_score_test_and_drop_agree_with_fits_that_have_the_part():
    """Rao's drop for a distortion that is small, the rise without it, and the shift of a held number."""
    numbers = with_parts(*TRUTH[:4], distortion=4e-4)
    reduced = reduce(photograph(picture(SHAPE, numbers, 0.01)), 1)
    without = solve(problem_on(reduced), reduced, TRUTH)
    full = solve(problem_on(reduced, free=(*COMMON, "distortion")), reduced, TRUTH)
    drop = without.chi2 - full.chi2
    assert normal_matrix(without).drop_with(["distortion"]) == pytest.approx(drop, rel=0.02)
    at, moved = NUMBERS.index("distortion"), normal_matrix(without)
    assert normal_matrix(full).rise_without(np.arange(len(moved.values)) == at) == pytest.approx(drop, rel=0.02)
    shift = Numbers(*moved.shift_by("distortion"))
    assert shift.curvature * full["distortion"] == pytest.approx(full["curvature"] - without["curvature"], rel=0.02)
    bend = without.fields.slopes[:, [at]]
    crossed, own, gradient = bends(without, bend)
    column = moved.matrix[:, at]
    assert crossed[:, 0] == pytest.approx(column, rel=1e-9, abs=1e-9 * np.abs(column).max())
    assert own[0, 0] == pytest.approx(moved.matrix[at, at], rel=1e-9)
    assert gradient[0] == pytest.approx(moved.gradient[at], rel=1e-6)


def test_degrees_are_those_that_the_light_has():
    reduced = reduce(photograph(picture(SHAPE, TRUTH, 0.01)), 1)
    full = solve(problem_on(reduced, degrees=(BACKGROUND, CONTRAST)), reduced, TRUTH)
    weight = full.weight
    assert choose_degrees(normal_matrix(full), full.chi2, weight, weight) == (1, 1)


def test_blocks_are_means_of_their_used_pixels_on_the_grid_of_the_frame():
    image = np.arange(70.0 * 50).reshape(70, 50) / 1e4
    mask = np.ones(image.shape, bool)
    mask[:11], mask[12:14, 20:24], mask[30:32, 8] = False, False, False
    reduced = reduce(photograph(image, mask), 4)
    grid = reduced.grid
    assert (grid.rows, grid.columns) == ((3, 18), (0, 13))
    assert grid.y[0] == 13.5
    assert grid.y[-1] == 68.5  # of rows 68 and 69, the last two
    light = reduced.light + reduced.offset
    assert light[0, 0] == pytest.approx(image[12:16, :4].mean(), abs=1e-6)
    assert light[4, 2] == pytest.approx(image[28:32, 8:12][mask[28:32, 8:12]].mean(), abs=1e-6)
    assert reduced.weights[4, 2] == pytest.approx(14 / 16)
    assert reduced.weights[0, 5] == 0.5
    assert reduced.pixels == mask[12:].sum() - 4  # a quarter of a block in the last corner


def test_a_phase_with_an_edge_is_taken_at_every_block():
    numbers = with_parts(*TRUTH[:4], contact=0.02)
    image = picture(SHAPE, numbers, 0.01)
    reduced = reduce(photograph(image), 1)
    solution = solve(problem_on(reduced), reduced, numbers)
    assert solution.chi2 / solution.weight == pytest.approx(1e-4, rel=0.03)
    assert solution["curvature"] == pytest.approx(7.0, rel=1e-3)


def test_image_tables_hold_background_and_contrast():
    table = image_of(np.arange(28.0), np.ones(289))
    assert table.background[tuple(degrees(BACKGROUND).T)] == pytest.approx(np.arange(28.0))
    assert table.contrast[0, 0] == pytest.approx(1.0)


def test_rings_are_as_long_as_the_coordinates_of_the_suite_say():
    r2 = coordinates(SHAPE, (100.0, 60.0))
    model = GapModel(frame_of(SHAPE), (0.0, 1.0))
    unit, (x, y) = model.frame.unit, model.frame.middle
    numbers = with_parts(7.0, (100.0 - x) / unit, (60.0 - y) / unit, 0.0)
    rows, columns = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
    assert gap_phase.phase(model, columns, rows, numbers) == pytest.approx(7.0 / unit**2 * r2, abs=1e-9)
