"""Designing a set-up: the numbers of a bench within bounds and limits that tell the most of what is measured.

Minimized is the expected relative deviation of the measured number (`prospects`), by sequential quadratic programming
with exact derivatives (Kraft 1988, SLSQP of SciPy: optimistix and optax have no constraints), from several starts.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from jaxtyping import Float
from scipy.stats import qmc

from fitting.designs.job import Job
from fitting.designs.prospects import LIMITS, Bench, Layout, Limits, forecast
from fitting.designs.search import BINDS, Binding, Search, none_found
from fitting.studies import FREE
from newtonjax.numerics import require_whole
from newtonjax.scene import Camera, Scene

# Nodes, samples and shifts of the fringes that are searched on, each with those whose forecast judges it: where they
# agree to `_AGREES` the search ends. The first is smooth however many the fringes, the others are right for few.
_AGREES = 0.02
_GRIDS = (((5, 16, 12), (9, 384)), ((5, 48), (9, 384)), ((9, 96), (17, 384)), ((17, 192), (33, 384)))


@dataclass(frozen=True)
class Design:
    """What `design` found. `str()` is a table.

    - `target`, `unit`, `over`: what is measured, and the values of it that count.
    - `values`, `units`: of the design's numbers, by name; `before`: of the bench as it was.
    - `relative_sd`: largest (or mean) expected relative deviation of the target over its values; `noise_sd`: by noise
      alone; `before_sd`: of the bench as it was, None where that breaks a limit.
    - `scene`, `camera`: the designed bench, its camera cropped to the field.
    - `bindings`: what holds it back; `used`: share of each limit that is used.
    - `evaluations`: of the objective with its derivatives; `starts`: relative deviation that each start ended with.
    """

    target: str
    unit: str
    over: tuple[float, ...]
    values: dict[str, float]
    units: dict[str, str]
    before: dict[str, float]
    relative_sd: float
    noise_sd: float
    before_sd: float | None
    scene: Scene
    camera: Camera
    bindings: tuple[Binding, ...]
    used: dict[str, float]
    evaluations: int
    starts: tuple[float, ...]

    def __str__(self) -> str:
        over = f"{self.over[0]:.6g}" if len(self.over) == 1 else f"{self.over[0]:.4g} to {self.over[-1]:.4g}"
        was = "breaks a limit" if self.before_sd is None else f"{self.before_sd:.3g}"
        lines = [
            f"{self.target} of {over} {self.unit}: relative sd {self.relative_sd:.3g} "
            f"(noise alone {self.noise_sd:.3g}; the bench as it was: {was})",
            f"{'':<14} {'designed':>12} {'was':>12} unit",
        ]
        for name, value in self.values.items():
            lines.append(f"{name:<14} {value:>12.6g} {self.before[name]:>12.6g} {self.units[name]}".rstrip())
        rows, columns = self.camera.shape
        lines.append(f"camera: {rows} x {columns} pixels of {float(self.camera.pixel_size) * 1e6:.4g} um on the screen")
        for binding in self.bindings:
            side = "limit" if binding.side == "limit" else f"{binding.side} bound"
            lines.append(f"binds: {binding.name} is at its {side}; 1 % more room lowers the sd by {binding.gain:.2g} %")
        return "\n".join([*lines, *([] if self.bindings else ["nothing binds: the best lies inside"])])


def design(
    scene: Scene,
    camera: Camera,
    vary: Mapping[str, tuple[float | int, float | int]],
    *,
    target: str = "radius",
    free: Sequence[str] = FREE,
    known: Mapping[str, float | int | str] | None = None,
    over: Sequence[float] | Float[np.ndarray, " targets"] | None = None,
    robust: str = "worst",
    choose: Mapping[str, Sequence[float | int]] | None = None,
    pixels_per_fringe: float = 2.5,
    fill: float = 0.9,
    rings: tuple[float | int, float | int] = (0.5, np.inf),
    starts: int = 6,
    seed: int = 0,
    report: Callable[[float], object] | None = None,
) -> Design:
    """The bench that measures one number best, within bounds and limits.

    Args:
      scene, camera: where to start from; the camera's shape is the sensor. One gap with two faces.
      vary: bounds (low, high) by name, of numbers of `knobs` in their units, and of "field": shorter side of the
        used part of the image, on the screen [m]. Without it the whole sensor is used.
      target: what is measured; free: what is fitted beside it.
      known: numbers that are held and known to a standard deviation only, in their units or, as "0.1%", of their value.
        Their effect on the target, by its slope, is added to that of noise. Without it noise alone counts.
      over: values of the target that the design must measure; None for the scene's.
      robust: "worst" or "mean" of them.
      choose: discrete values by name, such as available wavelengths: every one is tried.
      pixels_per_fringe: at the finest fringe, at least (2 is Nyquist's limit).
      fill: share of the full well that the brightest pixel may take.
      rings: in the field (change of order over it), at least and at most.
      starts: searches from quasi-random points, besides one from the bench as it is; seed: of these.
      report: called with the share of the work that is done.

    Limits hold for every value of `over`. Raises ValueError for what is not there or not allowed, where no start meets
    the limits, and where the image does not tell the target.

    """
    require_whole("starts", starts)
    if robust not in ("worst", "mean"):
        raise ValueError(f"robust is {robust!r}; allowed: 'worst' or 'mean'")
    job = Job(scene, camera, dict(vary), dict(choose or {}), target, free, dict(known or {}), over)
    limits = Limits(pixels_per_fringe, fill, *rings)
    for name, value in zip(limits._fields, limits, strict=True):
        if not value > 0:
            raise ValueError(f"{name} is {value}; allowed: above zero")
    if fill > 1:
        raise ValueError(f"fill is {fill}; allowed: at most 1, where the brightest pixel saturates")
    if not rings[0] < rings[1]:
        raise ValueError(f"rings is {rings}; allowed: fewer at least than at most")
    return _best(job, limits, robust, starts, seed, report or (lambda _: None))


def _best(job: Job, limits: Limits, robust: str, starts: int, seed: int, report: Callable[[float], object]) -> Design:
    bench, evaluations = job.bench(limits), 0
    choices = list(product(*job.choose.values()))
    count = len(job.vary)
    points = np.clip(qmc.Sobol(max(count, 1), rng=seed).random(1 << (starts - 1).bit_length())[:starts, :count], 0, 1)
    search = Search(job, job.layout(*_GRIDS[0][0]), bench, robust)
    runs = [(point, choice) for choice in choices for point in (search.place(job.before), *points)]
    ended: list[tuple[float, np.ndarray, tuple]] = []
    for number, (point, choice) in enumerate(runs):
        report(number / (len(runs) + 1))
        if (end := search.run(point, choice)) is not None:
            ended.append((*end, choice))
    evaluations += search.evaluations
    if not ended:
        raise none_found(search, runs)
    value, place, choice = min(ended, key=lambda run: run[0])
    for grid, finer in _GRIDS:
        if grid != _GRIDS[0][0]:  # from where the one before ended
            search = Search(job, job.layout(*grid), bench, robust)
            value, place = search.run(place[:count], choice) or (value, place)
            evaluations += search.evaluations
        design, judge = search.design(place[:count], choice), job.layout(*finer)
        outcome = forecast(judge, bench, design, job.over)
        if np.all(np.abs(outcome.total - search.look(place[:count], choice)[0]) < _AGREES):
            break
    else:
        raise ValueError("the field has too many fringes for a smooth forecast: give a smaller field, or fewer rings")
    report(1.0)
    pick = np.max if robust == "worst" else np.mean
    room = search.look(place[:count], choice)[2]
    scene, camera = job.made(design, job.moved[job.target].value)
    return Design(
        job.target,
        job.moved[job.target].unit,
        tuple(job.over.tolist()),
        dict(zip(job.names, design.tolist(), strict=True)),
        {name: knob.unit for name, knob in job.numbers.items()},
        dict(zip(job.names, job.before.tolist(), strict=True)),
        float(pick(np.exp(outcome.total))),
        float(pick(np.exp(outcome.noise))),
        _as_it_was(job, judge, bench, pick),
        scene,
        camera,
        search.bindings(place, choice),
        dict(zip(LIMITS, np.exp(-room).tolist(), strict=True)),
        evaluations,
        tuple(sorted(float(np.exp(run[0])) for run in ended)),
    )


def _as_it_was(job: Job, judge: Layout, bench: Bench, pick) -> float | None:
    outcome = forecast(judge, bench, job.before, job.over)
    within = np.all(outcome.used <= 1 + BINDS) and np.all(np.isfinite(outcome.total))
    return float(pick(np.exp(outcome.total))) if within else None
