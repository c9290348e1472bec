"""Designing a set-up: the numbers of a bench within bounds and limits that determine the target best.

Minimized is the expected relative deviation of the measured number (`prospects`), by sequential quadratic programming
with exact derivatives (Kraft 1988, SLSQP of SciPy: optimistix and optax have no constraints), from several starts.
"""

from collections.abc import Callable, Mapping, Sequence
from itertools import product
from operator import itemgetter

import numpy as np
from jaxtyping import Float
from scipy.stats import qmc

from fitting.parameters import Deviations, Progress, progress_of
from fitting.reasons import Reason
from fitting.studies.bench_origin import says_its_bench
from fitting.studies.design_job import DesignTask
from fitting.studies.design_result import Design
from fitting.studies.design_search import BINDS, Search, infeasible
from fitting.studies.prospects import LIMITS, Bench, Layout, Limits, forecast
from newtonjax.numerics import names_in, positive, require, require_choice, require_mapping, require_size, require_whole
from newtonjax.scene import Camera, Scene

# Nodes, samples and shifts of the fringes that are searched on, each with those whose forecast judges it: where they
# agree to `_AGREES` the search ends. The first is smooth however many the fringes, the others are right for few.
_AGREES = 0.02
_MOST_STARTS = 10_000
_GRIDS = (((5, 16, 12), (9, 384)), ((5, 48), (9, 384)), ((9, 96), (17, 384)), ((17, 192), (33, 384)))
# Where a search ends: its objective, its place and its choice.
_End = tuple[float, np.ndarray, tuple]
_value = itemgetter(0)


@says_its_bench
def design(
    scene: Scene,
    camera: Camera,
    vary: Mapping[str, tuple[float | int, float | int]],
    *,
    target: str | None = None,
    free: Sequence[str] | None = None,
    sd: Deviations | None = None,
    over: Sequence[float] | Float[np.ndarray, " targets"] | None = None,
    robust: str = "worst",
    choose: Mapping[str, Sequence[float | int]] | None = None,
    pixels_per_fringe: float = 2.5,
    fill_fraction: float = 0.9,
    rings: tuple[float | int, float | int] = (0.5, np.inf),
    starts: int = 6,
    seed: int = 0,
    progress: Progress = None,
    so_far: Callable[[Design], object] | None = None,
) -> Design:
    """The bench that measures one number best, within bounds and limits.

    Args:
      scene, camera: where to start from; the camera's shape is the sensor. One gap with two faces.
      vary: bounds (low, high) by name, of numbers of `knobs` in their units, and of "field": shorter side of the
        used part of the image, on the screen [m]. Without it the whole sensor is used.
      target: what is measured; free: what is determined with it; defaults as in `sensitivity`.
      sd: standard deviations of numbers that the fit is given, in their units or, as "0.1%", of their value. Their
        effect on the target, by its slope, is added to that of noise. Without it noise alone counts.
      over: values of the target that the design must measure; None for the scene's.
      robust: "worst" or "mean" of them.
      choose: discrete values by name, such as available wavelengths: every one is tried.
      pixels_per_fringe: at the finest fringe, at least (2 is Nyquist's limit).
      fill_fraction: fraction of the full well that the brightest pixel may take.
      rings: in the field (change of order over it), at least and at most.
      starts: searches from quasi-random points, besides one from the bench at the start; seed: of these.
      progress: True for a bar on the terminal, or a function of (searches done, their number).
      so_far: called with the best design of the searches done, after each one, for those who may stop early.

    Limits hold for every value of `over`. Raises ValueError for what is not there or not allowed, where no start meets
    the limits, and where the image does not determine the target.

    """
    if vary is None or starts is None or seed is None:
        raise ValueError("vary, starts or seed is None; allowed: a mapping, and two whole numbers")
    require_whole("starts", starts, 1, _MOST_STARTS)
    require_whole("seed", seed, 0, 2**32 - 1)
    allowed = "numbers above zero"
    for name, value in (("pixels_per_fringe", pixels_per_fringe), ("fill_fraction", fill_fraction)):
        require(name, value, allowed, positive)
        require_size(name, np.atleast_1d(value), 1, allowed)
    require("rings", rings, "two numbers, at least and at most", lambda pair: (pair > 0) & ~np.isnan(pair))
    require_size("rings", np.asarray(rings), 2, "two numbers, at least and at most")
    require_choice("robust", robust, ("worst", "mean"))
    for name, table in (("vary", vary), ("choose", choose), ("sd", sd)):
        require_mapping(name, table)
    if free is not None and not names_in("free", free):
        raise ValueError("free is empty; allowed: one name or more, or None for what the scene has")
    task = DesignTask(scene, camera, dict(vary), dict(choose or {}), target, free, dict(sd or {}), over)
    limits = Limits(pixels_per_fringe, fill_fraction, *rings)
    for name, value in zip(limits._fields, limits, strict=True):
        if not value > 0:
            raise ValueError(f"{name} is {value}; allowed: above zero")
    if fill_fraction > 1:
        raise ValueError(f"fill_fraction is {fill_fraction}; allowed: at most 1, where the brightest pixel saturates")
    if not rings[0] < rings[1]:
        raise ValueError(f"rings is {rings}; allowed: fewer at least than at most")
    with progress_of(progress, "searching") as done:
        return _best(task, limits, robust, starts, seed, done, so_far)


def _best(
    task: DesignTask,
    limits: Limits,
    robust: str,
    starts: int,
    seed: int,
    done: Callable[[int, int], object],
    so_far: Callable[[Design], object] | None,
) -> Design:
    bench, evaluations = task.bench(limits), 0
    choices = list(product(*task.choose.values()))
    count = len(task.vary)
    points = np.clip(qmc.Sobol(max(count, 1), rng=seed).random(1 << (starts - 1).bit_length())[:starts, :count], 0, 1)
    search = Search(task, task.layout(*_GRIDS[0][0]), bench, robust)
    runs = [(point, choice) for choice in choices for point in (search.to_unit(task.before), *points)]
    ended: list[_End] = []
    for number, (point, choice) in enumerate(runs):
        done(number, len(runs) + 1)
        if (end := search.run(point, choice)) is not None:
            ended.append((*end, choice))
            if so_far is not None:
                judge = task.layout(*_GRIDS[0][1])
                so_far(_design_of(search, judge, *min(ended, key=_value)[1:], ended, search.evaluations))
    evaluations += search.evaluations
    if not ended:
        raise infeasible(search, runs)
    value, place, choice = min(ended, key=_value)
    for grid, finer in _GRIDS:
        if grid != _GRIDS[0][0]:  # from where the one before ended
            search = Search(task, task.layout(*grid), bench, robust)
            value, place = search.run(place[:count], choice) or (value, place)
            evaluations += search.evaluations
        design, judge = search.design(place[:count], choice), task.layout(*finer)
        outcome = forecast(judge, bench, design, task.over)
        if np.all(np.abs(outcome.total - search.evaluate(place[:count], choice)[0]) < _AGREES):
            break
    else:
        raise ValueError(Reason.TOO_MANY_FRINGES())
    done(len(runs) + 1, len(runs) + 1)
    return _design_of(search, judge, place, choice, ended, evaluations)


def _design_of(
    search: Search, judge: Layout, place: np.ndarray, choice: tuple, ended: list[_End], evaluations: int
) -> Design:
    task, bench, pick = search.task, search.bench, np.max if search.robust == "worst" else np.mean
    own = place[: len(task.vary)]
    design = search.design(own, choice)
    outcome = forecast(judge, bench, design, task.over)
    room = search.evaluate(own, choice)[2]
    scene, camera = task.bench_of(design, task.moved[task.target].value)
    return Design(
        task.target,
        task.moved[task.target].unit,
        tuple(task.over.tolist()),
        dict(zip(task.names, design.tolist(), strict=True)),
        {name: knob.unit for name, knob in task.numbers.items()},
        dict(zip(task.names, task.before.tolist(), strict=True)),
        float(pick(np.exp(outcome.total))),
        float(pick(np.exp(outcome.noise))),
        _sd_at_the_start(task, judge, bench, pick),
        scene,
        camera,
        search.bindings(place, choice),
        dict(zip(LIMITS, np.exp(-room).tolist(), strict=True)),
        evaluations,
        tuple(sorted(float(np.exp(run[0])) for run in ended)),
    )


def _sd_at_the_start(task: DesignTask, judge: Layout, bench: Bench, pick) -> float | None:
    outcome = forecast(judge, bench, task.before, task.over)
    within = np.all(outcome.used <= 1 + BINDS) and np.all(np.isfinite(outcome.total))
    return float(pick(np.exp(outcome.total))) if within else None
