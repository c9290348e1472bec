"""Speed against accuracy of every method for one scene, and the bias of the radius that each would cause in a fit."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from time import perf_counter

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

import newtonjax as nj
from fitting.models import change, curved_surface
from newtonjax import chebyshev
from newtonjax.fields import fields_at, polar
from newtonjax.gap import closed_fields, gap_of, has_tilted_sphere, why_not_closed
from newtonjax.methods import AbstractMethod
from newtonjax.precision import x64

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

    Times and memory are those of the camera's own image; errors are taken on at most 192 x 192 pixels of the same
    field. The bias is that of least squares on the phase, with the radius, the centre and the gap free. `splat`: the
    algorithm of 2021 too, which takes long.
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
    """A scene with its reference image and phase."""

    def __init__(self, scene: nj.Scene, camera: nj.Camera):
        self.scene, self.camera = scene, camera
        factor = max(1.0, max(camera.shape) / _SIDE)
        shape = (max(int(camera.shape[0] / factor), 1), max(int(camera.shape[1] / factor), 1))
        centre = None if camera.centre_px is None else tuple((np.asarray(camera.centre_px) + 0.5) / factor - 0.5)
        self.small = replace(camera, shape=shape, pixel_size=float(camera.pixel_size) * factor, centre_px=centre)
        self.truth = nj.render(scene, self.small, nj.Traced())
        with x64():
            self.points = chebyshev.node_points(self.small, _POINTS)
        self.phase = self._traced_phase(scene)

    def formula(self) -> Way:
        """2 n t at normal incidence, also where `render` would refuse it."""
        reason = why_not_closed(self.scene)
        if gap_of(self.scene) is None or has_tilted_sphere(self.scene):
            return Way("ClosedForm", None, None, None, None, None, None, note=f"there is none: {reason}")
        with x64():
            image = _formula(self.scene, self.small)
            phase = _formula_phase(self.scene, self.points)
        seconds, size = _clock(lambda: _formula(self.scene, self.camera), _formula.lower(self.scene, self.camera))
        bias = self._bias(lambda scene: _formula_phase(scene, self.points))
        note = f"ignores {reason.split(':')[0]}" if reason else ""
        return Way("ClosedForm", seconds, size, self._away(phase), self._wrong(image), None, bias, note=note)

    def nodes(self, plan: nj.Plan, tolerance: float | None) -> Way:
        method = plan.method
        predicted = plan.intensity_error if tolerance is not None else None
        seconds, size = self._time(method, plan.scene)
        image = nj.render(plan.scene, self.small, method)

        def phase(scene):
            with x64():
                return _nodes_phase(scene, self.small, method.nodes, _POINTS)

        name = f"Chebyshev({method.nodes})"
        errors = self._away(phase(self.scene)), self._wrong(image)
        note = f"without {len(plan.dropped)} weak beams" if plan.dropped else ""
        return Way(name, seconds, size, *errors, predicted, self._bias(phase), tolerance, note)

    def splat(self) -> Way:
        """The mean of pairs of rays, timed on the smaller image: it is linear in the pixels."""
        begin = perf_counter()
        try:
            found = nj.splat(self.scene, self.small, nj.Splat())
        except ValueError as error:
            return Way("Splat", None, None, None, None, None, None, note=str(error).split(";")[0])
        share = np.prod(self.camera.shape) / np.prod(self.small.shape)
        seconds, lit = float(share) * (perf_counter() - begin), ~np.asarray(found.unpaired)
        wrong = np.abs(np.asarray(found.image) - np.asarray(self.truth))[lit]
        error = float(wrong.max() / self.truth.max()) if lit.any() else None
        note = f"time from {' x '.join(map(str, self.small.shape))} pixels, {1 - lit.mean():.0%} of them without a pair"
        return Way("Splat", seconds, None, None, error, None, None, note=note)

    def reference(self) -> Way:
        seconds, size = self._time(nj.Traced(), self.scene, 1)
        return Way("Traced", seconds, size, 0.0, 0.0, None, 0.0 if self._curved() else None, note="the reference")

    def _time(self, method: AbstractMethod, scene: nj.Scene, runs: int = _RUNS) -> tuple[float, int]:
        with x64():
            lowered = jax.jit(lambda s, c: method.image(s, c)).lower(scene, self.camera)
        return _clock(lambda: nj.render(scene, self.camera, method), lowered, runs)

    def _wrong(self, image) -> float:
        return float(jnp.abs(image - self.truth).max() / self.truth.max())

    def _away(self, phase) -> float:
        away = np.asarray(phase) - self.phase
        # Phases of the same light may be counted from other whole turns, and fringes of other signs by half a one.
        return float(np.abs(away - np.round(2 * np.median(away)) / 2).max())

    def _curved(self) -> bool:
        try:
            curved_surface(self.scene)
        except ValueError:
            return False
        return len(self.scene.beams) == 2

    def _traced_phase(self, scene: nj.Scene) -> np.ndarray:
        with x64():
            return np.asarray(_traced_phase(scene, self.points))

    def _bias(self, phase: Callable) -> float | None:
        """Relative error of the radius that puts this method's phase nearest to the reference's."""
        if not self._curved():
            return None
        face, total, step = curved_surface(self.scene), 1.0, 1e-4
        centre = np.asarray(self.points)
        for _ in range(_STEPS):
            here, more, less = (
                np.asarray(phase(change(self.scene, "radius", total * f, face))) for f in (1, 1 + step, 1 - step)
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


def _clock(function: Callable, lowered, runs: int = _RUNS) -> tuple[float, int]:
    """Median seconds of a call after the first, and the bytes that its compiled form takes."""
    analysis = lowered.compile().memory_analysis()
    jax.block_until_ready(function())
    times = []
    for _ in range(runs):
        begin = perf_counter()
        jax.block_until_ready(function())
        times.append(perf_counter() - begin)
    return float(np.median(times)), int(analysis.output_size_in_bytes + analysis.temp_size_in_bytes)


@jax.jit
def _formula(scene, camera):
    x, y = camera.axes()
    fields = closed_fields(scene, x[None, :], y[:, None])
    return fields.background + fields.envelope[0].real * nj.cos_turns(fields.phase[0])


@jax.jit
def _formula_phase(scene, points):
    return closed_fields(scene, points[:, 0], points[:, 1]).phase[0]


@jax.jit
def _traced_phase(scene, points):
    return polar(fields_at(scene, points))[1][0]


@eqx.filter_jit
def _nodes_phase(scene, camera, nodes: int, points: int):
    values = chebyshev.coefficients(polar(nj.Chebyshev(nodes).fields(scene, camera))[1])[0]
    onto = jnp.asarray(chebyshev.values(nodes, points))
    return (onto @ values @ onto.T).ravel()
