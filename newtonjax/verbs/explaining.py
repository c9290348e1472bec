"""What an image models, what it leaves out and what that costs: `explain`."""

from dataclasses import dataclass, replace
from time import perf_counter

import jax
import numpy as np
from jaxtyping import Float

from newtonjax.fields import Fields, arrivals, closed_fields, node_fields, pack, polar
from newtonjax.methods import ClosedForm, change_by_orders, one_line
from newtonjax.numerics import require_concrete
from newtonjax.planning import Plan, beam_amplitudes, plan, predicted_seconds
from newtonjax.scene import (
    Camera,
    Light,
    Scene,
    Surface,
    enumerate_beams,
    gap_of,
    has_tilted_sphere,
    node_points,
    require_bench,
)
from newtonjax.verbs.light_parts import (
    Omission,
    of_distance,
    of_extent,
    of_line_width,
    of_pixel,
    of_spectrum,
    peak_of,
    way_of_means,
)
from newtonjax.verbs.rendering import render

# Points to a side at which fields with and without a part are compared, and what may hide in between.
_POINTS, _BETWEEN = 17, 2.0
# A beam of so many reflections more is weaker by a power of a few percent.
_REFLECTIONS = 4


@dataclass(frozen=True)
class Explanation:
    """What `explain` found. `str()` is a page of text.

    - `plan`: the method, its nodes, its errors, and the beams that it drops.
    - `omissions`: parts in and out of the image.
    - `finest_fringe`: [pixels]; below two they pass for wider ones.
    - `predicted_seconds`, `measured_seconds`: of one image, compiled; `compile_seconds`: of the first call beyond that;
      `planning_seconds`: what `render` without a method takes to choose one.
    """

    scene: Scene
    camera: Camera
    tolerance: float
    plan: Plan
    omissions: tuple[Omission, ...]
    finest_fringe: float
    predicted_seconds: float
    measured_seconds: float
    compile_seconds: float
    planning_seconds: float

    def __str__(self) -> str:
        light = self.scene.light
        polarized = "unpolarized, two components" if light.polarization is None else "polarized"
        lines = [
            f"method      {self.plan.method.describe()}: {self.plan.reason}",
            f"error       {self.plan.phase_error:.2g} turns, {self.plan.intensity_error:.2g} of the peak "
            f"(tolerance {self.tolerance:g})",
            f"cost        predicted {_time(self.predicted_seconds)}, measured {_time(self.measured_seconds)} "
            f"(first call {_time(self.compile_seconds)} more; to choose the method {_time(self.planning_seconds)})",
            f"fringes     {self.finest_fringe:.3g} pixels at the finest"
            + ("; below 2 pixels fringes are aliased" if self.finest_fringe < 2.4 else ""),
            *(f"warning     {words}" for words in self.plan.warnings),
            f"beams       {', '.join(self.plan.scene.beams)}",
            f"light       {_lines(light)} {float(light.wavelength) * 1e9:.6g} nm, {_way_in(light)}, {polarized}",
            "",
            "modelled, and the change of intensity if omitted (fraction of the peak):",
            *_rows(o for o in self.omissions if o.modelled),
            "not modelled, and the change of intensity if included:",
            *_rows(o for o in self.omissions if not o.modelled),
        ]
        return "\n".join(lines)


def _lines(light: Light) -> str:
    return "one line of" if light.spectrum is None else f"{len(light.spectrum.weights)} lines or samples about"


def _way_in(light: Light) -> str:
    """From where light comes to the bench, in words."""
    over = "" if light.extent is None else f"over a {light.extent.shape} of sine {light.extent.sine:.3g}"
    curvature = 0.0 if light.curvature is None else float(light.curvature)
    if not curvature:
        return over or "collimated"
    distance = f"{abs(1 / curvature):.4g} m"
    waves = f"from {distance} away" if curvature > 0 else f"gathered {distance} beyond"
    return f"{over}, {waves}" if over else waves


def _rows(omissions) -> list[str]:
    rows = [
        f"  {o.part:<28} {'' if o.error is None else format(o.error, '.2g'):<9} {o.note}".rstrip() for o in omissions
    ]
    return rows or ["  nothing"]


def _time(seconds: float) -> str:
    return f"{seconds:.3g} s" if seconds >= 0.1 else f"{seconds * 1e3:.3g} ms"


def explain(scene: Scene, camera: Camera, tolerance: float = 1e-3) -> Explanation:
    """What `render` does for a scene: method, error, cost, and the parts that are in the image or left out of it.

    Each part's error is the largest change of intensity, over the peak, between the fields with it and without it, at
    17 x 17 points of the image, twice that for what lies between. Where phases differ by more than half a turn it is
    all that it can be.

    Renders the image four times to measure its cost. Raises ValueError for a tolerance that is not positive, and for
    traced values.
    """
    require_bench(scene, camera)
    require_concrete("explain", scene, camera)
    plan(scene, camera, tolerance)  # compiles
    begin = perf_counter()
    chosen = plan(scene, camera, tolerance)
    planning = perf_counter() - begin
    first, again = _clock(chosen, camera), min(_clock(chosen, camera) for _ in range(3))
    of_orders = None if scene.all_orders is None else change_by_orders(scene, camera)
    bench, points = scene, node_points(camera, _POINTS)
    light, scene = scene.light, one_line(scene)
    fields = _fields(scene, points)
    all_arrive = bool(fields.arrives.all())
    if not all_arrive:  # the part of the image that light reaches; where it does not, there is nothing
        points = points[fields.arrives] if fields.arrives.any() else points[:1]
        fields = _fields(scene, points)
    parts = [*_of_beams(scene, camera, chosen, fields), *_inside(scene, chosen, points, fields)]
    frequency = _frequency(scene, camera, points)
    note = way_of_means(bench, camera, chosen.method)
    parts.append(of_pixel(fields, frequency, all_arrive, camera.takes_means, note))
    if light.spectrum is None:
        parts.append(of_line_width(scene, fields, tolerance))
    else:
        parts.append(of_spectrum(light, fields))
    parts.append(of_extent(bench, camera, fields, tolerance))
    parts.append(of_distance(bench, camera, points, fields, tolerance))
    if of_orders is not None:
        parts = [part for part in parts if part.part != "more beams"]
        parts.append(Omission("all orders, coatings", of_orders, True, "against the gap's two beams on bare glass"))
    finest = float(np.hypot(*frequency).max())
    return Explanation(
        bench,
        camera,
        tolerance,
        chosen,
        tuple(parts),
        1 / finest if finest else np.inf,
        predicted_seconds(chosen.method, chosen.scene, camera),
        again,
        max(first - again, 0.0),
        planning,
    )


def _clock(chosen: Plan, camera: Camera) -> float:
    begin = perf_counter()
    jax.block_until_ready(render(chosen.scene, camera, chosen.method))
    return perf_counter() - begin


def _fields(scene: Scene, points: Float[np.ndarray, "n 2"]) -> Fields:
    bench = pack(scene)
    return node_fields(bench, arrivals(bench, points))


def _difference(fields: Fields, changed: Fields) -> float:
    """Largest change of intensity between two fields of the same pairs of beams, over the peak, whatever the phase."""
    (size, phase), (changed_size, changed_phase) = polar(fields), polar(changed)
    turns = np.abs(phase - changed_phase)
    turns = np.minimum(2 * np.pi * np.abs(turns - np.round(turns)), 2.0)
    beyond = np.abs(phase - changed_phase) > 0.5
    change = np.abs(fields.background - changed.background)
    change = change + np.abs(np.abs(size) - np.abs(changed_size)).sum(axis=0)
    change = change + (np.where(beyond, 2.0, turns) * np.abs(size)).sum(axis=0)
    return min(_BETWEEN * float(change.max()), 2.0 * peak_of(fields)) / peak_of(fields)


def _of_beams(scene: Scene, camera: Camera, chosen: Plan, fields: Fields) -> list[Omission]:
    """The scene's beams by the amplitudes that its rays have; those that it does not follow by those on the axis."""
    amplitudes, peak = beam_amplitudes(scene, camera), peak_of(fields)

    def change(added: float, present: float) -> float:
        return (2 * added * present + added**2) / peak

    weakest, *stronger = sorted(amplitudes.values())
    omissions = [Omission("beams", change(weakest, sum(stronger)), True, f"the weakest of {len(scene.beams)}")]
    if chosen.dropped:
        note = f"{', '.join(chosen.dropped)}: too weak to matter here"
        dropped_amplitude = sum(amplitudes[word] for word in chosen.dropped)
        error = change(dropped_amplitude, sum(amplitudes[word] for word in chosen.scene.beams))
        omissions.append(Omission("beams of the scene, dropped", error, False, note))
    candidates = enumerate_beams(scene.media, scene.view, _REFLECTIONS)
    unfollowed = [beam for beam in candidates if beam.word not in scene.beams and beam.energy > 0]
    if unfollowed:
        upright = _light_upright(scene) is None
        error = change(sum(np.sqrt(beam.energy) for beam in unfollowed), sum(amplitudes.values())) if upright else None
        names = ", ".join(beam.name for beam in unfollowed[:3])
        note = f"{len(unfollowed)} of up to {_REFLECTIONS} reflections, if coherent: {names}, ..."
        omissions.append(
            Omission("more beams", error, False, note if upright else f"{note}; oblique light has no number")
        )
    note = "rays from parts of the lens outside of the field of view are not searched for"
    omissions.append(Omission("light from beyond the image", None, False, note))
    return omissions


def _inside(scene: Scene, chosen: Plan, points: Float[np.ndarray, "n 2"], fields: Fields) -> list[Omission]:
    """Parts of the scene itself: polarization, tilts, the bare screen's rays, the exact sphere."""
    omissions = []
    if scene.light.polarization is None:
        lights = [replace(scene.light, polarization=angle) for angle in (0.0, np.pi / 2)]
        turned = [replace(scene, light=light) for light in lights]
        error = max(_difference(_fields(polarized, points), fields) for polarized in turned)
        omissions.append(Omission("polarization", error, True, "against light polarized along x or y"))
    for name, level in (("tilt of the light", _light_upright(scene)), ("tilt of the surfaces", _upright(scene))):
        if level is not None:
            omissions.append(Omission(name, _difference(_fields(level, points), fields), True, "against none"))
    if (upper := gap_of(scene)) is None or has_tilted_sphere(scene):
        return omissions
    x, y = points[:, 0], points[:, 1]
    formula = closed_fields(scene, x, y)
    note = f"against 2 n t at normal incidence{_why(scene)}"
    omissions.append(Omission("rays", _difference(formula, fields), chosen.method.traces_rays, note))
    if not all(face.is_plane() for face in scene.surfaces[upper : upper + 2]):
        parabola = closed_fields(scene, x, y, Surface.parabola)
        omissions.append(Omission("exact sphere", _difference(parabola, formula), True, "against the parabola r²/2R"))
    return omissions


def _why(scene: Scene) -> str:
    """What keeps 2 n t from being the path difference."""
    refusal = ClosedForm().refusal(scene)
    return "" if refusal is None else f"; there is a {refusal.part}"


def _light_upright(scene: Scene) -> Scene | None:
    if not np.any(np.asarray(scene.light.tilt) != 0):
        return None
    return replace(scene, light=replace(scene.light, tilt=(0.0, 0.0)))


def _upright(scene: Scene) -> Scene | None:
    if not any(np.any(np.asarray(surface.tilt) != 0) for surface in scene.surfaces):
        return None
    return replace(scene, surfaces=tuple(replace(surface, tilt=(0.0, 0.0)) for surface in scene.surfaces))


def _frequency(scene: Scene, camera: Camera, points: Float[np.ndarray, "n 2"]) -> tuple[np.ndarray, np.ndarray]:
    """Largest frequencies of the fringes along x and y at the points [cycles per pixel]: phases a pixel apart.

    0 where a beam does not reach both ends of the pixel.
    """
    half = float(camera.pixel_size) / 2 * np.array([[1.0, 0.0], [0.0, 1.0]])
    shifted = np.concatenate([points + sign * step for step in half for sign in (1, -1)])
    fields = _fields(scene, shifted)
    phase = polar(fields)[1].reshape(-1, 2, 2, len(points))
    arrives = fields.arrives.reshape(2, 2, len(points)).all(axis=1)
    along_x, along_y = np.where(arrives, np.abs(phase[:, :, 0] - phase[:, :, 1]).max(axis=0, initial=0.0), 0.0)
    return along_x, along_y
