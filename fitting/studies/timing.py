"""Speed against accuracy of every method for one scene, and the bias of the radius that each would cause in a fit."""

import tracemalloc
from collections.abc import Callable
from dataclasses import replace
from time import perf_counter
from typing import cast

import jax
import numpy as np

import newtonjax as nj
from fitting.parameters import Progress, change, curved_surface, progress_of
from fitting.studies.bench_origin import says_its_bench
from fitting.studies.tradeoff_result import MethodTiming, Tradeoff
from newtonjax.fields import closed_fields, intensity, packed, polar
from newtonjax.numerics import chebyshev, shown, x64
from newtonjax.scene import gap_of, has_tilted_sphere, node_points, points_of, require_bench

# Tolerances that are planned for, and the fixed grid that a user's own transformation gets.
TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8)
_DEFAULT = 17
# Points to a side for phases, and pixels to a side for images that are compared.
_POINTS, _SIDE = 21, 192
_RUNS, _STEPS = 5, 4


@says_its_bench
def tradeoff(
    scene: nj.Scene,
    camera: nj.Camera,
    *,
    splat: bool = False,
    progress: Progress = None,
    so_far: Callable[[Tradeoff], object] | None = None,
) -> Tradeoff:
    """Time, memory and errors of every method for a scene; rays at every pixel are the reference.

    Times [s] and memory [bytes] are those of the camera's own image; errors are taken on at most 192 x 192 of its
    pixels. The bias is that of least squares on the phase, with the radius, the centre and the gap free.

    Args:
      scene, camera: what is rendered.
      splat: the algorithm of 2021 too, which takes seconds to minutes.
      progress: True for a bar on the terminal, or a function of (methods done, their number).
      so_far: called with the methods timed so far after each one, for those who may stop early.

    Raises ValueError for a scene that cannot be rendered.

    """
    require_bench(scene, camera)
    if not isinstance(splat, bool):
        raise ValueError(f"splat is {shown(splat)}; allowed: True or False")
    comparison = _Comparison(scene, camera)
    jobs: list[Callable[[], MethodTiming]] = [comparison.formula]
    plans: dict[int, tuple[nj.Plan, float | None]] = {}
    for tolerance in TOLERANCES:
        chosen = nj.plan(scene, camera, tolerance)
        nodes = getattr(chosen.method, "nodes", None)
        if nodes is not None:
            plans.setdefault(nodes, (chosen, tolerance))
    jobs += [lambda p=p, t=t: comparison.nodes(p, t) for p, t in plans.values()]
    if _DEFAULT not in plans and plans:
        jobs.append(
            lambda: comparison.nodes(replace(next(iter(plans.values()))[0], method=nj.Chebyshev(_DEFAULT)), None)
        )
    if splat:
        jobs.append(comparison.splat)
    jobs.append(comparison.reference)
    timings = []
    with progress_of(progress, "timing every method") as done:
        for number, job in enumerate(jobs):
            timings.append(job())
            done(number + 1, len(jobs))
            if so_far is not None:
                so_far(_fastest_first(timings, camera))
    return _fastest_first(timings, camera)


def _fastest_first(timings: list[MethodTiming], camera: nj.Camera) -> Tradeoff:
    ordered = sorted(timings, key=lambda timing: (timing.seconds is None, timing.seconds or 0.0))
    return Tradeoff(tuple(ordered), camera.shape, float(camera.pixel_size))


class _Comparison:
    """A scene with its reference, of rays at some of its pixels and at nodes all over the image."""

    def __init__(self, scene: nj.Scene, camera: nj.Camera):
        self.scene, self.camera = scene, camera
        self.rows, self.columns = (np.unique(np.linspace(0, n - 1, _SIDE).round().astype(int)) for n in camera.shape)
        places = np.meshgrid(self.columns.astype(float), self.rows.astype(float))
        self.pixels = np.stack([np.ravel(axis) for axis in points_of(camera, *places)], axis=1)
        self.points = node_points(camera, _POINTS)
        self.truth = intensity(_fields(scene, self.pixels))
        self.phase = polar(_fields(scene, self.points))[1][0]

    def formula(self) -> MethodTiming:
        """2 n t at normal incidence, also where `render` would refuse it."""
        refusal = nj.ClosedForm().refusal(self.scene)
        if refusal and (gap_of(self.scene) is None or has_tilted_sphere(self.scene)):
            note = f"there is none: {refusal.part}: {refusal.demand}"
            return MethodTiming("ClosedForm", None, None, None, None, None, None, note=note)
        with x64():
            x, y = self.camera.axes()
            program = _formula.lower(self.scene, x[None, :], y[:, None]).compile()
            seconds = _seconds(lambda: program(self.scene, x[None, :], y[:, None]))
            intensity_error = self._intensity_error(np.asarray(_of_formula(closed_fields(self.scene, *self.pixels.T))))
        memory = program.memory_analysis()
        size = None if memory is None else int(memory.output_size_in_bytes + memory.temp_size_in_bytes)

        def phase(scene):
            return closed_fields(scene, *self.points.T).phase[0]

        note = f"ignores {refusal.part}" if refusal else ""
        phase_error, bias = self._phase_error(phase(self.scene)), self._bias(phase, self.scene)
        return MethodTiming("ClosedForm", seconds, size, phase_error, intensity_error, None, bias, note=note)

    def nodes(self, plan: nj.Plan, tolerance: float | None) -> MethodTiming:
        method = cast(nj.Chebyshev, plan.method)
        predicted = plan.intensity_error if tolerance is not None else None
        onto = chebyshev.values(method.nodes, _POINTS)

        def coefficients(scene):
            return method.coefficients(method.fields(scene, self.camera))

        def phase(scene):
            fields = coefficients(scene)
            return (onto @ fields[1 + len(fields) // 2] @ onto.T).ravel()

        with x64():
            image = np.asarray(nj.render(plan.scene, self.camera, method))
            seconds = _seconds(lambda: nj.render(plan.scene, self.camera, method))
            size = _bytes(lambda: nj.render(plan.scene, self.camera, method)) + image.nbytes
        intensity_error = self._intensity_error(image[np.ix_(self.rows, self.columns)])
        phase_error, bias = self._phase_error(phase(plan.scene)), self._bias(phase, plan.scene)
        note = f"without {len(plan.dropped)} weak beams" if plan.dropped else ""
        return MethodTiming(
            f"Chebyshev({method.nodes})", seconds, size, phase_error, intensity_error, predicted, bias, tolerance, note
        )

    def splat(self) -> MethodTiming:
        """The mean of pairs of rays, on a smaller image and timed there: it is linear in the pixels."""
        factor = max(1.0, max(self.camera.shape) / _SIDE)
        shape = (max(int(self.camera.shape[0] / factor), 1), max(int(self.camera.shape[1] / factor), 1))
        centre = self.camera.centre_px
        centre = None if centre is None else tuple((np.asarray(centre) + 0.5) / factor - 0.5)
        small = replace(self.camera, shape=shape, pixel_size=float(self.camera.pixel_size) * factor, centre_px=centre)
        truth = np.asarray(nj.render(self.scene, small, nj.Traced()))
        begin = perf_counter()
        try:
            splatted = nj.splat(self.scene, small, nj.Splat())
        except ValueError as error:
            return MethodTiming("Splat", None, None, None, None, None, None, note=str(error).split(";")[0])
        share = np.prod(self.camera.shape) / np.prod(shape)
        seconds, lit = float(share) * (perf_counter() - begin), ~np.asarray(splatted.unpaired)
        errors = np.abs(np.asarray(splatted.image) - truth)[lit]
        error = float(errors.max() / truth.max()) if lit.any() else None
        note = f"time from {' x '.join(map(str, shape))} pixels, {1 - lit.mean():.0%} of them without a pair"
        return MethodTiming("Splat", seconds, None, None, error, None, None, note=note)

    def reference(self) -> MethodTiming:
        method, (height, columns) = nj.Traced(), self.camera.shape
        # It works in blocks of pixels: memory is that of one block, and of the image and its blocks side by side.
        rows = min(-(-method.chunk // columns), height)
        strip = replace(self.camera, shape=(rows, columns))
        with x64():
            size = _bytes(lambda: nj.render(self.scene, strip, method)) + 2 * 8 * height * columns
            seconds = _seconds(lambda: nj.render(self.scene, self.camera, method), runs=1)
        return MethodTiming(
            "Traced", seconds, size, 0.0, 0.0, None, 0.0 if self._curved() else None, note="the reference"
        )

    def _intensity_error(self, image: np.ndarray) -> float:
        return float(np.abs(image.ravel() - self.truth).max() / self.truth.max())

    def _phase_error(self, phase) -> float:
        difference = np.asarray(phase) - self.phase
        # Phases of the same light may be counted from other whole turns, and fringes of other signs by half a one.
        return float(np.abs(difference - np.round(2 * np.median(difference)) / 2).max())

    def _curved(self) -> bool:
        try:
            curved_surface(self.scene)
        except ValueError:
            return False
        return len(self.scene.beams) == 2 and float(np.ptp(np.asarray(self.points))) > 0

    def _bias(self, phase: Callable, scene: nj.Scene) -> float | None:
        """Relative error of the radius that puts this method's phase nearest to the reference's."""
        if not self._curved():
            return None
        face, total, step = curved_surface(scene), 1.0, 1e-4
        centre = np.asarray(self.points)
        for _ in range(_STEPS):
            at_radius, larger, smaller = (
                np.asarray(phase(change(scene, "radius", total * f, face))) for f in (1, 1 + step, 1 - step)
            )
            residual = self.phase - at_radius
            columns = [(larger - smaller) / (2 * step), np.ones_like(at_radius), *_slopes(at_radius, centre)]
            total *= 1 + float(np.linalg.lstsq(np.stack(columns, axis=1), residual, rcond=1e-12)[0][0])
        return total - 1


def _slopes(phase: np.ndarray, points: np.ndarray) -> list[np.ndarray]:
    """Change of a phase with the place of its centre, from a polynomial through the points."""
    unit = points / np.abs(points).max()
    powers = [(j, k) for j in range(5) for k in range(5 - j)]
    table = np.stack([unit[:, 0] ** j * unit[:, 1] ** k for j, k in powers], axis=1)
    weights = np.linalg.lstsq(table, phase, rcond=None)[0]
    along_x = [j * unit[:, 0] ** max(j - 1, 0) * unit[:, 1] ** k for j, k in powers]
    along_y = [k * unit[:, 0] ** j * unit[:, 1] ** max(k - 1, 0) for j, k in powers]
    return [np.stack(columns, axis=1) @ weights for columns in (along_x, along_y)]


def _fields(scene: nj.Scene, points: np.ndarray):
    """The fields of all pairs of beams at points of the screen [n, 2] in metres, in NumPy."""
    bench = packed.pack(scene)
    return packed.node_fields(bench, packed.arrivals(bench, points))


def _seconds(function: Callable, runs: int = _RUNS) -> float:
    """Median of several calls, after a first one that may compile; of one run, without that."""
    if runs > 1:
        jax.block_until_ready(function())
    times = []
    for _ in range(runs):
        begin = perf_counter()
        jax.block_until_ready(function())
        times.append(perf_counter() - begin)
    return float(np.median(times))


def _bytes(function: Callable) -> int:
    """The most memory that NumPy has at a time during a call."""
    tracemalloc.start()
    try:
        jax.block_until_ready(function())
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def _of_formula(fields):
    return fields.background + fields.envelope[0].real * nj.cos_turns(fields.phase[0])


@jax.jit
def _formula(scene, x, y):
    return _of_formula(closed_fields(scene, x, y))
