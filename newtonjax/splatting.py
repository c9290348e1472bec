"""The algorithm of Debelov and Dolgov (2021), section 3: rays from source nodes, paired where they meet the screen."""

import warnings
from functools import partial
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from newtonjax.aim import aim
from newtonjax.camera import Camera, middle
from newtonjax.chebyshev import node_points
from newtonjax.fields import arrivals, pairs
from newtonjax.methods import AbstractMethod
from newtonjax.precision import require_concrete, x64
from newtonjax.scene import Scene
from newtonjax.surfaces import dot
from newtonjax.trace import Landing, Setting, carry_field, gather, trace
from newtonjax.turns import cos_turns, sin_turns

# Nodes to a side at which the frame is aimed at, to find where on the source its light comes from.
_FRAME = 9
# What a pair of rays of one node comes to; the order is that of `Pairs`.
_PAIRED, _APART, _OUTSIDE, _LOST = range(4)


class Source(NamedTuple):
    """A rectangular grid of nodes on the launch plane: the middle (u, v) [m], the step [m], nodes along u and v."""

    middle: Float[Array | np.ndarray, "2"]
    step: float | Float[Array, ""]
    nodes: tuple[int, int]


class Pairs(NamedTuple):
    """What became of the pairs of rays, two of one node each: counts that add up to nodes times pairs of beams.

    - `emitted`: all of them.
    - `paired`: met within epsilon, in the frame: they make the image.
    - `apart`: met in the frame, but landed further apart than epsilon (with `pairing="pixel"`: in different pixels).
    - `outside`: met outside of the frame.
    - `lost`: a ray of the pair never landed.
    """

    emitted: int
    paired: int
    apart: int
    outside: int
    lost: int


class Splatted(NamedTuple):
    """An image by `Splat`, and its books.

    - `image` [rows, columns]: mean intensity of the pairs in a pixel, over the incident one; 0 where there are none.
    - `hits` [rows, columns]: pairs in each pixel.
    - `unpaired` [rows, columns]: lit pixels without a pair, because the two rays of every node there land too far
      apart; no source step helps.
    - `pairs`: the counts; `source`: the grid of nodes.
    """

    image: Float[Array, "rows columns"]
    hits: Int[Array, "rows columns"]
    unpaired: Bool[Array, "rows columns"]
    pairs: Pairs
    source: Source


class Splat(AbstractMethod):
    """Rays from a grid of source nodes; two of one node interfere where they land (Debelov and Dolgov 2021, section 3).

    Coherent rays that land within `epsilon` of each other meet at the midpoint C. Their last segments are taken as
    radii of spherical wavelets: each optical path is corrected by the distance from the last surface to C. The pair's
    intensity goes to the pixel that contains C, and a pixel shows the mean of its pairs: densities of rays do not
    count, caustics cost no phase, and more than two beams add as pairs. The error of the wavelets is of second order
    in the pair's separation (Fermat). Differentiable for pairs that stay in their pixels: what a derivative leaves out
    is that a moving ray changes pixels, which steps the image.

    - `step`: of the source's nodes [m]; None halves it, from a pixel's size on, until no lit pixel is empty.
    - `epsilon`: [m]; None is a pixel's diameter, its diagonal.
    - `pairing`: "midpoint", or "pixel": the paper's first version, which drops rays that land in different pixels.
    - `path`: "wavelet", or "raw": optical paths to where each ray lands, not corrected.
    - `budget`: rays, at most; `chunk`: nodes at a time.
    """

    step: float | None = eqx.field(static=True, default=None)
    epsilon: float | None = eqx.field(static=True, default=None)
    pairing: str = eqx.field(static=True, default="midpoint")
    path: str = eqx.field(static=True, default="wavelet")
    budget: int = eqx.field(static=True, default=100_000_000)
    chunk: int = eqx.field(static=True, default=65536)

    def __check_init__(self):
        for name in ("step", "epsilon"):
            value = getattr(self, name)
            if value is not None and not 0 < value < np.inf:
                raise ValueError(f"{name} is {value}; allowed: a positive length in metres, or None")
        for name, allowed in (("pairing", ("midpoint", "pixel")), ("path", ("wavelet", "raw"))):
            if getattr(self, name) not in allowed:
                raise ValueError(f"{name} is {getattr(self, name)!r}; allowed: {' or '.join(map(repr, allowed))}")

    def check(self, scene: Scene) -> None:
        if len(scene.beams) < 2:
            raise ValueError("Splat cannot honour a scene of one beam: it shows pairs of rays; use Traced()")

    def image(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns"]:
        require_concrete("Splat", scene, camera)
        found = splat(scene, camera, self)
        if np.any(found.unpaired):
            warnings.warn(
                f"{int(found.unpaired.sum())} pixels are lit by pairs further apart than epsilon and were left at 0; "
                "give Splat a larger epsilon, or use Traced()",
                stacklevel=3,
            )
        return found.image

    def opd(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns"]:
        del scene, camera
        raise ValueError("Splat has no path difference of a pixel, it has one of every pair; use Traced()")


def splat(scene: Scene, camera: Camera, method: Splat | None = None) -> Splatted:
    """An image by the paper's algorithm, with its books. See `Splat`.

    Raises ValueError where the budget of rays is reached before every lit pixel has a pair, and for traced values.
    """
    method = Splat() if method is None else method
    require_concrete("splat", scene, camera)
    method.check(scene)
    with x64():
        low, high = _reach(scene, camera)
        step = float(camera.pixel_size) if method.step is None else method.step
        lit = None
        while True:
            source = _grid(low, high, step)
            rays = source.nodes[0] * source.nodes[1] * len(scene.beams)
            if rays > method.budget:
                raise ValueError(_over_budget(rays, method, step, lit))
            image, count, apart, fates = spread(scene, camera, method, source)
            empty = np.asarray(count == 0) & np.asarray(apart == 0)
            if method.step is not None or not empty.any():
                break
            lit = _lit(scene, camera) if lit is None else lit
            if not np.any(empty & lit):
                break
            step /= 2
        tally = [int(n) for n in fates]
        return Splatted(image, count, (count == 0) & (apart > 0), Pairs(sum(tally), *tally), source)


def _over_budget(rays: int, method: Splat, step: float, lit) -> str:
    why = "" if lit is None else "pixels are still empty, but "
    return (
        f"{why}a source step of {step:.3g} m takes {rays:.3g} rays, more than the budget of {method.budget:.3g}; "
        "give Splat a larger budget or step, or use Traced()"
    )


def _reach(scene: Scene, camera: Camera) -> tuple[np.ndarray, np.ndarray]:
    """Corners of the part of the launch plane from which any beam lights the frame."""
    starts, found = _aims(scene, node_points(camera, _FRAME))
    starts, found = np.asarray(starts), np.asarray(found)
    if not found.any():
        raise ValueError(
            "no beam reaches the frame: there is nothing to render; check screen, centre_px and pixel_size"
        )
    inside = starts[found]
    # Half a pixel of margin at the nearest, which are the outermost pixels' middles.
    margin = float(camera.pixel_size) + 0.02 * np.ptp(inside, axis=0)
    return inside.min(axis=0) - margin, inside.max(axis=0) + margin


@jax.jit
def _aims(scene: Scene, points):
    routes, setting = gather(scene)
    return jax.vmap(lambda route: jax.vmap(lambda point: aim(route, setting, point))(points))(routes)


def _grid(low: np.ndarray, high: np.ndarray, step: float) -> Source:
    nodes = tuple(int(n) for n in np.ceil((high - low) / step).astype(int) + 1)
    return Source((low + high) / 2, step, (nodes[0], nodes[1]))


def _lit(scene: Scene, camera: Camera) -> np.ndarray:
    """Pixels that both beams of some pair reach."""
    x, y = camera.axes()
    both = np.array(pairs(scene))

    @jax.jit
    def row(scene, y):
        arrives = arrivals(scene, jnp.stack([x, jnp.full_like(x, y)], axis=1)).arrives
        return (arrives[both[:, 0]] & arrives[both[:, 1]]).any(axis=0)

    return np.stack([np.asarray(row(scene, value)) for value in y])


def spread(scene: Scene, camera: Camera, method: Splat, source: Source):
    """Image, pairs in each pixel, pairs too far apart by the pixel of their midpoint, and the four fates' counts.

    For a given source: differentiable in scene and camera, with every pair kept in its pixel.
    """
    cells = camera.shape[0] * camera.shape[1]
    many = source.nodes[0] * source.nodes[1]
    none = jnp.zeros(cells + 1, jnp.int32)
    state = (jnp.zeros(cells + 1), none, none, jnp.zeros(len(Pairs._fields) - 1, int))
    # A power of two below a whole chunk: then few sizes are compiled.
    chunk = min(method.chunk, 1 << (many - 1).bit_length())
    for first in range(0, many, chunk):
        state = _add_block(scene, camera, method, source, first, chunk, state)
    total, count, apart, fates = state
    image = jnp.where(count > 0, total / jnp.where(count > 0, count, 1).astype(float), 0.0)
    return *(table[:cells].reshape(camera.shape) for table in (image, count, apart)), fates


@partial(jax.jit, static_argnames=("method", "chunk"))
def _add_block(scene, camera, method, source, first, chunk, state):
    """Add the pairs of one chunk of nodes to the sums; the last cell takes what does not count."""
    total, count, apart, fates = state
    nowhere = len(total) - 1
    routes, setting = gather(scene)

    def ray(route, start):
        landing, legs = trace(route, setting, start)
        return landing, carry_field(route, setting, legs)

    def node(index):
        along = jnp.stack([index % source.nodes[0], index // source.nodes[0]]).astype(float)
        last = jnp.stack(source.nodes).astype(float) - 1
        start = source.middle + (along - last / 2) * source.step
        landings, fields = jax.vmap(ray, in_axes=(0, None))(routes, start)
        found = [_meet(scene, camera, method, setting, landings, fields, j, k) for j, k in pairs(scene)]
        return tuple(jnp.stack(values) for values in zip(*found, strict=True))

    index = first + jnp.arange(chunk)
    value, cell, fate = jax.vmap(node)(index)
    fate = jnp.where((index < source.nodes[0] * source.nodes[1])[:, None], fate, -1)
    paired, near = fate == _PAIRED, fate == _APART
    at = jnp.where(paired, cell, nowhere)
    return (
        total.at[at].add(jnp.where(paired, value, 0.0)),
        count.at[at].add(1),
        apart.at[jnp.where(near, cell, nowhere)].add(1),
        fates + jnp.stack([jnp.sum(fate == which) for which in range(len(fates))]),
    )


def _meet(scene, camera, method, setting, landings, fields, j: int, k: int):
    """What two rays of one node make: intensity, cell of the midpoint, and fate."""
    one, two = (jax.tree.map(lambda leaf, b=b: leaf[b], landings) for b in (j, k))
    meeting, apart = (one.point + two.point) / 2, two.point - one.point
    path = two.path - one.path if method.path == "raw" else wavelet_opd(setting, one, two)
    turns = path / scene.wavelength
    mutual = 2 * jnp.sum(fields[k] * jnp.conj(fields[j]))
    both = sum(jnp.sum(fields[b].real ** 2 + fields[b].imag ** 2) for b in (j, k))
    value = both + mutual.real * cos_turns(turns) - mutual.imag * sin_turns(turns)
    alive = one.alive & two.alive
    cell, inside = _cell(camera, jnp.where(alive, meeting, 0.0))
    if method.pairing == "pixel":
        cells = [_cell(camera, jnp.where(alive, ray.point, 0.0)) for ray in (one, two)]
        close = (cells[0][0] == cells[1][0]) & cells[0][1] & cells[1][1]
    else:
        epsilon = jnp.sqrt(2.0) * camera.pixel_size if method.epsilon is None else method.epsilon
        close = apart @ apart <= epsilon**2
    fate = jnp.where(alive, jnp.where(inside, jnp.where(close, _PAIRED, _APART), _OUTSIDE), _LOST)
    return jnp.where(alive, value, 0.0), cell, fate


def _cell(camera: Camera, point: Float[Array, "2"]) -> tuple[Int[Array, ""], Bool[Array, ""]]:
    """Index of the pixel that holds a point of the screen, and whether there is one."""
    rows, columns = camera.shape
    centre = jnp.asarray(middle(camera.shape) if camera.centre_px is None else camera.centre_px)
    x, y = jax.lax.stop_gradient(jnp.round(point / camera.pixel_size + centre))
    inside = (x >= 0) & (x < columns) & (y >= 0) & (y < rows)
    return jnp.where(inside, y * columns + x, 0.0).astype(int), inside


def wavelet_opd(setting: Setting, one: Landing, two: Landing) -> Float[Array, ""]:
    """Optical path difference of two rays at the midpoint of their landing points [m], the second's minus the first's.

    Each path is taken to the midpoint along a spherical wavelet about the ray's last surface point (section 3).
    """
    meeting = (one.point + two.point) / 2
    return two.path + _longer(setting, two, meeting) - one.path - _longer(setting, one, meeting)


def _longer(setting: Setting, landing: Landing, meeting: Float[Array, "2"]) -> Float[Array, ""]:
    """By how much the optical path from the last surface to the meeting point exceeds that to the landing point [m]."""
    _, across_x, across_y, _ = setting.screen
    away = meeting - landing.point
    shift = away[0] * across_x + away[1] * across_y
    segment = landing.length * landing.direction
    length = jnp.sqrt(dot(segment + shift, segment + shift))
    grown = (dot(shift, shift) + 2 * dot(segment, shift)) / (length + jnp.abs(landing.length))
    return setting.exit_index * jnp.sign(landing.length) * grown
