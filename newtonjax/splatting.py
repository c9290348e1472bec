"""The algorithm of Debelov and Dolgov (2021), section 3: rays from source nodes, paired where they meet the screen."""

import warnings
from functools import partial
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from newtonjax.aim import aim, arrive
from newtonjax.camera import Camera
from newtonjax.chebyshev import node_points
from newtonjax.fields import arrivals, pairs
from newtonjax.meeting import Rule, Source, add_block, no_sums
from newtonjax.methods import AbstractMethod, at_every_pixel
from newtonjax.precision import require_concrete, x64
from newtonjax.scene import Scene
from newtonjax.symmetry import spare_component
from newtonjax.trace import gather, trace

# Nodes to a side at which the frame is aimed at, to find where on the source its light comes from.
_FRAME = 9
# Pixels at a time that are aimed at, to know which are lit.
_LIT = 16384


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
    - `error`: largest phase error of its pairs [turns], against rays that are aimed at the meeting points of a grid
      of nodes over the frame; with a quarter turn for each caustic that only one of the two rays crossed.
    """

    image: Float[np.ndarray, "rows columns"]
    hits: Int[np.ndarray, "rows columns"]
    unpaired: Bool[np.ndarray, "rows columns"]
    pairs: Pairs
    source: Source
    error: float


class Splat(AbstractMethod):
    """Rays from a grid of source nodes; two of one node interfere where they land (Debelov and Dolgov 2021, section 3).

    Coherent rays that land within `epsilon` of each other meet at the midpoint C. Their last segments are taken as
    radii of spherical wavelets: each optical path is corrected by the distance from the last surface to C. The pair's
    intensity goes to the pixel that contains C, and a pixel shows the mean of its pairs: densities of rays do not
    count, caustics cost no phase, and more than two beams add as pairs. The error of the wavelets is of second order
    in the pair's separation (Fermat). Components of polarization are rays of their own, which do not interfere: the
    same paths, and their intensities add. `spread` is differentiable for pairs that stay in their pixels: what a
    derivative leaves out is that a moving ray changes pixels, which steps the image.

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

    @property
    def rule(self) -> Rule:
        """Which pairs meet, and with which paths."""
        return Rule(self.epsilon, self.pairing, self.path)

    def check(self, scene: Scene) -> None:
        """A scene needs two beams; every part of it is honoured."""
        if len(scene.beams) < 2:
            raise ValueError("Splat cannot honour a scene of one beam: it shows pairs of rays; use Traced()")

    def image(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns"]:
        found = splat(scene, camera, self)
        if found.unpaired.any():
            warnings.warn(why_unpaired(found), stacklevel=3)
        return jnp.asarray(found.image)

    def opd(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns"]:
        del scene, camera
        raise ValueError("Splat has no path difference of a pixel, it has one of every pair; use Traced()")


def splat(scene: Scene, camera: Camera, method: Splat | None = None) -> Splatted:
    """An image by the paper's algorithm, with its books. See `Splat`.

    Raises ValueError where the budget of rays is reached before every lit pixel has a pair, and for traced values.
    """
    method = Splat() if method is None else method
    require_concrete("Splat", scene, camera)
    method.check(scene)
    scene = spare_component(scene)
    with x64():
        starts, found = _aims(scene, node_points(camera, _FRAME))
        low, high = _reach(starts, found, camera)
        step = float(camera.pixel_size) if method.step is None else method.step
        lit = None
        while True:
            source = _grid(low, high, step)
            rays = source.nodes[0] * source.nodes[1] * len(scene.beams)
            if rays > method.budget:
                raise ValueError(_over_budget(rays, method, step, lit))
            image, count, apart, fates = spread(scene, camera, method, source)
            image, count, apart = (np.asarray(table) for table in (image, count, apart))
            empty = (count == 0) & (apart == 0)
            if method.step is not None or not empty.any():
                break
            lit = np.asarray(_lit(scene, camera)) if lit is None else lit
            if not np.any(empty & lit):
                break
            step /= 2
        tally = [int(n) for n in fates]
        error = float(_error(scene, camera, method.rule, starts, found))
        return Splatted(image, count, (count == 0) & (apart > 0), Pairs(sum(tally), *tally), source, error)


def why_unpaired(found: Splatted) -> str:
    """One line on the pixels that no step of the source can fill."""
    return (
        f"{int(found.unpaired.sum())} pixels are lit by pairs further apart than epsilon and were left at 0; "
        "a larger epsilon pairs them, Traced needs no pairs"
    )


def _over_budget(rays: int, method: Splat, step: float, lit) -> str:
    why = "" if lit is None else "pixels are still empty, but "
    return (
        f"{why}a source step of {step:.3g} m takes {rays:.3g} rays, more than the budget of {method.budget:.3g}; "
        "give Splat a larger budget or step, or use Traced()"
    )


@jax.jit
def _aims(scene: Scene, points):
    """Launch coordinates [beams, n, 2] of the rays that land on points of the screen, and whether there are any."""
    routes, setting = gather(scene)
    return jax.vmap(lambda route: jax.vmap(lambda point: aim(route, setting, point))(points))(routes)


def _reach(starts, found, camera: Camera) -> tuple[np.ndarray, np.ndarray]:
    """Corners of the part of the launch plane from which any beam lights the frame."""
    inside = np.asarray(starts)[np.asarray(found)]
    if not len(inside):
        raise ValueError(
            "no beam reaches the frame: there is nothing to render; check screen, centre_px and pixel_size"
        )
    # The nodes end short of the frame's edge: by 0.8 % of its width, and half a pixel.
    margin = float(camera.pixel_size) + 0.02 * np.ptp(inside, axis=0)
    return inside.min(axis=0) - margin, inside.max(axis=0) + margin


def _grid(low: np.ndarray, high: np.ndarray, step: float) -> Source:
    nodes = tuple(int(n) for n in np.ceil((high - low) / step).astype(int) + 1)
    return Source((low + high) / 2, step, (nodes[0], nodes[1]))


@jax.jit
def _lit(scene: Scene, camera: Camera) -> Bool[Array, "rows columns"]:
    """Pixels that both beams of some pair reach."""
    both = np.array(pairs(scene))

    def lit(points):
        arrives = arrivals(scene, points).arrives
        return (arrives[both[:, 0]] & arrives[both[:, 1]]).any(axis=0)

    return at_every_pixel(lit, camera, _LIT)


@partial(jax.jit, static_argnames="rule")
def _error(scene: Scene, camera: Camera, rule: Rule, starts, found) -> Float[Array, ""]:
    """Largest phase error of the pairs within epsilon [turns]: see `Splatted`."""
    routes, setting = gather(scene)

    def wrong(first, second, start):
        one, two = trace(first, setting, start)[0], trace(second, setting, start)[0]
        opd, meeting, apart = rule.opd(setting, one, two)
        exact_1, exact_2 = arrive(first, setting, meeting), arrive(second, setting, meeting)
        error = jnp.abs(opd - exact_2.path + exact_1.path) / scene.wavelength
        # Pairs further apart than epsilon do not count; nearer ones there err less, by the order of the error.
        nearer = jnp.minimum(1.0, rule.reach(camera) / jnp.where(apart > 0, apart, 1.0))
        error = error * nearer ** (1 if rule.path == "raw" else 2)
        error = error + jnp.abs(exact_2.quarter_turns - exact_1.quarter_turns) / 4
        return jnp.where(one.alive & two.alive & exact_1.arrives & exact_2.arrives, error, 0.0)

    worst = jnp.zeros(())
    for j, k in pairs(scene):
        first, second = (jax.tree.map(lambda leaf, b=b: leaf[b], routes) for b in (j, k))
        error = jax.vmap(wrong, (None, None, 0))(first, second, starts[j])
        worst = jnp.maximum(worst, jnp.where(found[j] & found[k], error, 0.0).max())
    return worst


def spread(scene: Scene, camera: Camera, method: Splat, source: Source):
    """Image, pairs in each pixel, pairs too far apart by the pixel of their midpoint, and the four fates' counts.

    For a given source: differentiable in scene and camera, with every pair kept in its pixel.
    """
    cells = camera.shape[0] * camera.shape[1]
    many = source.nodes[0] * source.nodes[1]
    sums = no_sums(camera)
    # A power of two below a whole chunk: then few sizes are compiled.
    chunk = min(method.chunk, 1 << (many - 1).bit_length())
    for first in range(0, many, chunk):
        sums = add_block(scene, camera, method.rule, source, first, chunk, sums)
    total, count, apart, fates = sums
    image = jnp.where(count > 0, total / jnp.where(count > 0, count, 1).astype(float), 0.0)
    return *(table[:cells].reshape(camera.shape) for table in (image, count, apart)), fates
