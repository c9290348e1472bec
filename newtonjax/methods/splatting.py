"""The algorithm of Debelov and Dolgov (2021), section 3: rays from source nodes, paired where they meet the screen."""

import warnings
from dataclasses import dataclass, replace
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from newtonjax.fields import ErrorEstimate, Packed, arrivals, pack, pairs
from newtonjax.methods.base import AbstractMethod, CannotHonourError
from newtonjax.methods.many_wavelengths import require_points
from newtonjax.methods.meeting import Rule, SourceGrid, add_block, no_sums
from newtonjax.methods.meeting_error import largest_error
from newtonjax.methods.traced import by_blocks
from newtonjax.numerics import image_memory, require_concrete, require_x64, shown, x64
from newtonjax.rays import Arrival
from newtonjax.scene import Camera, Scene, require_bench

# Points to a side at which the frame is aimed at, to find where on the source its light comes from; and where a rim
# runs through it.
_FRAME, _RIM = 9, 129
# Pixels at a time that are aimed at, to know which are lit.
_LIT = 16384
# Of memory a pixel, measured.
_BYTES = 80


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
    - `error`: largest phase error of its pairs [turns], against rays aimed at the meeting points of pairs on a grid of
      points over the frame; with a quarter turn for each caustic that only one of the two rays crossed. Infinite where
      no pair was found to look at, or one meets where a beam has no ray.
    """

    image: Float[np.ndarray, "rows columns"]
    hits: Int[np.ndarray, "rows columns"]
    unpaired: Bool[np.ndarray, "rows columns"]
    pairs: Pairs
    source: SourceGrid
    error: float


@dataclass(frozen=True, repr=False)
class Splat(AbstractMethod):
    """Rays from a grid of source nodes; two of one node interfere where they land (Debelov and Dolgov 2021, section 3).

    Coherent rays that land within `epsilon` of each other meet at the midpoint C. Their last segments are taken as
    radii of spherical wavelets: each optical path is corrected by the distance from the last surface to C, with an
    error of second order in the pair's separation (Fermat). The pair's intensity goes to the pixel that contains C; a
    pixel shows the mean of its pairs: so a bench that gathers or spreads the light on its way to the screen is shown as
    if it did not, caustics cost no phase, and of more than two beams the mean of pairs is not the sum of their fields.
    `Traced` knows all three. Components of polarization are rays of their own, which do not interfere: the same paths,
    and their intensities add. `spread` is differentiable for pairs that stay in their pixels: what a derivative leaves
    out is that a moving ray changes pixels, which steps the image.

    - `step`: of the source's nodes [m]; None halves it, from a pixel's size on, until no lit pixel is empty.
    - `epsilon`: [m]; None is a pixel's diameter, its diagonal.
    - `pairing`: "midpoint", or "pixel": the paper's first version, which drops rays that land in different pixels.
    - `path`: "wavelet", or "raw": optical paths to where each ray lands, not corrected.
    - `budget`: rays, at most; `chunk`: nodes at a time.
    """

    step: float | None = None
    epsilon: float | None = None
    pairing: str = "midpoint"
    path: str = "wavelet"
    budget: int = 100_000_000
    chunk: int = 65536

    def __post_init__(self):
        for name in ("step", "epsilon"):
            value = getattr(self, name)
            if value is not None and not (isinstance(value, float | int) and 0 < value < np.inf):
                raise ValueError(f"{name} is {shown(value)}; allowed: a positive length in metres, or None")
        for name, allowed in (("pairing", ("midpoint", "pixel")), ("path", ("wavelet", "raw"))):
            if not isinstance(getattr(self, name), str) or getattr(self, name) not in allowed:
                raise ValueError(f"{name} is {shown(getattr(self, name))}; allowed: {' or '.join(map(repr, allowed))}")
        for name in ("budget", "chunk"):
            count = getattr(self, name)
            # Pixels count their pairs in 32 bits.
            if not (isinstance(count, int) and 1 <= count < 2**31):
                raise ValueError(f"{name} is {shown(count)}; allowed: 1 to 2147483647")

    @property
    def rule(self) -> Rule:
        """Which pairs meet, and with which paths."""
        return Rule(self.epsilon, self.pairing, self.path)

    def check(self, scene: Scene) -> None:
        """A scene needs two beams; what the mean of pairs leaves out stands above."""
        if len(scene.beams) < 2:
            raise CannotHonourError("Splat", "a scene of one beam", "it shows pairs of rays", "Traced()")

    def image(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns"]:
        require_points(camera, "Splat()")
        if camera.response is not None:
            raise ValueError("Splat with camera.response: its images have one channel; use Traced() or leave it out")
        splatted = splat(scene, camera, self)
        if splatted.unpaired.any():
            warnings.warn(why_unpaired(splatted), stacklevel=3)
        return jnp.asarray(splatted.image)

    def require_parts(self, verb: str) -> None:
        raise ValueError(f"Splat pairs rays over the whole image; give {verb} another method")

    def error(self, scene: Scene, camera: Camera) -> ErrorEstimate:
        """The phase error of its pairs, from the whole image; that of the intensity is not known."""
        return ErrorEstimate(splat(scene, camera, self).error, np.nan)

    def opd(self, scene: Scene, camera: Camera) -> Float[Array, "rows columns"]:
        del scene, camera
        raise ValueError("Splat has no path difference of a pixel, it has one of every pair; use Traced()")


def splat(scene: Scene, camera: Camera, method: Splat | None = None) -> Splatted:
    """An image by the paper's algorithm, with its books. See `Splat`.

    Raises ValueError where the budget of rays is reached before every lit pixel has a pair, for images larger than
    memory, and for traced values.
    """
    method = Splat() if method is None else method
    if not isinstance(method, Splat):
        raise ValueError(f"method is {shown(method)}; allowed: Splat(...)")
    require_bench(scene, camera)
    require_concrete("Splat", scene, camera)
    method.check(scene)
    method.check_camera(camera)
    image_memory(camera.shape, _BYTES)
    bench = pack(replace(scene, shield=None))  # where light would come from and meet, whatever a hole lets through
    with x64():
        points = _over_frame(camera, _FRAME)
        beams = arrivals(bench, points)
        low, high = _reach(bench, beams, camera)
        step = float(camera.pixel_size) if method.step is None else method.step
        error = largest_error(bench, camera, method.rule, points, np.asarray(beams.start))
        lit, before = None, np.inf
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
            lit = _lit(scene, camera) if lit is None else lit
            if not (unlit := int(np.sum(empty & lit))):
                break
            if unlit >= before:
                raise ValueError(
                    f"{unlit} lit pixels stay without a pair however fine the source, since the rays of a node do not "
                    "meet there; use Traced()"
                )
            step, before = step / 2, unlit
        tally = Pairs(source.nodes[0] * source.nodes[1] * len(pairs(scene)), *(int(n) for n in fates))
        return Splatted(image, count, (count == 0) & (apart > 0), tally, source, error)


def why_unpaired(splatted: Splatted) -> str:
    """One line on the pixels that no step of the source can fill."""
    return (
        f"{int(splatted.unpaired.sum())} pixels are lit by pairs further apart than epsilon and were left at 0; "
        "a larger epsilon pairs them, Traced needs no pairs"
    )


def _over_budget(rays: int, method: Splat, step: float, lit) -> str:
    why = "" if lit is None else "pixels are still empty, but "
    return (
        f"{why}a source step of {step:.3g} m takes {rays:.3g} rays, more than the budget of {method.budget:.3g}; "
        "give Splat a larger budget or step, or use Traced()"
    )


def _over_frame(camera: Camera, count: int) -> Float[np.ndarray, "n 2"]:
    """Screen points [m] of an even grid over the frame, up to the outer edges of its pixels."""
    half = camera.pixel_size / 2
    x, y = (np.linspace(axis[0] - half, axis[-1] + half, count) for axis in camera.ends())
    return np.stack([grid.ravel() for grid in np.meshgrid(x, y)], axis=1)


def _reach(bench: Packed, beams: Arrival, camera: Camera) -> tuple[np.ndarray, np.ndarray]:
    """Corners of the part of the launch plane from which any beam lights the frame."""
    margin = float(camera.pixel_size)
    if not np.all(beams.arrives):  # a rim runs through the frame: look closer, and one mesh further than what was seen
        beams = arrivals(bench, _over_frame(camera, _RIM))
        margin += 2 * max(camera.shape) * float(camera.pixel_size) / _RIM
    inside = np.asarray(beams.start)[np.asarray(beams.arrives)]
    if not len(inside):
        raise ValueError(
            "no beam reaches the frame: there is nothing to render; check screen, centre_px and pixel_size"
        )
    return inside.min(axis=0) - margin, inside.max(axis=0) + margin


def _grid(low: np.ndarray, high: np.ndarray, step: float) -> SourceGrid:
    nodes = tuple(int(n) for n in np.ceil((high - low) / step).astype(int) + 1)
    return SourceGrid((low + high) / 2, step, (nodes[0], nodes[1]))


def _lit(scene: Scene, camera: Camera) -> Bool[np.ndarray, "rows columns"]:
    """Pixels that both beams of some pair reach."""

    def lit(bench: Packed, beams: Arrival) -> np.ndarray:
        return np.any(np.asarray(beams.arrives)[bench.pairs].all(axis=1), axis=0)

    return by_blocks(pack(scene), camera, _LIT, lit)


def spread(scene: Scene, camera: Camera, method: Splat, source: SourceGrid):
    """Image, pairs in each pixel, pairs too far apart by the pixel of their midpoint, and the four fates' counts.

    For a given source: differentiable in scene and camera, with every pair kept in its pixel.

    Raises RuntimeError where JAX computes in float32.
    """
    if jnp.zeros(()).dtype != jnp.float64:
        require_x64("spread")
    bench, cells = pack(scene), camera.shape[0] * camera.shape[1]
    many = source.nodes[0] * source.nodes[1]
    sums = no_sums(camera)
    # A power of two below a whole chunk: then few sizes are compiled.
    chunk = min(method.chunk, 1 << (many - 1).bit_length())
    for first in range(0, many, chunk):
        sums = add_block(bench, camera, method.rule, source, first, chunk, sums)
    total, count, apart, fates = sums
    image = jnp.where(count > 0, total / jnp.where(count > 0, count, 1).astype(float), 0.0)
    return *(table[:cells].reshape(camera.shape) for table in (image, count, apart)), fates
