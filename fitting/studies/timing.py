"""Speed against accuracy of every method for one scene, and the bias of the radius that each would cause in a fit."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter
from typing import cast

import jax
import jax.numpy as jnp
import numpy as np

import newtonjax as nj
from fitting.parameters import change, curved_surface
from newtonjax.fields import closed_fields, fields_at, intensity, polar, synthesize, synthesize_on
from newtonjax.numerics import chebyshev, x64
from newtonjax.scene import gap_of, has_tilted_sphere, node_points, why_not_closed

# Tolerances that are planned for, and the fixed grid that a user's own transformation gets.
TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8)
_DEFAULT = 17
# Points to a side for phases, and pixels to a side for images that are compared.
_POINTS, _SIDE = 21, 192
_RUNS, _STEPS = 5, 4


@dataclass(frozen=True)
class Way:
    """One way to the image of a scene.

    - `name`: of the method; `tolerance`: for which it was planned, None for none.
    - `seconds`: of one image, compiled; `bytes`: that it takes beyond its input.
    - `phase_error`: largest [turns]; `intensity_error`: largest over the peak; `predicted`: what the plan says of it.
    - `radius_bias`: relative, of a fit with this method as the model to what the reference shows; None without a phase
      or a curved face.
    - `note`: why something is missing, or what the method ignores.
    """

    name: str
    seconds: float | None
    bytes: int | None
    phase_error: float | None
    intensity_error: float | None
    predicted: float | None
    radius_bias: float | None
    tolerance: float | None = None
    note: str = ""


def tradeoff(
    scene: nj.Scene, camera: nj.Camera, progress: Callable[[int, int], None] | None = None, splat: bool = False
) -> list[Way]:
    """Every method for a scene, the rays at every pixel last: these are the reference.

    Times and memory are those of the camera's own image; errors are taken on at most 192 x 192 of its pixels. The bias
    is that of least squares on the phase, with the radius, the centre and the gap free. `splat`: the algorithm of 2021
    too, which takes long.
    """
    way = _Race(scene, camera)
    jobs: list[Callable[[], Way]] = [way.formula]
    plans: dict[int, tuple[nj.Plan, float | None]] = {}
    for tolerance in TOLERANCES:
        chosen = nj.plan(scene, camera, tolerance)
        nodes = getattr(chosen.method, "nodes", None)
        if nodes is not None:
            plans.setdefault(nodes, (chosen, tolerance))
    jobs += [lambda p=p, t=t: way.nodes(p, t) for p, t in plans.values()]
    if _DEFAULT not in plans and plans:
        jobs.append(lambda: way.nodes(replace(next(iter(plans.values()))[0], method=nj.Chebyshev(_DEFAULT)), None))
    if splat:
        jobs.append(way.splat)
    jobs.append(way.reference)
    found = []
    for number, job in enumerate(jobs):
        found.append(job())
        if progress is not None:
            progress(number + 1, len(jobs))
    return found


class _Race:
    """A scene with its reference, of rays at some of its pixels and at nodes all over the image."""

    def __init__(self, scene: nj.Scene, camera: nj.Camera):
        self.scene, self.camera = scene, camera
        self.rows, self.columns = (np.unique(np.linspace(0, n - 1, _SIDE).round().astype(int)) for n in camera.shape)
        with x64():
            x, y = camera.axes()
            there = np.meshgrid(np.asarray(x)[self.columns], np.asarray(y)[self.rows])
            self.pixels = jnp.stack([jnp.asarray(axis.ravel()) for axis in there], axis=1)
            self.points = node_points(camera, _POINTS)
            self.truth = np.asarray(_traced_image(scene, self.pixels))
            self.phase = np.asarray(_traced_phase(scene, self.points))

    def formula(self) -> Way:
        """2 n t at normal incidence, also where `render` would refuse it."""
        reason = why_not_closed(self.scene)
        if gap_of(self.scene) is None or has_tilted_sphere(self.scene):
            return Way("ClosedForm", None, None, None, None, None, None, note=f"there is none: {reason}")
        with x64():
            x, y = self.camera.axes()
            made = _Timed(_formula, self.scene, x[None, :], y[:, None])
            image = np.asarray(_formula(self.scene, self.pixels[:, 0], self.pixels[:, 1]))
            phase = _formula_phase(self.scene, self.points)
        bias = self._bias(lambda scene: _formula_phase(scene, self.points), self.scene)
        note = f"ignores {reason.split(':')[0]}" if reason else ""
        return Way("ClosedForm", made.seconds, made.bytes, self._away(phase), self._wrong(image), None, bias, note=note)

    def nodes(self, plan: nj.Plan, tolerance: float | None) -> Way:
        """Rays at the nodes and the image of them are compiled and timed one after the other, as `render` has them."""
        count = cast(nj.Chebyshev, plan.method).nodes
        predicted = plan.intensity_error if tolerance is not None else None
        onto = chebyshev.values(count, _POINTS)

        def phase(scene):
            fields = np.asarray(rays.compiled(scene, self.camera))
            return (onto @ fields[1 + len(fields) // 2] @ onto.T).ravel()

        with x64():
            rays = _Timed(_coefficients, plan.scene, self.camera, static=(count,))
            fields = rays.compiled(plan.scene, self.camera)
            pixels = _Timed(_synthesize, fields, static=(self.camera.shape,))
            image = np.asarray(_at_pixels(fields, *self._bases(count)))
            away, bias = self._away(phase(plan.scene)), self._bias(phase, plan.scene)
        note = f"without {len(plan.dropped)} weak beams" if plan.dropped else ""
        seconds, size = rays.seconds + pixels.seconds, max(rays.bytes, pixels.bytes)
        return Way(f"Chebyshev({count})", seconds, size, away, self._wrong(image), predicted, bias, tolerance, note)

    def _bases(self, count: int) -> tuple[np.ndarray, np.ndarray]:
        rows, columns = (chebyshev.basis(n, count) for n in self.camera.shape)
        return rows[:, self.rows], columns[:, self.columns]

    def splat(self) -> Way:
        """The mean of pairs of rays, on a smaller image and timed there: it is linear in the pixels."""
        factor = max(1.0, max(self.camera.shape) / _SIDE)
        shape = (max(int(self.camera.shape[0] / factor), 1), max(int(self.camera.shape[1] / factor), 1))
        centre = self.camera.centre_px
        centre = None if centre is None else tuple((np.asarray(centre) + 0.5) / factor - 0.5)
        small = replace(self.camera, shape=shape, pixel_size=float(self.camera.pixel_size) * factor, centre_px=centre)
        truth = np.asarray(nj.render(self.scene, small, nj.Traced()))
        begin = perf_counter()
        try:
            found = nj.splat(self.scene, small, nj.Splat())
        except ValueError as error:
            return Way("Splat", None, None, None, None, None, None, note=str(error).split(";")[0])
        share = np.prod(self.camera.shape) / np.prod(shape)
        seconds, lit = float(share) * (perf_counter() - begin), ~np.asarray(found.unpaired)
        wrong = np.abs(np.asarray(found.image) - truth)[lit]
        error = float(wrong.max() / truth.max()) if lit.any() else None
        note = f"time from {' x '.join(map(str, shape))} pixels, {1 - lit.mean():.0%} of them without a pair"
        return Way("Splat", seconds, None, None, error, None, None, note=note)

    def reference(self) -> Way:
        with x64():
            made = _Timed(_reference, self.scene, self.camera, runs=1)
        bias = 0.0 if self._curved() else None
        return Way("Traced", made.seconds, made.bytes, 0.0, 0.0, None, bias, note="the reference")

    def _wrong(self, image: np.ndarray) -> float:
        return float(np.abs(image.ravel() - self.truth).max() / self.truth.max())

    def _away(self, phase) -> float:
        away = np.asarray(phase) - self.phase
        # Phases of the same light may be counted from other whole turns, and fringes of other signs by half a one.
        return float(np.abs(away - np.round(2 * np.median(away)) / 2).max())

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
            here, more, less = (
                np.asarray(phase(change(scene, "radius", total * f, face))) for f in (1, 1 + step, 1 - step)
            )
            left = self.phase - here
            columns = [(more - less) / (2 * step), np.ones_like(here), *_slopes(here, centre)]
            total *= 1 + float(np.linalg.lstsq(np.stack(columns, axis=1), left, rcond=1e-12)[0][0])
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


class _Timed:
    """A function compiled for its arguments: median seconds of a call, and the bytes that it takes beyond them."""

    def __init__(self, function, *arguments, static: tuple = (), runs: int = _RUNS):
        self.compiled = function.lower(*arguments, *static).compile()
        analysis = self.compiled.memory_analysis()
        self.bytes = int(analysis.output_size_in_bytes + analysis.temp_size_in_bytes)
        jax.block_until_ready(self.compiled(*arguments))
        times = []
        for _ in range(runs):
            begin = perf_counter()
            jax.block_until_ready(self.compiled(*arguments))
            times.append(perf_counter() - begin)
        self.seconds = float(np.median(times))


@jax.jit
def _formula(scene, x, y):
    fields = closed_fields(scene, x, y)
    return fields.background + fields.envelope[0].real * nj.cos_turns(fields.phase[0])


@jax.jit
def _formula_phase(scene, points):
    return closed_fields(scene, points[:, 0], points[:, 1]).phase[0]


@jax.jit
def _traced_phase(scene, points):
    return polar(fields_at(scene, points))[1][0]


@jax.jit
def _traced_image(scene, pixels):
    return jax.lax.map(lambda pixel: intensity(fields_at(scene, pixel[None]))[0], pixels, batch_size=4096)


@jax.jit
def _reference(scene, camera):
    return nj.Traced().image(scene, camera)


@partial(jax.jit, static_argnums=2)
def _coefficients(scene, camera, nodes: int):
    method = nj.Chebyshev(nodes)
    return method.coefficients(method.fields(scene, camera))


_synthesize = jax.jit(synthesize, static_argnums=1)
_at_pixels = jax.jit(synthesize_on)
