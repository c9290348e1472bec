"""Other people's programs on any upright or tilted bench, for speed against accuracy (`pareto.py`).

The ray tracers (batoid, Optiland, prysm, and loops by hand in numba and in Dr.Jit) follow the two beams of a scene and
deliver their path difference at every pixel. None of them aims: rays are launched at the pixel's own place. With
`rounds` of a chord method, its slope taken from three rays at the middle of the frame, they land on the pixel. Since
they know no fields, the true background and the true amplitude of the fringes are given to them, and cost them nothing.
tmm and LightPipes compute fringes of equal thickness at normal incidence.

Each maker returns a function without arguments that makes (path difference [m] or None, image), or None where the
library is not installed.
"""

import warnings
from collections.abc import Callable
from importlib.util import find_spec
from typing import NamedTuple

import numpy as np

from newtonjax import Scene
from newtonjax.scene import Surface, frame, itinerary


class Task(NamedTuple):
    """A scene of two beams and, flat over the pixels, their places [m], the true background and fringe amplitude."""

    scene: Scene
    x: np.ndarray
    y: np.ndarray
    background: np.ndarray
    fringes: np.ndarray

    def image(self, opd: np.ndarray) -> np.ndarray:
        return self.background + self.fringes * np.cos(2 * np.pi / float(self.scene.wavelength) * opd)


class Stop(NamedTuple):
    """What a ray meets: a surface, the indices on its side and beyond, whether it goes up, and is reflected."""

    surface: Surface
    before: float
    beyond: float
    up: bool
    reflects: bool


def stops(scene: Scene, word: str) -> list[Stop]:
    """The stops of a beam, the screen last."""
    path, found, up = itinerary(word, len(scene.surfaces)), [], False
    for k, action, before, beyond in zip(path.surface, path.action, path.before, path.beyond, strict=True):
        n1, n2 = float(scene.media[before]), float(scene.media[beyond])
        found.append(Stop(scene.surfaces[k], n1, n2, up, bool(action)))
        up = up != bool(action)
    last = found[-1].beyond
    return [*found, Stop(scene.screen, last, last, up, False)]


def routes(scene: Scene) -> tuple[list[Stop], list[Stop]]:
    """Of both beams, the one with fewer crossings of the gap first."""
    short, long = sorted(scene.beams, key=len)
    return stops(scene, short), stops(scene, long)


def launch_height(scene: Scene) -> float:
    return float(scene.surfaces[0].vertex[2]) + 1e-3


def slope_at_middle(trace: Callable, route, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The inverse of how the landing point moves with the launch point."""
    step = 1e-6
    # Off the axis by half a step: prysm's sphere divides by the radius.
    u, v, _ = trace(route, x.mean() + np.array([-step, step, -step]) / 2, y.mean() + np.array([-step, -step, step]) / 2)
    return np.linalg.inv(np.array([[u[1] - u[0], u[2] - u[0]], [v[1] - v[0], v[2] - v[0]]]) / step)


def aimed(trace: Callable, route, x: np.ndarray, y: np.ndarray, rounds: int) -> np.ndarray:
    """Optical path [m] of the rays launched at (x, y), or after some rounds of aiming at it."""
    u, v = x, y
    slope = slope_at_middle(trace, route, x, y) if rounds else np.eye(2)
    for _ in range(rounds):
        at_x, at_y, _ = trace(route, u, v)
        u = u + slope[0, 0] * (x - at_x) + slope[0, 1] * (y - at_y)
        v = v + slope[1, 0] * (x - at_x) + slope[1, 1] * (y - at_y)
    return trace(route, u, v)[2]


def _two_paths(task: Task, rounds: int, trace: Callable, both) -> Callable:
    def image():
        first, second = (aimed(trace, route, task.x, task.y, rounds) for route in both)
        return second - first, task.image(second - first)

    return image


def batoid_way(task: Task, rounds: int):
    """By batoid."""
    try:
        import batoid
    except ImportError:
        return None
    height, screen = launch_height(task.scene), float(task.scene.screen.vertex[2])

    def prepared(stop: Stop):
        surface = stop.surface
        shape = batoid.Plane() if surface.curvature == 0 else batoid.Sphere(1 / float(surface.curvature))
        there = batoid.CoordSys(np.array(surface.vertex, float), np.array(frame(surface.tilt)).T.copy())
        return stop, shape, there, batoid.ConstMedium(stop.before), batoid.ConstMedium(stop.beyond)

    def trace(route, u, v):
        zero = np.zeros_like(u)
        rays = batoid.RayVector(u.copy(), v.copy(), zero + height, zero, zero, zero - 1.0, 0.0, 500e-9, 1.0)
        for stop, shape, there, before, beyond in route[:-1]:
            if stop.reflects:
                batoid.reflect(shape, rays, coordSys=there)
            else:
                batoid.refract(shape, rays, before, beyond, coordSys=there)
        # By hand: batoid finds no virtual screen, which lies behind the rays.
        rays.toCoordSys(batoid.CoordSys())
        time = (screen - rays.z) / rays.vz
        return rays.x + time * rays.vx, rays.y + time * rays.vy, rays.t + time

    return _two_paths(task, rounds, trace, [[prepared(stop) for stop in route] for route in routes(task.scene)])


def optiland_way(task: Task, rounds: int):
    """By Optiland's geometries and rays (NumPy backend)."""
    try:
        from optiland.coordinate_system import CoordinateSystem
        from optiland.geometries import Plane, StandardGeometry
        from optiland.materials import IdealMaterial
        from optiland.rays import RealRays
    except ImportError:
        return None
    # Numba's internal check of Optiland's compiled intersection says so at every first call.
    warnings.filterwarnings("ignore", message="variable .* is not in scope")
    height = launch_height(task.scene)

    def prepared(stop: Stop):
        surface = stop.surface
        there = CoordinateSystem(*map(float, surface.vertex), *map(float, surface.tilt))
        shape = Plane(there) if surface.curvature == 0 else StandardGeometry(there, 1 / float(surface.curvature))
        return stop, shape, IdealMaterial(stop.before).propagation_model

    def trace(route, u, v):
        zero = np.zeros_like(u)
        rays = RealRays(u, v, zero + height, zero, zero, zero - 1.0, zero + 1.0, zero + 0.5)
        for stop, shape, medium in route:
            shape.localize(rays)
            way = shape.distance(rays)
            medium.propagate(rays, way)
            rays.opd = rays.opd + way * stop.before
            if stop.reflects:
                rays.reflect(*shape.surface_normal(rays))
            elif stop.before != stop.beyond:
                rays.refract(*shape.surface_normal(rays), stop.before, stop.beyond)
            shape.globalize(rays)
        return rays.x, rays.y, rays.opd

    return _two_paths(task, rounds, trace, [[prepared(stop) for stop in route] for route in routes(task.scene)])


def prysm_way(task: Task, rounds: int):
    """By prysm's ray trace. It refracts rays along +z only: faces that are met from above are turned over."""
    try:
        from prysm.experimental.raytracing.spencer_and_murty import raytrace
        from prysm.experimental.raytracing.surfaces import Surface as Face
    except ImportError:
        return None
    height = launch_height(task.scene)

    def prepared(route):
        faces = []
        for stop in route:
            surface, sign = stop.surface, 1.0 if stop.up else -1.0
            axes, c = np.array(frame(surface.tilt)), sign * float(surface.curvature)
            turned = np.stack([axes[0], sign * axes[1], sign * axes[2]])
            kind = "reflect" if stop.reflects else "refract"
            more = {"typ": kind, "P": np.array(surface.vertex, float), "R": turned, "n": lambda _, n=stop.beyond: n}
            faces.append(Face.sphere(c=c, **more) if c else Face.plane(**more))
        return faces, np.array([stop.before for stop in route])

    def trace(route, u, v):
        faces, indices = route
        start = np.stack([u, v, np.full_like(u, height)], axis=1)
        points, ways = raytrace(faces, start, np.broadcast_to([0.0, 0.0, -1.0], start.shape), 0.5)
        # Along the ray, negative to a virtual screen.
        lengths = np.einsum("kij,kij->ki", np.diff(points, axis=0), ways[:-1])
        return points[-1, :, 0], points[-1, :, 1], indices @ lengths

    return _two_paths(task, rounds, trace, [prepared(route) for route in routes(task.scene)])


def by_hand(sqrt: Callable, height: float) -> Callable:
    """A ray's landing point and optical path through rows of numbers, for any arrays that have this square root."""

    def trace(rows, u, v):
        x, y, z, dx, dy, dz, path = u, v, height, 0.0, 0.0, -1.0, 0.0
        for k in range(len(rows)):
            vx, vy, vz, ax, ay, az, c, n1, n2, sign, reflects = rows[k]
            along = dx * ax + dy * ay + dz * az
            slide = ((vx - x) * ax + (vy - y) * ay + (vz - z) * az) / along
            ox, oy, oz = x - vx + slide * dx, y - vy + slide * dy, z - vz + slide * dz
            b, rho2 = c * (ox * dx + oy * dy + oz * dz) - along, ox * ox + oy * oy + oz * oz
            beyond = c * rho2 / (sign * sqrt(b * b - c * c * rho2) - b)
            ox, oy, oz = ox + beyond * dx, oy + beyond * dy, oz + beyond * dz
            x, y, z, path = vx + ox, vy + oy, vz + oz, path + n1 * (slide + beyond)
            nx, ny, nz = ax - c * ox, ay - c * oy, az - c * oz
            cos_i = dx * nx + dy * ny + dz * nz
            if reflects > 0:
                dx, dy, dz = dx - 2 * cos_i * nx, dy - 2 * cos_i * ny, dz - 2 * cos_i * nz
            else:
                eta = n1 / n2
                more = sign * sqrt(1 - eta * eta * (1 - cos_i * cos_i)) - eta * cos_i
                dx, dy, dz = eta * dx + more * nx, eta * dy + more * ny, eta * dz + more * nz
        return x, y, path

    return trace


def _rows(route: list[Stop]) -> list[tuple[float, ...]]:
    return [
        (
            *map(float, stop.surface.vertex), *map(float, frame(stop.surface.tilt)[2]), float(stop.surface.curvature),
            stop.before, stop.beyond, 1.0 if stop.up else -1.0, float(stop.reflects),
        )
        for stop in route
    ]  # fmt: skip


def _slopes(task: Task) -> np.ndarray:
    trace = by_hand(np.sqrt, launch_height(task.scene))
    return np.stack([slope_at_middle(trace, _rows(route), task.x, task.y) for route in routes(task.scene)])


def numba_way(task: Task, rounds: int):
    """By one parallel loop over pixels in numba: both rays, their aim, and the cosine."""
    try:
        import numba
    except ImportError:
        return None
    rows = tuple(np.array(_rows(route)) for route in routes(task.scene))
    slopes, turn = _slopes(task), 2 * np.pi / float(task.scene.wavelength)
    trace = numba.njit(error_model="numpy")(by_hand(np.sqrt, launch_height(task.scene)))

    @numba.njit(error_model="numpy")
    def path(rows, slope, x, y):
        u, v = x, y
        for _ in range(rounds):
            at_x, at_y, _ = trace(rows, u, v)
            u, v = (
                u + slope[0, 0] * (x - at_x) + slope[0, 1] * (y - at_y),
                v + slope[1, 0] * (x - at_x) + slope[1, 1] * (y - at_y),
            )
        return trace(rows, u, v)[2]

    @numba.njit(parallel=True, error_model="numpy")
    def image(first, second, slopes, x, y, background, fringes):
        opd, out = np.empty(x.size), np.empty(x.size)
        for k in numba.prange(x.size):
            opd[k] = path(second, slopes[1], x[k], y[k]) - path(first, slopes[0], x[k], y[k])
            out[k] = background[k] + fringes[k] * np.cos(turn * opd[k])
        return opd, out

    return lambda: image(*rows, slopes, task.x, task.y, task.background, task.fringes)


def drjit_way(task: Task, rounds: int):
    """The same loop unrolled over stops and traced by Dr.Jit's LLVM backend."""
    try:
        import drjit as dr
        from drjit.llvm import Float64

        dr.eval(Float64(1.0))
    except (ImportError, RuntimeError, AttributeError):
        return None
    trace = by_hand(dr.sqrt, launch_height(task.scene))
    x, y, background, fringes = (Float64(np.ascontiguousarray(a)) for a in task[1:])
    slopes, both = _slopes(task), [_rows(route) for route in routes(task.scene)]

    def path(rows, slope):
        # Opaque: the numbers of the bench stay arguments of the kernel, as they are in ours.
        rows = [(*(dr.opaque(Float64, number) for number in row[:9]), *row[9:]) for row in rows]
        u, v = x, y
        for _ in range(rounds):
            at_x, at_y, _ = trace(rows, u, v)
            u, v = (
                u + float(slope[0, 0]) * (x - at_x) + float(slope[0, 1]) * (y - at_y),
                v + float(slope[1, 0]) * (x - at_x) + float(slope[1, 1]) * (y - at_y),
            )
        return trace(rows, u, v)[2]

    def image():
        opd = path(both[1], slopes[1]) - path(both[0], slopes[0])
        out = background + fringes * dr.cos(2 * np.pi / float(task.scene.wavelength) * opd)
        dr.eval(opd, out)
        dr.sync_thread()
        return opd, out

    return image


def gap_amplitudes(scene: Scene) -> tuple[float, float]:
    """Of two beams at normal incidence, in the order of `routes`, reflections r = (n1 - n2) / (n1 + n2)."""
    found = []
    for route in routes(scene):
        total = 1.0
        for stop in route[:-1]:
            n1, n2 = stop.before, stop.beyond
            total *= (n1 - n2) / (n1 + n2) if stop.reflects else 2 * np.sqrt(n1 * n2) / (n1 + n2)
        found.append(total)
    return found[0], found[1]


def lightpipes_way(task: Task, radius: float, pixel: float, count: int):
    """By LightPipes: a plane and a spherical wave mixed, a lens of focal length R / 2 making the path r² / R."""
    try:
        import LightPipes
    except ImportError:
        return None
    wavelength = float(task.scene.wavelength)
    first, second = gap_amplitudes(task.scene)

    def image():
        plane = LightPipes.Begin(count * pixel, wavelength, count)
        # Its even grids have a pixel on the axis: half a pixel is shifted back.
        sphere = LightPipes.Lens(plane, -radius / 2, -pixel / 2, -pixel / 2)
        if first * second < 0:
            sphere = LightPipes.MultPhase(sphere, np.pi)
        mixed = LightPipes.BeamMix(
            LightPipes.IntAttenuator(plane, first**2), LightPipes.IntAttenuator(sphere, second**2)
        )
        return None, LightPipes.Intensity(mixed).ravel()

    return image


def tmm_intensity(scene: Scene, thickness: np.ndarray) -> np.ndarray:
    """Transmittance of glass | gap | glass at normal incidence by tmm, times that of the two outer faces."""
    import tmm

    upper, gap, lower = (float(scene.media[k]) for k in (1, 2, 3))
    outer = 1.0
    for n1, n2 in ((scene.media[0], upper), (lower, scene.media[-1])):
        outer *= 4 * float(n1) * float(n2) / (float(n1) + float(n2)) ** 2
    light = float(scene.wavelength)
    found = [tmm.coh_tmm("s", [upper, gap, lower], [np.inf, t, np.inf], 0.0, light)["T"] for t in thickness]
    return outer * np.array(found)


def tmm_table_way(scene: Scene, thickness: np.ndarray, entries: int):
    """By tmm at some thicknesses of one fringe, linear in between."""
    if find_spec("tmm") is None:
        return None
    period = float(scene.wavelength) / (2 * float(scene.media[2]))
    nodes = np.linspace(0, period, entries)

    def image():
        return None, np.interp(thickness % period, nodes, tmm_intensity(scene, nodes))

    return image


def tmm_way(scene: Scene, thickness: np.ndarray):
    """By tmm at every thickness."""
    if find_spec("tmm") is None:
        return None
    return lambda: (None, tmm_intensity(scene, thickness))
