"""What a measurement with a design would attain: its deviation and its limits, differentiable in the design.

The sums over pixels of `fisher` become integrals over the field, by Gauss and Legendre's rule, of fields given by
their Chebyshev coefficients: a few thousand points whatever the sensor, and a smooth function of field and pixel size.
The derivatives by the design are a second level of the jets that have those by the numbers; nothing is compiled.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from numpy.polynomial.chebyshev import chebder, chebvander

from fitting.parameters import one_blas_thread
from fitting.studies.electrons import Moves, moved, tables
from newtonjax.numerics import Jet, jets
from newtonjax.scene import Camera, Scene, middle

FIELD = "field"
LIMITS = ("sensor", "sampling", "full_well", "rings_least", "rings_most")
# Place of the measured number among the moves.
_TARGET = 0


class Layout(NamedTuple):
    """What does not change while designs are compared.

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
    fill_fraction: float
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
    """What a design attains, for each value of the measured number.

    Logarithms of the relative deviation: with what is known to a limited extent, and by noise alone; and how much of
    each of `LIMITS` is used (allowed: up to 1).
    """

    total: Float[np.ndarray, " targets"]
    noise: Float[np.ndarray, " targets"]
    used: Float[np.ndarray, "targets limits"]


Targets = Sequence[float] | Float[np.ndarray, " targets"]


class _Seen(NamedTuple):
    """A design for each value of the measured number, as jets of one level, the design's.

    Coefficients of the image's fields, and their derivatives by the numbers; field [m], pixel size, and the distance
    of the pixels that edge the field; whether all beams reach it.
    """

    table: Jet
    changes: Jet
    field: Jet
    size: Jet
    pitch: Jet
    reached: Bool[np.ndarray, " targets"]


def forecast(layout: Layout, bench: Bench, design: Float[np.ndarray, " varied"], targets: Targets) -> Prospect:
    """Of one design, and several values of the measured number."""
    still = Jet(np.asarray(design, float)[None, None, None], 3)
    return Prospect(*(number.value for number in _prospect(layout, bench, still, targets)))


def prospects(
    layout: Layout, bench: Bench, design: Float[np.ndarray, " varied"], targets: Targets
) -> tuple[Prospect, Prospect]:
    """`forecast`, and its derivatives by the design, along the last axis."""
    prospect = _prospect(layout, bench, jets.variable(design, np.eye(len(design)), 2, 3), targets)
    slopes = (np.moveaxis(jets.full(number, (1 + len(design),)).parts[1:], 0, -1) for number in prospect)
    return Prospect(*(number.value for number in prospect)), Prospect(*slopes)


def _prospect(layout: Layout, bench: Bench, design: Jet, targets: Targets) -> tuple[Jet, Jet, Jet]:
    # Where nothing is told, or no beam arrives, the logarithms are no numbers: the search looks for that.
    with one_blas_thread(), np.errstate(all="ignore"):
        names = [name for name, _ in layout.varied]
        outlook = _see(layout, bench, names, design, targets)
        at, weight = np.polynomial.legendre.leggauss(layout.samples)
        onto = chebvander(at, layout.nodes - 1)
        fields = Jet(onto @ outlook.table.parts @ onto.T, 1)
        matrix = _information(layout, bench.camera, outlook, onto, fields, np.outer(weight, weight) / 4)
        spread, stretch = _spread(layout, bench, names, _of_design(design), outlook)
        noise, total = deviations(matrix, layout.free, spread)
        unit = (
            (1 / stretch[:, 0])
            * (bench.scales[0] / np.abs(np.asarray(targets)))
            * np.where(outlook.reached, 1.0, np.nan)
        )
        return jets.log(total * unit), jets.log(noise * unit), _used(bench.limits, bench.camera, outlook, fields, onto)


def _see(layout: Layout, bench: Bench, names: list[str], design: Jet, targets: Targets) -> _Seen:
    """Every field, from its nodes, edge to edge."""
    scene, camera, count = bench.scene, bench.camera, len(layout.moves)
    for (_, move), value, was in zip(layout.varied, design, bench.varied, strict=True):
        scene, camera = move(scene, camera, value - was)
    still = jets.variable(np.zeros(count), np.eye(count), 1, 3)
    benches, sizes, least = [], [], min(camera.shape)
    for target in targets:
        at_scene, at_camera = layout.moves[0][1](scene, camera, target - bench.values[0])
        size = at_camera.pixel_size
        field = design[names.index(FIELD)] if FIELD in names else least * size
        edge_camera = _edge_to_edge(at_camera, field * (1 / least))
        benches.append(moved(at_scene, edge_camera, layout.moves, still, bench.scales))
        sizes.append((field, size, edge_camera.pixel_size))
    table, reached = tables(benches, layout.nodes, 3)
    with_tangents = jets.full(table, (1, 1 + count, design.parts.shape[2])).parts[0]
    changes = np.moveaxis(with_tangents[1:], 0, 2)
    field, size, pitch = (
        _of_design(jets.stack([jets.asarray(number, float) for number in each])) for each in zip(*sizes, strict=True)
    )
    return _Seen(Jet(with_tangents[0], 1), Jet(changes, 1), field, size, pitch, reached)


def _of_design(number) -> Jet:
    """A jet that has tangents by the design only, as one of one level."""
    return Jet(number.parts[0, 0] if isinstance(number, Jet) else np.asarray(number, float)[None], 1)


def _information(layout: Layout, camera: Camera, outlook: _Seen, onto, fields: Jet, weight) -> Jet:
    """Fisher's information [targets, moves, moves], averaged over shifts of the fringes."""
    background, modulus, phase = (fields[:, k] for k in range(3))
    shift = (np.arange(layout.shifts) / layout.shifts)[:, None, None]
    angle = (phase[:, None] + shift) * (2 * np.pi)
    cosine, sine = jets.cos(angle), jets.sin(angle)
    image = background[:, None] + modulus[:, None] * cosine
    code = camera.full_well / (2**camera.bits - 1)
    variance = jets.where(image > 0, image, 0.0) + (camera.read_noise**2 + code**2 / 12)
    area = outlook.field * (1 / (min(camera.shape))) / outlook.size
    pixels = (area * area * (camera.shape[0] * camera.shape[1] / layout.shifts))[:, None, None, None]
    change = Jet(onto @ outlook.changes.parts @ onto.T, 1)[:, :, :, None]
    by_phase = modulus[:, None] * sine * (-2 * np.pi)
    tangent = change[:, :, 0] + change[:, :, 1] * cosine[:, None] + change[:, :, 2] * by_phase[:, None]
    weighted = tangent * (pixels * weight / variance)[:, None]
    weighted, tangent = (part.reshape(*part.shape[:2], -1) for part in (weighted, tangent))
    return jets.matmul(weighted, Jet(tangent.parts.swapaxes(-1, -2), 1))


def _spread(layout: Layout, bench: Bench, names: list[str], design: Jet, outlook: _Seen) -> tuple[Jet, Jet]:
    """Deviations of what is held [targets, held], in steps of the numbers; and by how much each step is larger here.

    In the frame seen here a pixel size is so much larger, and as many pixels aside are so many fewer.
    """
    larger, held = outlook.pitch / outlook.size, []
    fewer, unchanged = 1 / larger, larger * 0.0 + 1.0
    stretches = {"pixel_size": larger, "centre_x": fewer, "centre_y": fewer}
    stretch = jets.stack([stretches.get(name, unchanged) for name, _ in layout.moves], axis=1)
    steps = bench.deviations / bench.scales[layout.free :]
    for k, (name, _) in enumerate(layout.moves[layout.free :]):
        value = design[names.index(name)] if name in names else bench.values[layout.free + k]
        held.append(stretch[:, layout.free + k] * (value if layout.relative[k] else 1.0) * steps[k])
    empty = Jet(np.zeros((1, len(outlook.reached), 0)), 1)
    return jets.stack(held, axis=1) if held else empty, stretch


def _edge_to_edge(camera: Camera, pitch) -> Camera:
    """A camera whose outer pixels' centres are the edges of the field, with the same axis."""
    shape = (camera.shape[0] + 1, camera.shape[1] + 1)
    centre = None
    if camera.centre_px is not None:
        aside = (camera.centre_px - np.array(middle(camera.shape))) * camera.pixel_size / pitch
        centre = aside + np.array(middle(shape))
    return Camera(shape, pitch, centre, camera.exposure, camera.full_well, camera.read_noise, camera.bits)


def deviations(matrix, free: int, spread):
    """Of the first number: by noise alone, and with the errors of what is held, whose deviations are `spread` [..., n].

    `matrix`: Fisher's information [..., n, n] of the free numbers, then of these; jets or NumPy arrays.
    """
    inner, every = matrix[..., :free, :free], np.arange(free)
    unit = 1 / jets.sqrt(inner[..., every, every])
    units = unit[..., :, None] * unit[..., None, :]
    covariance = jets.inverse(inner * units) * units
    of_target = slice(_TARGET, _TARGET + 1)
    moved_by = jets.matmul(covariance[..., of_target, :], matrix[..., :free, free:])[..., 0, :] * spread
    noise = covariance[..., _TARGET, _TARGET]
    return jets.sqrt(noise), jets.sqrt(noise + (moved_by * moved_by).sum(-1))


def _used(limits: Limits, camera: Camera, outlook: _Seen, fields: Jet, onto) -> Jet:
    background, modulus, phase = (fields[:, k] for k in range(3))
    count = onto.shape[1]
    slope = onto[:, : count - 1] @ chebder(np.eye(count))
    turns = outlook.table[:, 2].parts
    extent = [(outlook.field * (n / min(camera.shape) / 2))[:, None, None] for n in camera.shape]
    along_y, along_x = Jet(slope @ turns @ onto.T, 1) / extent[0], Jet(onto @ turns @ slope.T, 1) / extent[1]
    steepest = jets.sqrt(jets.peak(along_x * along_x + along_y * along_y, 2) + 1e-30)
    brightest = jets.peak(background + abs(modulus), 2)
    rings = jets.peak(phase, 2) + jets.peak(-phase, 2)
    return jets.stack(
        [
            outlook.field / outlook.size * (1 / min(camera.shape)),
            outlook.size * steepest * limits.pixels_per_fringe,
            brightest * (1 / (limits.fill_fraction * camera.full_well)),
            limits.rings_least / rings,
            rings * (1 / limits.rings_most),
        ],
        axis=1,
    )
