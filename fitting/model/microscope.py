"""What a microscope that looks at the gap adds to the path difference 2 n t: a term without a free number.

The rays that meet in an image point are those of the ready bench, `newtonjax.newton_rings`: its indices, thicknesses
and focus, and the photograph's sphere. They are traced once for a fit, on a few nodes in (r/R)², in the plane of the
axis and by NumPy: nothing is compiled. What they add to 2 n t is a polynomial.

To fourth order of the slopes it can be written down. Fermat's principle leaves -n L σ²/2 of a segment of height L and
slope σ in a medium n: the displacements cancel to first order, and turn the sign of 1/cos σ - 1 = σ²/2. With the
sphere's slope θ = r/R, indices n of the lens, m of the gap, p of the plate, D = n - m, the gap t at the point and g at
the apex:

- Rays meet where the screen's image is: in the lens at the height -g D/m, where the plate's face is seen through the
  sphere, P = t + g D/m below the sphere; in transmission on the plate's face.
- Reflected: the first ray leaves the sphere with the slope 2 θ in the lens; the second crosses the gap twice, with
  D θ/m, and has 2 D θ/n in the lens. Drawn back by P, this is -θ² [t D²/m + 2 m (2 n - m)/n P].
- Transmitted: both rays cross the gap once with D θ/m; the second crosses it there and back with D θ/m and then
  (D - 2 m) θ/m after its reflection at the sphere. This is θ² t [2 D - D²/m - 2 m].
- A plane-parallel glass of thickness d and index n makes the path of a ray with a slope α in it, seen from its paraxial
  image, d (n³ - n) α⁴/8 longer: d (n³ - n)/8 θ⁴ [(2 D/n)⁴ - 2⁴] reflected, for the lens, whose lower face is all but
  plane for this; transmitted, for the plate of thickness e, e (p³ - p)/8 θ⁴ [((2 m - D)/p)⁴ - (D/p)⁴].

Tests hold the trace against newtonjax's rays and against these formulae.
"""

from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from jaxtyping import Array, Float
from numpy.polynomial.chebyshev import chebpts1

from fitting.model.warp import Frame
from fitting.parameters import TABLE, Numbers, Quantities
from newtonjax.benches import ARGUMENTS

_BENCH = {argument.name: argument.default for argument in ARGUMENTS}
# Coefficients of each polynomial, nodes that they are fitted to, and the least (r/R)² of the last node.
POWERS, _NODES, _LEAST = 6, 16, 1e-3
# Derivatives are differences: by a gap of so many radii, and by a relative change of k.
_GAP, _STEP = 1e-5, 1e-3
# (r/R)² of a search may be too small by so much.
_MARGIN = 1.5
# Rounds of aiming at an image point, at most: each leaves a share of the distance, small where no caustic is near. Near
# enough is a ray that misses its point by less than this share of the farthest one's distance.
_ROUNDS, _NEAR = 12, 1e-6

Table = Float[Array | np.ndarray, " powers"]
Scalar = Float[Array | np.ndarray, ""] | float
Rays = Float[np.ndarray, " rays"]


class Microscope(NamedTuple):
    """Polynomials in w = (r/R)²: w (o (S + h H) + T G) turns are added to 2 n t.

    o = k r² are the orders of a touching sphere, T what the gap has more than touching spheres [turns], and h the
    relative change of k against that of the trace.

    - `sphere`, `change`, `gap`: coefficients of S, H and G, lowest power first.
    - `scale`: k of the trace [1/px²]; `touching`: phase where the gap is nothing, 1/2 reflected, 0 transmitted [turns].
    - `modulo`: 1 where the phase tells the gap but for whole turns, 0 where its turns are counted.
    """

    sphere: Table = np.zeros(POWERS)
    change: Table = np.zeros(POWERS)
    gap: Table = np.zeros(POWERS)
    scale: Scalar = 1.0
    touching: Scalar = 0.0
    modulo: Scalar = 1.0


class View(NamedTuple):
    """What is looked at: a bench of `newtonjax.newton_rings` in SI units, but that its plate may be curved.

    `radius`: of the sphere that makes the rings; `plate_radius`: positive where the plate bulges towards the lens.
    """

    radius: float
    plate_radius: float
    gap_index: float
    is_reflected: bool
    lens_index: float = _BENCH["lens_index"]
    plate_index: float = _BENCH["plate_index"]
    lens_thickness: float = _BENCH["lens_thickness"]
    plate_thickness: float = _BENCH["plate_thickness"]

    def faces(self, gap: float) -> tuple[tuple[float, float], ...]:
        """(curvature, height of the vertex) of the bench's faces in their order, and of its screen at last.

        The screen is the paraxial image of the plate's upper face on the viewer's side, by n'/s' = n/s + (n' - n) c.
        """
        lens, ambient = 1 / self.radius - 1 / self.plate_radius, _BENCH["ambient_index"]
        if self.is_reflected:
            in_lens = self.lens_index * gap / (self.gap_index - (self.lens_index - self.gap_index) * lens * gap)
            screen = gap + self.lens_thickness - (self.lens_thickness + in_lens) * ambient / self.lens_index
        else:
            screen = self.plate_thickness * (ambient / self.plate_index - 1)
        upper, lower = (0.0, gap + self.lens_thickness), (0.0, -self.plate_thickness)
        return upper, (lens, gap), (-1 / self.plate_radius, 0.0), lower, (0.0, screen)

    def ways(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """The media that the two beams go through, as they are counted in a `newtonjax.Scene`."""
        return ((0, 1, 1, 0), (0, 1, 2, 2, 1, 0)) if self.is_reflected else ((0, 1, 2, 3, 4), (0, 1, 2, 2, 2, 3, 4))


def path_difference(view: View, gap: float, x: Rays) -> Rays:
    """Path of a bench's second beam less that of its first at points of its screen [m]; NaN where one does not arrive.

    Over the distance by which an aimed ray misses its point the path grows by the index times the sine of its angle,
    since rays are normal to their wavefronts.
    """
    paths, near = [], _NEAR * np.abs(x).max()
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        for way in view.ways():
            position, growth, path = _trace(view, gap, way, launch := x)
            for _ in range(_ROUNDS):
                if (np.abs(position - x) <= near).all():
                    break
                launch = launch - (position - x)
                position, growth, path = _trace(view, gap, way, launch)
            paths.append(np.where(np.abs(position - x) <= near, path - growth * (position - x), np.nan))
    return paths[1] - paths[0]


def _trace(view: View, gap: float, way: tuple[int, ...], launch: Rays) -> tuple[Rays, Rays, Rays]:
    """Position on the screen, growth of the path along it, and path, of rays launched along the axis."""
    ambient, faces = _BENCH["ambient_index"], view.faces(gap)
    media = (ambient, view.lens_index, view.gap_index, view.plate_index, ambient)
    x, z = launch, np.full_like(launch, faces[0][1])
    across, along, path = np.zeros_like(launch), -np.ones_like(launch), np.zeros_like(launch)
    sign = -1.0
    for before, beyond in pairwise(way):
        curvature, vertex = faces[before if sign < 0 else before - 1]
        # To the vertex's plane, and on to the sphere: the root of c |p + s d|² = 2 (p + s d)_z next to the vertex,
        # without a difference of like numbers.
        to_plane = (vertex - z) / along
        x = x + to_plane * across
        slope, excess = curvature * x * across - along, curvature * x * x
        step = -excess / (slope - sign * np.sqrt(slope * slope - curvature * excess))
        x, z, path = x + step * across, vertex + step * along, path + media[before] * (to_plane + step)
        normal_x, normal_z = curvature * x, curvature * (z - vertex) - 1
        cosine = across * normal_x + along * normal_z
        if before == beyond:
            ratio, turn, sign = 1.0, -2 * cosine, -sign
        else:
            ratio = media[before] / media[beyond]
            turn = -sign * np.sqrt(1 - ratio * ratio * (1 - cosine * cosine)) - ratio * cosine
        across, along = ratio * across + turn * normal_x, ratio * along + turn * normal_z
    to_screen = (faces[-1][1] - z) / along
    return x + to_screen * across, media[way[-1]] * across, path + media[way[-1]] * to_screen


def _excess(view: View, w: Rays, gap: float) -> Rays:
    """What a bench adds to 2 n t at image points of given (r/R)² [n radii]."""
    r2, plate = w * view.radius**2, 1 / view.plate_radius
    height = sum(r2 * c / (1 + np.sqrt(1 - r2 * c**2)) for c in (1 / view.radius - plate, plate))
    path = path_difference(view, gap, np.append(0.0, np.sqrt(r2)))
    return ((path[1:] - path[0]) / view.gap_index - 2 * height) / view.radius


@lru_cache(maxsize=64)
def view_tables(view: View, changed: View, steepest: float) -> Float[np.ndarray, "3 powers"] | None:
    """Coefficients of S, H and G up to a (r/R)²; None where rays of this bench do not get there.

    `changed`: what the view becomes where k is larger by `_STEP`, by which H is a difference.
    """
    w = max(steepest, _LEAST) * (1 + chebpts1(_NODES)) / 2
    with np.errstate(invalid="ignore"):
        touching, apart = (_excess(view, w, gap) for gap in (0.0, _GAP * view.radius))
        change = _excess(changed, w, 0.0) - touching if changed != view else np.zeros(_NODES)
    columns = np.stack([touching, change / _STEP, (apart - touching) * w / (2 * _GAP)], axis=1)
    if not np.isfinite(columns).all():
        return None
    powers = (w / w[-1])[:, None] ** np.arange(2, POWERS + 2)
    coefficients, *_ = np.linalg.lstsq(powers, columns / w[-1] ** 2, rcond=None)
    return (coefficients / w[-1] ** np.arange(POWERS)[:, None]).T


def plate_curvature(quantities: Quantities) -> float:
    """Of the other face [1/px]; 0 for a flat one."""
    return 0.0 if quantities.plate is None else quantities.given["pixel_size"] / quantities.plate[0]


def sphere_of(quantities: Quantities, scale: float) -> tuple[float, float]:
    """Factor and power of the sphere's curvature in 1/px, factor scale^power; factor 0 where it is not known.

    s/R is k λ/(n s) where the radius is measured, sqrt(k λ/(n R)) where the pixel size is, and given elsewhere.
    """
    if quantities.unknown is None:
        return 0.0, 1.0
    values, power = quantities.values(scale), {"radius": 1.0, "pixel_size": 0.5}.get(quantities.unknown, 0.0)
    return values["pixel_size"] / values["radius"] / scale**power, power


def microscope_on(
    quantities: Quantities, numbers: Numbers, frame: Frame, side: Microscope, **glass: float
) -> Microscope:
    """What a microscope adds on the ready bench; nothing without a scale, or where its rays do not reach all the image.

    `numbers`: where it is traced; `side`: another microscope that looks from the same side; `glass`: fields of `View`
    that are not to be the bench's defaults.
    """
    scale = float(numbers.curvature) / frame.unit**2
    empty = Microscope(scale=scale, touching=float(side.touching), modulo=float(side.modulo))
    if quantities.unknown is None or not scale > 0:
        return empty
    plate_radius = np.inf if quantities.plate is None else quantities.plate[0]
    values, low_high = quantities.values(scale), TABLE[quantities.unknown].bounds
    view, changed = (
        View(at["radius"], plate_radius, at["gap_index"], bool(side.touching), **glass)
        for at in (values, quantities.values(scale * (1 + _STEP)))
    )
    is_lens = 1 / view.radius > 1 / plate_radius
    factor, power = sphere_of(quantities, scale)
    farthest = frame.unit * (1 + float(np.hypot(numbers.centre_x, numbers.centre_y)))
    steepest = _MARGIN * (factor * scale**power * farthest) ** 2
    if not (is_lens and low_high[0] <= values[quantities.unknown] <= low_high[1] and steepest < 1):
        return empty
    tables = view_tables(view, changed, steepest)
    return empty if tables is None else empty._replace(sphere=tables[0], change=tables[1], gap=tables[2])
