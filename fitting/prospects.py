"""What a measurement with a design would attain: its deviation and its limits, differentiable in the design.

The sums over pixels of `fisher` become integrals over the field, by Gauss and Legendre's rule, of fields given by
their Chebyshev coefficients: a few thousand points whatever the sensor, and a smooth function of field and pixel size.
"""

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from numpy.polynomial.chebyshev import chebder, chebvander

from fitting.electrons import Moves, photoelectrons, variance
from newtonjax.camera import Camera, middle
from newtonjax.fringes import combine, slopes, split
from newtonjax.methods import Chebyshev
from newtonjax.scene import Scene

FIELD = "field"
LIMITS = ("sensor", "sampling", "full_well", "rings_least", "rings_most")


class Layout(NamedTuple):
    """What does not change while designs are compared; static.

    - `varied`: names and moves of the design's numbers, `FIELD` among them, which moves neither scene nor camera.
    - `moves`: of the measured number, of the other free numbers, and of those of limited knowledge.
    - `free`: how many of them are free; `relative`: of each of the others, whether its deviation is a fraction.
    - `nodes`, `samples`: to a side of the field, of rays and of the rule. `shifts`: of the fringes by equal parts of a
      turn, over which the sums are averaged: for many fringes, which the samples then need not resolve; 1 for none.
    """

    varied: Moves
    moves: Moves
    free: int
    relative: tuple[bool, ...]
    nodes: int
    samples: int
    shifts: int


class Limits(NamedTuple):
    """Pixels to a fringe at least; share of the full well at most; rings in the field, at least and at most."""

    pixels_per_fringe: float
    fill: float
    rings_least: float
    rings_most: float


class Bench(NamedTuple):
    """Where designs start from.

    Scene and camera, the numbers of `varied` and of `moves` there, the scales of these, the deviations of those of
    limited knowledge, and the limits.
    """

    scene: Scene
    camera: Camera
    varied: Float[np.ndarray, " varied"]
    values: Float[np.ndarray, " moves"]
    scales: Float[np.ndarray, " moves"]
    deviations: Float[np.ndarray, " held"]
    limits: Limits


class Prospect(NamedTuple):
    """What a design attains.

    Logarithms of the relative deviation: with what is known to a limited extent, and by noise alone; and how much of
    each of `LIMITS` is used (allowed: up to 1).
    """

    total: Float[Array, ""]
    noise: Float[Array, ""]
    used: Float[Array, " limits"]


def prospect(layout: Layout, bench: Bench, design: Float[Array, " varied"], target: Float[Array, ""]) -> Prospect:
    """Of one design and one value of the measured number."""
    scene, camera = bench.scene, bench.camera
    names = [name for name, _ in layout.varied]
    for (_, move), value, was in zip(layout.varied, design, bench.varied, strict=True):
        scene, camera = move(scene, camera, value - was)
    scene, camera = layout.moves[0][1](scene, camera, target - bench.values[0])
    size = jnp.asarray(camera.pixel_size)
    least = min(camera.shape)
    field = design[names.index(FIELD)] if FIELD in names else least * size
    seen = _edge_to_edge(camera, field / least)
    of_steps = photoelectrons(scene, seen, layout.moves, bench.scales, Chebyshev(layout.nodes))
    still = jnp.zeros(len(layout.moves))
    table, changes = of_steps(still), jnp.moveaxis(jax.jacfwd(of_steps)(still), -1, 0)
    at, weight = np.polynomial.legendre.leggauss(layout.samples)
    onto = chebvander(at, layout.nodes - 1)
    fields = list(_expand(table, onto, onto))
    change = _expand(changes, onto, onto)
    pixels = camera.shape[0] * camera.shape[1] * (field / least / size) ** 2

    def information(shift):
        background, moduli, phases = split(fields)
        shifted = [background, *moduli, *(phase + shift for phase in phases)]
        tangent = change[:, 0] + sum(factor * change[:, k + 1] for k, factor in enumerate(slopes(shifted)))
        shared = np.outer(weight, weight) / 4 * pixels / variance(combine(shifted), camera)
        return jnp.einsum("pyx,yx,qyx->pq", tangent, shared, tangent, precision="highest")

    matrix = jax.vmap(information)(np.arange(layout.shifts) / layout.shifts).mean(axis=0)
    held = list(bench.values[layout.free :])
    for k, (name, _) in enumerate(layout.moves[layout.free :]):
        if name in names:
            held[k] = design[names.index(name)]
    sizes = [value if share else 1.0 for value, share in zip(held, layout.relative, strict=True)]
    spread = jnp.asarray([size * sd for size, sd in zip(sizes, bench.deviations, strict=True)], dtype=float)
    # In the frame seen here a pixel size is so much larger, and as many pixels aside are so many fewer.
    larger = {
        "pixel_size": seen.pixel_size / size,
        "centre_x": size / seen.pixel_size,
        "centre_y": size / seen.pixel_size,
    }
    stretch = jnp.asarray([larger.get(name, 1.0) for name, _ in layout.moves])
    noise, total = deviations(matrix, layout.free, (spread * stretch[layout.free :]) / bench.scales[layout.free :])
    unit = bench.scales[0] / jnp.abs(target) / stretch[0]
    used = _used(bench.limits, camera, field, size, table, fields, onto)
    return Prospect(jnp.log(total * unit), jnp.log(noise * unit), used)


@partial(jax.jit, static_argnums=0)
def forecast(layout: Layout, bench: Bench, design: Float[Array, " varied"], targets: Float[Array, " targets"]):
    """`prospect` of several values of the measured number."""
    return jax.vmap(lambda target: prospect(layout, bench, design, target))(targets)


@partial(jax.jit, static_argnums=0)
def prospects(layout: Layout, bench: Bench, design: Float[Array, " varied"], targets: Float[Array, " targets"]):
    """`forecast`, and its derivatives by the design."""

    def of_design(design):
        return forecast(layout, bench, design, targets)

    return of_design(design), jax.jacfwd(of_design)(design)


def _edge_to_edge(camera: Camera, pitch) -> Camera:
    """A camera whose outer pixels' centres are the edges of the field, with the same axis."""
    shape = (camera.shape[0] + 1, camera.shape[1] + 1)
    centre = None
    if camera.centre_px is not None:
        aside = (jnp.asarray(camera.centre_px) - np.array(middle(camera.shape))) * camera.pixel_size / pitch
        centre = aside + np.array(middle(shape))
    return Camera(shape, pitch, centre, camera.exposure, camera.full_well, camera.read_noise, camera.bits)


def _expand(table, along_y, along_x):
    return jnp.einsum("...kl,yk,xl->...yx", table, along_y, along_x, precision="highest")


def deviations(matrix, free: int, spread):
    """Of the first number: by noise alone, and with the errors of what is held, whose deviations are `spread`.

    `matrix`: Fisher's information of the free numbers, then of these.
    """
    inner = matrix[:free, :free]
    unit = 1 / jnp.sqrt(jnp.diag(inner))
    covariance = jnp.linalg.inv(inner * jnp.outer(unit, unit)) * jnp.outer(unit, unit)
    moved = covariance[0] @ matrix[:free, free:] * spread
    return jnp.sqrt(covariance[0, 0]), jnp.sqrt(covariance[0, 0] + moved @ moved)


def _used(limits: Limits, camera: Camera, field, size, table, fields, onto):
    background, moduli, phases = split(fields)
    count = table.shape[-1]
    slope = onto[:, : count - 1] @ chebder(np.eye(count))
    turns = split(list(table))[2]
    extent = [n / min(camera.shape) * field / 2 for n in camera.shape]
    steepest = jnp.zeros(())
    for phase in turns:
        along_y, along_x = _expand(phase, slope, onto) / extent[0], _expand(phase, onto, slope) / extent[1]
        steepest = jnp.maximum(steepest, jnp.sqrt(jnp.max(along_x**2 + along_y**2) + 1e-30))
    brightest = jnp.max(background + sum(jnp.abs(modulus) for modulus in moduli))
    rings = jnp.max(phases[0]) - jnp.min(phases[0])
    return jnp.stack(
        [
            field / (min(camera.shape) * size),
            limits.pixels_per_fringe * size * steepest,
            brightest / (limits.fill * camera.full_well),
            limits.rings_least / rings,
            rings / limits.rings_most,
        ]
    )
