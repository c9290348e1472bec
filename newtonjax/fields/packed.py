"""Two compiled programs for the rays of every bench: a scene packed into arrays of fixed sizes, gone through in parts.

What differs between benches is data here: words of beams are tables padded with rests, an absent shield is an infinite
hole, every light has two components of polarization. One program is of few points, one of many, with the same numbers
bit for bit. However many benches and cameras are planned, explained or traced, there are these two for up to 8
interactions of a beam, two for 9 to 16, two for 17 to 32, and so on. Plans and images on nodes take the one of few
points alone; rays at every pixel take the other.
"""

from collections.abc import Callable, Sequence
from functools import partial
from itertools import product
from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Array, Float, Int

from newtonjax.fields.at_points import Fields, combine, pairs
from newtonjax.fields.smoothness import smooth
from newtonjax.numerics import module_of, x64
from newtonjax.rays import Arrival, Route, Setting, arrive_all, arrive_without_derivative, gather
from newtonjax.scene import Camera, Scene, Source, corners, node_points, source_of

# Beams and points of one call. A small call costs what it takes to start its many loops, which two beams share; a large
# one what its rays cost, half as much a ray. One small one does 9 x 9 nodes and the frame's corners, three do 17 x 17.
FEW, MANY = (2, 98), (1, 1024)
# The most points that small calls work through: 41 x 41 nodes and the corners, the finest grid of a plan. To compile
# the other program takes a second, and saves four milliseconds of these.
FOR_FEW = 41**2 + 4
# The fewest interactions of a route.
INTERACTIONS = 8
# A program of many small loops: XLA's older emitters, where it still has them, compile it in two thirds of the time,
# with the same numbers. An option that a compiler does not know is an error.
OPTIONS = {"xla_cpu_use_fusion_emitters": False} if jax.__version_info__ < (0, 11) else {}


class Packed(NamedTuple):
    """A scene as arrays, for `rays`: NumPy where all its numbers are known, JAX where some are traced.

    - `routes`: of the beams in order, [beams, interactions]; interactions padded to 8, 16, 32, ... with rests.
    - `setting`: what the beams share.
    - `source`: of the light.
    - `pairs`: indices of the beams that interfere, [pairs, 2], as `fields.pairs`.
    """

    routes: Route
    setting: Setting
    source: Source
    pairs: Int[np.ndarray, "pairs 2"]


def pack(scene: Scene) -> Packed:
    """The numbers of a scene in padded arrays. Known numbers take under a millisecond and compile nothing."""
    longest = max(len(word.split()) for word in scene.beams)
    routes, setting = gather(scene, max(INTERACTIONS, 1 << (longest - 1).bit_length()))
    xp = module_of(routes.before)
    # Copies: JAX remembers what it made of an array of the scene's, also for a program of another precision.
    return Packed(
        routes,
        jax.tree.map(xp.array, setting),
        jax.tree.map(lambda number: xp.asarray(number, dtype=float), source_of(scene.light)),
        np.array(pairs(scene), dtype=int).reshape(-1, 2),
    )


# Of known numbers: routes [beams, interactions], points [n, 2] in metres; the arrival's numbers are [beams, n]. The
# shell puts a form of it here that is kept between runs.
rays: Callable[..., Arrival] = jax.jit(arrive_without_derivative, compiler_options=OPTIONS)


def arrivals(packed: Packed, points: Float[np.ndarray, "n 2"]) -> Arrival:
    """Every beam at every point of the screen [beams, n], in NumPy; points in metres, any number of them.

    Calls `rays` for `FEW` or `MANY` beams and points at a time, in float64 on the processor whatever JAX is set to.
    """
    return jax.tree.map(lambda leaf: leaf[0], _arrivals_in(packed, [packed.setting], points))


def _arrivals_in(packed: Packed, settings: Sequence[Setting], points: Float[np.ndarray, "n 2"]) -> Arrival:
    """`arrivals` of each of these settings in the bench's place, [settings, beams, n]."""
    beams, number = len(packed.routes.action), len(points)
    side_by_side, points_of_call = FEW if number <= FOR_FEW else MANY
    blocks = [points[chosen] for chosen in _calls(number, points_of_call)]
    calls = _calls(beams, side_by_side)
    with x64(), jax.default_device(jax.local_devices(backend="cpu")[0]):
        routes = [jax.tree.map(lambda leaf, chosen=chosen: leaf[chosen], packed.routes) for chosen in calls]
        parts = [rays(route, setting, block) for setting, route, block in product(settings, routes, blocks)]
    grid = len(settings), len(calls), len(blocks)

    def joined(tables: Sequence[Array]) -> np.ndarray:
        stacked = np.stack(tables)
        stacked = np.moveaxis(stacked.reshape(*grid, *stacked.shape[1:]), 2, 3)
        shape = (grid[0], grid[1] * side_by_side, grid[2] * points_of_call, *stacked.shape[5:])
        return stacked.reshape(shape)[:, :beams, :number]

    return Arrival._make(joined(tables) for tables in zip(*parts, strict=True))


def _calls(number: int, size: int) -> Int[np.ndarray, "calls size"]:
    """Which of a number of things each call takes: the last one over again where there are no more."""
    calls = max(-(-number // size), 1)
    return np.minimum(np.arange(calls * size), number - 1).reshape(calls, size)


def node_arrivals(packed: Packed, camera: Camera, nodes: int) -> Arrival:
    """Every beam at nodes x nodes Chebyshev points of the image [beams, n], row by row, in NumPy.

    Behind a shield a beam arrives at a node only if it does at the frame's corners, which no node is at.
    """
    return jax.tree.map(lambda leaf: leaf[0], node_arrivals_in(packed, [packed.setting], camera, nodes))


def node_arrivals_in(packed: Packed, settings: Sequence[Setting], camera: Camera, nodes: int) -> Arrival:
    """`node_arrivals` of each of these settings in the bench's place, [settings, beams, n]."""
    points = node_points(camera, nodes)
    if np.isinf(packed.setting.hole[2]):
        return _arrivals_in(packed, settings, points)
    with_corners = _arrivals_in(packed, settings, np.concatenate([points, corners(camera)]))
    at_nodes = jax.tree.map(lambda leaf: leaf[:, :, : len(points)], with_corners)
    reaches_corners = with_corners.arrives[:, :, len(points) :].all(axis=2, keepdims=True)
    return at_nodes._replace(arrives=at_nodes.arrives & reaches_corners)


def with_beams(packed: Packed, arrival: Arrival, chosen: list[int]) -> tuple[Packed, Arrival]:
    """The bench with some of its beams only, in their order, and what arrives of these."""
    couples = [(chosen.index(j), chosen.index(k)) for j, k in packed.pairs if j in chosen and k in chosen]
    fewer = packed._replace(
        routes=jax.tree.map(lambda leaf: leaf[chosen], packed.routes),
        pairs=np.array(couples, dtype=int).reshape(-1, 2),
    )
    return fewer, jax.tree.map(lambda leaf: leaf[chosen], arrival)


def node_fields(packed: Packed, arrival: Arrival) -> Fields:
    """The fields that the beams make at points [beams, n]; NumPy makes NumPy."""
    return combine(arrival, packed.pairs, packed.source)


@partial(jax.jit, compiler_options=OPTIONS)
def coefficients_and_changes(numbers, changes, words, pairs):
    """The coefficients of a bench's fields, and their changes with changes of its numbers along a first axis."""

    def of(numbers):
        routes, setting, source, points = numbers
        routes = routes._replace(action=words[0], down=words[1])
        return smooth(combine(arrive_all(routes, setting, points), pairs, source)).coefficients

    return jax.vmap(lambda change: jax.jvp(of, (numbers,), (change,)), out_axes=(None, 0))(changes)


def peak_amplitudes(bench: Packed, beams: Arrival) -> Float[np.ndarray, " beams"]:
    """Largest amplitude of each beam, of incident light of irradiance 1."""
    return np.sqrt(bench.source.irradiance(beams.field).max(axis=1))
