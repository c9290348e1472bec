"""Two rays of one source node where they land: whether they meet, in which pixel, and with what intensity."""

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from newtonjax.camera import Camera, middle
from newtonjax.fields import pairs
from newtonjax.light import irradiance, mutual, shares
from newtonjax.scene import Scene
from newtonjax.trace import Landing, Setting, carry_field, gather, trace
from newtonjax.turns import cos_turns, sin_turns
from newtonjax.wavelets import wavelet_opd

# What a pair of rays of one node comes to; the order is that of `Sums.fates`.
_PAIRED, _APART, _OUTSIDE, _LOST = range(4)


class Source(NamedTuple):
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

    def opd(self, setting: Setting, one: Landing, two: Landing):
        """The pair's path difference, where the two meet on the screen, and how far apart they land [m]."""
        opd = two.path - one.path if self.path == "raw" else wavelet_opd(setting, one, two)
        return opd, (one.point + two.point) / 2, jnp.linalg.norm(two.point - one.point)


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


@partial(jax.jit, static_argnames=("rule", "chunk"), donate_argnames="state")
def add_block(scene: Scene, camera: Camera, rule: Rule, source: Source, first, chunk: int, state: Sums) -> Sums:
    """The sums with the pairs of one chunk of nodes added, the nodes counted from `first` on."""
    total, count, apart, fates = state
    nowhere = len(total) - 1  # the cell of what does not count
    routes, setting = gather(scene)

    def ray(route, start):
        landing, legs = trace(route, setting, start)
        return landing, carry_field(route, setting, legs)

    def node(index):
        along = jnp.stack([index % source.nodes[0], index // source.nodes[0]]).astype(float)
        last = jnp.stack(source.nodes).astype(float) - 1
        start = source.middle + (along - last / 2) * source.step
        landings, fields = jax.vmap(ray, in_axes=(0, None))(routes, start)
        found = [_meet(scene, camera, rule, setting, landings, fields, j, k) for j, k in pairs(scene)]
        return tuple(jnp.stack(values) for values in zip(*found, strict=True))

    index = first + jnp.arange(chunk)
    value, cell, fate = jax.vmap(node)(index)
    fate = jnp.where((index < source.nodes[0] * source.nodes[1])[:, None], fate, -1)
    paired, near = fate == _PAIRED, fate == _APART
    at = jnp.where(paired, cell, nowhere)
    return Sums(
        total.at[at].add(jnp.where(paired, value, 0.0)),
        count.at[at].add(1),
        apart.at[jnp.where(near, cell, nowhere)].add(1),
        fates + jnp.stack([jnp.sum(fate == which) for which in range(len(fates))]),
    )


def _meet(scene, camera, rule, setting, landings, fields, j: int, k: int):
    """What two rays of one node make: intensity, cell of the midpoint, and fate."""
    one, two = (jax.tree.map(lambda leaf, b=b: leaf[b], landings) for b in (j, k))
    opd, meeting, apart = rule.opd(setting, one, two)
    turns = opd / scene.wavelength
    weights = shares(scene.light)
    envelope = mutual(weights, fields[j], fields[k])
    both = irradiance(weights, fields[j]) + irradiance(weights, fields[k])
    value = both + envelope.real * cos_turns(turns) - envelope.imag * sin_turns(turns)
    alive = one.alive & two.alive
    cell, inside = _cell(camera, jnp.where(alive, meeting, 0.0))
    if rule.pairing == "pixel":
        cells = [_cell(camera, jnp.where(alive, ray.point, 0.0)) for ray in (one, two)]
        close = (cells[0][0] == cells[1][0]) & cells[0][1] & cells[1][1]
    else:
        close = apart <= rule.reach(camera)
    fate = jnp.where(alive, jnp.where(inside, jnp.where(close, _PAIRED, _APART), _OUTSIDE), _LOST)
    # A collecting lens spreads the light of the plane that it images.
    return jnp.where(alive, value / setting.magnification**2, 0.0), cell, fate


def _cell(camera: Camera, point: Float[Array, "2"]) -> tuple[Int[Array, ""], Bool[Array, ""]]:
    """Index of the pixel that holds a point of the screen, and whether there is one."""
    rows, columns = camera.shape
    centre = jnp.asarray(middle(camera.shape) if camera.centre_px is None else camera.centre_px)
    x, y = jax.lax.stop_gradient(jnp.round(point / camera.pixel_size + centre))
    inside = (x >= 0) & (x < columns) & (y >= 0) & (y < rows)
    return jnp.where(inside, y * columns + x, 0.0).astype(int), inside
