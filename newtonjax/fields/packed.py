"""One compiled program for the rays of every bench: a scene packed into arrays of fixed sizes, worked through in parts.

What differs between benches is data here: words of beams are tables padded with rests, an absent shield is an infinite
hole, every light has two components of polarization. However many benches and cameras are planned, explained or traced,
there is one program for up to 8 interactions of a beam, one for 9 to 16, one for 17 to 32, and so on.
"""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Array, Float, Int

from newtonjax.fields.at_points import Fields, combine, pairs
from newtonjax.fields.smoothness import smooth
from newtonjax.numerics import Scalar, namespace, x64
from newtonjax.rays import Arrival, Route, Setting, arrive_all, gather
from newtonjax.scene import Camera, Scene, corners, irradiance, node_points, shares

# Sizes of one call: points (17 x 17 nodes), and the fewest interactions; it takes one beam.
POINTS, INTERACTIONS = 289, 8
# A program of many small loops: XLA's older emitters, where it still has them, compile it in two thirds of the time,
# with the same numbers. An option that a compiler does not know is an error.
OPTIONS = {"xla_cpu_use_fusion_emitters": False} if jax.__version_info__ < (0, 11) else {}


class Packed(NamedTuple):
    """A scene as arrays, for `rays`: NumPy where all its numbers are known, JAX where some are traced.

    - `routes`: of the beams in order, [beams, interactions]; interactions padded to 8, 16, 32, ... with rests.
    - `setting`: what the beams share.
    - `wavelength`: in vacuum [m].
    - `shares`: of the two polarization components in the irradiance, [2].
    - `pairs`: indices of the beams that interfere, [pairs, 2], as `fields.pairs`.
    """

    routes: Route
    setting: Setting
    wavelength: Scalar
    shares: Float[Array | np.ndarray, "2"]
    pairs: Int[np.ndarray, "pairs 2"]


def pack(scene: Scene) -> Packed:
    """The numbers of a scene in padded arrays. Known numbers take under a millisecond and compile nothing."""
    longest = max(len(word.split()) for word in scene.beams)
    routes, setting = gather(scene, max(INTERACTIONS, 1 << (longest - 1).bit_length()))
    xp = namespace(scene)
    # Copies: JAX remembers what it made of an array of the scene's, also for a program of another precision.
    return Packed(
        routes,
        jax.tree.map(xp.array, setting),
        xp.asarray(scene.wavelength, dtype=float),
        xp.asarray(shares(scene.light)),
        np.array(pairs(scene), dtype=int).reshape(-1, 2),
    )


# Of known numbers: routes [1, interactions], points [289, 2] in metres; the arrival's numbers are [1, 289]. The shell
# puts a form of it here that is kept between runs.
rays: Callable[..., Arrival] = jax.jit(arrive_all, compiler_options=OPTIONS)


def arrivals(packed: Packed, points: Float[np.ndarray, "n 2"]) -> Arrival:
    """Every beam at every point of the screen [beams, n], in NumPy; points in metres, any number of them.

    Calls `rays` for one beam and 289 points at a time, in float64 on the processor whatever JAX is set to.
    """
    number = len(points)
    padded = points[np.minimum(np.arange(-(-number // POINTS) * POINTS), number - 1)].reshape(-1, POINTS, 2)
    beams = [
        jax.tree.map(lambda leaf, at=at: leaf[at : at + 1], packed.routes) for at in range(len(packed.routes.action))
    ]
    with x64(), jax.default_device(jax.local_devices(backend="cpu")[0]):
        parts = [[rays(beam, packed.setting, block) for block in padded] for beam in beams]
    rows = [jax.tree.map(lambda *leaves: np.concatenate(leaves, axis=1), *row) for row in parts]
    of_beams = jax.tree.map(lambda *leaves: np.concatenate(leaves), *rows)
    return jax.tree.map(lambda leaf: leaf[:, :number], of_beams)


def node_arrivals(packed: Packed, camera: Camera, nodes: int) -> Arrival:
    """Every beam at nodes x nodes Chebyshev points of the image [beams, n], row by row, in NumPy.

    Behind a shield a beam arrives at a node only if it does at the frame's corners, which no node is at.
    """
    points = node_points(camera, nodes)
    if np.isinf(packed.setting.hole[2]):
        return arrivals(packed, points)
    with_corners = arrivals(packed, np.concatenate([points, corners(camera)]))
    at_nodes = jax.tree.map(lambda leaf: leaf[:, : len(points)], with_corners)
    reaches_corners = with_corners.arrives[:, len(points) :].all(axis=1, keepdims=True)
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
    return combine(arrival, packed.pairs, packed.wavelength, packed.shares)


@partial(jax.jit, compiler_options=OPTIONS)
def coefficients_and_changes(numbers, changes, words, pairs):
    """The coefficients of a bench's fields, and their changes with changes of its numbers along a first axis."""

    def of(numbers):
        routes, setting, wavelength, weights, points = numbers
        routes = routes._replace(action=words[0], down=words[1])
        return smooth(combine(arrive_all(routes, setting, points), pairs, wavelength, weights)).coefficients

    return jax.vmap(lambda change: jax.jvp(of, (numbers,), (change,)), out_axes=(None, 0))(changes)


def peak_amplitudes(bench: Packed, beams: Arrival) -> Float[np.ndarray, " beams"]:
    """Largest amplitude of each beam, of incident light of irradiance 1."""
    return np.sqrt(irradiance(bench.shares, beams.field).max(axis=1))
