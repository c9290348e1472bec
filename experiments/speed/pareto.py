"""Claim: on eight scenes every peer is beaten by one of ours: nearer to the truth (down to rounding), in half the time.

Scenes (500 nm, 512 x 512 pixels): Newton's rings near the bench in both views, far from it, focused on the gap, with
all beams of the gap, with a strong curvature, over a tilted plate, and an air wedge. Ours: `Chebyshev` at a ladder of
nodes, `ClosedForm` where it holds, float32 pixels, `Splat` (four rays a pixel, on a quarter of a side at the corner),
and `Traced`, the truth, which is itself compared with the 50-digit trace of `tests/oracles.py` at nine pixels. Peers:
batoid, Optiland, prysm, and loops by hand in numba and Dr.Jit for the two paths; LightPipes; tmm. See `pareto_peers.py`
for what they are given for nothing: background and fringe amplitude. Their rays are launched at the pixel's own place,
and then aimed by one and by three rounds of a chord method.

The strong curvature's fringes are finer than its pixels: an exercise, not a photograph. Costs are medians over copies
of the image's array taken in turns in the same run, compilation apart. Errors are the largest of intensity over the
peak, and of phase in turns. Times of `Splat` and of tmm at every pixel are those of a part of the pixels, in
proportion.

    python -m experiments.speed.pareto [--quick]

Writes results/pareto.json and .png, and docs/pareto.png.
"""

import sys
from functools import partial
from pathlib import Path
from statistics import median
from typing import NamedTuple

import jax
import numpy as np

import newtonjax as nj
from experiments import records
from experiments.speed import pareto_peers
from experiments.speed.pareto_picture import draw
from newtonjax.fields import error_from_nodes, fields_at, intensity
from newtonjax.numerics import chebyshev

WAVELENGTH, TOLERANCES, ROUNDS = 500e-9, (1e-2, 1e-4, 1e-6), (0, 1, 3)
NODES = (3, 5, 7, 9, 13, 17, 25)
TRACERS = {"batoid": pareto_peers.batoid_way, "Optiland": pareto_peers.optiland_way, "prysm": pareto_peers.prysm_way,
           "numba by hand": pareto_peers.numba_way, "Dr.Jit by hand": pareto_peers.drjit_way}  # fmt: skip
GAP_BEAMS = tuple("T0 T1 " + k * "R2 R1 " + "T2 T3" for k in range(5))
# Turns and intensities below which an error is that of rounded paths, some hundred thousand wavelengths long.
ROUNDED = 1e-8
# What takes longer [s] is timed once.
SLOW = 2.0


class Case(NamedTuple):
    """A scene by its bench's keywords, and its pixels [m]; which peers besides ray tracers apply."""

    bench: dict
    pixel: float = 10e-6
    splat: bool = False
    formula: str = ""


NEAR = {"radius": 2.0, "view": "transmitted", "screen": 1e-3}
CASES = {
    "transmitted, screen at 1 mm": Case(NEAR, splat=True),
    "reflected, screen at 1 mm": Case(NEAR | {"view": "reflected"}, splat=True),
    "reflected, screen at 100 mm": Case(NEAR | {"view": "reflected", "screen": 0.1}, splat=True),
    "reflected, focused on the gap": Case(NEAR | {"view": "reflected", "screen": "gap"}, formula="LightPipes"),
    "transmitted, focused, 5 beams": Case(NEAR | {"screen": "gap", "beams": GAP_BEAMS}, formula="tmm"),
    "R = 20 mm, r/R up to 0.14": Case(NEAR | {"radius": 0.02}, 8e-6),
    "plate tilted by 5 mrad": Case(NEAR | {"gap": 15e-6, "plate_tilt": (5e-3, 0.0)}),
    "air wedge of 1 mrad": Case(
        {**NEAR, "radius": np.inf, "view": "reflected", "gap": 3e-6, "lens_tilt": (0.0, -1e-3)}
    ),
}


class Truth(NamedTuple):
    """Traced at every pixel: image, and of two beams their path difference [m], background and fringe amplitude."""

    image: np.ndarray
    peak: float
    opd: np.ndarray | None
    background: np.ndarray
    fringes: np.ndarray
    rounding: float


@jax.jit
def _traced(scene, camera):
    x, y = camera.axes()

    def row(at_y):
        fields = fields_at(scene, jax.numpy.stack([x, at_y + 0 * x], axis=1))
        path = fields.phase[0] * scene.wavelength
        return intensity(fields), fields.background, fields.envelope, path, fields.rounding

    return jax.lax.map(row, y)


def find_truth(scene: nj.Scene, camera: nj.Camera) -> Truth:
    image, background, envelope, opd, rounding = (np.asarray(a) for a in _traced(scene, camera))
    peak = (background + np.abs(envelope).sum(axis=1)).max()
    two = len(scene.beams) == 2
    assert not two or np.abs(envelope.imag).max() < 1e-12
    return Truth(image, peak, opd if two else None, background, envelope.real[:, 0], rounding.max())


def oracle_error(case: Case, scene: nj.Scene, camera: nj.Camera) -> float:
    """Largest phase error [turns] of `Traced` against 50 digits, of the first two beams at nine pixels."""
    sys.path.append(str(Path(__file__).parents[2] / "tests"))
    import oracles

    bench = oracles.rings(**{key: value for key, value in case.bench.items() if key != "beams"})
    axes = [np.asarray(axis)[[0, len(axis) // 3, -1]] for axis in camera.axes()]
    points = np.stack([grid.ravel() for grid in np.meshgrid(*axes)], axis=1)
    found = np.asarray(jax.jit(fields_at)(scene, points).phase[0])
    words = [" ".join(token[::-1] for token in word.split()) for word in sorted(scene.beams, key=len)[:2]]
    true = [float(bench.opd(words, *point) / WAVELENGTH) for point in points]
    return float(np.abs(found - true).max())


def ours(scene: nj.Scene, camera: nj.Camera, nodes) -> dict:
    """Name: method, scene, and the tolerances for which it was planned."""
    found = {f"Chebyshev({n})": (nj.Chebyshev(n), scene, []) for n in nodes}
    if len(nodes) > 1:
        found["Chebyshev(17), float32"] = nj.Chebyshev(17, "float32"), scene, []
    if nj.ClosedForm().refusal(scene) is None:
        found["ClosedForm"] = nj.ClosedForm(), scene, []
    for tolerance in TOLERANCES:
        chosen = nj.plan(scene, camera, tolerance)
        name = f"Chebyshev({chosen.method.nodes})" if isinstance(chosen.method, nj.Chebyshev) else "ClosedForm"
        name += f", {len(chosen.scene.beams)} beams" if chosen.dropped else ""
        found.setdefault(name, (chosen.method, chosen.scene, []))[2].append(tolerance)
    return found


def our_rows(found: dict, scene, camera, truth: Truth) -> tuple[list[dict], dict]:
    """Errors and bounds of our ways, and what is timed."""
    rows, timed = [], {}
    for name, (method, kept, planned) in found.items():
        compiled = jax.jit(lambda scene, camera, method=method: nj.render(scene, camera, method))
        timed[name] = lambda compiled=compiled, kept=kept: compiled(kept, camera)
        phase, bound = _judged(method, kept, camera, truth)
        if len(kept.beams) < len(scene.beams):
            bound = None  # what is left out has a bound of its own, in the plan
        rows.append({"way": name, "peer": False, "nodes": getattr(method, "nodes", None), "planned_for": planned,
                     "bound": bound, **errors(timed[name](), truth), "phase_error_turns": phase})  # fmt: skip
    return rows, timed


def _judged(method, scene, camera, truth: Truth) -> tuple[float | None, float | None]:
    """Phase error [turns] where there are two beams, and the method's own bound of the intensity's, with rounding."""
    single = getattr(method, "dtype", None) == "float32"
    turns, bound = None, None
    if isinstance(method, nj.Chebyshev):
        turns, bound = (np.asarray(a) for a in _at_nodes(scene, camera, method.nodes))
        bound = float(bound) + 2 * np.pi * truth.rounding
        # Float32 pixels are promised to be this near for phases up to 250 turns.
        bound += 2e-5 * max(1.0, np.abs(turns).max() / 250) if single else 0.0
    elif truth.opd is not None:
        turns = np.asarray(nj.opd(scene, camera, method)) / WAVELENGTH
    if truth.opd is None or single:
        return None, bound
    return float(np.abs(turns - truth.opd / WAVELENGTH).max()), bound


@partial(jax.jit, static_argnums=2)
def _at_nodes(scene, camera, nodes: int):
    fields = nj.Chebyshev(nodes).fields(scene, camera)
    phase = chebyshev.expand(chebyshev.coefficients(fields.phase[:1]), camera.shape)[0]
    return phase, error_from_nodes(fields, nodes).intensity


def errors(image, truth: Truth) -> dict:
    wrong = np.abs(np.asarray(image).reshape(truth.image.shape) - truth.image)
    return {"intensity_error": float(wrong.max() / truth.peak)}


def peer_rows(case: Case, scene, camera, truth: Truth) -> tuple[list[dict], dict, dict]:
    """Errors of the peers, what is timed, and over which share of the pixels."""
    x, y = np.meshgrid(*(np.asarray(axis) for axis in camera.axes()))
    rows, timed, shares = [], {}, {}

    def enter(name, way, pixels=None):
        if way is None:
            print(f"  {name} is not installed")
            return
        opd, image = (None if a is None else np.asarray(a) for a in way())
        some = truth if pixels is None else truth._replace(image=truth.image.ravel()[pixels])
        phase = None if opd is None else float(np.abs(opd - truth.opd.ravel()).max() / WAVELENGTH)
        rows.append({"way": name, "peer": True, **errors(image, some), "phase_error_turns": phase})
        timed[name], shares[name] = way, 1.0 if pixels is None else len(pixels) / truth.image.size

    if truth.opd is not None:
        task = pareto_peers.Task(scene, *(a.ravel() for a in (x, y, truth.background, truth.fringes)))
        for name, maker in TRACERS.items():
            for rounds in ROUNDS[: 2 if name == "prysm" else None]:
                enter(name + (f", aimed {rounds}" if rounds else ""), maker(task, rounds))
    if case.formula == "LightPipes":
        enter("LightPipes", pareto_peers.lightpipes_way(task, case.bench["radius"], case.pixel, camera.shape[0]))
    if case.formula == "tmm":
        r2, radius = (x**2 + y**2).ravel(), case.bench["radius"]
        gap = r2 / (radius + np.sqrt(radius**2 - r2))
        some = np.random.default_rng(0).choice(gap.size, 1000, replace=False)
        enter("tmm, 256 gaps, interpolated", pareto_peers.tmm_table_way(scene, gap, 257))
        enter("tmm", pareto_peers.tmm_way(scene, gap[some]), some)
    return rows, timed, shares


def splat_row(scene, camera) -> tuple[dict, object, float]:
    """The algorithm of 2021 on a corner of the image, whose pixels show means over their rays."""
    rows, columns = (n // 4 for n in camera.shape)
    centre = (
        (camera.shape[1] - 1) / 2 - (camera.shape[1] - columns),
        (camera.shape[0] - 1) / 2 - (camera.shape[0] - rows),
    )
    corner = nj.Camera((rows, columns), camera.pixel_size, centre)
    method = nj.Splat(step=float(camera.pixel_size) / 2, epsilon=1e-3)

    def image():
        return nj.splat(scene, corner, method).image

    truth = find_truth(scene, corner)
    row = {"way": "Splat", "peer": False, "nodes": None, "planned_for": [], "bound": None, **errors(image(), truth)}
    return row | {"phase_error_turns": None}, image, 1 / 16


def measure(name: str, case: Case, size: int, nodes, peers: bool, turns: int) -> list[dict]:
    """A line a way of one scene."""
    scene = nj.newton_rings(wavelength=WAVELENGTH, **case.bench)
    camera = nj.Camera((size, size), case.pixel)
    truth = find_truth(scene, camera)
    rows, fast = our_rows(ours(scene, camera, nodes), scene, camera, truth)
    wrong = oracle_error(case, scene, camera)
    traced = jax.jit(lambda scene, camera: nj.render(scene, camera, nj.Traced()))
    slow, shares = {"Traced": lambda: traced(scene, camera)}, {}
    slow["Traced"]().block_until_ready()
    rows.append({"way": "Traced", "peer": False, "nodes": None, "planned_for": [], "bound": 2 * np.pi * truth.rounding,
                 "intensity_error": float(2 * np.pi * wrong * np.abs(truth.fringes).max() / truth.peak),
                 "phase_error_turns": wrong})  # fmt: skip
    if peers and case.splat:
        row, slow["Splat"], shares["Splat"] = splat_row(scene, camera)
        rows.append(row)
    if peers:
        more, timed, parts = peer_rows(case, scene, camera, truth)
        rows, slow, shares = rows + more, slow | timed, shares | parts
    picture = jax.numpy.asarray(truth.image)
    copy = jax.jit(lambda a: a.copy())
    ratios, seconds = race({"copy": lambda: copy(picture)} | fast, slow, shares, turns)
    for row in rows:
        way = row["way"]
        row |= {"scene": name, "copies": ratios[way], "seconds": seconds[way], "timed_share": shares.get(way, 1.0)}
        print(f"  {way:32s} {row['copies']:10.2f} copies  {row['intensity_error']:9.2e} of the peak  "
              f"{row['phase_error_turns'] or float('nan'):9.2e} turns  {row['planned_for'] if not row['peer'] else ''}",
              flush=True)  # fmt: skip
    return rows


def race(fast: dict, slow: dict, shares: dict, turns: int) -> tuple[dict, dict]:
    """Median over turns of each way's time over a copy's of the same turn, and its seconds; slow ways once a turn.

    The slow ones have been called before, for their errors.
    """
    ratios, seconds = {}, {}
    for turn in range(turns):
        times = records.medians(fast, 15)
        for name, way in slow.items():
            if turn == 0 or seconds[name][0] * shares.get(name, 1) < SLOW:
                times[name] = records.clock(way) / shares.get(name, 1)
        for name, time in times.items():
            ratios.setdefault(name, []).append(time / times["copy"])
            seconds.setdefault(name, []).append(time)
    return {name: median(r) for name, r in ratios.items()}, {name: median(s) for name, s in seconds.items()}


def check(rows: list[dict]) -> None:
    """Bounds hold, and every peer is dominated: one of ours in half the time, at a smaller error or one of rounding."""
    for row in rows:
        if not row["peer"] and row["bound"] is not None:
            assert row["intensity_error"] <= row["bound"], row
    for peer in (row for row in rows if row["peer"]):
        beats = [row for row in rows if not row["peer"] and row["scene"] == peer["scene"]
                 and 2 * row["copies"] < peer["copies"]
                 and row["intensity_error"] < max(peer["intensity_error"], ROUNDED)]  # fmt: skip
        assert beats, peer


def cheapest(rows: list[dict], scene: str, error: float) -> dict:
    good = [row for row in rows if row["scene"] == scene and not row["peer"] and row["intensity_error"] < error]
    return min(good, key=lambda row: row["copies"])


def main(quick: bool) -> None:
    rows = []
    for name, case in list(CASES.items())[: 1 if quick else None]:
        print(name, flush=True)
        rows += measure(name, case, 128 if quick else 512, (7,) if quick else NODES, not quick, 1 if quick else 3)
        for error in (1e-3, 1e-6):
            row = cheapest(rows, name, error)
            print(f"  cheapest below {error:g}: {row['way']}, {row['copies']:.1f} copies", flush=True)
    if not quick:
        records.save("pareto", rows, draw(rows), dpi=110)
        draw(rows).savefig(Path(__file__).parents[2] / "docs" / "pareto.png", dpi=72)
    check(rows)


if __name__ == "__main__":
    main(records.arguments(__doc__, "one scene of 128 x 128 pixels, few ways, no peers; writes nothing").quick)
