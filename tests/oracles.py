"""Truth that shares no code with the project: a ray trace in three dimensions at 50 digits.

Textbook vector optics: a sphere is met where |p + t d - C|² = R², light is refracted by Snell's law in vector form and
reflected by d - 2 (d·n) n, and aimed by a chord method. Benches are laid out anew from their parameters.
"""

from dataclasses import dataclass, field

import mpmath
from mpmath import mpf

mpmath.mp.dps = 50
TRANSMITTED = ("0T 1T 2T 3T", "0T 1T 2R 1R 2T 3T")
REFLECTED = ("0T 1R 0T", "0T 1T 2R 1T 0T")


def _dot(a, b):
    return mpmath.fdot(a, b)


def _add(a, b, factor=1):
    return [p + factor * q for p, q in zip(a, b, strict=True)]


def turn(vector, tilt):
    """The vector turned about x by tilt[0], then about y by tilt[1]."""
    a, b = map(mpf, tilt)
    x, y, z = vector
    y, z = mpmath.cos(a) * y - mpmath.sin(a) * z, mpmath.sin(a) * y + mpmath.cos(a) * z
    return [mpmath.cos(b) * x + mpmath.sin(b) * z, y, -mpmath.sin(b) * x + mpmath.cos(b) * z]


def shift(length, tilt):
    """A vector of that length along the turned z axis."""
    return turn([mpf(0), mpf(0), mpf(length)], tilt)


@dataclass
class Face:
    """A sphere (infinite radius: a plane) through a vertex, its axis turned by a tilt."""

    radius: float
    vertex: list
    tilt: tuple = (0.0, 0.0)

    def meet(self, point, direction):
        """Distance along the ray, and the normal."""
        axis, offset = shift(1, self.tilt), _add(point, self.vertex, -1)
        if mpmath.isinf(mpf(self.radius)):
            return -_dot(axis, offset) / _dot(axis, direction), axis
        radius = mpf(self.radius)
        from_centre = _add(offset, axis, -radius)
        b, c = _dot(direction, from_centre), _dot(from_centre, from_centre) - radius**2
        root = mpmath.sqrt(b**2 - c)
        near = min((-b - root, -b + root), key=lambda t: abs(_dot(axis, _add(offset, direction, t))))
        return near, [p / radius for p in _add(from_centre, direction, near)]


def _bend(direction, normal, n1, n2):
    if _dot(direction, normal) > 0:
        normal = [-p for p in normal]
    cos_i = -_dot(direction, normal)
    ratio = n1 / n2
    cos_t = mpmath.sqrt(1 - ratio**2 * (1 - cos_i**2))
    return _add([ratio * p for p in direction], normal, ratio * cos_i - cos_t)


@dataclass
class Bench:
    """Faces from the light's side on, refractive indices between them, a screen, and light along -z turned."""

    faces: list
    media: list
    screen: Face
    light_tilt: tuple = (0.0, 0.0)
    launch: list = field(default_factory=lambda: [mpf(0), mpf(0), mpf("0.007")])

    def trace(self, word, u, v):
        """Landing point on the screen [m] and optical path [m] of the ray launched at (u, v)."""
        point = _add(_add(self.launch, turn([1, 0, 0], self.light_tilt), u), turn([0, 1, 0], self.light_tilt), v)
        direction, path, layer, down = shift(-1, self.light_tilt), mpf(0), 0, True
        for token in word.split():
            face, index = self.faces[int(token[0])], mpf(self.media[layer])
            distance, normal = face.meet(point, direction)
            point, path = _add(point, direction, distance), path + index * distance
            if token[1] == "R":
                direction, down = _add(direction, normal, -2 * _dot(direction, normal)), not down
            else:
                layer += 1 if down else -1
                direction = _bend(direction, normal, index, mpf(self.media[layer]))
        distance, _ = self.screen.meet(point, direction)
        offset = _add(_add(point, direction, distance), self.screen.vertex, -1)
        x, y = (_dot(turn(e, self.screen.tilt), offset) for e in ([1, 0, 0], [0, 1, 0]))
        return x, y, path + mpf(self.media[layer]) * distance

    def path(self, word, x, y):
        """Optical path [m] of the ray that lands on (x, y), found by a chord method to 1e-30 m."""
        x, y, h = mpf(x), mpf(y), mpf("1e-12")
        u, v = x, y
        x0, y0, _ = self.trace(word, u, v)
        xu, yu, _ = self.trace(word, u + h, v)
        xv, yv, _ = self.trace(word, u, v + h)
        slope = mpmath.matrix([[(xu - x0) / h, (xv - x0) / h], [(yu - y0) / h, (yv - y0) / h]])
        inverse = slope**-1
        for _ in range(60):
            x0, y0, path = self.trace(word, u, v)
            if abs(x - x0) + abs(y - y0) < mpf("1e-30"):
                return path
            move = inverse * mpmath.matrix([x - x0, y - y0])
            u, v = u + move[0], v + move[1]
        raise ArithmeticError(f"no ray of {word} was found that lands on ({x}, {y})")

    def opd(self, words, x, y):
        """Optical path of the second word less that of the first [m]."""
        return self.path(words[1], x, y) - self.path(words[0], x, y)


def rings(
    view,
    radius=2.0,
    gap=0.0,
    screen=1e-3,
    lens_index=1.5,
    plate_index=1.5,
    gap_index=1.0,
    ambient_index=1.0,
    lens_thickness=5e-3,
    plate_thickness=5e-3,
    lens_tilt=(0.0, 0.0),
    plate_tilt=(0.0, 0.0),
    light_tilt=(0.0, 0.0),
):
    """A lens, convex face down, over a plate, as the contract describes the bench."""
    gap, lens_thickness, plate_thickness = mpf(gap), mpf(lens_thickness), mpf(plate_thickness)
    n, n_plate = mpf(lens_index) / mpf(ambient_index), mpf(plate_index) / mpf(ambient_index)
    if screen == "gap" and view == "transmitted":
        height = -plate_thickness + plate_thickness / n_plate
    elif screen == "gap":
        # The plate's upper face through the convex face (power (n' - n) c), then through the flat one.
        n_gap, c = mpf(gap_index), 1 / mpf(radius)
        inside = mpf(lens_index) / (n_gap / (-gap) + (mpf(lens_index) - n_gap) * c) if gap else mpf(0)
        height = gap + lens_thickness - (lens_thickness - inside) / n
    elif view == "transmitted":
        height = -plate_thickness - mpf(screen)
    else:
        height = gap + lens_thickness + mpf(screen)
    inf = float("inf")
    return Bench(
        faces=[
            Face(inf, _add([0, 0, gap], shift(lens_thickness, lens_tilt)), lens_tilt),
            Face(radius, [mpf(0), mpf(0), gap], lens_tilt),
            Face(inf, [mpf(0)] * 3, plate_tilt),
            Face(inf, shift(-plate_thickness, plate_tilt), plate_tilt),
        ],
        media=[ambient_index, lens_index, gap_index, plate_index, ambient_index],
        screen=Face(inf, [mpf(0), mpf(0), height]),
        light_tilt=light_tilt,
    )
