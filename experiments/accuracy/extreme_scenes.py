"""The benches of `extremes.py`: one number of an ordinary bench at its extreme, as a scene and as an oracle.

A bench is a vector of the numbers in `NAMES`, so that one compiled function serves all of them.
"""

import sys
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import equinox as eqx
import numpy as np

import newtonjax as nj
from newtonjax.numerics import namespace

sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))
import oracles
from oracles import mpf, mpmath

TURNED = ("lens", "plate", "light", "face 0", "face 1", "face 2", "face 3", "screen")
BASE = {
    "curvature": 0.5, "wavelength": 500e-9, "gap": 1e-6, "height": 0.0, "lens_index": 1.5, "plate_index": 1.5,
    "gap_index": 1.0, "ambient_index": 1.0, "lens_thickness": 5e-3, "plate_thickness": 5e-3,
    **{f"{name} {axis}": 0.0 for name in TURNED for axis in "xy"},
}  # fmt: skip
NAMES = tuple(BASE)
INDICES = ("lens_index", "plate_index", "gap_index", "ambient_index")
THICKNESSES = ("lens_thickness", "plate_thickness")
WORDS = {"transmitted": oracles.TRANSMITTED, "reflected": oracles.REFLECTED}
VIEWS = tuple(WORDS)


@dataclass(frozen=True)
class Row:
    """One extreme.

    - `quantity`, `value`: what is extreme, and how much, as text.
    - `numbers`: what differs from `BASE`; a `screen` at a distance [m], or "gap", instead of its `height`.
    - `by`: the number whose derivative is taken beside that by the curvature.
    - `half`: half of the image's width [m].
    - `shape`, `centre_px`: of the camera.
    - `light`: irradiance that is known where no two rays meet, or None.
    - `follow`: the camera's middle is where the first beam's ray through the origin lands.
    """

    quantity: str
    value: str
    view: str
    numbers: dict
    by: str
    half: float
    shape: tuple[int, int] = (65, 65)
    centre_px: tuple[float, float] | None = None
    light: float | None = None
    follow: bool = False

    def vector(self) -> np.ndarray:
        """The numbers in the order of `NAMES`; the screen's height is computed."""
        given = dict(self.numbers)
        screen = given.pop("screen", 1e-3)
        values = {**BASE, **given}
        if screen == "gap":
            height = scene_of(np.array(list(values.values())), self.view, screen="gap").screen.vertex[2]
        elif self.view == "transmitted":
            height = -values["plate_thickness"] - screen
        else:
            height = values["gap"] + values["lens_thickness"] + screen
        return np.array(list((values | {"height": height}).values()), dtype=float)

    def camera(self) -> nj.Camera:
        pixel, centre = 2 * self.half / max(max(self.shape) - 1, 1), self.centre_px
        if self.follow:
            centre = ((self.shape[1] - 1) / 2 - self._aside() / pixel, (self.shape[0] - 1) / 2)
        return nj.Camera(self.shape, pixel, centre)

    def _aside(self) -> float:
        """Where light turned about y lands that the plates let pass through the origin [m]: Snell's law."""
        n = {**BASE, **self.numbers}
        invariant = n["ambient_index"] * np.sin(n["light y"])
        down = self.view == "transmitted"
        way = [(n["plate_index"], n["plate_thickness"])] if down else [(n["lens_index"], n["lens_thickness"])]
        way += [(n["ambient_index"], n.get("screen", 1e-3))] + ([] if not down else [(n["gap_index"], n["gap"])])
        return -sum(length * np.tan(np.arcsin(min(invariant / index, 1.0))) for index, length in way)


def scene_of(vector, view: str, screen=None) -> nj.Scene:
    """The scene of a vector of numbers, known or traced."""
    n = dict(zip(NAMES, vector, strict=True))
    xp = namespace(vector)
    pairs = {name: xp.stack([n[f"{name} x"], n[f"{name} y"]]) for name in TURNED}
    flat = n["curvature"] == 0 if xp is np else False
    scene = nj.newton_rings(
        np.inf if flat else 1 / n["curvature"], n["wavelength"], n["gap"], view,
        screen=1e-3 if screen is None else screen,
        **{name: n[name] for name in INDICES + THICKNESSES},
        **{f"{name}_tilt": pairs[name] for name in ("lens", "plate", "light")},
    )  # fmt: skip
    if screen is not None:
        return scene
    tilts = [face.tilt + pairs[f"face {k}"] for k, face in enumerate(scene.surfaces)]
    zero = 0 * n["height"]
    return eqx.tree_at(
        lambda s: (s.surfaces[1].curvature, s.screen.vertex, s.screen.tilt, *(face.tilt for face in s.surfaces)),
        scene,
        (n["curvature"], xp.stack([zero, zero, n["height"]]), pairs["screen"], *tilts),
    )


def oracle_of(vector, view: str) -> oracles.Bench:
    """The same bench at 50 digits."""
    n = {name: mpf(value) for name, value in zip(NAMES, vector, strict=True)}
    pairs = {name: (n[f"{name} x"], n[f"{name} y"]) for name in TURNED}
    bench = oracles.rings(
        view,
        radius=mpmath.inf if n["curvature"] == 0 else 1 / n["curvature"],
        **{name: n[name] for name in ("gap", *INDICES, *THICKNESSES)},
        **{f"{name}_tilt": pairs[name] for name in ("lens", "plate", "light")},
    )
    for k, face in enumerate(bench.faces):
        face.tilt = tuple(a + b for a, b in zip(face.tilt, pairs[f"face {k}"], strict=True))
    bench.screen = oracles.Face(mpmath.inf, [mpf(0), mpf(0), n["height"]], pairs["screen"])
    return bench


@dataclass
class _Watched(oracles.Face):
    """A face that notes from which side it is met."""

    sides: list = field(default_factory=list)

    def meet(self, point, direction):
        distance, normal = super().meet(point, direction)
        along, up = (mpmath.fdot(a, normal) for a in (direction, oracles.shift(1, self.tilt)))
        self.sides.append(along * up < 0)
        return distance, normal


def _watched(bench) -> list:
    """Let a bench note, in the list that is returned, whether light meets its faces from above."""
    sides = []
    bench.faces = [_Watched(face.radius, face.vertex, face.tilt, sides) for face in bench.faces]
    return sides


def _runs(word: str, sides: list) -> bool:
    """Whether the last ray met every face from the side on which it was: else it ran backwards."""
    down, expected = True, []
    for token in word.split():
        expected.append(down)
        down ^= token[1] == "R"
    return sides[-len(expected) :] == expected


def _newton(bench, word: str, target, start):
    """The path of the ray that lands on the target, by Newton's method from a start; the oracle's own takes chords."""
    (x, y), (u, v), h = target, start, mpf("1e-20")
    for _ in range(60):
        x0, y0, path = bench.trace(word, u, v)
        if abs(x - x0) + abs(y - y0) < mpf("1e-30"):
            return path
        (xu, yu, _), (xv, yv, _) = bench.trace(word, u + h, v), bench.trace(word, u, v + h)
        slope = mpmath.matrix([[(xu - x0) / h, (xv - x0) / h], [(yu - y0) / h, (yv - y0) / h]])
        move = slope**-1 * mpmath.matrix([x - x0, y - y0])
        u, v = u + move[0], v + move[1]
    raise ArithmeticError(f"no ray of {word} was found that lands on ({x}, {y})")


def _path(bench, sides: list, word: str, target, start):
    """Optical path of a ray that lands on the target; None where none is found. It may complete a start of ours."""
    ways = [] if start is None else [lambda: _newton(bench, word, target, start)]
    for way in (*ways, lambda: bench.path(word, *target), lambda: _newton(bench, word, target, target)):
        try:
            path = way()
        except (ArithmeticError, TypeError, ValueError):  # a complex number has no order: total reflection
            continue
        if isinstance(path, mpf) and _runs(word, sides):
            return path
    return None


def turns(vector, view: str, point, starts=(None, None)):
    """Path difference [turns] at a point of the screen at 50 digits, or None where no two rays meet."""
    bench = oracle_of(vector, view)
    bench.launch, sides = bench.faces[0].vertex, _watched(bench)  # launched where ours are
    target = [mpf(float(value)) for value in point]
    paths = []
    for word, start in zip(WORDS[view], starts, strict=True):
        paths.append(_path(bench, sides, word, target, None if start is None else [mpf(float(u)) for u in start]))
        if paths[-1] is None:
            return None
    return (paths[1] - paths[0]) / mpf(vector[NAMES.index("wavelength")])


def rays(vector, view: str, points, reach: float) -> int | None:
    """The most rays of one beam, launched within `reach` of the axis, that land on one of the points of the screen.

    Only for upright benches, whose rays stay in a plane with the axis: else None.
    """
    n = dict(zip(NAMES, vector, strict=True))
    if any(n[f"{name} {axis}"] for name in TURNED for axis in "xy"):
        return None
    bench, most = oracle_of(vector, view), 0
    bench.launch, sides = bench.faces[0].vertex, _watched(bench)

    def lands(word, u):
        try:
            x = float(bench.trace(word, mpf(u), mpf(0))[0])
        except (ArithmeticError, TypeError, ValueError):
            return np.nan
        return x if _runs(word, sides) else np.nan

    start = reach * np.linspace(-1, 1, 82)  # not the axis itself
    with mpmath.workdps(20):
        for word in WORDS[view]:
            found = np.array([lands(word, u) for u in start])
            for r in set(np.hypot(*np.asarray(points).T).round(12)):
                crossed = np.flatnonzero(np.abs(np.diff(np.sign(found - r))) == 2)
                most = max(most, sum(_crosses(partial(lands, word), start[k], start[k + 1], r) for k in crossed))
    return most


def _crosses(lands, low: float, high: float, r: float) -> bool:
    """Whether a landing point passes through r between two starts, and not through infinity."""
    sign = np.sign(lands(low) - r)
    for _ in range(25):
        middle = (low + high) / 2
        low, high = (middle, high) if np.sign(lands(middle) - r) == sign else (low, middle)
    return abs(lands(low) - r) < 1e-3 * abs(r) + 1e-9


def scale(vector, name: str) -> float:
    """By how much a number may sensibly change."""
    value = abs(float(vector[NAMES.index(name)]))
    light = float(vector[NAMES.index("wavelength")])
    least = {"curvature": 1e-4, "gap": light, "height": 1e-3}
    return max(value, 1e-3 if name.split()[0] in ("lens", "plate", "light", "face", "screen") else least.get(name, 0.0))


def rings_wide(radius: float, wavelength: float = 500e-9, rings: float = 10.0) -> float:
    """Half a width [m] that shows so many rings, and at most a tenth of the radius."""
    return min((rings * wavelength * abs(radius)) ** 0.5, abs(radius) / 10)


def _radii():
    water = {"gap_index": 1.33, "ambient_index": 1.33, "screen": "gap", "gap": 0.0}
    for view in VIEWS:
        yield Row("radius", "10 um, in water", view, {"curvature": 1e5, **water}, "gap", 1e-6)
        for radius, text in ((1e-4, "0.1 mm"), (1e-3, "1 mm"), (1e4, "10 km"), (-1e4, "-10 km"), (np.inf, "plane")):
            half = rings_wide(min(abs(radius), 1e4)) if abs(radius) > 1 else abs(radius) / 50
            focused = {"screen": "gap"} if abs(radius) < 1 else {}
            yield Row("radius", text, view, {"curvature": 1 / radius, **focused}, "gap", half)


def _steep():
    for view in VIEWS:
        for part in (0.1, 0.5, 0.9, 0.99, 0.999):
            numbers = {"curvature": 50.0, "screen": "gap"}
            yield Row("r/R", f"{part}", view, numbers, "gap", part * 0.02 / 2**0.5)
    # Without a lens to bend them rays go straight on: the direct beam reaches the equator.
    straight = {"curvature": 50.0, "lens_index": 1.0, "screen": "gap"}
    yield Row("r/R", "0.999, lens of index 1", "transmitted", straight, "gap", 0.01412)


def _gaps():
    for view in VIEWS:
        for gap, text in (
            (-1e-5, "-10 um (pressed)"), (-3e-7, "-300 nm (pressed)"), (0.0, "contact"), (1e-9, "1 nm"),
            (1e-3, "1 mm"), (1e-2, "10 mm"),
        ):  # fmt: skip
            yield Row("gap", text, view, {"gap": gap}, "gap", rings_wide(2.0))
        yield Row("gap", "contact, focused", view, {"gap": 0.0, "screen": "gap"}, "gap", rings_wide(2.0))


def _wavelengths():
    for view in VIEWS:
        for light, text in ((1e-8, "10 nm"), (1e-7, "100 nm"), (1e-5, "10 um"), (1e-3, "1 mm")):
            yield Row("wavelength", text, view, {"wavelength": light}, "wavelength", rings_wide(2.0, light))


def _indices():
    for view in VIEWS:
        yield Row("index", "all media 1", view, {"lens_index": 1.0, "plate_index": 1.0}, "lens_index", rings_wide(2.0))
        yield Row(
            "index", "all media 1.5", view, {"gap_index": 1.5, "ambient_index": 1.5}, "gap_index", rings_wide(2.0)
        )
        yield Row("index", "lens 1", view, {"lens_index": 1.0}, "lens_index", rings_wide(2.0))
        yield Row("index", "liquid as the glasses", view, {"gap_index": 1.5}, "gap_index", rings_wide(2.0))
        for name in INDICES:
            yield Row("index", f"{name} 4", view, {name: 4.0}, name, rings_wide(2.0))


def _incidences():
    for view in VIEWS:
        for degrees in (30.0, 60.0, 80.0, 89.0, 89.9):
            # Grazing light leaves the lens only where its faces are all but parallel.
            numbers = {"light y": np.radians(degrees), "curvature": 0.5 if degrees < 70 else 1e-4}
            yield Row("incidence", f"{degrees:g} deg", view, numbers, "light y", 1e-3, follow=True)
        for degrees in (41.8, 42.0, 80.0, 89.9):
            passes = degrees < 41.81
            light = None if passes else 0.0 if view == "transmitted" else np.cos(np.radians(degrees))
            numbers = {"light y": np.radians(degrees), "ambient_index": 1.5, "curvature": 0.0}
            text = f"{degrees:g} deg in glass, {'below' if passes else 'beyond'} the critical angle"
            yield Row("incidence", text, view, numbers, "light y", 1e-3, light=light, follow=True)
        for degrees in (91.0, 180.0):
            yield Row(
                "incidence", f"{degrees:g} deg, from below", view, {"light y": np.radians(degrees)}, "light y", 1e-3
            )


def _images():
    for view in VIEWS:
        yield Row("image", "1 pixel", view, {}, "gap", 1e-3, (1, 1), (-100.0, -50.0))
    middle = 16383.5
    large = (32768, 32768)
    for view in VIEWS:
        yield Row("image", "32768 x 32768", view, {}, "gap", 16e-3, large)
        yield Row("image", "corner pixel of 32768 x 32768", view, {}, "gap", 0.5e-6, (1, 1), (middle, middle))
    yield Row(
        "image", "last 16 rows of 32768 x 32768", "reflected", {}, "gap", 16e-3, (16, 32768), (middle, -middle + 15)
    )


def _fringes():
    for view in VIEWS:
        for half, text in (
            (1e-6, "1e-6 of a ring"),
            (3e-4, "0.1 ring"),
            (2.38e-3, "11 rings, 2 px"),
            (16e-3, "512 rings, 0.04 px"),
            (0.1, "20 000 rings, 0.001 px"),
        ):
            yield Row("fringes", text, view, {"gap": 0.0}, "curvature", half)


def _tilts():
    for view in VIEWS:
        for name in (*(f"face {k}" for k in range(4)), "screen", "lens", "plate"):
            yield Row("tilt", f"{name} 0.1 rad", view, {f"{name} y": 0.1, f"{name} x": -0.07}, f"{name} y", 1e-3)
        yield Row("tilt", "lens 3 rad, upside down", view, {"lens y": 3.0}, "lens y", 1e-3)
        for name in ("face 1", "face 2", "screen"):
            yield Row("tilt", f"{name} 0.6 rad", view, {f"{name} y": 0.6}, f"{name} y", 1e-4)


def _lengths():
    for view in VIEWS:
        yield Row("screen", "on the glass", view, {"screen": 0.0}, "height", rings_wide(2.0))
        yield Row(
            "screen",
            "near the focus of R1" if view == "reflected" else "0.66 m",
            view,
            {"screen": 0.66},
            "height",
            1e-3,
        )
        yield Row("screen", "10 m", view, {"screen": 10.0}, "height", rings_wide(2.0))
        yield Row("thickness", "1 um", view, dict.fromkeys(THICKNESSES, 1e-6), "lens_thickness", rings_wide(2.0))
        yield Row("thickness", "0.5 m", view, dict.fromkeys(THICKNESSES, 0.5), "lens_thickness", rings_wide(2.0))


def rows() -> list[Row]:
    groups = (_radii, _steep, _gaps, _wavelengths, _indices, _incidences, _images, _fringes, _tilts, _lengths)
    return [row for group in groups for row in group()]


# What no bench can have.
REFUSED = {
    ("radius", "0"): lambda: nj.newton_rings(0.0, view="transmitted", screen=1e-3),
    ("wavelength", "0"): lambda: nj.newton_rings(wavelength=0.0, view="transmitted", screen=1e-3),
    ("gap", "infinite"): lambda: nj.newton_rings(gap=np.inf, view="transmitted", screen=1e-3),
    ("index", "0"): lambda: nj.newton_rings(lens_index=0.0, view="transmitted", screen=1e-3),
    ("thickness", "0"): lambda: nj.newton_rings(lens_thickness=0.0, view="transmitted", screen=1e-3),
    ("incidence", "not a number"): lambda: nj.newton_rings(light_tilt=(0.0, np.nan), view="transmitted", screen=1e-3),
    ("image", "no pixel"): lambda: nj.Camera((0, 5), 1e-6),
    ("image", "pixels of no size"): lambda: nj.Camera((5, 5), 0.0),
}
