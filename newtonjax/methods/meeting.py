"""Two rays of one source node where they land: whether they meet, in which pixel, and with what intensity."""

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from newtonjax.fields import Packed
from newtonjax.methods.wavelets import wavelet_opd
from newtonjax.numerics import cos_turns, sin_turns
from newtonjax.rays import Landing, Setting, carry_field, trace
from newtonjax.scene import Camera, middle

# What a pair of rays of one node comes to; the order is that of `Sums.fates`.
_PAIRED, _APART, _OUTSIDE, _LOST = range(4)


class SourceGrid(NamedTuple):
    """A rectangular grid of nodes on the launch plane: the middle (u, v) [m], the step [m], nodes along u and v."""

    middle: Float[Array | np.ndarray, "2"]
    step: float | Float[Array, ""]
    nodes: tuple[int, int]


class Rule(NamedTuple):
    """Which pairs meet, and with which paths: the fields of `Splat` with these names."""

    epsilon: float | None
    pairing: str
    path: str

    def reach(self, camera: Camera):
        """How far apart two rays of a pair may land [m]."""
        if self.epsilon is None or self.pairing == "pixel":
            return jnp.sqrt(2.0) * camera.pixel_size
        return self.epsilon


class Sums(NamedTuple):
    """Sums over pairs by the pixel of their midpoint, one more cell for none: intensity, hits, hits of those too far
    apart; and how many pairs came to which fate (paired, apart, outside, lost).
    """

    total: Float[Array, " cells"]
    hits: Int[Array, " cells"]
    apart: Int[Array, " cells"]
    fates: Int[Array, "4"]


def no_sums(camera: Camera) -> Sums:
    """Before the first pair."""
    cells = camera.shape[0] * camera.shape[1] + 1
    return Sums(jnp.zeros(cells), jnp.zeros(cells, jnp.int32), jnp.zeros(cells, jnp.int32), jnp.zeros(4, int))


def pair_opd(path: str, setting: Setting, first: Landing, second: Landing):
    """A pair's path difference, where the two meet on the screen, and how far apart they land [m]."""
    opd = second.path - first.path if path == "raw" else wavelet_opd(setting, first, second)
    return opd, (first.point + second.point) / 2, jnp.linalg.norm(second.point - first.point)


class _Frame(NamedTuple):
    """Of a camera: pixels along x and y, the screen's origin in pixels, a pixel's size [m]; and `Rule.reach` [m]."""

    shape: Float[Array | np.ndarray, "2"]
    centre: Float[Array, "2"]
    pixel_size: Float[Array, ""]
    reach: Float[Array, ""]


def add_block(
    bench: Packed, camera: Camera, rule: Rule, source: SourceGrid, first: int, chunk: int, sums: Sums
) -> Sums:
    """The sums with the pairs of one chunk of nodes added, the nodes counted from `first` on."""
    centre = middle(camera.shape) if camera.centre_px is None else camera.centre_px
    shape = np.array(camera.shape[::-1], dtype=float)
    frame = _Frame(shape, jnp.asarray(centre), jnp.asarray(camera.pixel_size), jnp.asarray(rule.reach(camera)))
    grid = (source.middle, source.step, np.array(source.nodes))
    return _added(sums, *_pairs_of_nodes(bench, frame, grid, first, path=rule.path, pairing=rule.pairing, chunk=chunk))


@partial(jax.jit, static_argnames=("path", "pairing", "chunk"))
def _pairs_of_nodes(bench: Packed, frame: _Frame, grid, first, path: str, pairing: str, chunk: int):
    """Intensity, cell and fate of every pair of rays of a chunk of nodes [chunk, pairs].

    A program for each number of beams and of pairs; not for other differences of benches, nor for shapes.
    """
    routes, setting = bench.routes, bench.setting
    middle, step, nodes = grid

    def ray(route, start):
        landing, legs = trace(route, setting, start)
        return landing, carry_field(route, setting, legs)

    def node(index):
        along = jnp.stack([index % nodes[0], index // nodes[0]]).astype(float)
        start = middle + (along - (nodes.astype(float) - 1) / 2) * step
        landings, fields = jax.vmap(ray, in_axes=(0, None))(routes, start)
        return jax.vmap(lambda pair: _meet(bench, frame, path, pairing, landings, fields, *pair))(
            jnp.asarray(bench.pairs)
        )

    index = first + jnp.arange(chunk)
    value, cell, fate = jax.vmap(node)(index)
    return value, cell, jnp.where((index < nodes[0] * nodes[1])[:, None], fate, -1)


@partial(jax.jit, donate_argnames="sums")
def _added(sums: Sums, value, cell, fate) -> Sums:
    total, count, apart, fates = sums
    nowhere = len(total) - 1  # the cell of what does not count
    paired, near = fate == _PAIRED, fate == _APART
    at = jnp.where(paired, cell, nowhere)
    return Sums(
        total.at[at].add(jnp.where(paired, value, 0.0)),
        count.at[at].add(1),
        apart.at[jnp.where(near, cell, nowhere)].add(1),
        fates + jnp.stack([jnp.sum(fate == which) for which in range(len(fates))]),
    )


def _meet(bench: Packed, frame: _Frame, path: str, pairing: str, landings, fields, j, k):
    """What two rays of one node make: intensity, cell of the midpoint, and fate."""
    first, second = (jax.tree.map(lambda leaf, b=b: leaf[b], landings) for b in (j, k))
    opd, meeting, apart = pair_opd(path, bench.setting, first, second)
    envelope, turns = bench.source.fringes(bench.source.mutual(fields[j], fields[k]), opd)
    background = bench.source.irradiance(fields[j]) + bench.source.irradiance(fields[k])
    value = background + envelope.real * cos_turns(turns) - envelope.imag * sin_turns(turns)
    alive = first.alive & second.alive
    cell, inside = _cell(frame, jnp.where(alive, meeting, 0.0))
    if pairing == "pixel":
        cells = [_cell(frame, jnp.where(alive, ray.point, 0.0)) for ray in (first, second)]
        close = (cells[0][0] == cells[1][0]) & cells[0][1] & cells[1][1]
    else:
        close = apart <= frame.reach
    fate = jnp.where(alive, jnp.where(inside, jnp.where(close, _PAIRED, _APART), _OUTSIDE), _LOST)
    # A collecting lens spreads the light of the plane that it images.
    return jnp.where(alive, value / bench.setting.magnification**2, 0.0), cell, fate


def _cell(frame: _Frame, point: Float[Array, "2"]) -> tuple[Int[Array, ""], Bool[Array, ""]]:
    """Index of the pixel that holds a point of the screen, and whether there is one."""
    columns, rows = frame.shape
    x, y = jax.lax.stop_gradient(jnp.round(point / frame.pixel_size + frame.centre))
    inside = (x >= 0) & (x < columns) & (y >= 0) & (y < rows)
    return jnp.where(inside, y * columns + x, 0.0).astype(int), inside
